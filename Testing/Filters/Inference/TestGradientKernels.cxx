// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of the training of PoissonNets for every instruction set that this processor has: derivatives against
// differences of the forward loops, transposes against inner products, and the sets against each other.
#include "Inference/PoissonNet/GradientKernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{
using Floats = std::vector<float>;

struct Variant
{
  std::string Name;
  const GradientKernels* Kernels;
};

void PrintTo(const Variant& variant, std::ostream* stream) { *stream << variant.Name; }

std::vector<Variant> Variants()
{
  std::vector<Variant> variants = { { "Generic", &GenericGradientKernels }, { "Best", &BestGradientKernels() } };
#ifdef SURFACE_SYNTHESIS_X86_KERNELS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
  {
    variants.push_back({ "Avx2", &Avx2GradientKernels });
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
  {
    variants.push_back({ "Avx512", &Avx512GradientKernels });
  }
#endif
  return variants;
}

constexpr std::int64_t Rows = 2;
constexpr std::int64_t Points = 4;
constexpr std::int64_t Width = 37; // whole vectors and a rest
constexpr std::size_t Signal = Points * Width;
constexpr std::size_t Plain = Rows * Width;
constexpr std::size_t Complex = 2 * Plain;

/// Numbers in [-scale, scale].
Floats Numbers(std::size_t count, int seed, float scale = 1.0F)
{
  Floats numbers(count);
  for (std::size_t k = 0; k < count; ++k)
  {
    numbers[k] = scale * static_cast<float>(std::sin(12.9898 * static_cast<double>(k + 1) + 78.233 * seed));
  }
  return numbers;
}

double Dot(const Floats& a, const Floats& b)
{
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k)
  {
    sum += static_cast<double>(a[k]) * static_cast<double>(b[k]);
  }
  return sum;
}

void ExpectNear(const Floats& found, const Floats& expected, double limit)
{
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k)
  {
    EXPECT_NEAR(found[k], expected[k], limit * (1.0 + std::abs(static_cast<double>(expected[k])))) << k;
  }
}

/// The derivative of <f(x), weights> along @p direction by central differences.
double Slope(
  const std::function<Floats(const Floats&)>& f, const Floats& x, const Floats& direction, const Floats& weights)
{
  constexpr float step = 1e-2F;
  const auto moved = [&](float by) {
    Floats y = x;
    for (std::size_t k = 0; k < y.size(); ++k)
    {
      y[k] += by * direction[k];
    }
    return Dot(f(y), weights);
  };
  // Fourth order: the step is large, because numbers are float32.
  return (8.0 * (moved(step) - moved(-step)) - (moved(2.0F * step) - moved(-2.0F * step))) /
    (12.0 * static_cast<double>(step));
}

class GradientKernelsOf : public testing::TestWithParam<Variant>
{
protected:
  const GradientKernels& Kernels = *this->GetParam().Kernels;
  const std::vector<std::int32_t> Corners = { 0, 1, 2, 2, 1, 3 };
  const Floats Gradients = Numbers(6 * Rows, 3);
  const Floats Areas = { 0.7F, 1.3F };
  const FaceRows Faces = { this->Corners.data(), this->Gradients.data(), this->Areas.data(), Rows };
};
} // namespace

TEST_P(GradientKernelsOf, GeluHasItsDerivative)
{
  const auto gelu = [&](const Floats& x) {
    Floats out(x.size());
    this->Kernels.Gelu(x.data(), static_cast<std::int64_t>(x.size()), out.data());
    return out;
  };
  const Floats x = Numbers(Complex, 1, 4.0F);
  const Floats values = gelu(x);
  for (std::size_t k = 0; k < x.size(); ++k)
  {
    const auto exact = static_cast<double>(x[k]);
    EXPECT_NEAR(values[k], 0.5 * exact * std::erfc(-exact / std::sqrt(2.0)), 2e-6);
  }
  const Floats direction = Numbers(Complex, 2);
  const Floats weights = Numbers(Complex, 3);
  Floats again(x.size());
  Floats slopes = x; // in place
  this->Kernels.GeluWithSlopes(slopes.data(), static_cast<std::int64_t>(x.size()), again.data(), slopes.data());
  ExpectNear(again, values, 1e-6);
  Floats gradient = weights;
  this->Kernels.Scale(slopes.data(), static_cast<std::int64_t>(x.size()), gradient.data());
  EXPECT_NEAR(Dot(gradient, direction), Slope(gelu, x, direction, weights), 1e-3);
}

