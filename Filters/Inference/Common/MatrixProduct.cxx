// SPDX-License-Identifier: BSD-3-Clause
#include "Inference/Common/MatrixProduct.h"

#include "Inference/Common/ProductKernels.h"

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
  MultiplyBlocks({ a, inner }, { b, columns }, c, columns, rows, inner, columns, accumulate);
}

void MultiplyInCache(const MatrixBlock& a, const MatrixBlock& b, float* c, std::int64_t stride, std::int64_t rows,
  std::int64_t inner, std::int64_t columns, bool accumulate)
{
  const ProductKernels* kernels = b.Transposed ? nullptr : BestProductKernels();
  const std::int64_t whole = kernels ? columns / kernels->Lanes * kernels->Lanes : 0;
  if (whole > 0)
  {
    kernels->Multiply({ a.Data, a.Transposed ? 1 : a.Stride, a.Transposed ? a.Stride : 1, b.Data, b.Stride, c, stride,
      rows, inner, whole, accumulate });
  }
  if (whole < columns)
  {
    const MatrixBlock rest = { b.Transposed ? b.Data : b.Data + whole, b.Stride, b.Transposed };
    MultiplyBlocks(a, rest, c + whole, stride, rows, inner, columns - whole, accumulate);
  }
}

#ifdef SURFACE_SYNTHESIS_BLAS
void MultiplyBlocks(const MatrixBlock& a, const MatrixBlock& b, float* c, std::int64_t stride, std::int64_t rows,
  std::int64_t inner, std::int64_t columns, bool accumulate)
{
  // Row-major matrices are the transposes of column-major ones: c^T = b^T a^T.
  const int m = static_cast<int>(columns);
  const int n = static_cast<int>(rows);
  const int k = static_cast<int>(inner);
  const int strideA = static_cast<int>(a.Stride);
  const int strideB = static_cast<int>(b.Stride);
  const int strideC = static_cast<int>(stride);
  const float one = 1.0F;
  const float beta = accumulate ? 1.0F : 0.0F;
  sgemm_(b.Transposed ? "T" : "N", a.Transposed ? "T" : "N", &m, &n, &k, &one, b.Data, &strideB, a.Data, &strideA,
    &beta, c, &strideC);
}
#else
namespace
{
using ProductMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using FactorMap = Eigen::Map<const ProductMatrix, 0, Eigen::OuterStride<>>;
using ProductMap = Eigen::Map<ProductMatrix, 0, Eigen::OuterStride<>>;

/// The matrix in memory of a factor [rows, columns].
FactorMap InMemory(const MatrixBlock& block, std::int64_t rows, std::int64_t columns)
{
  return FactorMap(block.Data, block.Transposed ? columns : rows, block.Transposed ? rows : columns,
    Eigen::OuterStride<>(block.Stride));
}

template <typename Left, typename Right>
void Assign(const Left& a, const Right& b, ProductMap& c, bool accumulate)
{
  if (accumulate)
  {
    c.noalias() += a * b;
  }
  else
  {
    c.noalias() = a * b;
  }
}
} // namespace

void MultiplyBlocks(const MatrixBlock& a, const MatrixBlock& b, float* c, std::int64_t stride, std::int64_t rows,
  std::int64_t inner, std::int64_t columns, bool accumulate)
{
  const FactorMap left = InMemory(a, rows, inner);
  const FactorMap right = InMemory(b, inner, columns);
  ProductMap product(c, rows, columns, Eigen::OuterStride<>(stride));
  if (a.Transposed && b.Transposed)
  {
    Assign(left.transpose(), right.transpose(), product, accumulate);
  }
  else if (a.Transposed)
  {
    Assign(left.transpose(), right, product, accumulate);
  }
  else if (b.Transposed)
  {
    Assign(left, right.transpose(), product, accumulate);
  }
  else
  {
    Assign(left, right, product, accumulate);
  }
}
#endif

} // namespace surfsynth
