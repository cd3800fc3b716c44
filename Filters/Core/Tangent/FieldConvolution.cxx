// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Tangent/FieldConvolution.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

namespace surfsynth
{

namespace
{
using Complex = std::complex<double>;

[[noreturn]] void Refuse(const std::string& found, const std::string& expected)
{
  throw InvalidInput("FieldConvolution: " + found + "; expected " + expected + ".");
}

void CheckEdges(const FieldConvolutionEdges& edges, Index vertices)
{
  const auto count = edges.Sources.size();
  if (edges.Targets.size() != count || edges.Logarithms.size() != static_cast<Eigen::Index>(count) ||
    edges.Transport.size() != static_cast<Eigen::Index>(count))
  {
    Refuse("the numbers of sources, targets, logarithms and transports differ", "one of each for an edge");
  }
  const auto outside = [vertices](Index v) { return v < 0 || v >= vertices; };
  if (std::any_of(edges.Sources.begin(), edges.Sources.end(), outside) ||
    std::any_of(edges.Targets.begin(), edges.Targets.end(), outside))
  {
    Refuse("an edge has a vertex that does not exist", "ids below " + std::to_string(vertices));
  }
}

/// Filter values of one edge without weight and transport. @param out row of R (2 B + 1) numbers, set to 0
void SampleBasis(double radius, double angle, FieldConvolutionStencil& stencil, Eigen::Index edge)
{
  const auto knot = [&](int k) { return std::sqrt(static_cast<double>(k) / (stencil.Rings - 1)); };
  int upper = 1;
  while (upper < stencil.Rings - 1 && knot(upper) < radius)
  {
    ++upper;
  }
  const double share = (radius - knot(upper - 1)) / (knot(upper) - knot(upper - 1));
  for (int m = -stencil.BandLimit; m <= stencil.BandLimit; ++m)
  {
    const Complex wave = std::polar(1.0, m * angle);
    const int column = stencil.BandLimit + m;
    stencil.Values(edge, (upper - 1) * stencil.Frequencies() + column) = (1.0 - share) * wave;
    stencil.Values(edge, upper * stencil.Frequencies() + column) = share * wave;
  }
}

/// Coefficients as a matrix [C R (2 B + 1), O], with phases.
Eigen::MatrixXcd FilterMatrix(const FieldConvolutionStencil& stencil, const FieldFilters& filters)
{
  const int rings = stencil.Rings;
  const int band = stencil.BandLimit;
  const int waves = filters.Type == 2 ? 2 * band : band;
  Eigen::MatrixXcd matrix(filters.Inputs * rings * stencil.Frequencies(), filters.Outputs);
  for (int o = 0; o < filters.Outputs; ++o)
  {
    for (int c = 0; c < filters.Inputs; ++c)
    {
      for (int k = 0; k < rings; ++k)
      {
        const auto at = static_cast<std::size_t>((o * filters.Inputs + c) * rings + k);
        const Complex* spherical = filters.Spherical.data() + at * static_cast<std::size_t>(waves);
        for (int m = -band; m <= band; ++m)
        {
          Complex value = filters.Zonal[at];
          if (m != 0)
          {
            value = filters.Type == 2 ? spherical[m < 0 ? m + band : band + m - 1]
                                      : (m > 0 ? spherical[m - 1] : std::conj(spherical[-m - 1]));
          }
          if (filters.Type == 1)
          {
            const int phase = (o * filters.Inputs + c) * (band + 1) + std::abs(m);
            value *= std::polar(1.0, filters.Phase[static_cast<std::size_t>(phase)]);
          }
          matrix((c * rings + k) * stencil.Frequencies() + band + m, o) = value / double(stencil.Frequencies());
        }
      }
    }
  }
  return matrix;
}

void CheckFilters(const FieldConvolutionStencil& stencil, const FieldFilters& filters)
{
  const auto pairs = static_cast<std::size_t>(std::max(0, filters.Outputs) * std::max(0, filters.Inputs));
  const auto rings = static_cast<std::size_t>(stencil.Rings);
  const auto band = static_cast<std::size_t>(stencil.BandLimit);
  if (filters.Type < 0 || filters.Type > 2)
  {
    Refuse("the filters are of type " + std::to_string(filters.Type), "0, 1 or 2");
  }
  if (filters.Zonal.size() != pairs * rings ||
    filters.Spherical.size() != pairs * rings * band * (filters.Type == 2 ? 2 : 1) ||
    (filters.Type == 1 && filters.Phase.size() != pairs * (band + 1)))
  {
    Refuse("the numbers of coefficients do not fit the stencil", "those of FieldFilters");
  }
}
} // namespace

FieldConvolutionStencil MakeFieldConvolutionStencil(
  const FieldConvolutionEdges& edges, const Eigen::VectorXd& weights, double radius, int rings, int bandLimit)
{
  const auto vertices = static_cast<Index>(weights.size());
  CheckEdges(edges, vertices);
  if (!(radius > 0.0) || rings < 2 || bandLimit < 0)
  {
    Refuse("radius " + std::to_string(radius) + ", " + std::to_string(rings) + " rings, band limit " +
        std::to_string(bandLimit),
      "a radius larger than 0, 2 rings or more, a band limit of 0 or more");
  }
  FieldConvolutionStencil stencil;
  stencil.Vertices = vertices;
  stencil.Rings = rings;
  stencil.BandLimit = bandLimit;
  Eigen::VectorXd sums = Eigen::VectorXd::Constant(vertices, 1e-12);
  std::vector<Eigen::Index> kept;
  for (std::size_t e = 0; e < edges.Sources.size(); ++e)
  {
    if (std::abs(edges.Logarithms[static_cast<Eigen::Index>(e)]) <= radius)
    {
      kept.push_back(static_cast<Eigen::Index>(e));
      sums[edges.Targets[e]] += weights[edges.Sources[e]];
    }
  }
  stencil.Values.setZero(static_cast<Eigen::Index>(kept.size()), rings * stencil.Frequencies());
  for (std::size_t k = 0; k < kept.size(); ++k)
  {
    const auto e = static_cast<std::size_t>(kept[k]);
    const auto row = static_cast<Eigen::Index>(k);
    const Complex logarithm = edges.Logarithms[kept[k]];
    stencil.Sources.push_back(edges.Sources[e]);
    stencil.Targets.push_back(edges.Targets[e]);
    SampleBasis(std::abs(logarithm) / radius, std::arg(logarithm), stencil, row);
    stencil.Values.row(row) *= weights[edges.Sources[e]] / sums[edges.Targets[e]] * edges.Transport[kept[k]];
  }
  return stencil;
}

Eigen::MatrixXcd ConvolveField(
  const FieldConvolutionStencil& stencil, const Eigen::MatrixXcd& field, const FieldFilters& filters)
{
  CheckFilters(stencil, filters);
  if (field.rows() != stencil.Vertices || field.cols() != filters.Inputs)
  {
    Refuse("the field is [" + std::to_string(field.rows()) + ", " + std::to_string(field.cols()) + "]",
      "[" + std::to_string(stencil.Vertices) + ", " + std::to_string(filters.Inputs) + "]");
  }
  const int band = stencil.BandLimit;
  const int columns = stencil.Rings * stencil.Frequencies();
  Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> sums = Eigen::MatrixXcd::Zero(
    field.rows(), filters.Inputs * columns);
  for (std::size_t e = 0; e < stencil.Sources.size(); ++e)
  {
    for (int c = 0; c < filters.Inputs; ++c)
    {
      const Complex value = field(stencil.Sources[e], c);
      const bool zero = std::abs(value.real()) < 1e-7 && std::abs(value.imag()) < 1e-7;
      const Complex back = zero ? 1.0 : std::conj(value) / std::abs(value);
      Complex turned = value * std::polar(1.0, -band * std::arg(back)); // frequency -B
      for (int m = 0; m < stencil.Frequencies(); ++m, turned *= back)
      {
        for (int k = 0; k < stencil.Rings; ++k)
        {
          const int column = k * stencil.Frequencies() + m;
          sums(stencil.Targets[e], c * columns + column) += turned *
            stencil.Values(static_cast<Eigen::Index>(e), column);
        }
      }
    }
  }
  return sums * FilterMatrix(stencil, filters);
}

} // namespace surfsynth
