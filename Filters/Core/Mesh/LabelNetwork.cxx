// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Mesh/LabelNetwork.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

namespace surfsynth
{

namespace
{
/// Factors of the two halves of a step: the low-pass filter of [Taubin1995].
constexpr double Shrinking = 0.5;
constexpr double Growing = -0.51;
constexpr int MostVolumeSteps = 40;
constexpr double VolumeTolerance = 1e-4;

/// Indices of labels of the lattice, with one layer of background around it.
class PaddedLabels
{
public:
  PaddedLabels(const LabelVolume& volume, LabelNetwork& network)
  {
    const auto [nx, ny, nz] = volume.Dimensions;
    const std::int64_t count = std::int64_t(nx) * ny * nz;
    std::map<std::int32_t, std::int64_t> counts{ { 0, 0 } };
    std::int32_t last = 0;
    std::int64_t* counter = &counts[0];
    for (std::int64_t k = 0; k < count; ++k)
    {
      if (volume.Labels[k] != last)
      {
        last = volume.Labels[k];
        counter = &counts[last];
      }
      ++*counter;
    }
    std::map<std::int32_t, std::int32_t> indices;
    for (const auto& [label, samples] : counts)
    {
      indices[label] = static_cast<std::int32_t>(network.Labels.size());
      network.Labels.push_back(label);
      network.SampleVolumes.push_back(static_cast<double>(samples) * volume.Spacing.prod());
    }
    network.Background = indices[0];
    this->Size = { nx + 2, ny + 2, nz + 2 };
    this->Indices.assign(static_cast<std::size_t>(std::int64_t(nx + 2) * (ny + 2) * (nz + 2)),
      static_cast<std::int32_t>(network.Background));
    const std::int32_t* label = volume.Labels;
    for (int z = 0; z < nz; ++z)
    {
      for (int y = 0; y < ny; ++y)
      {
        std::int32_t* row = &this->Indices[static_cast<std::size_t>(this->Place(1, y + 1, z + 1))];
        for (int x = 0; x < nx; ++x, ++label)
        {
          row[x] = x > 0 && label[0] == label[-1] ? row[x - 1] : indices[*label];
        }
      }
    }
  }

  std::int64_t Place(int x, int y, int z) const { return (std::int64_t(z) * this->Size[1] + y) * this->Size[0] + x; }
  std::int32_t At(std::int64_t place) const { return this->Indices[static_cast<std::size_t>(place)]; }
  std::int64_t Step(int axis) const
  {
    return axis == 0 ? 1 : axis == 1 ? this->Size[0] : std::int64_t(this->Size[0]) * this->Size[1];
  }

  std::array<int, 3> Size;

private:
  std::vector<std::int32_t> Indices;
};

/// Number of different numbers among @p count.
int Different(const std::int32_t* labels, int count)
{
  int different = 0;
  for (int k = 0; k < count; ++k)
  {
    different += std::find(labels, labels + k, labels[k]) == labels + k;
  }
  return different;
}

/// Finds the points, quadrilaterals and edges of a network, cube by cube. A cube is named by its lowest sample.
class NetworkBuilder
{
public:
  NetworkBuilder(const LabelVolume& volume, const PaddedLabels& labels, LabelNetwork& network)
    : Volume(volume)
    , Labels(labels)
    , Network(network)
    , PointOfCube(static_cast<std::size_t>(labels.Step(2) * labels.Size[2]), -1)
  {}

  void Build(const Progress& progress)
  {
    const std::array<int, 3>& size = this->Labels.Size;
    for (int z = 0; z + 1 < size[2]; ++z)
    {
      Report(progress, static_cast<double>(z) / size[2]);
      for (int y = 0; y + 1 < size[1]; ++y)
      {
        for (int x = 0; x + 1 < size[0]; ++x)
        {
          this->AddCube(x, y, z);
        }
      }
    }
    this->Network.Points.resize(static_cast<Eigen::Index>(this->Coordinates.size() / 3), 3);
    std::copy(this->Coordinates.begin(), this->Coordinates.end(), this->Network.Points.data());
  }

private:
  void AddCube(int x, int y, int z)
  {
    const std::int64_t place = this->Labels.Place(x, y, z);
    std::int32_t corner[8];
    bool same = true;
    for (int k = 0; k < 8; ++k)
    {
      corner[k] = this->Labels.At(
        place + (k & 1) + (k >> 1 & 1) * this->Labels.Step(1) + (k >> 2) * this->Labels.Step(2));
      same = same && corner[k] == corner[0];
    }
    if (same)
    {
      return;
    }
    this->AddPoint(place, corner, Eigen::Vector3d(x, y, z));
    for (int axis = 0; axis < 3; ++axis)
    {
      this->AddEdge(place, corner, axis);
      this->AddQuad(place, corner, axis);
    }
  }

