// A mesh with materials, supports and a time step: everything the compliance is computed from.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calot/fem/block_matrix.h"
#include "calot/fem/element.h"
#include "calot/mesh/topology_edit.h"

namespace calot {

enum class MassLumping {
  element,  ///< a quarter of each tet's mass goes to each of its vertices
  uniform,  ///< SOFA's UniformMass: every vertex the same share; a cut leaves each survivor's share as it was
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

/// What an edit changed in the step stiffness; made by Model::apply, consumed by Compliance::update.
struct StiffnessChange {
  Remap remap;
  std::vector<VertexId> struck;   ///< old ids of the vertices that lost their last tet, ascending
  std::vector<VertexId> touched;  ///< old ids of the surviving vertices of removed tets, ascending; k of them
  Eigen::MatrixXd removed;        ///< 3k×3k, Σ Â_e of the removed tets on `touched` [N/m]
  struct Entry {
    std::uint32_t row, column;  ///< positions in `touched`
    Mat3 block;                 ///< Â' there, summed from the live tets in the order of a fresh assembly
  };
  std::vector<Entry> entries;  ///< every block of Â' between two touched vertices of a removed tet
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
  [[nodiscard]] const std::vector<std::uint8_t>& fixed() const { return fixed_; }
  [[nodiscard]] bool is_fixed(VertexId v) const { return fixed_[v.index()] != 0; }
  [[nodiscard]] const Dynamics& dynamics() const { return dynamics_; }
  [[nodiscard]] const Origin& origin() const { return origin_; }
  void set_origin(Origin origin) { origin_ = std::move(origin); }

  /// Lumped mass of each vertex [kg], n.
  [[nodiscard]] std::vector<double> vertex_masses() const;
  /// Each vertex's share under uniform lumping [kg]; 0 under element lumping.
  [[nodiscard]] double uniform_share() const { return uniform_share_; }
  /// K [N/m] over all vertices, fixed ones too.
  [[nodiscard]] BlockMatrix stiffness() const;
  /// Â [N/m] over all vertices, fixed ones too.
  [[nodiscard]] BlockMatrix step_stiffness() const;
  /// SHA-256 of everything the compliance depends on: coordinates, tets, materials, supports, step, damping, masses.
  [[nodiscard]] std::string fingerprint() const;

  /// Applies a topology edit and says what it changed. Added vertices and tets arrive with the `split` mode.
  StiffnessChange apply(const TopologyEdit& edit);

 private:
  [[nodiscard]] BlockMatrix assemble(double mass_factor, double stiffness_factor) const;
  void sum_rows(StiffnessChange& change, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) const;

  TetMesh mesh_;
  std::map<std::int32_t, Material> materials_;
  std::vector<std::uint8_t> fixed_;  // n
  Dynamics dynamics_;
  double uniform_share_ = 0;
  Origin origin_;
};

}  // namespace calot
