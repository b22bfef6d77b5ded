#include "calot/compliance/blas.h"

#include <cblas.h>

#include <mutex>

#include "calot/base/memory.h"
#include "calot/base/parallel.h"

extern "C" {
char* openblas_get_corename(void);
char* openblas_get_config(void);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
void dtrtri_(const char* uplo, const char* diag, const int* n, double* a, const int* lda, int* info, std::size_t,
             std::size_t);
void dlauum_(const char* uplo, const int* n, double* a, const int* lda, int* info, std::size_t);
}

namespace calot::blas {
namespace {
int as_int(std::size_t n) {
  return static_cast<int>(n);
}
CBLAS_TRANSPOSE transpose(char op) {
  return op == 'T' ? CblasTrans : CblasNoTrans;
}
}  // namespace

void use_one_thread() {
  static std::once_flag once;
  std::call_once(once, [] {
    // OpenBLAS maps work space for each thread and, refused, tries again for ever; so it is asked for here first.
    require_memory((std::uint64_t{128} << 20) * static_cast<std::uint64_t>(thread_count()),
                   "the work space of OpenBLAS");
    openblas_set_num_threads(1);
  });
}

void set_threads(int count) {
  use_one_thread();
  openblas_set_num_threads(count);
}

std::string kernel_name() {
  std::string config = openblas_get_config();
  return std::string(openblas_get_corename()) + " (" + config.substr(0, config.find(' ', 9)) + ")";
}

void gemm(char op_a, char op_b, std::size_t m, std::size_t n, std::size_t k, double alpha, const double* a,
          std::size_t lda, const double* b, std::size_t ldb, double beta, double* c, std::size_t ldc) {
  if (m == 0 || n == 0) return;
  cblas_dgemm(CblasColMajor, transpose(op_a), transpose(op_b), as_int(m), as_int(n), as_int(k), alpha, a, as_int(lda),
              b, as_int(ldb), beta, c, as_int(ldc));
}

void syrk(char op, std::size_t n, std::size_t k, double alpha, const double* a, std::size_t lda, double beta, double* c,
          std::size_t ldc) {
  if (n == 0) return;
  cblas_dsyrk(CblasColMajor, CblasLower, transpose(op), as_int(n), as_int(k), alpha, a, as_int(lda), beta, c,
              as_int(ldc));
}

void trsm(char side, char op, std::size_t m, std::size_t n, double alpha, const double* l, std::size_t ldl, double* b,
          std::size_t ldb) {
  if (m == 0 || n == 0) return;
  cblas_dtrsm(CblasColMajor, side == 'L' ? CblasLeft : CblasRight, CblasLower, transpose(op), CblasNonUnit, as_int(m),
              as_int(n), alpha, l, as_int(ldl), b, as_int(ldb));
}

void gemm(char op_a, char op_b, std::size_t m, std::size_t n, std::size_t k, float alpha, const float* a,
          std::size_t lda, const float* b, std::size_t ldb, float beta, float* c, std::size_t ldc) {
  if (m == 0 || n == 0) return;
  cblas_sgemm(CblasColMajor, transpose(op_a), transpose(op_b), as_int(m), as_int(n), as_int(k), alpha, a, as_int(lda),
              b, as_int(ldb), beta, c, as_int(ldc));
}

void trsm(char side, char op, std::size_t m, std::size_t n, float alpha, const float* l, std::size_t ldl, float* b,
          std::size_t ldb) {
  if (m == 0 || n == 0) return;
  cblas_strsm(CblasColMajor, side == 'L' ? CblasLeft : CblasRight, CblasLower, transpose(op), CblasNonUnit, as_int(m),
              as_int(n), alpha, l, as_int(ldl), b, as_int(ldb));
}

void trsv(char op, std::size_t n, const double* l, std::size_t ldl, double* x) {
  if (n == 0) return;
  cblas_dtrsv(CblasColMajor, CblasLower, transpose(op), CblasNonUnit, as_int(n), l, as_int(ldl), x, 1);
}

void gemv(char op, std::size_t m, std::size_t n, const double* a, std::size_t lda, const double* x, double* y) {
  if (m == 0 || n == 0) return;
  cblas_dgemv(CblasColMajor, transpose(op), as_int(m), as_int(n), 1, a, as_int(lda), x, 1, 0, y, 1);
}

void gemv(char op, std::size_t m, std::size_t n, const float* a, std::size_t lda, const float* x, float* y) {
  if (m == 0 || n == 0) return;
  cblas_sgemv(CblasColMajor, transpose(op), as_int(m), as_int(n), 1, a, as_int(lda), x, 1, 0, y, 1);
}

int potrf(std::size_t n, double* a, std::size_t lda) {
  const int size = as_int(n), ld = as_int(lda);
  int info = 0;
  if (n > 0) dpotrf_("L", &size, a, &ld, &info, 1);
  return info;
}

void trtri(std::size_t n, double* l, std::size_t ldl) {
  const int size = as_int(n), ld = as_int(ldl);
  int info = 0;
  if (n > 0) dtrtri_("L", "N", &size, l, &ld, &info, 1, 1);
}

void lauum(std::size_t n, double* l, std::size_t ldl) {
  const int size = as_int(n), ld = as_int(ldl);
  int info = 0;
  if (n > 0) dlauum_("L", &size, l, &ld, &info, 1);
}

int potri(std::size_t n, double* a, std::size_t lda) {
  const int size = as_int(n), ld = as_int(lda);
  int info = 0;
  dpotri_("L", &size, a, &ld, &info, 1);
  return info;
}

}  // namespace calot::blas
