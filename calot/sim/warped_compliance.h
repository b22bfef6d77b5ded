// C = Â⁻¹ of the tissue as it was bent a few steps ago, turned with each vertex since, and exact for every edit since.
#pragma once
#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "calot/compliance/compact_factor.h"
#include "calot/compliance/float_factor.h"
#include "calot/fem/model.h"
#include "calot/sim/spring.h"

namespace calot {

using Mat12 = Eigen::Matrix<double, 12, 12>;

/// One tet's share of Â before its rotation, entering (+) or leaving (−) the sum.
struct ElementChange {
  std::array<VertexId, 4> vertices;  ///< old ids where it leaves, new ids where it enters
  Mat12 stiffness;                   ///< Â_e, unsigned, in the rest frame [N/m]
  TetId tet;                         ///< the old tet whose rotation it has
  bool enters = false;
};

/// What bases of the same vertices and edges share.
struct BasePattern {
  std::shared_ptr<const FactorPattern> factor;
  BlockMatrix structure;  ///< of Â: rows and columns, no blocks
  std::vector<Tet> tets;  ///< that `places` is for
  std::vector<std::array<std::uint32_t, 10>> places;
};

/// What a base is made from: a copy, so that the work can go on aside.
struct BaseRequest {
  Model model;
  std::vector<Eigen::Quaterniond> rotations;  ///< m, of the tets
  std::vector<Spring> springs;
  std::vector<VertexId> likely;                ///< vertices near a blade: their columns are made ready
  std::shared_ptr<const BasePattern> pattern;  ///< of the same vertices and at least the same edges; may be null
};

/// Columns of L⁻¹ P for vertices that edits touch, packed to the rows where they are not zero, and C0 between them.
class ReadyColumns {
 public:
  /// Makes three columns ready for each of the given first rows (in the factor's order) that aren't yet.
  void add(const SparseFactor& factor, std::span<const std::uint32_t> first_rows);
  /// First of the three columns of a vertex, or −1.
  [[nodiscard]] std::int32_t column_of(std::uint32_t first_row) const {
    return first_row < column_of_row_.size() ? column_of_row_[first_row] : -1;
  }
  /// C0 [m/N] between ready columns; larger than their number.
  [[nodiscard]] const Eigen::MatrixXd& compliance() const { return gram_; }
  /// The factor's rows that columns are packed to.
  [[nodiscard]] const std::vector<std::uint32_t>& rows() const { return rows_; }
  /// C0 between the ready columns and others: `packed` holds L⁻¹ P of those at `rows()`, |rows()|×k.
  /// @return a row for each ready column
  template <class Matrix>
  [[nodiscard]] Matrix against(const Matrix& packed) const;

 private:
  struct Chunk {
    Eigen::Index first;       // its first column among all
    Eigen::MatrixXd columns;  // on the rows there were when it was made
    Eigen::MatrixXf single;   // the same
    [[nodiscard]] const Eigen::MatrixXd& in(double) const { return columns; }
    [[nodiscard]] const Eigen::MatrixXf& in(float) const { return single; }
  };
  Eigen::MatrixXd solve(const SparseFactor& factor, std::span<const std::uint32_t> fresh,
                        std::span<const std::uint32_t> path);
  void extend_compliance(const Chunk& fresh);

