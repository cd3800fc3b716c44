// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of inference against the standard library in double, for every instruction set that this processor
// has.
#include "Core/Common/InstructionSet.h"
#include "Inference/Common/ActivationKernels.h"
#include "Inference/Common/MatrixProduct.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{

struct Variant
{
  std::string Name;
  const ActivationKernels* Kernels;
};

void PrintTo(const Variant& variant, std::ostream* stream) { *stream << variant.Name; }

std::vector<Variant> Variants()
{
  std::vector<Variant> variants = { { "Generic", &GenericActivationKernels }, { "Best", &BestActivationKernels() } };
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
  {
    variants.push_back({ "Avx2", &Avx2ActivationKernels });
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
  {
    variants.push_back({ "Avx512", &Avx512ActivationKernels });
  }
#endif
  return variants;
}

double Gelu(double x) { return 0.5 * x * std::erfc(-x / std::sqrt(2.0)); }

/// Numbers of all sizes up to @p largest, both signs, and zero.
std::vector<float> Numbers(float largest)
{
  std::vector<float> numbers = { 0.0F, -0.0F };
  for (int k = -20000; k <= 20000; ++k)
  {
    numbers.push_back(largest * static_cast<float>(k) / 20000.0F);
  }
  for (float x = largest; x > 1e-30F; x *= 0.83F)
  {
    numbers.push_back(x);
    numbers.push_back(-x);
  }
  return numbers;
}

/// | found - exact | <= limit max(1, | exact |)
void ExpectClose(double found, double exact, double limit, double x)
{
  EXPECT_LE(std::abs(found - exact), limit * std::max(1.0, std::abs(exact))) << "at " << x;
}

class ActivationKernelsOf : public testing::TestWithParam<Variant>
{
protected:
  const ActivationKernels& Kernels = *GetParam().Kernels;
};

INSTANTIATE_TEST_SUITE_P(
  InstructionSet, ActivationKernelsOf, testing::ValuesIn(Variants()), [](const auto& info) { return info.param.Name; });

} // namespace

TEST_P(ActivationKernelsOf, Gelu)
{
  for (const float largest : { 1.0F, 6.0F, 40.0F, 1e6F })
  {
    const std::vector<float> numbers = Numbers(largest);
    const std::vector<float> bias(numbers.size(), 0.0F);
    std::vector<float> values = numbers;
    this->Kernels.BiasGelu(values.data(), bias.data(), 1, static_cast<std::int64_t>(values.size()));
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      ExpectClose(values[k], Gelu(numbers[k]), 1e-6, numbers[k]);
    }
  }
}

TEST_P(ActivationKernelsOf, BiasesAreThoseOfTheColumns)
{
  std::vector<float> values = { 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F };
  const float bias[3] = { 10.0F, 20.0F, 30.0F };
  this->Kernels.BiasGelu(values.data(), bias, 2, 3);
  EXPECT_EQ(values, (std::vector<float>{ 11.0F, 22.0F, 33.0F, 14.0F, 25.0F, 36.0F }));
}

TEST_P(ActivationKernelsOf, ModulationTurnsAndScales)
{
  for (const float largest : { 1.0F, 20.0F, 100.0F, 30000.0F })
  {
    const std::vector<float> phases = Numbers(largest);
    const auto width = static_cast<std::int64_t>(phases.size());
    std::vector<float> both = phases;                   // one row: phases, then scales
    both.insert(both.end(), phases.size(), 0.5413249F); // softplus of it is 1
    const std::vector<float> bias(both.size(), 0.0F);
    std::vector<float> re(phases.size(), 1.0F);
    std::vector<float> im(phases.size(), 0.0F);
    std::vector<float> sum(phases.size());
    this->Kernels.Modulate(both.data(), bias.data(), 1, width, re.data(), im.data(), sum.data());
    for (std::size_t k = 0; k < phases.size(); ++k)
    {
      ExpectClose(re[k], std::cos(static_cast<double>(phases[k])), 1e-6, phases[k]);
      ExpectClose(im[k], std::sin(static_cast<double>(phases[k])), 1e-6, phases[k]);
      EXPECT_EQ(sum[k], re[k] + im[k]);
    }
  }
}

