// The few BLAS and LAPACK calls Calot makes: column-major, one thread each (parallelism is ours, so that the bits do
// not depend on the number of threads).
#pragma once
#include <cstddef>
#include <string>

namespace calot::blas {

/// Must be in force before any call; the first factor or matrix of a process sees to it.
void use_one_thread();
/// For measuring LAPACK against us only: threads inside each call.
void set_threads(int count);
/// The name of the kernel set that OpenBLAS chose for this processor, and its version.
std::string kernel_name();

/// C ← alpha·op(A) op(B) + beta·C; C m×n, inner dimension k. op is 'N' or 'T'.
void gemm(char op_a, char op_b, std::size_t m, std::size_t n, std::size_t k, double alpha, const double* a,
          std::size_t lda, const double* b, std::size_t ldb, double beta, double* c, std::size_t ldc);
/// Lower triangle of C ← alpha·op(A) op(A)ᵀ + beta·C; C n×n, inner dimension k. op 'N': A n×k, 'T': A k×n.
void syrk(char op, std::size_t n, std::size_t k, double alpha, const double* a, std::size_t lda, double beta, double* c,
          std::size_t ldc);
/// B ← alpha·op(L)⁻¹ B (side 'L') or alpha·B op(L)⁻¹ (side 'R'); L lower triangular, B m×n.
void trsm(char side, char op, std::size_t m, std::size_t n, double alpha, const double* l, std::size_t ldl, double* b,
          std::size_t ldb);
/// The same two in single precision.
void gemm(char op_a, char op_b, std::size_t m, std::size_t n, std::size_t k, float alpha, const float* a,
          std::size_t lda, const float* b, std::size_t ldb, float beta, float* c, std::size_t ldc);
void trsm(char side, char op, std::size_t m, std::size_t n, float alpha, const float* l, std::size_t ldl, float* b,
          std::size_t ldb);
/// x ← op(L)⁻¹ x for one vector.
void trsv(char op, std::size_t n, const double* l, std::size_t ldl, double* x);
/// y ← op(A) x; A m×n.
void gemv(char op, std::size_t m, std::size_t n, const double* a, std::size_t lda, const double* x, double* y);
void gemv(char op, std::size_t m, std::size_t n, const float* a, std::size_t lda, const float* x, float* y);
/// Cholesky of the lower triangle in place. @return 0, or the 1-based column whose pivot is not positive.
int potrf(std::size_t n, double* a, std::size_t lda);
/// L ← L⁻¹ in place, lower triangular.
void trtri(std::size_t n, double* l, std::size_t ldl);
/// Lower triangle of L ← LᵀL in place.
void lauum(std::size_t n, double* l, std::size_t ldl);
/// The inverse from a Cholesky factor, lower triangle, in place (LAPACK's own; the baseline we are measured against).
int potri(std::size_t n, double* a, std::size_t lda);

}  // namespace calot::blas
