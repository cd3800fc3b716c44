// SPDX-License-Identifier: BSD-3-Clause
#include "FilterChecks.h"

#include "Core/Common/Sanitizers.h"

#include <vtkAlgorithm.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDoubleArray.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>

namespace surfsynthtest
{

EventRecorder::EventRecorder(vtkAlgorithm* algorithm)
  : Algorithm(algorithm)
  , Executive(algorithm->GetExecutive())
{
  for (const unsigned long event : { vtkCommand::ErrorEvent, vtkCommand::WarningEvent, vtkCommand::ProgressEvent,
         vtkCommand::StartEvent, vtkCommand::EndEvent })
  {
    this->Tags.push_back(algorithm->AddObserver(event, this, &EventRecorder::Handle));
  }
  for (const unsigned long event : { vtkCommand::ErrorEvent, vtkCommand::WarningEvent })
  {
    this->ExecutiveTags.push_back(this->Executive->AddObserver(event, this, &EventRecorder::Handle));
  }
}

EventRecorder::~EventRecorder()
{
  for (const unsigned long tag : this->Tags)
  {
    this->Algorithm->RemoveObserver(tag);
  }
  for (const unsigned long tag : this->ExecutiveTags)
  {
    this->Executive->RemoveObserver(tag);
  }
}

namespace
{
/// Seconds that the calling thread has waited for a processor, since it began; 0 where the kernel does not say. Allocates
/// nothing, since tests let allocations fail.
double SecondsInTheRunQueue()
{
  const int file = open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC);
  char text[64] = {};
  const bool done = file >= 0 && read(file, text, sizeof(text) - 1) > 0;
  if (file >= 0)
  {
    close(file);
  }
  const char* second = done ? std::strchr(text, ' ') : nullptr; // running and waiting, nanoseconds
  return second ? 1e-9 * std::strtod(second, nullptr) : 0.0;
}

/// Time of the calling thread: stands still while other programs keep it from a processor. Both clocks are read without
/// an interruption between them.
double TimeOfThread()
{
  double waited = SecondsInTheRunQueue();
  for (;;)
  {
    const double now = Now();
    const double again = SecondsInTheRunQueue();
    if (again == waited)
    {
      return now - waited;
    }
    waited = again;
  }
}
} // namespace

void EventRecorder::Handle(vtkObject*, unsigned long event, void* data)
{
  this->ForeignThread = this->ForeignThread || std::this_thread::get_id() != this->Thread;
  const double now = TimeOfThread();
  if (event == vtkCommand::EndEvent || event == vtkCommand::ProgressEvent)
  {
    this->LongestSilence = std::max(this->LongestSilence, now - this->LastReport);
  }
  if (event != vtkCommand::ErrorEvent && event != vtkCommand::WarningEvent)
  {
    this->LastReport = now;
  }
  switch (event)
  {
    case vtkCommand::ErrorEvent:
      // The executive adds an event of its own to each failure: it says nothing, and comes after every return of 0.
      if (!std::strstr(static_cast<const char*>(data), "returned failure for request"))
      {
        this->Errors.emplace_back(static_cast<const char*>(data));
      }
      break;
    case vtkCommand::WarningEvent:
      this->Warnings.emplace_back(static_cast<const char*>(data));
      break;
    case vtkCommand::StartEvent:
      ++this->Executions;
      break;
    case vtkCommand::EndEvent:
      if (this->AbortTime >= 0.0)
      {
        this->SecondsAfterAbort = std::max(0.0, now - this->AbortTime);
        this->AbortTime = -1.0;
      }
      break;
    default:
      this->Progress.push_back(this->Algorithm->GetProgress());
      if (this->Progress.back() >= this->AbortAt && this->AbortTime < 0.0)
      {
        this->AbortTime = now;
        this->Algorithm->SetAbortExecute(1);
      }
  }
}

std::string EventRecorder::AllErrors() const
{
  return std::accumulate(this->Errors.begin(), this->Errors.end(), std::string());
}

bool Update(vtkAlgorithm* algorithm) { return algorithm->GetExecutive()->Update() != 0; }

