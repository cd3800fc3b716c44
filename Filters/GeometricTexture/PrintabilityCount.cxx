// SPDX-License-Identifier: BSD-3-Clause
#include "PrintabilityCount.h"

#include "Reporting.h"

namespace surfsynth
{

void PrintabilityCount::Add(vtkAlgorithm* filter, const std::string& where, const GeometricTexturePrintability& found)
{
  GeometricTexturePrintability sum = this->Sum.value_or(GeometricTexturePrintability());
  sum.NumberOfPairsLeft += found.NumberOfPairsLeft;
  sum.Height += found.Height;
  sum.HeightBefore += found.HeightBefore;
  this->Sum = sum;
  if (found.NumberOfPairsLeft > 0)
  {
    ReportWarning(filter, where,
      "Printable: " + std::to_string(found.NumberOfPairsLeft) +
        " pairs of triangles intersect where the target does so itself, without a texture. "
        "vtkSurfaceRepairFilter with RemoveSelfIntersections repairs it.");
  }
}

vtkTypeInt64 PrintabilityCount::NumberOfPairsLeft() const
{
  return this->Sum ? static_cast<vtkTypeInt64>(this->Sum->NumberOfPairsLeft) : -1;
}

double PrintabilityCount::HeightKept() const
{
  return this->Sum && this->Sum->HeightBefore > 0.0 ? this->Sum->Height / this->Sum->HeightBefore : 1.0;
}

} // namespace surfsynth