  /// Point in the mean of the middles of the edges between different labels.
  void AddPoint(std::int64_t place, const std::int32_t* corner, const Eigen::Vector3d& lowest)
  {
    if (this->Coordinates.size() / 3 >= static_cast<std::size_t>(std::numeric_limits<Index>::max()))
    {
      throw InvalidInput("MakeLabelSurfaces: the borders have more than 2^31 - 1 points; expected a smaller volume.");
    }
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int crossings = 0;
    for (int k = 0; k < 8; ++k)
    {
      for (int axis = 0; axis < 3; ++axis)
      {
        const int other = k | 1 << axis;
        if (other != k && corner[k] != corner[other])
        {
          Eigen::Vector3d middle(k & 1, k >> 1 & 1, k >> 2);
          middle[axis] = 0.5;
          sum += middle;
          ++crossings;
        }
      }
    }
    const Eigen::Vector3d sample = lowest + sum / crossings - Eigen::Vector3d::Ones(); // without the padding
    const Eigen::Vector3d point = sample.cwiseProduct(this->Volume.Spacing);
    this->PointOfCube[static_cast<std::size_t>(place)] = static_cast<Index>(this->Coordinates.size() / 3);
    this->Coordinates.insert(this->Coordinates.end(), point.data(), point.data() + 3);
    this->AddLabels(corner);
  }

  void AddLabels(const std::int32_t* corner)
  {
    std::size_t different = 0;
    for (int k = 0; k < 8; ++k)
    {
      if (std::find(corner, corner + k, corner[k]) == corner + k)
      {
        this->Network.PointLabels.push_back(corner[k]);
        ++different;
      }
    }
    this->Network.FirstLabel.push_back(this->Network.PointLabels.size());
    this->Network.IsJunction.push_back(different > 2);
  }

  Index PointOf(std::int64_t place) const { return this->PointOfCube[static_cast<std::size_t>(place)]; }

  /// Edge to the cube before this one along @p axis, through the face between them.
  void AddEdge(std::int64_t place, const std::int32_t* corner, int axis)
  {
    std::int32_t face[4];
    for (int k = 0, n = 0; k < 8; ++k)
    {
      if (!(k >> axis & 1))
      {
        face[n++] = corner[k];
      }
    }
    const int different = Different(face, 4);
    if (different > 1)
    {
      this->Network.Edges.push_back(
        { this->PointOf(place - this->Labels.Step(axis)), this->PointOf(place), different > 2 });
    }
  }

  /// Quadrilateral across the edge from the lowest sample of the cube along @p axis, of the cubes around the edge.
  void AddQuad(std::int64_t place, const std::int32_t* corner, int axis)
  {
    const std::int32_t inside = corner[0], outside = corner[1 << axis];
    if (inside == outside)
    {
      return;
    }
    const std::int64_t u = this->Labels.Step((axis + 1) % 3), v = this->Labels.Step((axis + 2) % 3);
    this->Network.Quads.push_back(
      { { this->PointOf(place - u - v), this->PointOf(place - v), this->PointOf(place), this->PointOf(place - u) },
        { inside, outside } });
  }

