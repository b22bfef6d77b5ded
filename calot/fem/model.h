// A mesh with materials, supports and a time step: everything the compliance is computed from.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calot/fem/block_matrix.h"
#include "calot/fem/element.h"
#include "calot/mesh/topology_edit.h"

namespace calot {

enum class MassLumping {
  element,  ///< a quarter of each tet's mass goes to each of its vertices
  uniform,  ///< SOFA's UniformMass: every vertex the same share. What a cut leaves keeps its share; a vertex that an
            ///< edit adds gets its own from those it comes from, so that a split keeps the mass
};

/// Time stepping and damping. Step stiffness Â = ((1 + hα) M + (h² + hβ) K)/h²; static (h = 0): Â = K.
struct Dynamics {
  double time_step = 0.02;        ///< h ≥ 0 [s]; 0 is static
  double rayleigh_mass = 0;       ///< α ≥ 0 [1/s]
  double rayleigh_stiffness = 0;  ///< β ≥ 0 [s]
  MassLumping mass_lumping = MassLumping::element;
  [[nodiscard]] bool is_static() const { return time_step == 0; }
  [[nodiscard]] double mass_factor() const;       ///< of M in Â [1/s²]; 0 when static
  [[nodiscard]] double stiffness_factor() const;  ///< of K in Â [1]; 1 when static
};

/// Where a model came from; used to recognise a compliance file that belongs to another one.
struct Origin {
  std::filesystem::path model_file, mesh_file;  ///< empty for models made in memory
  std::string mesh_sha256;                      ///< of the mesh file's bytes; empty for models made in memory
};

/// What an edit changed in the step stiffness; made by Model::apply, consumed by Compliance::update. Its "sites" are
/// the touched vertices and, after them, the added ones.
struct StiffnessChange {
  Remap remap;
  std::vector<VertexId> struck;           ///< old ids of the vertices that lost their last tet, ascending
  std::vector<VertexId> touched;          ///< old ids of the survivors whose rows changed, ascending; k of them
  std::vector<VertexId> added;            ///< new ids of the added vertices, ascending; sites from k on
  std::vector<std::uint8_t> added_fixed;  ///< a flag for each of `added`
  struct Entry {
    std::uint32_t row, column;  ///< sites
    Mat3 block;                 ///< Â' there [N/m], summed from the live tets in the order of a fresh assembly
    Mat3 change;                ///< Â' − Â there [N/m], from what went, came and changed; indefinite in general
  };
  std::vector<Entry> entries;  ///< every block that changed between two sites, both triangles, ascending
  std::string unsupported;     ///< static models: the part that nothing holds now (`unsupported_part`); else empty
};

/// Constant materials and supports over one mesh. A value; copy it to try something.
class Model {
 public:
  /// @param materials  one for each region of the mesh
  /// @param fixed      n flags, 1 = held in place
  /// @param total_mass [kg], for uniform lumping only; density × volume when empty
  /// Throws InputError for a material, mesh or step out of range.
  Model(TetMesh mesh, std::map<std::int32_t, Material> materials, std::vector<std::uint8_t> fixed, Dynamics dynamics,
        std::optional<double> total_mass = {}, Origin origin = {});

  [[nodiscard]] const TetMesh& mesh() const { return mesh_; }
  [[nodiscard]] const std::map<std::int32_t, Material>& materials() const { return materials_; }
  [[nodiscard]] const Material& material(TetId tet) const { return materials_.at(mesh_.regions[tet.index()]); }
  /// Lamé's parameters of a tet, its own factor included [Pa].
  [[nodiscard]] Lame lame_of(TetId tet) const {
    const Lame plain = lame(material(tet));
    const double factor = stiffness_scale_[tet.index()];
    return {factor * plain.lambda, factor * plain.mu};
  }
  [[nodiscard]] const std::vector<std::uint8_t>& fixed() const { return fixed_; }
  [[nodiscard]] bool is_fixed(VertexId v) const { return fixed_[v.index()] != 0; }
  [[nodiscard]] const Dynamics& dynamics() const { return dynamics_; }
  [[nodiscard]] const Origin& origin() const { return origin_; }
  void set_origin(Origin origin) { origin_ = std::move(origin); }

  /// Lumped mass of each vertex [kg], n.
  [[nodiscard]] std::vector<double> vertex_masses() const;
  /// Each vertex's share under uniform lumping [kg], before edits added any; 0 under element lumping.
  [[nodiscard]] double uniform_share() const { return uniform_share_; }
  /// Factor on the stiffness of each tet [1], m; 1 unless `scale_stiffness` said otherwise. Pieces inherit it.
  [[nodiscard]] const std::vector<double>& stiffness_scale() const { return stiffness_scale_; }
  [[nodiscard]] bool has_scaled_stiffness() const;  ///< some factor is not 1
  [[nodiscard]] bool has_even_masses() const;       ///< no edit made shares differ; always so under element lumping
  /// K [N/m] over all vertices, fixed ones too.
  [[nodiscard]] BlockMatrix stiffness() const;
  /// Â [N/m] over all vertices, fixed ones too.
  [[nodiscard]] BlockMatrix step_stiffness() const;
  /// SHA-256 of everything the compliance depends on: coordinates, tets, materials, supports, step, damping, masses.
  [[nodiscard]] std::string fingerprint() const;

  /// Applies a topology edit and says what it changed. An added vertex is fixed when both vertices it comes from are.
  /// Under uniform lumping a vertex shares its mass with those that come from it: a copy counts as much as itself, one
  /// between a and b with its weights; the shares of a vertex that goes pass to them too. Throws InputError as
  /// calot::apply, and has then changed nothing.
  StiffnessChange apply(const TopologyEdit& edit);

  /// Sets the factors on the stiffness (not the mass) of some tets, as heat changes them, and says what that changed;
  /// the remap is the identity.
  /// @param tets     ascending, unique
  /// @param factors  one for each, > 0 [1]; of the material's own stiffness, not of the last factor
  /// Throws InputError for anything else, and has then changed nothing.
  StiffnessChange scale_stiffness(std::span<const TetId> tets, std::span<const double> factors);

  /// Gives each vertex its own mass, for models read back from a file. Throws InputError unless lumping is uniform and
  /// there are n finite masses > 0 [kg].
  void set_vertex_masses(std::vector<double> masses);

 private:
  struct Pieces;
  [[nodiscard]] BlockMatrix assemble(double mass_factor, double stiffness_factor) const;
  [[nodiscard]] Pieces pieces_that_go(const TopologyEdit& edit) const;
  void follow(const Remap& remap);
  void describe(StiffnessChange& change, const Pieces& went, const std::vector<TetId>& came,
                const std::vector<double>& shares_before) const;

  TetMesh mesh_;
  std::map<std::int32_t, Material> materials_;
  std::vector<std::uint8_t> fixed_;  // n
  Dynamics dynamics_;
  double uniform_share_ = 0;
  std::vector<double> shares_;           // n under uniform lumping [kg]; else empty
  std::vector<double> stiffness_scale_;  // m
  Origin origin_;
};

}  // namespace calot