  std::vector<std::int32_t> place_of_row_;   // of every row of the factor, in rows_, or −1
  std::vector<std::int32_t> column_of_row_;  // of every row of the factor that is a vertex's first, or −1
  std::vector<std::uint32_t> rows_;
  std::vector<Chunk> chunks_;
  Eigen::Index count_ = 0;
  Eigen::MatrixXd gram_;
  std::vector<double> solved_, work_;
};

/// The factored Â of one moment.
struct WarpedBase {
  std::shared_ptr<const BasePattern> shared;
  std::shared_ptr<const FactorPattern> pattern;
  SparseFactor factor;
  FloatFactor single;
  CompactFactor compact;
  std::vector<std::int32_t> row_of_slot;             ///< first row in the factor's order; −1 for fixed vertices
  std::vector<Eigen::Quaterniond> rotation_of_slot;  ///< of the vertices then
  ReadyColumns ready;
};
std::unique_ptr<WarpedBase> make_base(const BaseRequest& request);

/// Mean rotation of each vertex's tets; n.
std::vector<Eigen::Quaterniond> vertex_rotations(const VertexTets& around, std::span<const Eigen::Quaterniond> of_tets);

/// A contact's rows: frameᵀ Σ w x.
struct ContactRows {
  std::array<VertexId, 6> vertices;
  std::array<double, 6> weights;
  std::size_t count = 0;
  Mat3 frame;  ///< columns: normal, two tangents
};

/// Follows the mesh through edits from the moment its base was asked for; can answer once the base is there. A linear
/// model of the tissue: C' = Q (C0 − C0_:T K C0_T:) Qᵀ, with Q the rotations of the vertices since then, T the vertices
/// that edits touched, and K = Δ (I + C0_TT Δ)⁻¹ for the change Δ of Â on them [Hager1989]. Rows are called slots: the
/// vertices of the mesh that the base was asked for, and after them those that came later.
class WarpedCompliance {
 public:
  explicit WarpedCompliance(const BaseRequest& request);
  void set_base(std::unique_ptr<WarpedBase> base);
  [[nodiscard]] bool has_base() const { return base_ != nullptr; }
  [[nodiscard]] const WarpedBase& base() const { return *base_; }

  /// Takes in an edit, which `remap` describes, or with the identity a change of stiffness.
  void follow(const std::vector<ElementChange>& changes, const Remap& remap);
  /// Takes in the springs of this step: whatever differs from those it knows.
  void set_springs(std::span<const Spring> springs);
  /// First rows of the slots that edits have touched, for ReadyColumns::add on another thread.
  [[nodiscard]] std::vector<std::uint32_t> touched_rows(const WarpedBase& base) const;
  /// Makes the next answers right after `follow`, `set_springs` or `set_base`.
  void settle();
  /// Rotations of the vertices now (n); before `apply` and `delassus`, each step.
  void turn(std::span<const Eigen::Quaterniond> vertex_rotations);

  /// x = C' f; n each. As a preconditioner it may be off by some thousandths, else by what single precision leaves.
  enum class Use : std::uint8_t { preconditioner, answer };
  void apply(std::span<const Vec3> f, std::span<Vec3> x, Use use = Use::answer);
  /// W = J C' Jᵀ [m/N] of k contacts, 3k×3k, normal first.
  [[nodiscard]] Eigen::MatrixXd delassus(std::span<const ContactRows> contacts);

  /// Parts that nothing joins any more share rounding: they hung together when the base was asked for.
  [[nodiscard]] bool mixes_parts() const { return mixes_parts_; }
  /// The corrections cancel more digits than single precision has.
  [[nodiscard]] bool needs_double() const { return precision_ == Precision::twice; }
  [[nodiscard]] std::size_t touched() const { return touched_.size(); }
  /// Slots that the next `settle` takes in.
  [[nodiscard]] std::size_t pending() const { return pending_.slots.size(); }

