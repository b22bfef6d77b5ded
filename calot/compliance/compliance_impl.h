// What a Compliance holds. Internal to the room.
#pragma once
#include <future>
#include <optional>

#include "calot/compliance/compliance.h"
#include "calot/compliance/correction.h"

namespace calot {

inline constexpr std::uint32_t no_group = ~0u;

/// A small connected group that cuts have set free: answered from its own inverse. Left in the correction, a crumb held
/// by nothing but its mass would cost every other part its digits.
struct Island {
  std::vector<std::uint32_t> slots;  // ascending
  Eigen::MatrixXd inverse;           // 3·slots squared
};

/// Vertices are kept in "slots", the numbering of the mesh when the compliance was made: cuts renumber the mesh, never
/// the rows. A slot has three rows in the base, unless its vertex is fixed or belongs to no tet.
struct Compliance::Impl {
  // Constant since the compliance was made.
  Backend backend = Backend::dense;
  bool is_static = false;
  std::vector<std::uint8_t> fixed;               // slots
  std::vector<std::int32_t> row_of_slot;         // first base row, or −1
  std::vector<std::uint32_t> slot_of_row;        // base rows / 3
  std::vector<std::uint8_t> active;              // slots that have rows: neither fixed nor without tets when analysed
  std::shared_ptr<const FactorPattern> pattern;  // of the active slots, in base row order

  // Changed by cuts.
  BlockMatrix stiffness;                      // Â over slots; blocks of dead slots are zero
  std::vector<std::uint8_t> dead;             // slots whose vertex has lost its last tet
  std::vector<std::uint32_t> slot_of_vertex;  // current mesh vertices
  std::vector<std::uint32_t> group;           // slots: what is still coupled; no_group for dead and fixed ones
  std::unique_ptr<ComplianceBase> base;
  Correction correction;
  std::vector<Island> islands;
  std::vector<std::int32_t> island_of_slot;  // or −1
  bool base_is_stale = false;  // an island was cut: answers are right, but the base is not that of Â any more
  std::vector<UpdateStep> steps_since_fold;  // updates that a fold under way does not know

  // Declared last: its thread reads the members above, so it must end first.
  std::future<std::unique_ptr<ComplianceBase>> fold;
  std::vector<std::future<std::unique_ptr<ComplianceBase>>>
      abandoned;  // folds that came too late; waited for at the end
  Buffer spare;   // the matrix before the last fold, to write the next one into

  [[nodiscard]] std::size_t slots() const { return fixed.size(); }
  [[nodiscard]] std::vector<std::uint32_t> rows_of(std::span<const DofId> dofs) const;  // ~0u for fixed ones
  void regroup();
  /// Slots that form small groups now and were touched or islands before; groups must be up to date.
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> small_groups(const std::vector<std::uint32_t>& touched) const;
  [[nodiscard]] double island_entry(std::uint32_t row_slot, std::uint32_t row_axis, std::uint32_t column_slot,
                                    std::uint32_t column_axis) const;
  void settle_islands(const std::vector<std::vector<std::uint32_t>>& groups);
  /// Answered by the base and its correction: has rows, is neither dead nor on an island.
  [[nodiscard]] bool in_base(std::size_t slot) const {
    return row_of_slot[slot] >= 0 && !dead[slot] && island_of_slot[slot] < 0;
  }

  // Vectors over slots (3 values each) to base rows and back.
  [[nodiscard]] Eigen::MatrixXd to_rows(const Eigen::MatrixXd& x) const;
  [[nodiscard]] Eigen::MatrixXd to_slots(const Eigen::MatrixXd& x) const;
  /// C F over slots, refined; couplings between groups are exactly zero.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& forces, int refinements) const;
  void lay_out_rows(std::shared_ptr<const FactorPattern> made = {});  // analyses Â and gives every active slot its rows
  void build(Progress* progress);
  [[nodiscard]] std::function<std::unique_ptr<ComplianceBase>()> fold_work();
  void adopt(std::unique_ptr<ComplianceBase> folded);
  /// Makes a fresh factor of the current Â the base, whatever the home: a tenth of the time of inverting it.
  void refactor();
  [[nodiscard]] bool is_lost(const CorrectionHealth& health) const;
  void drop_abandoned();
  [[nodiscard]] bool away_from_home() const;  ///< a dense compliance that answers from a factor for now
};

}  // namespace calot