  const LabelVolume& Volume;
  const PaddedLabels& Labels;
  LabelNetwork& Network;
  std::vector<Index> PointOfCube;
  std::vector<double> Coordinates;
};

/// Half a step: moves each point towards the mean of its neighbors. Points of junctions only follow their junction.
void Relax(LabelNetwork& network, double factor, const PointMatrix& start, const Eigen::Vector3d& largestMove)
{
  PointMatrix sums = PointMatrix::Zero(network.Points.rows(), 3);
  PointMatrix junctionSums = sums;
  std::vector<std::array<int, 2>> counts(static_cast<std::size_t>(network.Points.rows()), { 0, 0 });
  for (const LabelNetwork::Edge& edge : network.Edges)
  {
    for (const auto& [from, to] : { std::pair(edge.A, edge.B), std::pair(edge.B, edge.A) })
    {
      sums.row(to) += network.Points.row(from);
      ++counts[static_cast<std::size_t>(to)][0];
      if (edge.IsJunction)
      {
        junctionSums.row(to) += network.Points.row(from);
        ++counts[static_cast<std::size_t>(to)][1];
      }
    }
  }
  for (Eigen::Index p = 0; p < network.Points.rows(); ++p)
  {
    const auto [all, onJunction] = counts[static_cast<std::size_t>(p)];
    const bool follows = network.IsJunction[static_cast<std::size_t>(p)] && onJunction > 1;
    if (all == 0)
    {
      continue;
    }
    const Eigen::RowVector3d mean = follows ? (junctionSums.row(p) / onJunction).eval() : (sums.row(p) / all).eval();
    const Eigen::RowVector3d moved = network.Points.row(p) + factor * (mean - network.Points.row(p));
    network.Points.row(
      p) = moved.cwiseMax(start.row(p) - largestMove.transpose()).cwiseMin(start.row(p) + largestMove.transpose());
  }
}

/// Volumes of labels and their gradients.
struct VolumeGradient
{
  Eigen::VectorXd Volumes;                   ///< [labels]
  std::vector<Eigen::Vector3d> ByPointLabel; ///< for each of PointLabels: derivative of its volume by the point
  Eigen::VectorXd Areas;                     ///< [points], of the triangles at each
};

VolumeGradient GradientOf(const LabelNetwork& network, const TriangleMatrix& triangles)
{
  VolumeGradient gradient;
  gradient.Areas = Eigen::VectorXd::Zero(network.Points.rows());
  gradient.Volumes = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.Labels.size()));
  gradient.ByPointLabel.assign(network.PointLabels.size(), Eigen::Vector3d::Zero());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
  {
    const Eigen::Vector3d a = network.Points.row(triangles(t, 0)), b = network.Points.row(triangles(t, 1)),
                          c = network.Points.row(triangles(t, 2));
    const Eigen::Vector3d area = 0.5 * (b - a).cross(c - a);
    const auto [inside, outside] = network.Quads[static_cast<std::size_t>(t / 2)].Label;
    gradient.Volumes[inside] += a.dot(area) / 3.0;
    gradient.Volumes[outside] -= a.dot(area) / 3.0;
    for (int k = 0; k < 3; ++k)
    {
      const Index point = triangles(t, k);
      gradient.Areas[point] += area.norm();
      gradient.ByPointLabel[network.Slot(point, inside)] += area / 3.0;
      gradient.ByPointLabel[network.Slot(point, outside)] -= area / 3.0;
    }
  }
  return gradient;
}

/// Changes of all volumes under a pressure of 1 in each label, [labels, labels]: symmetric, positive semi-definite.
Eigen::SparseMatrix<double> PressureResponse(const LabelNetwork& network, const VolumeGradient& gradient)
{
  std::map<std::pair<int, int>, double> entries;
  for (Eigen::Index p = 0; p < network.Points.rows(); ++p)
  {
    for (std::size_t k = network.FirstLabel[p]; gradient.Areas[p] > 0.0 && k < network.FirstLabel[p + 1]; ++k)
    {
      for (std::size_t l = network.FirstLabel[p]; l < network.FirstLabel[p + 1]; ++l)
      {
        entries[{ network.PointLabels[k], network.PointLabels[l] }] += 3.0 *
          gradient.ByPointLabel[k].dot(gradient.ByPointLabel[l]) / gradient.Areas[p];
      }
    }
  }
  std::vector<Eigen::Triplet<double>> triplets;
  for (const auto& [place, value] : entries)
  {
    triplets.emplace_back(place.first, place.second, value);
  }
  const auto labels = static_cast<Eigen::Index>(network.Labels.size());
  Eigen::SparseMatrix<double> response(labels, labels);
  response.setFromTriplets(triplets.begin(), triplets.end());
  return response;
}

/// Moves the points under pressures in the labels.
void MoveUnderPressure(LabelNetwork& network, const VolumeGradient& gradient, const Eigen::VectorXd& pressure)
{
  for (Eigen::Index p = 0; p < network.Points.rows(); ++p)
  {
    for (std::size_t k = network.FirstLabel[p]; gradient.Areas[p] > 0.0 && k < network.FirstLabel[p + 1]; ++k)
    {
      const double factor = 3.0 * pressure[network.PointLabels[k]] / gradient.Areas[p];
      network.Points.row(p) += factor * gradient.ByPointLabel[k].transpose();
    }
  }
}