TEST_P(ActivationKernelsOf, SoftplusIsAccurateWhereItIsTiny)
{
  for (const float largest : { 1.0F, 80.0F })
  {
    const std::vector<float> scales = Numbers(largest);
    const auto width = static_cast<std::int64_t>(scales.size());
    std::vector<float> both(scales.size(), 0.0F);
    both.insert(both.end(), scales.begin(), scales.end());
    const std::vector<float> bias(both.size(), 0.0F);
    std::vector<float> re(scales.size(), 1.0F);
    std::vector<float> im(scales.size(), -1.0F);
    std::vector<float> sum(scales.size());
    this->Kernels.Modulate(both.data(), bias.data(), 1, width, re.data(), im.data(), sum.data());
    for (std::size_t k = 0; k < scales.size(); ++k)
    {
      const double x = scales[k];
      const double exact = std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))) + 1e-8;
      EXPECT_LE(std::abs(re[k] - exact), 1e-6 * exact) << x;
      EXPECT_LE(std::abs(im[k] + exact), 1e-6 * exact) << x;
    }
  }
}

TEST_P(ActivationKernelsOf, ComplexGelu)
{
  const std::vector<float> a = Numbers(5.0F);
  const auto width = static_cast<std::int64_t>(a.size());
  std::vector<float> b(a.rbegin(), a.rend());
  std::vector<float> c(a.size());
  std::vector<float> bias(a.size());
  for (std::size_t k = 0; k < a.size(); ++k)
  {
    c[k] = std::sin(static_cast<float>(k));
    bias[k] = std::cos(static_cast<float>(k));
  }
  std::vector<float> re(a.size());
  std::vector<float> im(a.size());
  std::vector<float> sum(a.size());
  this->Kernels.ComplexGelu(a.data(), b.data(), c.data(), bias.data(), 1, width, re.data(), im.data(), sum.data());
  for (std::size_t k = 0; k < a.size(); ++k)
  {
    const double x = static_cast<double>(a[k]) - static_cast<double>(c[k]);
    const double y = static_cast<double>(a[k]) + static_cast<double>(b[k]);
    const double r = std::sqrt(x * x + y * y + 1e-8);
    const double factor = Gelu(r + static_cast<double>(bias[k])) / (r + 1e-8);
    ExpectClose(re[k], x * factor, 1e-6, x);
    ExpectClose(im[k], y * factor, 1e-6, y);
    ExpectClose(sum[k], (x + y) * factor, 2e-6, x);
  }
}

TEST_P(ActivationKernelsOf, Tanh)
{
  for (const float largest : { 1.0F, 20.0F, 1e4F })
  {
    const std::vector<float> numbers = Numbers(largest);
    const std::vector<float> scale(numbers.size(), 1.5F);
    std::vector<float> values = numbers;
    this->Kernels.ScaledTanh(values.data(), scale.data(), 1, static_cast<std::int64_t>(values.size()));
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      ExpectClose(values[k], std::tanh(1.5 * static_cast<double>(numbers[k])), 1e-6, numbers[k]);
    }
  }
}

TEST_P(ActivationKernelsOf, GatherAndScatterOfTwoFaces)
{
  // Two channels, four vertices, faces (0, 1, 2) and (3, 2, 1).
  const float signal[8] = { 1.0F, 10.0F, 2.0F, 20.0F, 4.0F, 40.0F, 8.0F, 80.0F };
  const std::int32_t corners[6] = { 0, 1, 2, 3, 2, 1 };
  const float basisGradients[12] = { 1.0F, 2.0F, 3.0F, -1.0F, 0.5F, 1.0F, 0.0F, 1.0F, 0.0F, 2.0F, 0.0F, 0.0F };
  float re[4];
  float im[4];
  this->Kernels.FaceGradient(signal, corners, basisGradients, 2, 2, re, im);
  EXPECT_EQ(re[0], 17.0F); // 1 + 4 + 12
  EXPECT_EQ(re[1], 170.0F);
  EXPECT_EQ(im[0], 4.0F); // -1 + 1 + 4
  EXPECT_EQ(re[2], 4.0F);
  EXPECT_EQ(im[3], 160.0F);

  float mean[4];
  this->Kernels.FaceMeanGelu(signal, corners, 2, 2, mean);
  EXPECT_NEAR(mean[0], Gelu(7.0 / 3.0), 2e-6);
  EXPECT_NEAR(mean[3], 140.0 / 3.0, 1e-4);

  const float areas[2] = { 3.0F, 6.0F };
  float along[8] = {};
  float across[8] = {};
  this->Kernels.ScatterDivergence(re, im, corners, basisGradients, areas, 2, 2, along, across);
  // Vertex 1: face 0 with basis gradients (2, 0.5), face 1 with (0, 0). Vertex 2: face 0 (3, 1), face 1 (1, 0).
  EXPECT_EQ(along[2], 3.0F * (2.0F * 17.0F + 0.5F * 4.0F));
  EXPECT_EQ(across[2], 3.0F * (0.5F * 17.0F - 2.0F * 4.0F));
  EXPECT_EQ(along[4], 3.0F * (3.0F * 17.0F + 4.0F) + 6.0F * 4.0F);
  EXPECT_EQ(across[4], 3.0F * (17.0F - 3.0F * 4.0F) - 6.0F * 16.0F);

  // With products (1, 0, 0) the mapped features are 1 + i.
  const float ones[4] = { 1.0F, 1.0F, 1.0F, 1.0F };
  const float zeros[4] = {};
  float dots[8] = {};
  this->Kernels.ScatterDots(ones, zeros, zeros, re, im, corners, areas, 2, 2, dots);
  EXPECT_NEAR(dots[0], 21.0F, 1e-5);
  EXPECT_NEAR(dots[2], 21.0F + 2.0F * 20.0F, 1e-4);
  EXPECT_NEAR(dots[6], 40.0F, 1e-4);
}

