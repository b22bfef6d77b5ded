// Blood and bile: where they come from, how much, and whether something stops them.
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calot/contact/tissue_contact.h"
#include "calot/sim/fluids_graph.h"
#include "calot/sim/injury.h"

namespace calot {

constexpr double millilitres(double cubic_metres) {
  return cubic_metres * 1e6;
}

struct FluidOptions {
  double gallbladder_volume = 40e-6;    ///< of bile at the start; usually 30 … 50 mL, ≥ 0 [m³]
  double biliary_tree_volume = 5e-6;    ///< of bile in the ducts, > 0 [m³]
  double bile_secretion = 7e-9;         ///< of the liver, 600 mL a day, ≥ 0 [m³/s]
  double discharge = 0.6;               ///< coefficient of a sharp-edged opening, 0 … 1
  double sealing_coagulation = 0.8;     ///< coagulated fraction at which an opening is shut, in (0, 1]
  double largest_sealed_radius = 1e-3;  ///< of a lumen that heat can shut [m]
};

enum class FluidSourceKind : std::uint8_t {
  vessel,  ///< an open lumen
  ooze,    ///< a raw face
  injury,  ///< a surface that a tool broke
};

struct FluidSource {
  std::uint32_t id = 0;  ///< stays; never given twice
  FluidSourceKind kind = FluidSourceKind::ooze;
  Fluid fluid = Fluid::blood;
  std::int32_t region = 0;
  SurfacePoint place;            ///< on the surface of the mesh as it is now; not kept up once ended
  Vec3 position = Vec3::Zero();  ///< where that was in the last step [m]
  double open_area = 0;          ///< of raw face not shut by heat, at rest [m²]
  double rate = 0;               ///< now [m³/s]
  double shed = 0;               ///< since it opened [m³]
  double pooled = 0;             ///< of it, not sucked off [m³]
  bool fed = false;              ///< a vessel: a way to its supply is open; others: always
  bool ended = false;            ///< its opening is gone; what it shed stays
};

struct FluidTotals {
  double blood_lost = 0, bile_spilled = 0;  ///< since the start [m³]
  double blood_rate = 0, bile_rate = 0;     ///< now [m³/s]
  double sucked = 0;                        ///< [m³]
  double gallbladder_left = 0;              ///< bile in the gallbladder [m³]
  double biliary_tree_left = 0;             ///< bile in the ducts [m³]
};

/// The vertices through which tubes are fed, by default: for each connected tree of arteries, and of bile ducts, its
/// fixed vertices (of bile ducts those towards the liver, in the common hepatic or an aberrant duct, where there are
/// any); of a tree without fixed vertices, the one farthest from the gallbladder, or from the tree's own middle.
std::vector<VertexId> supply_vertices(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
                                      std::span<const std::uint8_t> fixed);

/// Openings appear where an edit lays bare a face that was inside the tissue before: between two tets of one lumen it
/// opens the vessel, and raw faces of tissues that ooze, ooze. A vessel's flow Q solves
/// Δp = R Q + ρ/2 (Q / (C_d A))², R the Hagen–Poiseuille resistance of the way to its supply. docs/simulation.md.
class Fluids {
 public:
  Fluids() = default;
  /// Throws InputError for a region without properties, figures out of range and supplies that don't exist.
  Fluids(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
         std::span<const VertexId> supplies, const FluidOptions& options = {});

  /// One step of `dt` > 0 [s].
  /// @param coagulation  n, 0 … 1, as TissueHeat has it
  /// @param closed       m flags: tets of tubes that a clip closes; or empty
  void step(double dt, const TetMesh& mesh, std::span<const Vec3> positions, std::span<const double> coagulation,
            std::span<const std::uint8_t> closed);
  /// Finds new openings; `mesh` and `around` are those after the edit.
  void follow(const Remap& remap, const TetMesh& mesh, const VertexTets& around);
  /// A surface broke: bleeding that joins an injury within 3 mm (at rest), or starts a source.
  void injure(const BleedingOnset& onset, const TetMesh& mesh);
  /// Takes up what is pooled within `radius` of a tip, the nearest first, at most `flow` [m³/s] · dt. @return how much
  /// [m³]
  double suck(const Vec3& tip, double radius, double flow, double dt);