/// One step of Newton's method. @return false when its equations have no solution
bool CorrectVolumes(LabelNetwork& network, const VolumeGradient& gradient)
{
  Eigen::SparseMatrix<double> response = PressureResponse(network, gradient);
  const Eigen::Map<const Eigen::VectorXd> wanted(
    network.SampleVolumes.data(), static_cast<Eigen::Index>(network.SampleVolumes.size()));
  Eigen::VectorXd missing = wanted - gradient.Volumes;
  const double scale = response.diagonal().maxCoeff();
  for (Eigen::Index l = 0; l < response.rows(); ++l) // no pressure in the background
  {
    response.coeffRef(l, l) += l == network.Background ? 1e9 * scale : 1e-12 * scale;
  }
  missing[network.Background] = 0.0;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(response);
  const Eigen::VectorXd pressure = solver.solve(missing);
  if (solver.info() != Eigen::Success || !pressure.allFinite())
  {
    return false;
  }
  MoveUnderPressure(network, gradient, pressure);
  return true;
}

/// Largest relative error of a volume, without the background.
double VolumeError(const LabelNetwork& network, const Eigen::VectorXd& volumes)
{
  double largest = 0.0;
  for (std::size_t l = 0; l < network.Labels.size(); ++l)
  {
    const double wanted = network.SampleVolumes[l];
    const bool counts = static_cast<int>(l) != network.Background;
    largest = counts ? std::max(largest, std::abs(volumes[static_cast<Eigen::Index>(l)] / wanted - 1.0)) : largest;
  }
  return largest;
}
} // namespace

LabelNetwork FindNetwork(const LabelVolume& volume, const Progress& progress)
{
  LabelNetwork network;
  const PaddedLabels labels(volume, network);
  NetworkBuilder(volume, labels, network).Build(progress);
  return network;
}

void SmoothNetwork(
  LabelNetwork& network, const LabelVolume& volume, const LabelSurfaceOptions& options, const Progress& progress)
{
  const PointMatrix start = network.Points;
  const Eigen::Vector3d largestMove = options.MaximumMove * volume.Spacing;
  for (int k = 0; k < options.SmoothingIterations; ++k)
  {
    Relax(network, Shrinking, start, largestMove);
    Relax(network, Growing, start, largestMove);
    Report(progress, (k + 1.0) / options.SmoothingIterations);
  }
}

TriangleMatrix Triangulate(const LabelNetwork& network)
{
  TriangleMatrix triangles(static_cast<Eigen::Index>(2 * network.Quads.size()), 3);
  for (std::size_t q = 0; q < network.Quads.size(); ++q)
  {
    const auto& [a, b, c, d] = network.Quads[q].Points;
    const auto t = static_cast<Eigen::Index>(2 * q);
    const bool alongAC = (network.Points.row(a) - network.Points.row(c)).squaredNorm() <=
      (network.Points.row(b) - network.Points.row(d)).squaredNorm();
    triangles.row(t) << a, b, (alongAC ? c : d);
    triangles.row(t + 1) << (alongAC ? a : b), c, d;
  }
  return triangles;
}

void RestoreVolumes(LabelNetwork& network, const TriangleMatrix& triangles, const Progress& progress)
{
  if (network.Quads.empty())
  {
    return;
  }
  for (int step = 0; step < MostVolumeSteps; ++step)
  {
    Report(progress, static_cast<double>(step) / MostVolumeSteps);
    const VolumeGradient gradient = GradientOf(network, triangles);
    if (VolumeError(network, gradient.Volumes) <= VolumeTolerance || !CorrectVolumes(network, gradient))
    {
      break;
    }
  }
  const double error = VolumeError(network, GradientOf(network, triangles).Volumes);
  if (!(error <= VolumeTolerance))
  {
    throw SolverFailure("MakeLabelSurfaces: a volume differs by " + FormatNumber(100.0 * error) +
      " % where corrections end, at most " + std::to_string(MostVolumeSteps) +
      "; expected at most 0.01 %, without smoothing at the latest.");
  }
}

} // namespace surfsynth
