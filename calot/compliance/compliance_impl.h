// What a Compliance holds. Internal to the room.
#pragma once
#include <future>
#include <optional>

#include "calot/compliance/compliance.h"
#include "calot/compliance/correction.h"

namespace calot {

inline constexpr std::uint32_t no_group = ~0u;

/// Vertices are kept in "slots", the numbering of the mesh when the compliance was made: cuts renumber the mesh, never
/// the rows. A slot has three rows in the base, unless its vertex is fixed or belongs to no tet.
struct Compliance::Impl {
  // Constant since the compliance was made.
  Backend backend = Backend::dense;
  bool is_static = false;
  std::vector<std::uint8_t> fixed;        // slots
  std::vector<std::int32_t> row_of_slot;  // first base row, or −1
  std::vector<std::uint32_t> slot_of_row; // base rows / 3
  std::vector<std::uint8_t> active;       // slots that have rows: neither fixed nor without tets when analysed
  std::shared_ptr<const FactorPattern> pattern;  // of the active slots, in base row order

  // Changed by cuts.
  BlockMatrix stiffness;                    // Â over slots; blocks of dead slots are zero
  std::vector<std::uint8_t> dead;           // slots whose vertex has lost its last tet
  std::vector<std::uint32_t> slot_of_vertex;  // current mesh vertices
  std::vector<std::uint32_t> group;         // slots: what is still coupled; no_group for dead and fixed ones
  std::unique_ptr<ComplianceBase> base;
  Correction correction;
  std::vector<UpdateStep> steps_since_fold;  // updates that a fold under way does not know

  // Declared last: its thread reads the members above, so it must end first.
  std::future<std::unique_ptr<ComplianceBase>> fold;
  Buffer spare;  // the matrix before the last fold, to write the next one into

  [[nodiscard]] std::size_t slots() const { return fixed.size(); }
  [[nodiscard]] std::vector<std::uint32_t> rows_of(std::span<const DofId> dofs) const;  // ~0u for fixed ones
  void regroup();

  // Vectors over slots (3 values each) to base rows and back.
  [[nodiscard]] Eigen::MatrixXd to_rows(const Eigen::MatrixXd& x) const;
  [[nodiscard]] Eigen::MatrixXd to_slots(const Eigen::MatrixXd& x) const;
  /// C F over slots, refined; couplings between groups are exactly zero.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& forces, int refinements) const;
  void lay_out_rows();  // analyses Â and gives every active slot its rows
  void build(Progress* progress);
  [[nodiscard]] std::function<std::unique_ptr<ComplianceBase>()> fold_work();
  void adopt(std::unique_ptr<ComplianceBase> folded);
};

}  // namespace calot
