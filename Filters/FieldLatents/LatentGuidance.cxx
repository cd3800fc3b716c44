// SPDX-License-Identifier: BSD-3-Clause
#include "LatentGuidance.h"

#include "PointRows.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/UsedPoints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace surfsynth
{

namespace
{
/// Part of the longest direction below which a vertex has none.
constexpr double ShortestDirection = 1e-6;

/// Values of an array at all points of the surface, [V, components]; 0 where no triangle uses one.
PointRows AllRows(const GuidedSurface& surface, const NamedPointArray& array, std::int64_t components)
{
  const UsedPoints used(surface.Converted->Mesh);
  const PointRows rows = ReadPointRows(surface.Arrays, used, array, components);
  PointRows all = PointRows::Zero(surface.Converted->Mesh.NumberOfPoints(), components);
  for (Index k = 0; k < used.Count(); ++k)
  {
    all.row(used.Id(k)) = rows.row(k);
  }
  return all;
}

/// Linear interpolation of rows at the places of the vertices.
PointRows AtVertices(const GuidedSurface& surface, const PointRows& rows)
{
  const std::vector<SurfacePlace>& places = surface.Triangulation->Places();
  PointRows values = PointRows::Zero(static_cast<Eigen::Index>(places.size()), rows.cols());
  for (std::size_t v = 0; v < places.size(); ++v)
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      values.row(static_cast<Eigen::Index>(v)) += places[v].Weights[corner] *
        rows.row(surface.Converted->Mesh.Triangles(places[v].Triangle, corner));
    }
  }
  return values;
}

[[noreturn]] void Refuse(const NamedPointArray& array, double found, Eigen::Index point, const std::string& expected)
{
  throw InvalidInput("The point array \"" + array.Name + "\" (" + array.Property + ") is " + FormatNumber(found) +
    " at point " + std::to_string(point) + "; " + expected + ".");
}
} // namespace

std::vector<std::int32_t> ReadLabels(const GuidedSurface& surface, const std::string& name, std::int64_t numberOfLabels)
{
  const NamedPointArray array{ name, "LabelArrayName" };
  const PointRows rows = AllRows(surface, array, 1);
  for (Eigen::Index p = 0; p < rows.rows(); ++p)
  {
    const double label = rows(p, 0);
    if (!(label >= -1.0 && label < static_cast<double>(numberOfLabels)) || std::round(label) != label)
    {
      Refuse(array, label, p,
        "whole numbers from 0 to " + std::to_string(numberOfLabels - 1) + ", or -1 for no label, are needed");
    }
  }
  std::vector<std::int32_t> labels;
  for (const SurfacePlace& place : surface.Triangulation->Places())
  {
    Eigen::Index nearest = 0;
    place.Weights.maxCoeff(&nearest);
    labels.push_back(static_cast<std::int32_t>(rows(surface.Converted->Mesh.Triangles(place.Triangle, nearest), 0)));
  }
  return labels;
}

FieldLatentMatrix ReadDirections(const GuidedSurface& surface, const std::string& name)
{
  const PointRows rows = AllRows(surface, { name, "DirectionArrayName" }, 3);
  const double longest = rows.rowwise().norm().maxCoeff();
  const PointRows vectors = AtVertices(surface, rows);
  const VertexFrames& frames = surface.Triangulation->Welded().Rings.Frames;
  FieldLatentMatrix directions = FieldLatentMatrix::Zero(vectors.rows(), 2);
  for (Eigen::Index v = 0; v < vectors.rows(); ++v)
  {
    const Eigen::Vector2d tangent(vectors.row(v).dot(frames.X.row(v)), vectors.row(v).dot(frames.Y.row(v)));
    if (tangent.norm() > ShortestDirection * longest)
    {
      directions.row(v) = tangent.normalized().cast<float>();
    }
  }
  return directions;
}

std::vector<float> ReadMask(const GuidedSurface& surface, const std::string& name)
{
  const NamedPointArray array{ name, "MaskArrayName" };
  const PointRows rows = AllRows(surface, array, 1);
  for (Eigen::Index p = 0; p < rows.rows(); ++p)
  {
    if (!(rows(p, 0) >= 0.0 && rows(p, 0) <= 1.0))
    {
      Refuse(array, rows(p, 0), p, "numbers from 0 (new texture) to 1 (the texture of the input is kept) are needed");
    }
  }
  const PointRows values = AtVertices(surface, rows);
  std::vector<float> mask;
  for (Eigen::Index v = 0; v < values.rows(); ++v)
  {
    mask.push_back(static_cast<float>(std::clamp(values(v, 0), 0.0, 1.0)));
  }
  return mask;
}

} // namespace surfsynth