TEST_P(GradientKernelsOf, ComplexGeluHasItsDerivatives)
{
  const Floats bias = Numbers(Width, 5);
  const auto evaluate = [&](const Floats& z, const Floats& b) {
    Floats out(Complex);
    this->Kernels.ComplexGelu(z.data(), b.data(), Rows, Width, out.data());
    return out;
  };
  const Floats z = Numbers(Complex, 1, 2.0F);
  const Floats out = evaluate(z, bias);
  const double x = z[0];
  const double y = z[Width];
  const double modulus = std::sqrt(x * x + y * y + 1e-8);
  const double sum = modulus + static_cast<double>(bias[0]);
  EXPECT_NEAR(out[0], x * 0.5 * sum * std::erfc(-sum / std::sqrt(2.0)) / modulus, 2e-6);
  const Floats weights = Numbers(Complex, 7);
  Floats gradient = weights;
  Floats byBias(Width, 1.0F);
  Floats again(Complex);
  Floats slopes(3 * Plain);
  this->Kernels.ComplexGeluWithSlopes(z.data(), bias.data(), Rows, Width, again.data(), slopes.data());
  ExpectNear(again, out, 1e-6);
  this->Kernels.ComplexGeluBackward(z.data(), slopes.data(), Rows, Width, gradient.data(), byBias.data());
  const Floats direction = Numbers(Complex, 2);
  EXPECT_NEAR(
    Dot(gradient, direction), Slope([&](const Floats& at) { return evaluate(at, bias); }, z, direction, weights), 2e-3);
  const Floats along = Numbers(Width, 4);
  const double added = Dot(Floats(Width, 1.0F), along); // to what was there
  EXPECT_NEAR(
    Dot(byBias, along) - added, Slope([&](const Floats& at) { return evaluate(z, at); }, bias, along, weights), 2e-3);
}

TEST_P(GradientKernelsOf, ModulationHasItsDerivatives)
{
  const auto evaluate = [&](const Floats& phases, const Floats& z) {
    Floats out(Complex);
    this->Kernels.Modulate(phases.data(), z.data(), Rows, Width, out.data());
    return out;
  };
  const Floats phases = Numbers(Complex, 1, 2.0F);
  const Floats z = Numbers(Complex, 2);
  const Floats weights = Numbers(Complex, 3);
  const double scale = std::log1p(std::exp(static_cast<double>(phases[Width])));
  EXPECT_NEAR(evaluate(phases, z)[0],
    scale * (z[0] * std::cos(static_cast<double>(phases[0])) - z[Width] * std::sin(static_cast<double>(phases[0]))),
    2e-6);
  Floats byPhases = phases;
  Floats byZ = weights;
  Floats again(Complex);
  Floats slopes(Plain);
  this->Kernels.ModulateWithSlopes(byPhases.data(), z.data(), Rows, Width, again.data(), slopes.data());
  ExpectNear(again, evaluate(phases, z), 1e-6);
  this->Kernels.ModulateBackward(again.data(), slopes.data(), Rows, Width, byPhases.data(), byZ.data());
  const Floats direction = Numbers(Complex, 4);
  EXPECT_NEAR(Dot(byPhases, direction),
    Slope([&](const Floats& at) { return evaluate(at, z); }, phases, direction, weights), 2e-3);
  EXPECT_NEAR(
    Dot(byZ, direction), Slope([&](const Floats& at) { return evaluate(phases, at); }, z, direction, weights), 2e-3);
}

