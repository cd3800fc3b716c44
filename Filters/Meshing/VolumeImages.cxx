// SPDX-License-Identifier: BSD-3-Clause
#include "VolumeImages.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"

#include <vtkArrayDispatch.h>
#include <vtkDataArray.h>
#include <vtkDataArrayRange.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <set>

namespace surfsynth
{

namespace
{
constexpr std::int64_t SampleGrain = 1 << 16;
/// Values between two reports of progress.
constexpr std::int64_t Slab = 1 << 24;
constexpr int Bins = 1024;
/// Tolerance of directions as orthogonal unit vectors; files store them in single precision.
constexpr double DirectionTolerance = 1e-4;

/// Calls task(begin, end, value) for consecutive parts of [0, @p count), in parallel, with value(i) the i-th value.
struct ForParts
{
  template <typename Array, typename Task>
  void operator()(Array* array, std::int64_t count, const Progress& progress, const Task& task) const
  {
    const auto values = vtk::DataArrayValueRange(array);
    const auto value = [&values](std::int64_t i) { return static_cast<double>(values[i]); };
    for (std::int64_t first = 0; first < count; first += Slab)
    {
      Report(progress, static_cast<double>(first) / static_cast<double>(count));
      ParallelFor(std::min(Slab, count - first), SampleGrain,
        [&](std::int64_t begin, std::int64_t end) { task(first + begin, first + end, value); });
    }
  }
};

template <typename Task>
void ForValues(vtkDataArray* values, std::int64_t count, const Progress& progress, const Task& task)
{
  if (!vtkArrayDispatch::Dispatch::Execute(values, ForParts{}, count, progress, task))
  {
    ForParts{}(values, count, progress, task);
  }
}

std::int64_t CountOf(const ImageLattice& lattice)
{
  return std::int64_t(lattice.Dimensions[0]) * lattice.Dimensions[1] * lattice.Dimensions[2];
}

/// Eight samples around a position, and their weights.
struct Surrounding
{
  Surrounding(const ImageLattice& lattice, const Eigen::Vector3d& place)
  {
    std::array<std::int64_t, 3> first;
    std::array<std::int64_t, 3> step;
    Eigen::Vector3d fraction;
    for (int axis = 0; axis < 3; ++axis)
    {
      const double last = lattice.Dimensions[axis] - 1.0;
      const double at = std::clamp(place[axis], 0.0, last);
      first[axis] = static_cast<std::int64_t>(std::min(std::floor(at), std::max(last - 1.0, 0.0)));
      fraction[axis] = at - static_cast<double>(first[axis]);
      step[axis] = lattice.Dimensions[axis] > 1 ? 1 : 0;
    }
    for (int corner = 0; corner < 8; ++corner)
    {
      const int bit[3] = { corner & 1, (corner >> 1) & 1, corner >> 2 };
      double weight = 1.0;
      std::int64_t id = 0;
      for (int axis = 2; axis >= 0; --axis)
      {
        weight *= bit[axis] ? fraction[axis] : 1.0 - fraction[axis];
        id = id * lattice.Dimensions[axis] + first[axis] + bit[axis] * step[axis];
      }
      this->Ids[corner] = id;
      this->Weights[corner] = weight;
    }
  }
  std::int64_t Nearest() const { return this->Ids[std::max_element(Weights.begin(), Weights.end()) - Weights.begin()]; }

  std::array<std::int64_t, 8> Ids;
  std::array<double, 8> Weights;
};

void Interpolate(vtkDataArray* source, const Surrounding& around, vtkDataArray* target, vtkIdType tuple)
{
  for (int c = 0; c < source->GetNumberOfComponents(); ++c)
  {
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner)
    {
      if (around.Weights[corner] > 0.0) // a sample that does not count must not spread its NaN
      {
        sum += around.Weights[corner] * source->GetComponent(around.Ids[corner], c);
      }
    }
    target->SetComponent(tuple, c, sum);
  }
}

bool IsCarried(vtkDataSetAttributes* source, int k, vtkDataArray* contoured, std::int64_t samples)
{
  vtkAbstractArray* array = source->GetAbstractArray(k);
  const int role = source->IsArrayAnAttribute(k);
  const char* name = array->GetName();
  const bool ghosts = name && std::strcmp(name, vtkDataSetAttributes::GhostArrayName()) == 0;
  return array != contoured && !ghosts && role != vtkDataSetAttributes::GLOBALIDS &&
    role != vtkDataSetAttributes::PEDIGREEIDS && array->GetNumberOfTuples() == samples;
}
} // namespace

