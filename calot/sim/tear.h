// Tearing: where tissue is stretched beyond what it bears, and along which faces it gives way.
#pragma once
#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calot/mesh/topology_edit.h"
#include "calot/sim/tissue_properties.h"

namespace calot {

struct TearOptions {
  int steps_to_tear = 2;      ///< successive steps beyond the limit before a tet gives way, 1 … 200
  std::size_t max_tears = 8;  ///< tets that may give way in one step
  double weak_share = 0.6;    ///< a crack runs on through tets that have this share of their ultimate strain, 0 … 1
};

struct RegionStretch {
  std::int32_t region = 0;
  double largest = 1;      ///< principal stretch, of all tets of the region
  double utilisation = 0;  ///< (stretch − 1) / (ultimate stretch − 1); 1 is the limit
  TetId tet;               ///< where
};

struct TearStep {
  double largest = 1;                          ///< principal stretch of all tets
  std::vector<RegionStretch> by_region;        ///< ascending by region
  std::vector<TetId> inverted;                 ///< turned inside out or flat: det F ≤ 0; ascending
  std::vector<TetId> torn;                     ///< that give way now, worst first
  std::vector<TetId> stuck;                    ///< beyond the limit still after many tries; ascending
  std::vector<std::array<VertexId, 3>> faces;  ///< for `separate`, each once
};

/// Watches the largest principal stretch of every tet, √λ_max(FᵀF). Where it passes the region's ultimate stretch in
/// successive steps, a crack opens across the direction of that stretch: all faces around one face of the tet, the one
/// whose normal is nearest to that direction, that part the tets on both sides of it. One thread, linear in the tets.
class Tearing {
 public:
  Tearing() = default;
  /// Throws InputError for a region without properties and options out of range.
  Tearing(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
          const TearOptions& options = {});

  /// @param positions  where the vertices are now, n; `mesh` and `around` as after the last edit
  const TearStep& step(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> positions);
  void follow(const Remap& remap, const TetMesh& mesh);

  /// Largest principal stretch of a tet in the last step.
  [[nodiscard]] double stretch(TetId tet) const;
  void append_state(std::string& bytes) const;

 private:
  static constexpr std::size_t lanes = 8;
  using Lane = std::array<double, lanes>;
  struct Block {  // of eight tets; unused lanes repeat the last tet
    std::array<std::array<std::uint32_t, lanes>, 4> vertex;
    std::array<Lane, 9> inverse;  // of the rest edges' matrix, row-major [1/m]
  };
  struct Kind {
    std::int32_t region;
    double limit;    // ultimate stretch
    double squared;  // its square
  };
  void build(const TetMesh& mesh);
  static void measure(const Block& block, const double* x, Lane& squared_stretch, Lane& determinant);
  void survey(const TetMesh& mesh);
  [[nodiscard]] double utilisation(std::size_t t) const;
  [[nodiscard]] Vec3 direction(std::size_t t, std::span<const Vec3> positions) const;
  void crack(const TetMesh& mesh, const VertexTets& around, TetId tet, const Vec3& across_it);
  void give_way(const TetMesh& mesh, const VertexTets& around, std::span<const Vec3> positions);

  TearOptions options_;
  std::vector<Kind> kinds_;
  std::vector<Block> blocks_;
  std::vector<std::uint8_t> kind_;          // m
  std::vector<std::uint8_t> over_, tries_;  // m, steps beyond the limit, and cracks tried since
  std::vector<double> squared_;             // m, largest stretch squared
  TearStep report_;
  std::vector<TetId> over_now_;
};

}  // namespace calot
