// SPDX-License-Identifier: BSD-3-Clause
#include "ColorRows.h"

#include "PointRows.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/LoopGrain.h"
#include "Core/Common/Parallel.h"

#include <vtkDataArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>

namespace surfsynth
{

namespace
{
/// Largest value of a byte: what an image of bytes holds in wider integers.
constexpr double LargestByte = 255.0;

/// Findings in the values of an array.
struct Findings
{
  double Lowest = std::numeric_limits<double>::infinity();   ///< of the colors
  double Highest = -std::numeric_limits<double>::infinity(); ///< of the colors
  std::int64_t Translucent = 0;                              ///< tuples with an alpha below the largest one
  std::int64_t NonFinite = -1;                               ///< first tuple that is not finite

  void Add(const Findings& other)
  {
    this->Lowest = std::min(this->Lowest, other.Lowest);
    this->Highest = std::max(this->Highest, other.Highest);
    this->Translucent += other.Translucent;
    if (other.NonFinite >= 0 && (this->NonFinite < 0 || other.NonFinite < this->NonFinite))
    {
      this->NonFinite = other.NonFinite;
    }
  }
};

bool IsFloating(vtkDataArray* array) { return array->GetDataType() == VTK_FLOAT || array->GetDataType() == VTK_DOUBLE; }

/// Number that stands for white, and for opaque.
double White(vtkDataArray* array) { return IsFloating(array) ? 1.0 : array->GetDataTypeMax(); }

/// Converts one tuple.
void Convert(const double* tuple, int components, double white, std::int64_t t, float* rgb, Findings& findings)
{
  const int colors = components < 3 ? 1 : 3;
  for (int c = 0; c < 3; ++c)
  {
    const double value = tuple[std::min(c, colors - 1)];
    if (!std::isfinite(value))
    {
      findings.NonFinite = findings.NonFinite < 0 ? t : findings.NonFinite;
      return;
    }
    findings.Lowest = std::min(findings.Lowest, value);
    findings.Highest = std::max(findings.Highest, value);
    rgb[c] = static_cast<float>(2.0 * std::clamp(value / white, 0.0, 1.0) - 1.0);
  }
  findings.Translucent += components != colors && tuple[colors] < white ? 1 : 0;
}

std::vector<std::string> Describe(const Findings& findings, vtkDataArray* array, const std::string& name)
{
  std::vector<std::string> remarks;
  const bool isFloating = IsFloating(array);
  const std::string range = "from " + FormatNumber(findings.Lowest) + " to " + FormatNumber(findings.Highest);
  if (findings.Lowest < 0.0 || findings.Highest > White(array))
  {
    remarks.push_back(name + " has values " + range + ", which were clamped: " +
      (isFloating ? "floating-point colors range from 0 to 1."
                  : "colors range from 0 to the largest number of their type."));
  }
  else if (!isFloating && White(array) > LargestByte && findings.Highest <= LargestByte && findings.Highest > 0.0)
  {
    remarks.push_back(name + " has values " + range + " of the type " + array->GetDataTypeAsString() +
      ", for which white is " + FormatNumber(White(array)) +
      ": it is nearly black. Colors of 0 to 255 need the type "
      "unsigned char (vtkImageCast).");
  }
  if (findings.Translucent > 0)
  {
    remarks.push_back(name + " has an alpha component, which was left out; it is below its largest value at " +
      std::to_string(findings.Translucent) + " of " + std::to_string(array->GetNumberOfTuples()) + " places.");
  }
  return remarks;
}
} // namespace

ColorRows ReadColors(vtkDataArray* array, const std::string& name, const std::vector<bool>& isUsed)
{
  const int components = array->GetNumberOfComponents();
  const std::int64_t count = array->GetNumberOfTuples();
  if (components < 1 || components > 4 || count < 1)
  {
    throw InvalidInput(name + " has " + FormatCount(components, "component") + " and " + FormatCount(count, "tuple") +
      "; 1 component (gray), 2 (gray and alpha), 3 (RGB) or 4 (RGBA) are needed.");
  }
  ColorRows rows;
  rows.Values.assign(static_cast<std::size_t>(count) * 3, -1.0F);
  Findings findings;
  std::mutex mutex;
  const double white = White(array);
  ParallelFor(count, FineGrain, [&](std::int64_t begin, std::int64_t end) {
    Findings own;
    std::array<double, 4> tuple{};
    for (std::int64_t t = begin; t < end; ++t)
    {
      if (isUsed.empty() || isUsed[static_cast<std::size_t>(t)])
      {
        array->GetTuple(t, tuple.data());
        Convert(tuple.data(), components, white, t, rows.Values.data() + 3 * t, own);
      }
    }
    const std::lock_guard<std::mutex> lock(mutex);
    findings.Add(own);
  });
  if (findings.NonFinite >= 0)
  {
    throw InvalidInput(name + " is not finite at place " + std::to_string(findings.NonFinite) +
      " of its array; finite colors are needed.");
  }
  rows.Remarks = Describe(findings, array, name);
  return rows;
}

} // namespace surfsynth
