// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Random/CounterNormals.h"
#include "Core/Random/CounterUniforms.h"

#include <Random123/philox.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

using namespace surfsynth;

namespace
{

constexpr double TwoPi = 6.28318530717958647693;

std::array<std::uint32_t, 4> Philox(
  const std::array<std::uint32_t, 4>& counter, const std::array<std::uint32_t, 2>& key)
{
  const r123::Philox4x32::ctr_type c = { { counter[0], counter[1], counter[2], counter[3] } };
  const r123::Philox4x32::key_type k = { { key[0], key[1] } };
  const r123::Philox4x32::ctr_type words = r123::Philox4x32()(c, k);
  return { words.v[0], words.v[1], words.v[2], words.v[3] };
}

/// The documented definition, with the standard library's functions: Philox 4x32-10 keyed by the seed (low word first)
/// at the counter (point / 4, component, sample, stream); words 2 k and 2 k + 1 give, by Box-Muller, the numbers of
/// points 2 k and 2 k + 1 of the four.
double Reference(const NormalKey& key, std::int64_t point)
{
  const auto words = Philox({ static_cast<std::uint32_t>(point / 4), key.Component, key.Sample, key.Stream },
    { static_cast<std::uint32_t>(key.Seed), static_cast<std::uint32_t>(key.Seed >> 32) });
  const auto pair = static_cast<std::size_t>(point % 4 / 2 * 2);
  const double radius = std::sqrt(-2.0 * std::log((words[pair] + 0.5) / 4294967296.0));
  const double angle = TwoPi * (words[pair + 1] / 4294967296.0);
  return radius * (point % 2 == 0 ? std::cos(angle) : std::sin(angle));
}

std::vector<double> Fill(const NormalKey& key, std::int64_t first, std::int64_t count)
{
  std::vector<double> out(static_cast<std::size_t>(count));
  FillNormals(key, first, count, out.data());
  return out;
}

bool SameBits(const std::vector<double>& a, const std::vector<double>& b)
{
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

double Correlation(const std::vector<double>& a, const std::vector<double>& b)
{
  double ab = 0.0;
  double aa = 0.0;
  double bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
  {
    ab += a[i] * b[i];
    aa += a[i] * a[i];
    bb += b[i] * b[i];
  }
  return ab / std::sqrt(aa * bb);
}

} // namespace

TEST(Philox, GivesItsPublishedKnownAnswers)
{
  // philox4x32 with 10 rounds, from the file kat_vectors of Random123's distribution.
  using Words = std::array<std::uint32_t, 4>;
  EXPECT_EQ(Philox({ 0, 0, 0, 0 }, { 0, 0 }), (Words{ 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8 }));
  EXPECT_EQ(Philox({ 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff }, { 0xffffffff, 0xffffffff }),
    (Words{ 0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd }));
  EXPECT_EQ(Philox({ 0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344 }, { 0xa4093822, 0x299f31d0 }),
    (Words{ 0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1 }));
}

TEST(CounterNormals, FollowTheirDefinitionOnPhiloxWords)
{
  const std::vector<NormalKey> keys = { {}, { 1, 0, 0, 0 }, { 0, 1, 0, 0 }, { 0, 0, 1, 0 }, { 0, 0, 0, 1 },
    { 0x123456789abcdef0ULL, 0xdeadbeef, 0xffffffff, 7 } };
  for (const NormalKey& key : keys)
  {
    for (std::int64_t point = 0; point < 20000; ++point)
    {
      ASSERT_NEAR(Normal(key, point), Reference(key, point), 4e-15) << "point " << point;
    }
  }
}

TEST(CounterNormals, ReachPointsBeyond32Bits)
{
  const std::int64_t far = (std::int64_t(1) << 33) + 4;
  EXPECT_NEAR(Normal({ 3, 1, 2, 0 }, far), Reference({ 3, 1, 2, 0 }, far), 4e-15);
}

TEST(CounterNormals, DoNotDependOnHowCallsAreSplit)
{
  const NormalKey key{ 42, 3, 1, 9 };
  const std::vector<double> whole = Fill(key, 0, 1003);
  for (const std::int64_t piece : { 4, 8, 12, 252, 256, 260, 1000 })
  {
    std::vector<double> joined;
    for (std::int64_t first = 0; first < 1003; first += piece)
    {
      const std::vector<double> part = Fill(key, first, std::min<std::int64_t>(piece, 1003 - first));
      joined.insert(joined.end(), part.begin(), part.end());
    }
    EXPECT_TRUE(SameBits(joined, whole)) << "pieces of " << piece;
  }
  for (std::int64_t point = 0; point < 1003; ++point)
  {
    const double single = Normal(key, point);
    EXPECT_EQ(std::memcmp(&single, &whole[static_cast<std::size_t>(point)], sizeof(double)), 0) << point;
  }
}

TEST(CounterNormals, WriteExactlyTheNumbersAskedFor)
{
  for (std::int64_t count = 0; count < 12; ++count)
  {
    std::vector<double> out(20, 99.0);
    FillNormals({ 5, 0, 0, 0 }, 8, count, out.data());
    for (std::int64_t i = 0; i < 20; ++i)
    {
      EXPECT_EQ(out[static_cast<std::size_t>(i)], i < count ? Normal({ 5, 0, 0, 0 }, 8 + i) : 99.0);
    }
  }
}

TEST(CounterNormals, HaveTheMomentsOfTheNormalDistribution)
{
  // Bounds: 5 standard errors of n = 4,000,000 numbers.
  const std::int64_t n = 4000000;
  const std::vector<double> numbers = Fill({ 2024, 0, 0, 0 }, 0, n);
  double m1 = 0.0;
  double m2 = 0.0;
  double m3 = 0.0;
  double m4 = 0.0;
  for (const double x : numbers)
  {
    m1 += x;
    m2 += x * x;
    m3 += x * x * x;
    m4 += x * x * x * x;
  }
  const double root = std::sqrt(static_cast<double>(n));
  EXPECT_NEAR(m1 / n, 0.0, 5.0 / root);
  EXPECT_NEAR(m2 / n, 1.0, 5.0 * std::sqrt(2.0) / root);
  EXPECT_NEAR(m3 / n, 0.0, 5.0 * std::sqrt(15.0) / root);
  EXPECT_NEAR(m4 / n, 3.0, 5.0 * std::sqrt(96.0) / root);
}

TEST(CounterNormals, PassTheKolmogorovSmirnovTest)
{
  // sqrt(n) D exceeds 1.95 with probability 0.001.
  for (const std::uint64_t seed : { 0ULL, 1ULL, 0xffffffffffffffffULL })
  {
    std::vector<double> numbers = Fill({ seed, 0, 0, 0 }, 0, 1000000);
    std::sort(numbers.begin(), numbers.end());
    const auto n = static_cast<double>(numbers.size());
    double distance = 0.0;
    for (std::size_t i = 0; i < numbers.size(); ++i)
    {
      const double cdf = 0.5 * std::erfc(-numbers[i] / std::sqrt(2.0));
      distance = std::max({ distance, cdf - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - cdf });
    }
    EXPECT_LT(std::sqrt(n) * distance, 1.95) << "seed " << seed;
  }
}

TEST(CounterNormals, TailsHaveTheExpectedWeightAndEnd)
{
  const std::vector<double> numbers = Fill({ 7, 0, 0, 0 }, 0, 8000000);
  std::int64_t beyond3 = 0;
  double largest = 0.0;
  for (const double x : numbers)
  {
    ASSERT_TRUE(std::isfinite(x));
    beyond3 += std::abs(x) > 3.0 ? 1 : 0;
    largest = std::max(largest, std::abs(x));
  }
  const double expected = 8e6 * std::erfc(3.0 / std::sqrt(2.0));
  EXPECT_NEAR(static_cast<double>(beyond3), expected, 5.0 * std::sqrt(expected));
  EXPECT_GT(largest, 4.8);
  EXPECT_LE(largest, std::sqrt(-2.0 * std::log(0.5 / 4294967296.0)) + 1e-12); // 6.76
}

TEST(CounterNormals, AreUncorrelatedAcrossNeighborsInEveryField)
{
  // |r| exceeds 5 / sqrt(n) with probability 6e-7.
  const std::int64_t n = 400000;
  const NormalKey base{ 11, 5, 2, 3 };
  const std::vector<double> reference = Fill(base, 0, n);
  std::vector<std::pair<const char*, NormalKey>> neighbors;
  const auto with = [&](const char* field, auto change) {
    NormalKey key = base;
    change(key);
    neighbors.emplace_back(field, key);
  };
  with("seed + 1", [](NormalKey& key) { ++key.Seed; });
  with("seed high word", [](NormalKey& key) { key.Seed += 1ULL << 32; });
  with("sample", [](NormalKey& key) { ++key.Sample; });
  with("component", [](NormalKey& key) { ++key.Component; });
  with("stream", [](NormalKey& key) { ++key.Stream; });
  with("sample and component exchanged", [](NormalKey& key) { std::swap(key.Sample, key.Component); });
  with("sample and stream exchanged", [](NormalKey& key) { std::swap(key.Sample, key.Stream); });
  const double bound = 5.0 / std::sqrt(static_cast<double>(n));
  for (const auto& [field, key] : neighbors)
  {
    EXPECT_LT(std::abs(Correlation(reference, Fill(key, 0, n))), bound) << field;
  }
  for (const std::size_t lag : { 1, 2, 3, 4, 64, 256 })
  {
    const std::vector<double> head(reference.begin(), reference.end() - static_cast<std::ptrdiff_t>(lag));
    const std::vector<double> tail(reference.begin() + static_cast<std::ptrdiff_t>(lag), reference.end());
    EXPECT_LT(std::abs(Correlation(head, tail)), bound) << "points at lag " << lag;
  }
  // Box-Muller pairs share their radius: their squares must be uncorrelated too (r has standard error 1 / sqrt(n)).
  std::vector<double> even;
  std::vector<double> odd;
  for (std::size_t i = 0; i + 1 < reference.size(); i += 2)
  {
    even.push_back(reference[i] * reference[i] - 1.0);
    odd.push_back(reference[i + 1] * reference[i + 1] - 1.0);
  }
  EXPECT_LT(std::abs(Correlation(even, odd)), 5.0 / std::sqrt(static_cast<double>(even.size())));
}

TEST(Uniform, IsUniformFrom0UpTo1)
{
  constexpr int Count = 100000;
  std::vector<int> bins(10, 0);
  NormalKey key;
  key.Seed = 5;
  for (int k = 0; k < Count; ++k)
  {
    key.Sample = static_cast<std::uint32_t>(k);
    const double u = Uniform(key, k % 7);
    ASSERT_TRUE(u >= 0.0 && u < 1.0);
    ++bins[static_cast<std::size_t>(10.0 * u)];
  }
  double chiSquared = 0.0;
  for (const int count : bins)
  {
    chiSquared += std::pow(count - Count / 10.0, 2) / (Count / 10.0);
  }
  EXPECT_LT(chiSquared, 27.9); // 9 degrees of freedom, probability 0.1 per cent; the numbers are always the same
}

TEST(Uniform, DiffersFromThoseThatNormalsOfTheSameKeyAreMadeOf)
{
  // Were the random words the same, small uniforms would go with large normals: Box-Muller takes the logarithm of one.
  constexpr int Count = 20000;
  double product = 0.0;
  NormalKey key;
  for (int k = 0; k < Count; ++k)
  {
    key.Sample = static_cast<std::uint32_t>(k);
    product += (Uniform(key, 0) - 0.5) * (std::abs(Normal(key, 0)) - std::sqrt(2.0 / 3.14159265358979)) / Count;
  }
  EXPECT_NEAR(product, 0.0, 4.0 * std::sqrt((1.0 / 12.0) * (1.0 - 2.0 / 3.14159265358979) / Count));
}

TEST(Uniform, IndicesAreEquallyLikelyAndInRange)
{
  constexpr int Count = 30000;
  std::vector<int> bins(7, 0);
  NormalKey key;
  for (int k = 0; k < Count; ++k)
  {
    key.Sample = static_cast<std::uint32_t>(k);
    const std::int64_t index = UniformIndex(key, 1, 7);
    ASSERT_TRUE(index >= 0 && index < 7);
    ++bins[static_cast<std::size_t>(index)];
  }
  double chiSquared = 0.0;
  for (const int count : bins)
  {
    chiSquared += std::pow(count - Count / 7.0, 2) / (Count / 7.0);
  }
  EXPECT_LT(chiSquared, 22.5); // 6 degrees of freedom, probability 0.1 per cent; the numbers are always the same
}
