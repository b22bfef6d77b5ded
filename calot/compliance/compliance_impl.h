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

/// One update, told in slots, so that it can be played again on a newer base whose rows are laid out anew.
struct SlotStep {
  struct Entering {
    std::uint32_t slot;
    double stiffness;  // σ [N/m]
  };
  std::vector<Entering> entering;    // get new rows, uncoupled: vertices that were added, or left an island
  std::vector<std::uint32_t> slots;  // struck, then changed ones
  std::size_t struck = 0;
  Eigen::MatrixXd change;  // Â' − Â on the changed ones; −σ I where they enter
};

/// What a fold computes: C0 anew, and how its rows lie.
struct Folded {
  std::unique_ptr<ComplianceBase> base;
  std::shared_ptr<const FactorPattern> pattern;
  std::vector<std::uint8_t> active;  // slots when the fold began
};

/// Vertices are kept in "slots": first the numbering of the mesh when the compliance was made, then, in the order that
/// edits add them, the new ones. Edits renumber the mesh, never the slots or rows. A slot has three rows in the base,
/// unless its vertex is fixed or belongs to no tet.
struct Compliance::Impl {
  // Constant since the compliance was made.
  Backend backend = Backend::dense;
  bool is_static = false;

  // How the base's rows lie; anew when a fold has analysed Â anew.
  std::vector<std::int32_t> row_of_slot;         // first base row, or −1
  std::vector<std::uint32_t> slot_of_row;        // base rows / 3; no_slot for rows that their slot has left
  std::vector<std::uint8_t> active;              // slots that the pattern has: neither fixed nor dead when analysed
  std::shared_ptr<const FactorPattern> pattern;  // of the active slots
  bool pattern_is_small = false;                 // Â has entries that the pattern has no room for

  // Changed by cuts.
  std::vector<std::uint8_t> fixed;            // slots
  BlockMatrix stiffness;                      // Â over slots; blocks of dead slots are zero
  std::vector<std::uint8_t> dead;             // slots whose vertex has lost its last tet
  std::vector<std::uint32_t> slot_of_vertex;  // current mesh vertices
  std::vector<std::uint32_t> group;           // slots: what is still coupled; no_group for dead and fixed ones
  std::unique_ptr<ComplianceBase> base;
  Correction correction;
  std::vector<Island> islands;
  std::vector<std::int32_t> island_of_slot;  // or −1
  bool base_is_stale = false;  // an island was cut: answers are right, but the base is not that of Â any more
  std::vector<SlotStep> steps_since_fold;  // updates that a fold under way does not know
  bool fold_is_small = false;              // as pattern_is_small, of the pattern of the fold under way

  // Declared last: its thread reads the members above, so it must end first.
  std::future<Folded> fold;
  std::vector<std::future<Folded>> abandoned;  // folds that came too late; waited for at the end
  Buffer spare;                                // the matrix before the last fold, to write the next one into

  static constexpr std::uint32_t no_slot = ~0u;
  [[nodiscard]] std::size_t slots() const { return fixed.size(); }
  [[nodiscard]] bool is_free(std::size_t slot) const { return !fixed[slot] && !dead[slot]; }
  [[nodiscard]] std::vector<std::uint32_t> rows_of(std::span<const DofId> dofs) const;  // ~0u for fixed ones
  void regroup();
  /// Slots that form small groups now and were touched or islands before; groups must be up to date.
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> small_groups(const std::vector<std::uint32_t>& touched) const;
  [[nodiscard]] double island_entry(std::uint32_t row_slot, std::uint32_t row_axis, std::uint32_t column_slot,
                                    std::uint32_t column_axis) const;
  [[nodiscard]] std::vector<Island> make_islands(const std::vector<std::vector<std::uint32_t>>& groups) const;
  void settle_islands(std::vector<Island> made);
  /// Answered by the base and its correction: has rows, is neither dead nor on an island.
  [[nodiscard]] bool in_base(std::size_t slot) const {
    return row_of_slot[slot] >= 0 && !dead[slot] && island_of_slot[slot] < 0;
  }

  /// Appends slots; they have no rows yet.
  void add_slots(const std::vector<std::uint8_t>& fixed_flags);
  /// Gives the entering slots of a step their rows, and says the step in rows.
  UpdateStep enter(const SlotStep& step);

  // Vectors over slots (3 values each) to base rows and back.
  [[nodiscard]] Eigen::MatrixXd to_rows(const Eigen::MatrixXd& x) const;
  [[nodiscard]] Eigen::MatrixXd to_slots(const Eigen::MatrixXd& x) const;
  /// C F over slots, refined; couplings between groups are exactly zero.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& forces, int refinements) const;
  /// Gives every active slot its rows; an empty correction.
  void lay_out_rows(std::shared_ptr<const FactorPattern> made, std::vector<std::uint8_t> of_slots);
  /// The same for a compliance that is just being made, with this pattern.
  void start_rows(std::shared_ptr<const FactorPattern> made);
  void build(Progress* progress);
  [[nodiscard]] std::function<Folded()> fold_work();
  void adopt(Folded folded);
  /// Makes a fresh factor of the current Â the base, whatever the home: a tenth of the time of inverting it.
  void refactor();
  /// Drops slots that nothing refers to any more, once there are many.
  void compact();
  [[nodiscard]] bool is_lost(const CorrectionHealth& health) const;
  void drop_abandoned();
  [[nodiscard]] bool away_from_home() const;  ///< a dense compliance that answers from a factor for now
};

/// The slots that a pattern should have now: neither fixed nor dead.
std::vector<std::uint8_t> active_slots(const Compliance::Impl& impl);

}  // namespace calot