 private:
  struct SpringEntry {
    std::uint32_t a, b;  // slots; b none: to a place
    Mat3 stiffness;      // in the frame of the base
    friend bool operator==(const SpringEntry&, const SpringEntry&) = default;
  };
  struct Change {  // what one settle has to take in
    std::vector<std::uint32_t> slots;
    std::vector<std::int32_t> place;  // of each slot in `slots`, or −1
    struct Block {
      std::uint32_t a, b;  // slots
      Mat3 value;
      bool leaves;  // what the sum loses; `value` is negative
    };
    std::vector<Block> blocks;
    void add(std::uint32_t a, std::uint32_t b, const Mat3& value, bool leaves = false);
    [[nodiscard]] Eigen::MatrixXd sum(double kept) const;  // δ; of what leaves, this share stays
  };
  void add_slots(const Remap& remap);
  [[nodiscard]] SpringEntry entry_of(const Spring& spring) const;
  void add_spring(const SpringEntry& spring, double sign);
  [[nodiscard]] bool free(std::uint32_t slot) const { return !fixed_[slot]; }
  [[nodiscard]] const Eigen::Quaterniond& base_rotation(std::uint32_t slot) const;
  [[nodiscard]] Eigen::MatrixXd base_block(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const;
  [[nodiscard]] Eigen::MatrixXd middle(const Eigen::MatrixXd& compliance);
  /// What `apply` needs, in single or double precision.
  template <class Real>
  struct Solver {
    std::vector<Real> x, held, work;  // in the factor's order: L⁻¹ P f, L⁻¹ P K C0_T: f
    Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> correction;  // K
    Eigen::Matrix<Real, Eigen::Dynamic, 1> at_touched, answer;
  };
  void gather_touched();
  template <class Real>
  void hold(Solver<Real>& solver, std::span<const Vec3> f) const;
  template <class Real, class Factor>
  void apply_with(Solver<Real>& solver, const Factor& factor, std::span<const Vec3> f, std::span<Vec3> x) const;
  template <class Real>
  struct Spread {
    std::vector<Real> columns;  // L⁻¹ P Jᵀ of `delassus`, a column after another
    std::vector<std::vector<Real>> work;
  };
  template <class Visit>
  void each_base_vertex(const ContactRows& contact, const Visit& visit) const;
  [[nodiscard]] std::vector<std::uint32_t> path_of(std::span<const ContactRows> contacts) const;
  template <class Real, class Factor>
  void spread_contacts(Spread<Real>& spread, const Factor& factor, std::span<const ContactRows> contacts);
  template <class Real>
  [[nodiscard]] Eigen::MatrixXd touched_by(const Spread<Real>& spread, std::span<const ContactRows> contacts) const;
  template <class Real, class Factor>
  [[nodiscard]] Eigen::MatrixXd delassus_with(Spread<Real>& spread, const Factor& factor,
                                              std::span<const ContactRows> contacts);
  void add_later_slots(std::span<const ContactRows> contacts, Eigen::MatrixXd& w) const;

  double own_stiffness_ = 1;   // σ of slots that came later, or died
  double damping_factor_ = 0;  // 1/h
  std::unique_ptr<WarpedBase> base_;
  std::size_t base_slots_ = 0;
  std::vector<std::uint8_t> fixed_;    // slots
  std::vector<std::uint32_t> origin_;  // slots: themselves, or the slot of the base whose rotation a later one has
  std::vector<std::uint32_t> slot_of_vertex_;      // current vertices
  std::vector<Eigen::Quaterniond> tet_rotation_;   // current tets: what they have in the base
  std::vector<Eigen::Quaterniond> slot_rotation_;  // slots of the base
  std::vector<SpringEntry> springs_;               // as the base and the changes know them
  Change pending_;
  std::vector<std::uint32_t> touched_;  // T, slots
  std::vector<std::int32_t> place_;     // of each slot in T, or −1
  Eigen::MatrixXd correction_;          // K, 3|T|×3|T|
  bool mixes_parts_ = false;
  // What the corrections on this base need so far; digits that they cancel must be there.
  enum class Precision : std::uint8_t { compact, single, twice } precision_ = Precision::compact;
  Solver<float> single_;
  Solver<double> double_;
  std::vector<std::uint32_t> touched_path_;  // supernodes that L⁻¹ P of T reaches

  std::vector<Mat3> turn_;  // n, base frame → now
  Spread<float> spread_single_;
  Spread<double> spread_double_;
  std::vector<std::uint32_t> path_;            // supernodes where L⁻¹ P Jᵀ isn't zero
  std::vector<std::uint32_t> vertex_of_slot_;  // slots, or none where dead
};

}  // namespace calot
