// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/LabelSurfaces.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/LabelNetwork.h"
#include "Core/Mesh/SeparateSheets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace surfsynth
{

namespace
{
void RequireLabels(const LabelVolume& volume, const LabelSurfaceOptions& options)
{
  for (int axis = 0; axis < 3; ++axis)
  {
    if (volume.Dimensions[axis] < 1 || !(volume.Spacing[axis] > 0.0) || !std::isfinite(volume.Spacing[axis]))
    {
      throw InvalidInput("MakeLabelSurfaces: found " + std::to_string(volume.Dimensions[axis]) +
        " samples and a spacing of " + FormatNumber(volume.Spacing[axis]) +
        " along an axis; expected at least 1 sample and a finite spacing larger than 0.");
    }
  }
  if (options.SmoothingIterations < 0 || !(options.MaximumMove >= 0.0))
  {
    throw InvalidInput("MakeLabelSurfaces: found " + std::to_string(options.SmoothingIterations) +
      " iterations and a largest move of " + FormatNumber(options.MaximumMove) + "; expected at least 0.");
  }
}

/// Triangles of each label, wound outwards.
std::vector<std::vector<Index>> CornersByLabel(const LabelNetwork& network, const TriangleMatrix& triangles)
{
  std::vector<std::vector<Index>> corners(network.Labels.size());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
  {
    const auto [inside, outside] = network.Quads[static_cast<std::size_t>(t / 2)].Label;
    const Index a = triangles(t, 0), b = triangles(t, 1), c = triangles(t, 2);
    auto& of = corners[static_cast<std::size_t>(inside)];
    of.insert(of.end(), { a, b, c });
    auto& other = corners[static_cast<std::size_t>(outside)];
    other.insert(other.end(), { a, c, b });
  }
  return corners;
}

/// Mesh of the points that some triangles use, in the order of the network. @p ids has -1 for each point of the network.
TriangleMesh MeshOf(const LabelNetwork& network, const std::vector<Index>& corners, std::vector<Index>& ids)
{
  std::vector<Index> used(corners);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  TriangleMesh mesh;
  mesh.Points.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t k = 0; k < used.size(); ++k)
  {
    mesh.Points.row(static_cast<Eigen::Index>(k)) = network.Points.row(used[k]);
    ids[static_cast<std::size_t>(used[k])] = static_cast<Index>(k);
  }
  mesh.Triangles.resize(static_cast<Eigen::Index>(corners.size() / 3), 3);
  for (std::size_t k = 0; k < corners.size(); ++k)
  {
    mesh.Triangles.data()[k] = ids[static_cast<std::size_t>(corners[k])];
  }
  return SeparateSheets(mesh);
}

std::vector<LabelSurface> MakeTogether(
  const LabelVolume& volume, const LabelSurfaceOptions& options, const Progress& progress)
{
  LabelNetwork network = FindNetwork(volume, SubProgress(progress, 0.0, 0.3));
  SmoothNetwork(network, volume, options, SubProgress(progress, 0.3, 0.6));
  const TriangleMatrix triangles = Triangulate(network);
  if (options.PreserveVolume)
  {
    RestoreVolumes(network, triangles, SubProgress(progress, 0.6, 0.8));
  }
  const auto corners = CornersByLabel(network, triangles);
  std::vector<Index> ids(static_cast<std::size_t>(network.Points.rows()), -1);
  std::vector<LabelSurface> surfaces;
  for (std::size_t l = 0; l < network.Labels.size(); ++l)
  {
    Report(progress, 0.8 + 0.2 * static_cast<double>(l) / static_cast<double>(network.Labels.size()));
    if (static_cast<int>(l) != network.Background)
    {
      surfaces.push_back({ network.Labels[l], MeshOf(network, corners[l], ids), network.SampleVolumes[l] });
    }
  }
  return surfaces;
}

/// Samples between two corners, both included.
struct SampleBox
{
  std::array<int, 3> Lower, Upper;
};

/// Boxes around the labels other than 0, in ascending order.
std::map<std::int32_t, SampleBox> BoxesOf(const LabelVolume& volume)
{
  std::map<std::int32_t, SampleBox> boxes;
  const std::int32_t* label = volume.Labels;
  for (int z = 0; z < volume.Dimensions[2]; ++z)
  {
    for (int y = 0; y < volume.Dimensions[1]; ++y)
    {
      for (int x = 0; x < volume.Dimensions[0]; ++x, ++label)
      {
        if (*label == 0)
        {
          continue;
        }
        const std::array<int, 3> place{ x, y, z };
        SampleBox& box = boxes.try_emplace(*label, SampleBox{ place, place }).first->second;
        for (int axis = 0; axis < 3; ++axis)
        {
          box.Lower[axis] = std::min(box.Lower[axis], place[axis]);
          box.Upper[axis] = std::max(box.Upper[axis], place[axis]);
        }
      }
    }
  }
  return boxes;
}

/// The surface of one label, as if the others were background.
LabelSurface MakeAlone(const LabelVolume& volume, std::int32_t label, const SampleBox& box,
  const LabelSurfaceOptions& options, const Progress& progress)
{
  LabelVolume part;
  part.Spacing = volume.Spacing;
  std::vector<std::int32_t> labels;
  for (int axis = 0; axis < 3; ++axis)
  {
    part.Dimensions[axis] = box.Upper[axis] - box.Lower[axis] + 1;
  }
  for (int z = box.Lower[2]; z <= box.Upper[2]; ++z)
  {
    for (int y = box.Lower[1]; y <= box.Upper[1]; ++y)
    {
      const std::int64_t row = (std::int64_t(z) * volume.Dimensions[1] + y) * volume.Dimensions[0];
      for (int x = box.Lower[0]; x <= box.Upper[0]; ++x)
      {
        labels.push_back(volume.Labels[row + x] == label ? label : 0);
      }
    }
  }
  part.Labels = labels.data();
  LabelSurface surface = MakeTogether(part, options, progress).front();
  const Eigen::Vector3d corner(box.Lower[0], box.Lower[1], box.Lower[2]);
  surface.Mesh.Points.rowwise() += corner.cwiseProduct(volume.Spacing).transpose();
  return surface;
}
} // namespace

std::vector<LabelSurface> MakeLabelSurfaces(
  const LabelVolume& volume, const LabelSurfaceOptions& options, const Progress& progress)
{
  RequireLabels(volume, options);
  std::vector<LabelSurface> surfaces;
  if (options.SharedBorders)
  {
    surfaces = MakeTogether(volume, options, progress);
  }
  else
  {
    const auto boxes = BoxesOf(volume);
    for (const auto& [label, box] : boxes)
    {
      const double share = 1.0 / static_cast<double>(boxes.size());
      const double begin = share * static_cast<double>(surfaces.size());
      surfaces.push_back(MakeAlone(volume, label, box, options, SubProgress(progress, begin, begin + share)));
    }
  }
  Report(progress, 1.0);
  return surfaces;
}

} // namespace surfsynth
