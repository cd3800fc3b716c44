// SPDX-License-Identifier: BSD-3-Clause
#include "TestSurfaces.h"

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
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gtest/gtest.h>

#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <numeric>

namespace surfsynthtest
{

vtkIdType Soup::AddPoint(double x, double y, double z)
{
  this->Points.insert(this->Points.end(), { x, y, z });
  return this->NumberOfPoints() - 1;
}

namespace
{
vtkSmartPointer<vtkCellArray> ToCellArray(const std::vector<std::vector<vtkIdType>>& cells)
{
  auto array = vtkSmartPointer<vtkCellArray>::New();
  for (const auto& cell : cells)
  {
    array->InsertNextCell(static_cast<vtkIdType>(cell.size()), cell.data());
  }
  return array;
}
} // namespace

vtkSmartPointer<vtkPolyData> Soup::ToPolyData(int pointType) const
{
  vtkNew<vtkPoints> points;
  points->SetDataType(pointType);
  points->SetNumberOfPoints(this->NumberOfPoints());
  for (vtkIdType p = 0; p < this->NumberOfPoints(); ++p)
  {
    points->SetPoint(p, this->Points.data() + 3 * p);
  }
  auto polyData = vtkSmartPointer<vtkPolyData>::New();
  polyData->SetPoints(points);
  polyData->SetVerts(ToCellArray(this->Verts));
  polyData->SetLines(ToCellArray(this->Lines));
  polyData->SetPolys(ToCellArray(this->Polys));
  polyData->SetStrips(ToCellArray(this->Strips));
  return polyData;
}

Soup Icosphere(int levels)
{
  Soup soup;
  const auto add = [&soup](double x, double y, double z) {
    const double length = std::sqrt(x * x + y * y + z * z);
    return soup.AddPoint(x / length, y / length, z / length);
  };
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  for (const double a : { -1.0, 1.0 })
  {
    for (const double b : { -golden, golden })
    {
      add(a, b, 0.0);
      add(0.0, a, b);
      add(b, 0.0, a);
    }
  }
  // Faces are the triples of points at the edge length 2 / |(1, golden, 0)|, wound outwards.
  const auto x = [&soup](vtkIdType p) { return soup.Points.data() + 3 * p; };
  const auto near = [&](vtkIdType p, vtkIdType q) {
    const double d2 = std::inner_product(x(p), x(p) + 3, x(q), 0.0);
    return d2 > 0.4;
  };
  for (vtkIdType p = 0; p < 12; ++p)
  {
    for (vtkIdType q = p + 1; q < 12; ++q)
    {
      for (vtkIdType r = q + 1; r < 12; ++r)
      {
        if (near(p, q) && near(q, r) && near(r, p))
        {
          const double* a = x(p);
          const double* b = x(q);
          const double* c = x(r);
          const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
            a[2] * (b[0] * c[1] - b[1] * c[0]);
          soup.Polys.push_back(volume > 0.0 ? std::vector<vtkIdType>{ p, q, r } : std::vector<vtkIdType>{ p, r, q });
        }
      }
    }
  }
  for (int level = 0; level < levels; ++level)
  {
    std::map<std::pair<vtkIdType, vtkIdType>, vtkIdType> middles;
    const auto middle = [&](vtkIdType p, vtkIdType q) {
      const auto key = std::minmax(p, q);
      const auto found = middles.find(key);
      if (found != middles.end())
      {
        return found->second;
      }
      const double sum[3] = { x(p)[0] + x(q)[0], x(p)[1] + x(q)[1], x(p)[2] + x(q)[2] };
      return middles[key] = add(sum[0], sum[1], sum[2]);
    };
    std::vector<std::vector<vtkIdType>> finer;
    for (const auto& t : soup.Polys)
    {
      const vtkIdType m[3] = { middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0]) };
      finer.insert(
        finer.end(), { { t[0], m[0], m[2] }, { t[1], m[1], m[0] }, { t[2], m[2], m[1] }, { m[0], m[1], m[2] } });
    }
    soup.Polys = std::move(finer);
  }
  return soup;
}

Soup Grid(int n, int corners)
{
  Soup soup;
  for (int j = 0; j <= n; ++j)
  {
    for (int i = 0; i <= n; ++i)
    {
      soup.AddPoint(static_cast<double>(i) / n, static_cast<double>(j) / n, 0.0);
    }
  }
  for (int j = 0; j < n; ++j)
  {
    for (int i = 0; i < n; ++i)
    {
      const vtkIdType a = static_cast<vtkIdType>(j) * (n + 1) + i;
      const vtkIdType b = a + 1;
      const vtkIdType c = a + n + 2;
      const vtkIdType d = a + n + 1;
      if (corners == 4)
      {
        soup.Polys.push_back({ a, b, c, d });
      }
      else
      {
        soup.Polys.push_back({ a, b, c });
        soup.Polys.push_back({ a, c, d });
      }
    }
  }
  return soup;
}

vtkSmartPointer<vtkPolyData> RingSphere(int rings, int sectors)
{
  Soup soup;
  soup.AddPoint(0.0, 0.0, 1.0);
  const double pi = std::acos(-1.0);
  for (int r = 1; r < rings; ++r)
  {
    for (int s = 0; s < sectors; ++s)
    {
      const double theta = pi * r / rings;
      const double phi = 2.0 * pi * s / sectors;
      soup.AddPoint(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    }
  }
  const vtkIdType south = soup.AddPoint(0.0, 0.0, -1.0);
  const auto id = [sectors](int r, int s) { return static_cast<vtkIdType>(1 + (r - 1) * sectors + s % sectors); };
  for (int s = 0; s < sectors; ++s)
  {
    soup.Polys.push_back({ 0, id(1, s), id(1, s + 1) });
    for (int r = 1; r + 1 < rings; ++r)
    {
      soup.Polys.push_back({ id(r, s), id(r + 1, s), id(r + 1, s + 1) });
      soup.Polys.push_back({ id(r, s), id(r + 1, s + 1), id(r, s + 1) });
    }
    soup.Polys.push_back({ id(rings - 1, s), south, id(rings - 1, s + 1) });
  }
  return soup.ToPolyData();
}

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

void EventRecorder::Handle(vtkObject*, unsigned long event, void* data)
{
  this->ForeignThread = this->ForeignThread || std::this_thread::get_id() != this->Thread;
  const double now = Now();
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
        this->SecondsAfterAbort = Now() - this->AbortTime;
        this->AbortTime = -1.0;
      }
      break;
    default:
      this->Progress.push_back(this->Algorithm->GetProgress());
      if (this->Progress.back() >= this->AbortAt && this->AbortTime < 0.0)
      {
        this->AbortTime = Now();
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

bool IsSanitized()
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  return true;
#else
  return false;
#endif
#else
  return false;
#endif
}

} // namespace surfsynthtest