TEST(MatrixProduct, IsRowMajorAndAccumulates)
{
  const float a[6] = { 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F };  // [2, 3]
  const float b[12] = { 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1 }; // [3, 4]
  float c[8];
  Multiply(a, b, c, 2, 3, 4);
  EXPECT_EQ(std::vector<float>(c, c + 8), (std::vector<float>{ 1, 2, 3, 6, 4, 5, 6, 15 }));
  Multiply(a, b, c, 2, 3, 4, true);
  EXPECT_EQ(std::vector<float>(c, c + 8), (std::vector<float>{ 2, 4, 6, 12, 8, 10, 12, 30 }));
}

/// Products of blocks of larger matrices in cache are those of double precision, whatever the shapes.
TEST(MatrixProduct, InCacheIsTheProduct)
{
  const InstructionSet before = CurrentInstructionSet();
  const auto number = [](std::int64_t k) { return static_cast<float>(std::sin(12.9898 * static_cast<double>(k + 1))); };
  for (const InstructionSet set : { InstructionSet::Generic, InstructionSet::Avx2, InstructionSet::Avx512 })
  {
    if (!HasInstructionSet(set))
    {
      continue;
    }
    SetInstructionSet(set);
    for (const std::int64_t rows : { 1, 5, 6, 19 })
    {
      for (const std::int64_t columns : { 3, 16, 40, 77, 128 })
      {
        for (int transposed = 0; transposed < 4; ++transposed)
        {
          const bool a = (transposed & 1) != 0;
          const bool b = (transposed & 2) != 0;
          const std::int64_t inner = 9;
          const std::int64_t stride = 131; // of both factors and the result
          std::vector<float> left(20 * stride);
          std::vector<float> right(129 * stride);
          for (std::size_t k = 0; k < right.size(); ++k)
          {
            right[k] = number(static_cast<std::int64_t>(k));
            left[k % left.size()] = number(static_cast<std::int64_t>(7 * k));
          }
          std::vector<float> product(20 * stride, 1.0F);
          MultiplyInCache(
            { left.data(), stride, a }, { right.data(), stride, b }, product.data(), stride, rows, inner, columns);
          MultiplyInCache({ left.data(), stride, a }, { right.data(), stride, b }, product.data(), stride, rows, inner,
            columns, true);
          for (std::int64_t k = 0; k < 20 * stride; ++k)
          {
            const std::int64_t i = k / stride;
            const std::int64_t j = k % stride;
            double expected = 1.0; // beside the product nothing is written
            for (std::int64_t l = 0; i < rows && j < columns && l < inner; ++l)
            {
              const float factor = left[static_cast<std::size_t>(a ? l * stride + i : i * stride + l)];
              const float other = right[static_cast<std::size_t>(b ? j * stride + l : l * stride + j)];
              expected += 2.0 * static_cast<double>(factor) * static_cast<double>(other) - (l == 0 ? 1.0 : 0.0);
            }
            ASSERT_NEAR(product[static_cast<std::size_t>(k)], expected, 1e-5) << rows << " x " << columns;
          }
        }
      }
    }
  }
  SetInstructionSet(before);
}
