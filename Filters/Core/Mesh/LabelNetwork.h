// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Network of the borders between labels. Private to the core.
#pragma once

#include "Core/Mesh/LabelSurfaces.h"

namespace surfsynth
{

/// Points and quadrilaterals between labels.
struct LabelNetwork
{
  /// Border between two neighboring samples; its normal points from Inside to Outside.
  struct Quad
  {
    std::array<Index, 4> Points;
    std::array<int, 2> Label; ///< indices into Labels: inside, outside
  };
  /// Edge of quadrilaterals.
  struct Edge
  {
    Index A, B;
    bool IsJunction; ///< three or more labels meet in it
  };

  std::vector<std::int32_t> Labels;         ///< in ascending order, with the background
  std::vector<double> SampleVolumes;        ///< of Labels
  PointMatrix Points;                       ///< world units
  std::vector<std::size_t> FirstLabel{ 0 }; ///< [points + 1], first of PointLabels of each point
  std::vector<int> PointLabels;             ///< labels around each point, indices into Labels
  std::vector<bool> IsJunction;             ///< point at three or more labels
  std::vector<Quad> Quads;
  std::vector<Edge> Edges;
  int Background = 0; ///< index of label 0 in Labels

  /// Place in PointLabels of a label around a point.
  std::size_t Slot(Index point, int label) const
  {
    std::size_t slot = this->FirstLabel[static_cast<std::size_t>(point)];
    while (this->PointLabels[slot] != label)
    {
      ++slot;
    }
    return slot;
  }
};

/// Finds the network. @throws InvalidInput, Cancelled
LabelNetwork FindNetwork(const LabelVolume& volume, const Progress& progress);

/// Smooths the points.
void SmoothNetwork(
  LabelNetwork& network, const LabelVolume& volume, const LabelSurfaceOptions& options, const Progress& progress);

/// Cuts each quadrilateral along its shorter diagonal; two triangles for each, in order.
TriangleMatrix Triangulate(const LabelNetwork& network);

/// Moves the points until each label has its volume. @throws SolverFailure
void RestoreVolumes(LabelNetwork& network, const TriangleMatrix& triangles, const Progress& progress);

} // namespace surfsynth
