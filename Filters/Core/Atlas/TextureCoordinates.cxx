// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Atlas/TextureCoordinates.h"

#include "Core/Common/Errors.h"

#include <algorithm>
#include <cmath>

namespace surfsynth
{

namespace
{
constexpr double OutsideTolerance = 1e-4;

/// Twice the signed area of triangle @p f, counter-clockwise positive; 0 when it is degenerate.
double DoubleArea(const TextureCoordinates& coordinates, std::int64_t f)
{
  const Eigen::RowVector2d a = coordinates.row(3 * f + 1) - coordinates.row(3 * f);
  const Eigen::RowVector2d b = coordinates.row(3 * f + 2) - coordinates.row(3 * f);
  const double longest = std::max({ a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm() });
  const double doubleArea = a.x() * b.y() - a.y() * b.x();
  return std::abs(doubleArea) > 2e-12 * longest ? doubleArea : 0.0;
}

void Count(AtlasFinding& finding, std::int64_t f)
{
  finding.First = finding.Count == 0 ? f : finding.First;
  ++finding.Count;
}

std::string DescribeAtlasFinding(const AtlasFinding& finding, std::int64_t first, std::int64_t second)
{
  const std::string count = std::to_string(finding.Count);
  const std::string id = std::to_string(first);
  switch (finding.Defect)
  {
    case AtlasDefect::NonFiniteCoordinate:
      return count + " cell(s) with a NaN or infinite texture coordinate, first cell " + id +
        "; new texture coordinates are needed.";
    case AtlasDefect::OutsideUnitSquare:
      return count + " cell(s) with texture coordinates outside [0, 1], first cell " + id +
        "; a repeated texture can be looked up but not written: texture coordinates of an atlas are needed.";
    case AtlasDefect::DegenerateTriangle:
      return count + " cell(s) without area in the texture, first cell " + id +
        "; they show one texel or a line of texels.";
    case AtlasDefect::FlippedTriangle:
      return count + " cell(s) that are mirrored in the texture, first cell " + id +
        "; what is written there appears mirrored.";
    case AtlasDefect::OverlappingTriangles:
      return count + " texel(s) that several cells share, first the cells " + id + " and " + std::to_string(second) +
        "; texture coordinates without overlap are needed to give each cell its own colors.";
  }
  return {};
}
} // namespace

std::vector<AtlasFinding> CheckTextureCoordinates(const TextureCoordinates& coordinates, std::int64_t numberOfTriangles)
{
  if (coordinates.rows() != 3 * numberOfTriangles)
  {
    throw InvalidInput("CheckTextureCoordinates: texture coordinates of " + std::to_string(coordinates.rows()) +
      " corners; expected " + std::to_string(3 * numberOfTriangles) + ", three for each triangle.");
  }
  AtlasFinding nonFinite{ AtlasDefect::NonFiniteCoordinate };
  AtlasFinding outside{ AtlasDefect::OutsideUnitSquare };
  AtlasFinding degenerate{ AtlasDefect::DegenerateTriangle };
  AtlasFinding clockwise{ AtlasDefect::FlippedTriangle };
  AtlasFinding counterClockwise{ AtlasDefect::FlippedTriangle };
  double area = 0.0;
  for (std::int64_t f = 0; f < numberOfTriangles; ++f)
  {
    const auto corners = coordinates.middleRows<3>(3 * f);
    if (!corners.allFinite())
    {
      Count(nonFinite, f);
      continue;
    }
    if (corners.minCoeff() < -OutsideTolerance || corners.maxCoeff() > 1.0 + OutsideTolerance)
    {
      Count(outside, f);
    }
    const double doubleArea = DoubleArea(coordinates, f);
    area += doubleArea;
    if (doubleArea == 0.0)
    {
      Count(degenerate, f);
      continue;
    }
    Count(doubleArea > 0.0 ? counterClockwise : clockwise, f);
  }
  std::vector<AtlasFinding> findings;
  for (const AtlasFinding& finding : { nonFinite, outside, degenerate, area >= 0.0 ? clockwise : counterClockwise })
  {
    if (finding.Count > 0)
    {
      findings.push_back(finding);
    }
  }
  return findings;
}

std::string DescribeAtlasFindings(
  const std::vector<AtlasFinding>& findings, const std::function<std::int64_t(std::int64_t)>& cellOfTriangle)
{
  std::string text;
  for (const AtlasFinding& finding : findings)
  {
    const auto cell = [&](std::int64_t f) { return cellOfTriangle && f >= 0 ? cellOfTriangle(f) : f; };
    text += (text.empty() ? "" : " Also ") + DescribeAtlasFinding(finding, cell(finding.First), cell(finding.Second));
  }
  return text;
}

} // namespace surfsynth