ImageLattice::ImageLattice(vtkImageData* image, bool onCells)
{
  int extent[6];
  image->GetExtent(extent);
  const vtkMatrix3x3* direction = image->GetDirectionMatrix();
  Eigen::Vector3d spacing;
  Eigen::Vector3d first;
  Eigen::Matrix3d directions;
  for (int axis = 0; axis < 3; ++axis)
  {
    const int points = extent[2 * axis + 1] - extent[2 * axis] + 1;
    const bool inCells = onCells && points > 1;
    this->Dimensions[axis] = inCells ? points - 1 : points;
    spacing[axis] = image->GetSpacing()[axis];
    first[axis] = extent[2 * axis] + (inCells ? 0.5 : 0.0);
    this->Origin[axis] = image->GetOrigin()[axis];
    for (int column = 0; column < 3; ++column)
    {
      directions(axis, column) = direction->GetElement(axis, column);
    }
  }
  if (!spacing.allFinite() || !this->Origin.allFinite() || !directions.allFinite() || (spacing.array() == 0.0).any())
  {
    throw InvalidInput("The image has the spacing " + FormatNumber(spacing[0]) + ", " + FormatNumber(spacing[1]) +
      ", " + FormatNumber(spacing[2]) +
      "; finite numbers other than 0, and a finite origin and direction, are needed.");
  }
  const double deviation = (directions.transpose() * directions - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (deviation > DirectionTolerance)
  {
    throw InvalidInput("The direction matrix of the image is not orthogonal (its columns deviate by " +
      FormatNumber(deviation) +
      "): it is sheared or scaled; resample it on orthogonal axes with vtkImageReslice first.");
  }
  this->Axes = directions * spacing.asDiagonal();
  this->Origin += this->Axes * first;
  this->Spacing = spacing.cwiseAbs();
}

PointMatrix ImageLattice::ToWorld(const PointMatrix& local) const
{
  const Eigen::Matrix3d map = this->Axes * this->Spacing.cwiseInverse().asDiagonal();
  return (local * map.transpose()).rowwise() + this->Origin.transpose();
}

ValueRange FiniteRange(vtkDataArray* values, const Progress& progress)
{
  ValueRange range{ std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() };
  std::mutex mutex;
  ForValues(
    values, values->GetNumberOfTuples(), progress, [&](std::int64_t begin, std::int64_t end, const auto& value) {
      ValueRange part{ std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() };
      for (std::int64_t i = begin; i < end; ++i)
      {
        const double v = value(i);
        if (std::isfinite(v))
        {
          part.Lower = std::min(part.Lower, v);
          part.Upper = std::max(part.Upper, v);
        }
      }
      std::lock_guard<std::mutex> lock(mutex);
      range.Lower = std::min(range.Lower, part.Lower);
      range.Upper = std::max(range.Upper, part.Upper);
    });
  constexpr double NaN = std::numeric_limits<double>::quiet_NaN();
  return range.Lower <= range.Upper ? range : ValueRange{ NaN, NaN };
}

double OtsuThreshold(vtkDataArray* values, const ValueRange& range, const Progress& progress)
{
  const double width = 0.5 * range.Upper - 0.5 * range.Lower; // half, as the whole may overflow
  const double middle = range.Lower + width;
  if (!(width > 0.0))
  {
    return middle;
  }
  std::vector<std::int64_t> histogram(Bins, 0);
  std::mutex mutex;
  ForValues(
    values, values->GetNumberOfTuples(), progress, [&](std::int64_t begin, std::int64_t end, const auto& value) {
      std::vector<std::int64_t> part(Bins, 0);
      for (std::int64_t i = begin; i < end; ++i)
      {
        const double v = value(i);
        if (std::isfinite(v))
        {
          const double place = 0.5 * ((v - middle) / width + 1.0);
          ++part[static_cast<std::size_t>(std::clamp(place * Bins, 0.0, Bins - 1.0))];
        }
      }
      std::lock_guard<std::mutex> lock(mutex);
      std::transform(part.begin(), part.end(), histogram.begin(), histogram.begin(), std::plus<>());
    });
  double total = 0.0;
  double sum = 0.0;
  for (int b = 0; b < Bins; ++b)
  {
    total += static_cast<double>(histogram[b]);
    sum += static_cast<double>(histogram[b]) * b;
  }
  double below = 0.0, sumBelow = 0.0, best = -1.0;
  int firstBest = 0, lastBest = 0; // splits behind bin b
  for (int b = 0; b + 1 < Bins; ++b)
  {
    below += static_cast<double>(histogram[b]);
    sumBelow += static_cast<double>(histogram[b]) * b;
    const double above = total - below;
    const double distance = above > 0.0 ? sumBelow / below - (sum - sumBelow) / above : 0.0;
    const double between = below * above * distance * distance;
    if (between > best)
    {
      best = between;
      firstBest = b;
    }
    lastBest = between >= best ? b : lastBest;
  }
  return middle + width * ((firstBest + lastBest + 2.0) / Bins - 1.0);
}

std::vector<double> LabelsOf(vtkDataArray* values)
{
  constexpr std::size_t Most = 32;
  if (values->GetDataType() == VTK_FLOAT || values->GetDataType() == VTK_DOUBLE)
  {
    return {};
  }
  std::set<double> labels;
  std::mutex mutex;
  std::atomic<bool> tooMany{ false };
  ForValues(values, values->GetNumberOfTuples(), {}, [&](std::int64_t begin, std::int64_t end, const auto& value) {
    std::set<double> part;
    double last = std::numeric_limits<double>::quiet_NaN();
    for (std::int64_t i = begin; i < end && !tooMany; ++i)
    {
      const double v = value(i);
      if (v != last) // neighbors are mostly equal
      {
        part.insert(v);
        last = v;
        tooMany = tooMany || part.size() > Most;
      }
    }
    std::lock_guard<std::mutex> lock(mutex);
    labels.insert(part.begin(), part.end());
    tooMany = tooMany || labels.size() > Most;
  });
  return tooMany ? std::vector<double>() : std::vector<double>(labels.begin(), labels.end());
}

VolumeSamples MakeSamples(const ImageLattice& lattice, vtkDataArray* values, double isoValue, bool insideIsBelow,
  const ValueRange& range, const Progress& progress)
{
  VolumeSamples samples;
  samples.Dimensions = lattice.Dimensions;
  samples.Spacing = lattice.Spacing;
  samples.Values.resize(static_cast<std::size_t>(CountOf(lattice)));
  // Samples are scaled to [-1, 1]; where there is no finite one, or their difference overflows, infinities still count.
  const double largest = std::max(std::abs(range.Lower - isoValue), std::abs(range.Upper - isoValue));
  const double farthest = std::isnan(largest)
    ? 1.0
    : std::clamp(largest, std::numeric_limits<double>::min(), std::numeric_limits<double>::max());
  const double sign = insideIsBelow ? 1.0 : -1.0;
  ForValues(values, CountOf(lattice), progress, [&](std::int64_t begin, std::int64_t end, const auto& value) {
    for (std::int64_t i = begin; i < end; ++i)
    {
      const double v = value(i);
      samples.Values[i] = std::isnan(v) ? 1.0F
                                        : static_cast<float>(std::clamp(sign * (v - isoValue) / farthest, -1.0, 1.0));
    }
  });
  return samples;
}

void SampleArrays(vtkImageData* image, vtkDataArray* contoured, const ImageLattice& pointLattice,
  const PointMatrix& points, vtkDataSetAttributes* target)
{
  const Eigen::Matrix3d toIndex = pointLattice.Axes.inverse();
  std::vector<Surrounding> around;
  around.reserve(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index p = 0; p < points.rows(); ++p)
  {
    around.emplace_back(pointLattice, toIndex * (points.row(p).transpose() - pointLattice.Origin));
  }
  vtkDataSetAttributes* source = image->GetPointData();
  for (int k = 0; k < source->GetNumberOfArrays(); ++k)
  {
    vtkAbstractArray* old = source->GetAbstractArray(k);
    if (!IsCarried(source, k, contoured, CountOf(pointLattice)))
    {
      continue;
    }
    const auto made = vtkSmartPointer<vtkAbstractArray>::Take(old->NewInstance());
    made->SetName(old->GetName());
    made->SetNumberOfComponents(old->GetNumberOfComponents());
    made->CopyComponentNames(old);
    made->SetNumberOfTuples(points.rows());
    const bool isReal = old->GetDataType() == VTK_FLOAT || old->GetDataType() == VTK_DOUBLE;
    for (Eigen::Index p = 0; p < points.rows(); ++p)
    {
      if (isReal)
      {
        Interpolate(vtkDataArray::SafeDownCast(old), around[p], vtkDataArray::SafeDownCast(made), p);
      }
      else
      {
        made->SetTuple(p, around[p].Nearest(), old);
      }
    }
    target->AddArray(made);
  }
}

} // namespace surfsynth
