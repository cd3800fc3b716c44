// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// A corpus of malformed and borderline inputs, and the checks that every filter on surfaces must pass on each of them:
///
///  - R1 no crash and no hang: each case within CaseTimeLimit();
///  - R2 finite output, or an error event, an empty output and a failed update;
///  - R3 empty input gives empty output without an error event;
///  - R6 the input is not modified.
///
/// To test another filter, instantiate a parameterised test over MalformedCorpus() that calls CheckAlone() and
/// CheckAsBlock() with a function that makes the filter: see TestMaternNoiseCorpus.cxx.
#pragma once

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace surfsynthtest
{

/// Permitted outcomes of a filter on surfaces for a case.
enum class Expectation
{
  Empty, ///< empty output, no error
  Error, ///< an error event, empty output, a failed update
  Valid, ///< a surface with manifold edges and triangles of some area: output, no error
  Either ///< borderline, where the answer depends on the filter and on rounding: finite output, or an error
};

struct MalformedCase
{
  std::string Name; ///< letters and digits only
  Expectation Expected;
  std::function<vtkSmartPointer<vtkDataObject>()> Make;
};

/// Prints the name.
std::ostream& operator<<(std::ostream& os, const MalformedCase& malformed);

/// At least 90 cases with different names: topology, geometry, data and pipeline.
const std::vector<MalformedCase>& MalformedCorpus();

/// Makes the filter under test, with one input port.
using FilterFactory = std::function<vtkSmartPointer<vtkAlgorithm>()>;

/// Requirements of the filter under test on a surface.
struct FilterTraits
{
  /// False for a filter that needs more than a valid surface (closed, connected, ...): Valid then reads Either.
  bool AcceptsEveryValidSurface = true;
  /// True for a filter that refuses open surfaces: the good blocks beside a case are then closed.
  bool NeedsClosedSurfaces = false;
  /// False for a filter that repairs defects or accepts other datasets: Error then reads Either.
  bool RefusesEveryDefect = true;
  /// True for a filter that moves the points of a surface: a point that is not finite and that no polygon uses may stay
  /// so.
  bool KeepsStrayPoints = false;
  /// Name of the filter's settings, in tests whose cases differ in them: cases of equal settings share the run on the
  /// good blocks alone.
  std::string Settings;
};

/// Seconds that one case may take.
double CaseTimeLimit();

/// Runs the filter on the case by itself; GoogleTest expectations report what is wrong.
void CheckAlone(const MalformedCase& malformed, const FilterFactory& make, const FilterTraits& traits = {});

/// Runs the filter on a multiblock dataset with the case between two good surfaces, whose output must be the one they
/// have without it.
void CheckAsBlock(const MalformedCase& malformed, const FilterFactory& make, const FilterTraits& traits = {});

} // namespace surfsynthtest
