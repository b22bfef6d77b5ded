// The compliance of a model, kept exact through any number of cuts.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calot/base/progress.h"
#include "calot/compliance/displacements.h"
#include "calot/compliance/full_compliance.h"
#include "calot/fem/model.h"

namespace calot {

class SparseFactor;

enum class Backend {
  dense,   ///< the whole matrix C in memory: any block at once
  sparse,  ///< the Cholesky factor of Â: columns on demand, small and quick to rebuild
};

struct PrecomputeOptions {
  Backend backend = Backend::dense;
};

/// What an update found.
struct UpdateReport {
  std::size_t rank = 0;    ///< struck and touched free degrees of freedom: the size of the correction
  bool refreshed = false;  ///< the update would have kept few digits, so Â was factored anew; a dense home answers from
                           ///< that factor, slower, until it is folded
  double smallest_eigenvalue =
      1;  ///< estimate, of the condensed stiffness against the uncut one: 1 costs no digits, 1e-6 costs six
};

/// C = Â⁻¹ [m/N] of a model and of everything it is cut into. Queries use the numbers of the current mesh.
class Compliance {
 public:
  Compliance(Compliance&&) noexcept;
  Compliance& operator=(Compliance&&) noexcept;
  ~Compliance();

  [[nodiscard]] Backend backend() const;
  [[nodiscard]] std::size_t vertex_count() const;  ///< of the current mesh

  /// C_IJ as it stands, pending corrections included; usable at once after an update, not refined.
  /// @return |rows|×|columns| [m/N]
  [[nodiscard]] Eigen::MatrixXd block(std::span<const DofId> rows, std::span<const DofId> columns) const;
  /// Whole columns of C, refined once with the sparse Â: 3n×k [m/N]. Source: DESIGN: X += C(B − ÂX).
  [[nodiscard]] Eigen::MatrixXd columns(std::span<const DofId> columns) const;
  /// u = C f, refined once. Forces on fixed vertices do nothing. Throws InputError for a vertex out of range.
  [[nodiscard]] Displacements solve(const std::vector<PointForce>& forces) const;
  /// X = C F, F 3n×k [N], refined `refinements` times.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& forces, int refinements = 1) const;

  /// Takes in a change of the model, exactly; the answer is usable at once. Work left for `fold` grows with the rank.
  /// Throws Unsupported (static models only) when a part can move freely; nothing has changed then.
  UpdateReport update(const StiffnessChange& change);
  /// Degrees of freedom that wait to be folded; 0 when none. All of them after an update that had to factor anew.
  [[nodiscard]] std::size_t pending_rank() const;
  /// Folds pending corrections in: into the matrix (dense) or by factoring anew (sparse). Blocks until done.
  void fold();
  /// Takes the memory that a fold of a dense compliance writes to, a second matrix, so that the first fold need not
  /// wait for it. Throws FailedError if there is too little.
  void reserve_fold();
  /// Starts the same on a background thread; queries and updates go on meanwhile. Does nothing when one is under way.
  void start_fold();
  [[nodiscard]] bool fold_ready() const;  ///< a started fold is done and waits for `adopt_fold`
  /// Waits for a started fold and swaps its result in; call it at a fixed step, never "when ready".
  void adopt_fold();
  /// Computes C anew from the current Â, dropping all accumulated rounding.
  void refresh(Progress* progress = nullptr);

  /// ‖Â(Cz) − z‖/‖z‖ for a pseudo-random z from `seed`, zero on fixed dofs: how far C has drifted.
  [[nodiscard]] double probe(std::uint64_t seed = 1) const;
  /// 1-norm condition number of the current Â: exact ‖Â‖₁ times an estimate of ‖C‖₁ (Higham & Tisseur 2000).
  [[nodiscard]] double condition() const;
  [[nodiscard]] std::uint64_t bytes() const;            ///< memory held
  [[nodiscard]] std::uint64_t factor_nonzeros() const;  ///< of the sparse factor; 0 for dense

  /// Three rows of C for each of `count` vertices from `first`, 3n values a row, row-major; pending corrections must
  /// have been folded. For writing files.
  void copy_rows(VertexId first, std::size_t count, double* out) const;
  [[nodiscard]] FullCompliance full() const;

  /// Builds a dense compliance from rows read elsewhere: `read(first, count, rows)` fills 3·count rows of 3n values.
  static Compliance from_rows(const Model& model, const std::function<void(VertexId, std::size_t, double*)>& read);

  /// The sparse factor; nullptr for dense. Pending corrections must have been folded. For writing files.
  [[nodiscard]] const SparseFactor* factor() const;
  /// The model's free vertices in the order that active vertices of a factor are numbered; |factor vertices|.
  [[nodiscard]] std::vector<VertexId> factor_vertices() const;
  /// Builds a sparse compliance around a factor read elsewhere. Throws InputError if it is not of the model's size, or
  /// not its factor (by the drift probe).
  static Compliance from_factor(const Model& model, SparseFactor factor);

  struct Impl;
  explicit Compliance(std::unique_ptr<Impl> impl);
  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Computes the compliance of a model. Throws FailedError, before allocating, if memory will not do; Unsupported for a
/// static model with a part that can move; Interrupted.
Compliance precompute(const Model& model, const PrecomputeOptions& options = {}, Progress* progress = nullptr);

/// Peak bytes that `precompute` will need beyond what the process holds now (an upper estimate for sparse).
std::uint64_t precompute_memory(const Model& model, const PrecomputeOptions& options);

}  // namespace calot
