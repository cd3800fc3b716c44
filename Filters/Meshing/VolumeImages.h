// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Conversion between vtkImageData and the samples of a volume. Private to the module.
#pragma once

#include "MeshProcessing/LevelSets/VolumeSurface.h"

#include "Core/Common/Progress.h"

#include <Eigen/LU>

class vtkDataArray;
class vtkDataSetAttributes;
class vtkImageData;

namespace surfsynth
{

/// Positions of the samples of an image: p = Origin + Axes (i, j, k), i from 0 to Dimensions - 1. The samples lie on
/// the points of the image or in the middle of its cells.
struct ImageLattice
{
  /// @throws InvalidInput when spacing, origin or direction are not finite, a spacing is 0, or the directions are not
  /// orthogonal and of unit length: lengths in world units would then depend on the direction.
  ImageLattice(vtkImageData* image, bool onCells);

  /// Converts points [N, 3] from samples times Spacing to world coordinates.
  PointMatrix ToWorld(const PointMatrix& local) const;
  /// Returns true when Axes is left-handed, so that triangles must be reversed.
  bool IsMirrored() const { return this->Axes.determinant() < 0.0; }

  std::array<int, 3> Dimensions;
  Eigen::Vector3d Spacing; ///< world units between samples, larger than 0
  Eigen::Vector3d Origin;
  Eigen::Matrix3d Axes;
};

/// Smallest and largest finite value of an array of one component; NaN without a finite value.
struct ValueRange
{
  double Lower;
  double Upper;
};
ValueRange FiniteRange(vtkDataArray* values, const Progress& progress);

/// Threshold of [Otsu1979]: the value that splits the histogram (1024 bins over the range) into two classes with the
/// largest variance between them; the middle where several splits are equally good. The middle of the range when all
/// values are the same.
double OtsuThreshold(vtkDataArray* values, const ValueRange& range, const Progress& progress);

/// Returns the distinct values of an array of integers, in ascending order, when there are at most 32 of them; empty for
/// more, and for other arrays.
std::vector<double> LabelsOf(vtkDataArray* values);

/// Makes the samples of @p values, negative where they are above (or, with @p insideIsBelow, below) @p isoValue. Values
/// that are NaN are outside, infinite ones on the side of their sign.
VolumeSamples MakeSamples(const ImageLattice& lattice, vtkDataArray* values, double isoValue, bool insideIsBelow,
  const ValueRange& range, const Progress& progress);

/// Fills @p target with the point arrays of @p image but @p contoured at world points [N, 3]: floating-point arrays
/// linearly between samples, others, which are labels, from the nearest sample; beyond the samples as at the border.
void SampleArrays(vtkImageData* image, vtkDataArray* contoured, const ImageLattice& pointLattice,
  const PointMatrix& points, vtkDataSetAttributes* target);

} // namespace surfsynth
