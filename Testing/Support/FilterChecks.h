// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Runs of filters under observation, and comparisons of data objects.
#pragma once

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <string>
#include <thread>
#include <vector>

class vtkAlgorithm;
class vtkDataArray;
class vtkDataObject;
class vtkObject;

namespace surfsynthtest
{

/// Records what an algorithm and its executive report while the object lives.
class EventRecorder
{
public:
  explicit EventRecorder(vtkAlgorithm* algorithm);
  ~EventRecorder();
  EventRecorder(const EventRecorder&) = delete;
  EventRecorder& operator=(const EventRecorder&) = delete;

  std::vector<std::string> Errors; ///< without the executive's remark that a request has failed
  std::vector<std::string> Warnings;
  std::vector<double> Progress;
  int Executions = 0;
  bool ForeignThread = false; ///< an event came on another thread than the one that made this object
  double AbortAt = 2.0;       ///< asks the algorithm to stop once its progress is at least this
  /// Seconds from the request to the end of the execution, without those in which the thread waited for a processor.
  double SecondsAfterAbort = -1;
  double LongestSilence = 0.0; ///< the same between two progress reports, or one and the start or end
  std::string AllErrors() const;

private:
  void Handle(vtkObject* caller, unsigned long event, void* data);

  vtkAlgorithm* Algorithm;
  vtkSmartPointer<vtkObject> Executive;
  std::vector<unsigned long> Tags;
  std::vector<unsigned long> ExecutiveTags;
  std::thread::id Thread = std::this_thread::get_id();
  double AbortTime = -1.0;
  double LastReport = 0.0;
};

/// Brings @p algorithm up to date; false when that failed.
bool Update(vtkAlgorithm* algorithm);

/// Updates @p filter, at time @p time where that is not negative, and expects no errors and no warnings.
vtkSmartPointer<vtkDataObject> OutputOf(vtkAlgorithm* filter, double time = -1.0);
vtkSmartPointer<vtkPolyData> SurfaceOf(vtkAlgorithm* filter, double time = -1.0);

/// A point array of a surface, which must be there.
vtkDataArray* PointArray(vtkDataObject* surface, const char* name);

/// Largest difference of two arrays of the same shape.
double LargestDifference(vtkDataArray* a, vtkDataArray* b);

/// Hash of everything a data object holds: points, cells, arrays with names and attributes, modification times, and
/// of all blocks of a composite one.
std::uint64_t HashOf(vtkDataObject* data);

/// True when two arrays have the same shape and the same bits.
bool SameBits(vtkDataArray* a, vtkDataArray* b);

/// Seconds of a steady clock.
double Now();

/// Resident memory of this process in bytes, once freed memory has been given back to the system.
std::int64_t ResidentMemory();

/// True in builds with AddressSanitizer or ThreadSanitizer, whose memory figures mean nothing.
bool IsSanitized();

} // namespace surfsynthtest
