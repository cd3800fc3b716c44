// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/MatrixProduct.h"

#ifdef SURFACE_SYNTHESIS_BLAS
extern "C" void sgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
  const float* alpha, const float* a, const int* lda, const float* b, const int* ldb, const float* beta, float* c,
  const int* ldc);
#else
#include <Eigen/Core>
#endif

namespace surfsynth
{

void Multiply(const float* a, const float* b, float* c, std::int64_t rows, std::int64_t inner, std::int64_t columns,
  bool accumulate)
{
#ifdef SURFACE_SYNTHESIS_BLAS
  // Row-major matrices are the transposes of column-major ones: c^T = b^T a^T.
  const int m = static_cast<int>(columns);
  const int n = static_cast<int>(rows);
  const int k = static_cast<int>(inner);
  const float one = 1.0F;
  const float beta = accumulate ? 1.0F : 0.0F;
  sgemm_("N", "N", &m, &n, &k, &one, b, &m, a, &k, &beta, c, &m);
#else
  using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Matrix> left(a, rows, inner);
  const Eigen::Map<const Matrix> right(b, inner, columns);
  Eigen::Map<Matrix> product(c, rows, columns);
  if (accumulate)
  {
    product.noalias() += left * right;
  }
  else
  {
    product.noalias() = left * right;
  }
#endif
}

} // namespace surfsynth
