// SPDX-License-Identifier: BSD-3-Clause
// Field convolutions against the numbers of the published implementation. `ref` of the fixture was computed there in
// float64 on a float32 stencil. README.md tables the limits.
#include "Fixtures.h"

#include "Core/Tangent/FieldConvolution.h"

#include <gtest/gtest.h>

#include <string>

using namespace surfsynth;
using namespace surfsynth::test;

namespace
{
using Complex = std::complex<double>;

std::vector<Complex> Numbers(const SafetensorsFile& file, const std::string& name, bool real)
{
  const std::vector<double> values = file.Float64(name);
  std::vector<Complex> numbers;
  for (std::size_t k = 0; k < values.size(); k += real ? 1 : 2)
  {
    numbers.emplace_back(values[k], real ? 0.0 : values[k + 1]);
  }
  return numbers;
}

Eigen::MatrixXcd Field(const SafetensorsFile& file, const std::string& name)
{
  const FixtureMatrix parts = ReadMatrix(file, name);
  Eigen::MatrixXcd field(parts.rows(), parts.cols() / 2);
  for (Eigen::Index c = 0; c < field.cols(); ++c)
  {
    field.col(c).real() = parts.col(2 * c);
    field.col(c).imag() = parts.col(2 * c + 1);
  }
  return field;
}

FieldConvolutionStencil Stencil(const SafetensorsFile& file)
{
  FieldConvolutionEdges edges;
  const std::vector<std::int64_t> ids = file.Integers("pre.supp_edges");
  for (std::size_t e = 0; e < ids.size(); e += 2)
  {
    edges.Sources.push_back(static_cast<Index>(ids[e]));
    edges.Targets.push_back(static_cast<Index>(ids[e + 1]));
  }
  const FixtureMatrix modulus = ReadMatrix(file, "pre.log_mag");
  const FixtureMatrix angle = ReadMatrix(file, "pre.log_ang");
  edges.Logarithms.resize(modulus.rows());
  for (Eigen::Index e = 0; e < modulus.rows(); ++e)
  {
    edges.Logarithms[e] = std::polar(modulus(e, 0), angle(e, 0));
  }
  edges.Transport = Field(file, "pre.transport").col(0);
  return MakeFieldConvolutionStencil(edges, ReadMatrix(file, "pre.w").col(0), 0.2, 6, 2);
}
} // namespace

TEST(FieldConvolutionParity, AllTypesOfFilters)
{
  const std::string path = FindFixture("fieldconv/fieldconv_eight");
  ASSERT_FALSE(path.empty());
  const SafetensorsFile file(path);
  const FieldConvolutionStencil stencil = Stencil(file);
  const Eigen::MatrixXcd field = Field(file, "in.x");
  for (int type = 0; type <= 2; ++type)
  {
    const std::string name = "conv" + std::to_string(type);
    FieldFilters filters;
    filters.Type = type;
    filters.Inputs = 5;
    filters.Outputs = 4;
    filters.Zonal = Numbers(file, name + ".weights.zonal", type != 2);
    filters.Spherical = Numbers(file, name + ".weights.spherical", false);
    filters.Phase = file.Float64(name + ".weights.phase");
    const Eigen::MatrixXcd expected = Field(file, name + ".ref");
    const double error = (ConvolveField(stencil, field, filters) - expected).norm() / expected.norm();
    EXPECT_LT(error, 1e-6) << name;
    RecordProperty(name, std::to_string(error));
  }
}