  [[nodiscard]] const std::vector<FluidSource>& sources() const { return sources_; }  ///< ascending by id
  [[nodiscard]] const FluidTotals& totals() const { return totals_; }
  void append_state(std::string& bytes) const;

 private:
  struct OpenFace {
    TetId tet;
    std::uint8_t face = 0;
    bool lumen = false;
    std::uint32_t source = 0;  // id
    double area = 0;           // at rest [m²]
    double age = 0;            // [s]
  };
  struct Ways {                        // of a source in a step
    std::array<double, 3> resistance;  // from arteries, gallbladder, biliary tree [Pa s/m³]
    std::array<double, 3> drawn{};     // from each [m³/s]
    double ooze = 0;                   // [m³/s]
  };
  [[nodiscard]] const TissueProperties& tissue(TetId tet) const { return kinds_[kind_[tet.index()]]; }
  [[nodiscard]] const TissueProperties& tissue_of(std::int32_t region) const;
  [[nodiscard]] bool lumen_between(TetId a, TetId b) const;
  [[nodiscard]] std::size_t parent_face(const Remap& remap, const Tet& parent, const Tet& piece, std::size_t f) const;
  void carry_faces(const Remap& remap, const TetMesh& mesh, const VertexTets& around);
  void look_at_pieces(const Remap& remap, const TetMesh& mesh, std::vector<detail::Neighbours>& after);
  void look_at_survivors(const Remap& remap, const TetMesh& mesh, const VertexTets& around,
                         std::vector<detail::Neighbours>& after);
  void open_face(const TetMesh& mesh, TetId tet, std::size_t f, const TissueProperties& tissue, bool lumen);
  void group_faces(const TetMesh& mesh);
  std::uint32_t new_source(const TetMesh& mesh, const OpenFace& open);
  [[nodiscard]] bool move_to(SurfacePoint& point, VertexId vertex, std::int32_t region, const TetMesh& mesh,
                             const VertexTets& around) const;
  void place(FluidSource& source, const TetMesh& mesh, std::span<const std::uint32_t> faces) const;
  void follow_injuries(const Remap& remap, const TetMesh& mesh, const VertexTets& around);
  void find_ways(const TetMesh& mesh, std::span<const std::uint8_t> closed);
  [[nodiscard]] double open_share(const TissueProperties& tissue, bool lumen, double coagulated) const;
  void survey(double dt, const TetMesh& mesh, std::span<const double> coagulation);
  void flow(FluidSource& source, Ways& ways) const;
  void share_supplies(double dt);
  void shed(double dt, std::span<const Vec3> positions);
  [[nodiscard]] std::size_t index_of(std::uint32_t id) const;

  FluidOptions options_;
  std::vector<TissueProperties> kinds_;
  std::map<std::int32_t, std::uint8_t> kind_of_region_;
  std::vector<std::uint8_t> kind_;              // m
  std::vector<Tet> tets_;                       // m, to see where the pieces of the next edit come from
  std::vector<detail::Neighbours> neighbours_;  // m
  std::vector<std::uint8_t> supply_;            // n, fed here
  std::vector<OpenFace> open_;                  // ascending by (tet, face, lumen)
  std::vector<FluidSource> sources_;            // ascending by id
  std::vector<double> injury_rate_;             // of each source, before heat seals it [m³/s]
  FluidTotals totals_;

  bool ways_known_ = false;  // found anew when an edit or a clip changes them
  detail::VesselGraph graph_;
  std::vector<std::uint8_t> closed_;
  std::array<std::vector<double>, 3> resistance_;  // m
  std::vector<Ways> ways_;                         // of each source
};

}  // namespace calot
