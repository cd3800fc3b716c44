// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Numbers of an update with Printable. Private to the filters.
#pragma once

#include "GeometricTextureAdjustment.h"

#include <vtkType.h>

#include <optional>
#include <string>

class vtkAlgorithm;

namespace surfsynth
{

/// What MakePrintable() has left in all blocks of an update.
class PrintabilityCount
{
public:
  /// Forgets the update before.
  void Begin() { this->Sum.reset(); }

  /// Adds a block, and warns where triangles still intersect. @param where see ReportWarning()
  void Add(vtkAlgorithm* filter, const std::string& where, const GeometricTexturePrintability& found);

  /// Number of pairs of triangles that intersect; -1 without a block.
  vtkTypeInt64 NumberOfPairsLeft() const;

  /// Share of the height that was kept, 0 to 1; 1 without a block, or a height.
  double HeightKept() const;

private:
  std::optional<GeometricTexturePrintability> Sum;
};

} // namespace surfsynth