namespace
{
class Hash
{
public:
  void Bytes(const void* data, std::size_t size)
  {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t k = 0; k < size; ++k)
    {
      this->Value = (this->Value ^ bytes[k]) * 1099511628211ull;
    }
  }
  template <typename Number>
  void Add(Number number)
  {
    this->Bytes(&number, sizeof(number));
  }
  void Add(const char* text) { this->Bytes(text ? text : "(null)", text ? std::strlen(text) : 6); }
  void Add(vtkAbstractArray* array)
  {
    this->Add(array != nullptr);
    if (!array)
    {
      return;
    }
    this->Add(array->GetName());
    this->Add(array->GetMTime());
    this->Add(array->GetNumberOfComponents());
    this->Add(array->GetNumberOfTuples());
    auto* numbers = vtkDataArray::SafeDownCast(array);
    for (vtkIdType k = 0; numbers && k < numbers->GetNumberOfValues(); ++k)
    {
      const double value = numbers->GetVariantValue(k).ToDouble();
      this->Bytes(&value, sizeof(value));
    }
  }
  void Add(vtkFieldData* fields)
  {
    for (int k = 0; k < fields->GetNumberOfArrays(); ++k)
    {
      this->Add(fields->GetAbstractArray(k));
    }
    if (auto* attributes = vtkDataSetAttributes::SafeDownCast(fields))
    {
      int indices[vtkDataSetAttributes::NUM_ATTRIBUTES];
      attributes->GetAttributeIndices(indices);
      this->Bytes(indices, sizeof(indices));
    }
  }
  void Add(vtkPolyData* data)
  {
    this->Add(data->GetPoints() ? data->GetPoints()->GetData() : nullptr);
    for (vtkCellArray* cells : { data->GetVerts(), data->GetLines(), data->GetPolys(), data->GetStrips() })
    {
      this->Add(static_cast<vtkAbstractArray*>(cells->GetOffsetsArray()));
      this->Add(static_cast<vtkAbstractArray*>(cells->GetConnectivityArray()));
    }
    this->Add(static_cast<vtkFieldData*>(data->GetPointData()));
    this->Add(static_cast<vtkFieldData*>(data->GetCellData()));
  }

  std::uint64_t Value = 1469598103934665603ull;
};

void AddObject(vtkDataObject* data, Hash& hash)
{
  hash.Add(data != nullptr);
  if (!data)
  {
    return;
  }
  hash.Add(data->GetClassName());
  hash.Add(data->GetMTime());
  hash.Add(data->GetFieldData());
  if (auto* polyData = vtkPolyData::SafeDownCast(data))
  {
    hash.Add(polyData);
  }
  if (auto* tree = vtkDataObjectTree::SafeDownCast(data))
  {
    const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
    place->SkipEmptyNodesOff();
    for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
    {
      AddObject(place->GetCurrentDataObject(), hash);
    }
  }
}
} // namespace

vtkSmartPointer<vtkDataObject> OutputOf(vtkAlgorithm* filter, double time)
{
  EventRecorder events(filter);
  EXPECT_TRUE(time < 0.0 ? Update(filter) : filter->UpdateTimeStep(time));
  EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
  EXPECT_TRUE(events.Warnings.empty()) << ::testing::PrintToString(events.Warnings);
  return filter->GetOutputDataObject(0);
}

vtkSmartPointer<vtkPolyData> SurfaceOf(vtkAlgorithm* filter, double time)
{
  auto copy = vtkSmartPointer<vtkPolyData>::New(); // the filter's own output changes with the next update
  copy->ShallowCopy(OutputOf(filter, time));
  return copy;
}

vtkDataArray* PointArray(vtkDataObject* surface, const char* name)
{
  auto* polydata = vtkPolyData::SafeDownCast(surface);
  vtkDataArray* array = polydata ? polydata->GetPointData()->GetArray(name) : nullptr;
  EXPECT_TRUE(array) << name;
  return array;
}

double LargestDifference(vtkDataArray* a, vtkDataArray* b)
{
  EXPECT_EQ(a->GetNumberOfValues(), b->GetNumberOfValues());
  double largest = 0.0;
  for (vtkIdType t = 0; t < a->GetNumberOfTuples(); ++t)
  {
    for (int c = 0; c < a->GetNumberOfComponents(); ++c)
    {
      largest = std::max(largest, std::abs(a->GetComponent(t, c) - b->GetComponent(t, c)));
    }
  }
  return largest;
}

std::uint64_t HashOf(vtkDataObject* data)
{
  Hash hash;
  AddObject(data, hash);
  return hash.Value;
}

bool SameBits(vtkDataArray* a, vtkDataArray* b)
{
  if (!a || !b || a->GetDataType() != b->GetDataType() || a->GetNumberOfComponents() != b->GetNumberOfComponents() ||
    a->GetNumberOfTuples() != b->GetNumberOfTuples())
  {
    return false;
  }
  const std::size_t bytes = static_cast<std::size_t>(a->GetNumberOfValues()) * a->GetDataTypeSize();
  return bytes == 0 || std::memcmp(a->GetVoidPointer(0), b->GetVoidPointer(0), bytes) == 0;
}

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::int64_t ResidentMemory()
{
#ifdef __GLIBC__
  malloc_trim(0); // how much freed memory malloc() keeps is chance
#endif
  std::int64_t total = 0;
  std::int64_t resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

bool IsSanitized() { return surfsynth::HasSanitizer(); }

} // namespace surfsynthtest