TEST_P(GradientKernelsOf, TransposesAreThoseOfGradientMeanAndDivergence)
{
  const Floats signal = Numbers(Signal, 1);
  const Floats hidden = Numbers(Signal, 2);
  Floats z(Complex);
  Floats mean(Plain);
  this->Kernels.Gradient(signal.data(), this->Faces, Width, z.data());
  this->Kernels.CornerMean(hidden.data(), this->Faces, Width, mean.data());
  EXPECT_NEAR(mean[0], (hidden[0] + hidden[Width] + hidden[2 * Width]) / 3.0F, 1e-6);
  const Floats byZ = Numbers(Complex, 3);
  const Floats byMean = Numbers(Plain, 4);
  Floats both(2 * Signal, 0.0F);
  this->Kernels.AddTransposed(byZ.data(), byMean.data(), this->Faces, Width, both.data());
  Floats interleaved(2 * Signal);
  for (std::size_t k = 0; k < Signal; ++k)
  {
    const std::size_t at = k / Width * 2 * Width + k % Width;
    interleaved[at] = signal[k];
    interleaved[at + Width] = hidden[k];
  }
  EXPECT_NEAR(Dot(both, interleaved), Dot(z, byZ) + Dot(mean, byMean), 1e-4);
  Floats alone(Signal, 0.0F);
  this->Kernels.AddTransposed(byZ.data(), nullptr, this->Faces, Width, alone.data());
  EXPECT_NEAR(Dot(alone, signal), Dot(z, byZ), 1e-4);

  const Floats features = Numbers(Complex, 5);
  Floats sums(2 * Signal, 0.0F);
  this->Kernels.AddDivergence(features.data(), this->Faces, Width, sums.data());
  EXPECT_NEAR(
    sums[0], this->Areas[0] * (this->Gradients[0] * features[0] + this->Gradients[3] * features[Width]), 1e-6);
  const Floats bySums = Numbers(2 * Signal, 6);
  Floats back(Complex);
  this->Kernels.DivergenceTransposed(bySums.data(), this->Faces, Width, back.data());
  EXPECT_NEAR(Dot(sums, bySums), Dot(features, back), 1e-4);
}

TEST_P(GradientKernelsOf, DotProductsHaveTheirDerivatives)
{
  const Floats a = Numbers(Complex, 1);
  const Floats b = Numbers(Complex, 2);
  const auto evaluate = [&](const Floats& first, const Floats& second) {
    Floats sums(Signal, 0.0F);
    this->Kernels.AddDots(first.data(), second.data(), this->Faces, Width, sums.data());
    return sums;
  };
  const Floats weights = Numbers(Signal, 3);
  Floats byA = a;
  Floats byB(Complex, 0.0F);
  this->Kernels.DotsBackward(weights.data(), b.data(), this->Faces, Width, byA.data(), byB.data());
  const double whole = Dot(evaluate(a, b), weights); // bilinear: Euler's theorem in each argument
  EXPECT_NEAR(Dot(byA, a), whole, 1e-4);
  EXPECT_NEAR(Dot(byB, b), whole, 1e-4);
  const Floats other = Numbers(Complex, 4);
  EXPECT_NEAR(Dot(byA, other), Dot(evaluate(other, b), weights), 1e-4);
  EXPECT_NEAR(Dot(byB, other), Dot(evaluate(a, other), weights), 1e-4);
}

TEST_P(GradientKernelsOf, RowsAndColumns)
{
  const Floats row = Numbers(Width, 1);
  Floats filled(Plain);
  this->Kernels.FillRows(row.data(), Rows, Width, filled.data());
  Floats sums(Width, 1.0F);
  this->Kernels.AddColumnSums(filled.data(), Rows, Width, sums.data());
  const Floats scale = Numbers(Width, 2);
  Floats values = Numbers(Plain, 3);
  const Floats before = values;
  this->Kernels.AddScaled(filled.data(), scale.data(), Rows, Width, values.data());
  Floats byTerms(Plain);
  Floats byScale(Width, 0.0F);
  this->Kernels.AddScaledBackward(
    before.data(), filled.data(), scale.data(), Rows, Width, byTerms.data(), byScale.data());
  for (std::size_t k = 0; k < Plain; ++k)
  {
    const std::size_t c = k % Width;
    EXPECT_FLOAT_EQ(filled[k], row[c]);
    EXPECT_NEAR(values[k], before[k] + scale[c] * row[c], 1e-6);
    EXPECT_FLOAT_EQ(byTerms[k], scale[c] * before[k]);
  }
  for (std::size_t c = 0; c < Width; ++c)
  {
    EXPECT_NEAR(sums[c], 1.0F + 2.0F * row[c], 1e-6);
    EXPECT_NEAR(byScale[c], row[c] * (before[c] + before[c + Width]), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, GradientKernelsOf, testing::ValuesIn(Variants()));
