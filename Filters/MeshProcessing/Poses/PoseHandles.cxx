// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Poses/PoseHandles.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Solvers/HeatGeodesics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
/// Distance of the fixed region from the extremities, in handle radii: the surface between them can bend.
constexpr double Clearance = 3.0;
/// Half the width of the band of the surface whose centroid is the joint, as a fraction of the way.
constexpr double BandHalfWidth = 0.1;
} // namespace

PoseHandles::PoseHandles(TriangleMesh shape, const MeshTopology& topology, const PoseHandleOptions& options,
  PlaceFinder finder, const Progress& progress)
  : Shape(std::move(shape))
  , Options(options)
  , Finder(std::move(finder))
{
  const HeatGeodesics geodesics(this->Shape, topology, SubProgress(progress, 0.0, 0.8));
  const Eigen::VectorXd& mass = geodesics.Mass();
  this->ShapeSize = std::sqrt(mass.sum());
  this->Centroid = (mass.asDiagonal() * this->Shape.Points).colwise().sum().transpose() / mass.sum();
  this->FindExtremities(geodesics);
  this->FindPivots(mass);
  Report(progress, 1.0);
}

void PoseHandles::FindExtremities(const HeatGeodesics& geodesics)
{
  const Index points = this->Shape.NumberOfPoints();
  Eigen::VectorXd fromCentroid = (this->Shape.Points.rowwise() - this->Centroid.transpose()).rowwise().norm();
  for (Index v = 0; v < points; ++v)
  {
    if (geodesics.Components().OfVertex[v] < 0)
    {
      fromCentroid[v] = std::numeric_limits<double>::infinity();
    }
  }
  Eigen::Index center = 0;
  this->SmallestDistance = fromCentroid.minCoeff(&center);
  Eigen::VectorXd nearest = geodesics.Distances({ static_cast<Index>(center) }).col(0);
  this->Distances.resize(points, this->Options.NumberOfHandles);
  const double radius = this->Options.HandleRadius * this->ShapeSize;
  for (int k = 0; k < this->Options.NumberOfHandles; ++k)
  {
    const auto distanceOf = [&](Index v) { return std::isfinite(nearest[v]) ? nearest[v] : -1.0; };
    Index farthest = 0;
    for (Index v = 1; v < points; ++v)
    {
      farthest = distanceOf(v) > distanceOf(farthest) ? v : farthest;
    }
    if (distanceOf(farthest) <= 2.0 * radius)
    {
      throw InvalidInput("There is no room for handle " + std::to_string(k + 1) + " of " +
        std::to_string(this->Options.NumberOfHandles) + ": every point is within two handle radii, " +
        FormatNumber(2.0 * radius) + ", of another one or of the centre; fewer or smaller handles are needed.");
    }
    this->Found.push_back({ farthest, this->Shape.Points.row(farthest).transpose() });
    this->Distances.col(k) = geodesics.Distances({ farthest }).col(0);
    nearest = nearest.cwiseMin(this->Distances.col(k));
  }
}

void PoseHandles::FindPivots(const Eigen::VectorXd& mass)
{
  const int stays = static_cast<int>(this->Found.size());
  for (int k = 0; k < stays; ++k)
  {
    double way = std::numeric_limits<double>::infinity();
    for (Index v = 0; v < this->Shape.NumberOfPoints(); ++v)
    {
      if (mass[v] > 0.0 && this->RegionOf(this->Shape.Points.row(v), this->Distances.row(v)) == stays)
      {
        way = std::min(way, this->Distances(v, k));
      }
    }
    if (!std::isfinite(way))
    {
      throw InvalidInput("Nothing of the shape stays: every point near its centroid is within " +
        FormatNumber(Clearance * this->Options.HandleRadius * this->ShapeSize) +
        " of an extremity; fewer or smaller handles, or a larger AnchorRadius, are needed.");
    }
    double weight = 0.0;
    for (Index v = 0; v < this->Shape.NumberOfPoints(); ++v)
    {
      // A weight around the wanted distance, never 0: each triangle on the way has a share.
      const double apart = std::abs(this->Distances(v, k) / way - this->Options.PivotPosition);
      const double share = mass[v] > 0.0 ? mass[v] * std::max(1.0 - apart / BandHalfWidth, 1e-12 / (1e-6 + apart))
                                         : 0.0;
      this->Found[k].Pivot += share * this->Shape.Points.row(v).transpose();
      weight += share;
    }
    this->Found[k].Pivot /= weight;
  }
}

int PoseHandles::RegionOf(const Eigen::Vector3d& point, const Eigen::VectorXd& distances) const
{
  const double radius = this->Options.HandleRadius * this->ShapeSize;
  Eigen::Index nearest = 0;
  const double distance = distances.minCoeff(&nearest);
  if (distance <= radius)
  {
    return static_cast<int>(nearest);
  }
  const bool stays = distance >= Clearance * radius &&
    (point - this->Centroid).norm() <= this->SmallestDistance + this->Options.AnchorRadius * this->ShapeSize;
  return stays ? static_cast<int>(this->Found.size()) : Free;
}

std::vector<int> PoseHandles::Regions(const TriangleMesh& mesh) const
{
  std::vector<bool> isUsed(static_cast<std::size_t>(mesh.NumberOfPoints()), false);
  for (Eigen::Index corner = 0; corner < mesh.Triangles.size(); ++corner)
  {
    isUsed[mesh.Triangles.data()[corner]] = true;
  }
  const std::vector<SurfacePlace> places = this->Finder(this->Shape, mesh.Points);
  std::vector<int> regions(places.size(), Free);
  std::vector<bool> hasPoint(this->Found.size() + 1, false);
  for (std::size_t v = 0; v < places.size(); ++v)
  {
    if (!isUsed[v])
    {
      continue;
    }
    const auto t = this->Shape.Triangles.row(places[v].Triangle);
    Eigen::VectorXd distances = Eigen::VectorXd::Zero(this->Distances.cols());
    for (int k = 0; k < 3; ++k)
    {
      distances += places[v].Weights[k] * this->Distances.row(t(k)).transpose();
    }
    regions[v] = this->RegionOf(mesh.Points.row(static_cast<Eigen::Index>(v)).transpose(), distances);
    if (regions[v] != Free)
    {
      hasPoint[regions[v]] = true;
    }
  }
  for (std::size_t k = 0; k < hasPoint.size(); ++k)
  {
    if (!hasPoint[k])
    {
      throw InvalidInput((k < this->Found.size() ? "Handle " + std::to_string(k) : std::string("The part that stays")) +
        " has no point of the surface: the surface is too coarse, or its template is of another shape.");
    }
  }
  return regions;
}

} // namespace surfsynth
