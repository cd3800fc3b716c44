// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Repair/SurfaceRepair.h"

#include "MeshProcessing/Repair/RepairPass.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshCheck.h"
#include "Core/Mesh/MeshStatistics.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace surfsynth
{

namespace
{
constexpr double LargestCoordinate = 1e90;
constexpr int MaximumPasses = 10;
constexpr int MergingPasses = 5; ///< with the tolerance

/// Percentage with at most two significant digits.
std::string Percent(double fraction)
{
  const double percent = 100.0 * fraction;
  return FormatNumber(percent < 1.0 ? std::round(100.0 * percent) / 100.0 : std::round(10.0 * percent) / 10.0) + " %";
}

/// One run of RepairSurface().
class SurfaceRepairer
{
public:
  SurfaceRepairer(const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options,
    const std::atomic<bool>* stop)
    : Input(mesh)
    , Losses(losses)
    , Options(options)
    , Stop(stop)
  {}

  RepairedSurface Result()
  {
    this->RequireModestCoordinates();
    this->ReportConversion();
    this->RunPasses();
    this->MeasureOutcome();
    this->Warn();
    this->Collect();
    return std::move(this->Surface);
  }

private:
  void Note(const char* what, std::int64_t count)
  {
    if (count > 0)
    {
      this->Lines.push_back({ what, count, false });
    }
  }

  void ReportConversion()
  {
    this->Note("cells left out that name a point which does not exist", this->Losses.CellsOutOfRange);
    this->Note("points with a NaN or infinite coordinate left out", this->Losses.NonFinitePoints);
    this->Note("cells left out because they used such points", this->Losses.CellsNotFinite);
    this->Note("polygons and strips without three different points left out", this->Losses.CellsTooSmall);
    this->Note("polygons that used a point twice", this->Losses.RepeatedPoints);
    this->Note("polygons without a simple outline cut into triangles", this->Losses.PolygonsNotSimple);
  }

  /// Repeats the steps until they change nothing.
  void RunPasses()
  {
    this->State.Mesh = this->Input;
    this->State.IsFilling.assign(static_cast<std::size_t>(this->Input.Triangles.rows()), false);
    for (int pass = 0; pass < MaximumPasses && !this->IsSettled; ++pass)
    {
      const TriangleMesh before = pass > 0 ? this->State.Mesh : TriangleMesh();
      // Later passes merge points that earlier ones added; in the end points that stay too near do not change any more.
      const double tolerance = pass < MergingPasses ? this->Options.MergeTolerance : 0.0;
      PassReport report = RunRepairPass(this->State, this->Options, tolerance, this->Stop);
      this->IsSettled = !report.NeedsAnother || (pass > 0 && IsSameMesh(before, this->State.Mesh));
      this->Add(report);
      if (pass == 0)
      {
        this->First = report;
      }
      this->Last = std::move(report);
    }
  }

  /// Adds the lines of a pass: changes are summed up, and what is left is that of the last pass.
  void Add(const PassReport& report)
  {
    this->Lines.erase(
      std::remove_if(this->Lines.begin(), this->Lines.end(), [](const auto& line) { return line.IsLeft; }),
      this->Lines.end());
    for (const RepairLine& line : report.Lines)
    {
      const auto same = std::find_if(
        this->Lines.begin(), this->Lines.end(), [&](const RepairLine& other) { return other.Text == line.Text; });
      same == this->Lines.end() ? this->Lines.push_back(line) : static_cast<void>(same->Count += line.Count);
    }
    this->Removed.Area += report.Removed.Area;
    this->Removed.Volume += report.Removed.Volume;
    this->Removed.Components += report.Removed.Components;
  }

  /// Squares and cubes of coordinates must be finite numbers.
  void RequireModestCoordinates() const
  {
    const double largest = this->Input.Points.size() > 0 ? this->Input.Points.cwiseAbs().maxCoeff() : 0.0;
    if (largest > LargestCoordinate)
    {
      throw InvalidInput("The points have coordinates up to " + FormatNumber(largest) + "; at most " +
        FormatNumber(LargestCoordinate) + " is allowed. vtkTransformPolyDataFilter scales them.");
    }
  }

  void MeasureOutcome()
  {
    const SurfaceExtent& before = this->First.Before;
    SurfaceExtent after = MeasureExtent(this->State.Mesh, this->State.IsClosed);
    after.Area -= this->FillingArea();
    RepairOutcome& outcome = this->Surface.Outcome;
    outcome.Measures.push_back({ "Area", before.Area, after.Area });
    outcome.AreaLoss = LostFraction(before.Area - this->Removed.Area, after.Area);
    if (before.IsClosed && after.IsClosed)
    {
      outcome.Measures.push_back({ "Volume", before.Volume, after.Volume });
      outcome.VolumeLoss = LostFraction(before.Volume - this->Removed.Volume, after.Volume);
    }
    const auto kept = static_cast<double>(before.Components - this->Removed.Components);
    const auto components = static_cast<double>(after.Components);
    outcome.Measures.push_back({ "Components", static_cast<double>(before.Components), components });
    outcome.ComponentChange = kept > 0.0 ? std::abs(components - kept) / kept : 0.0;
    outcome.IntersectingTriangles = this->Last.Removal.Left;
    if (this->Options.RemoveSelfIntersections)
    {
      outcome.Measures.push_back({ "IntersectingTriangles", static_cast<double>(this->First.Removal.Before),
        static_cast<double>(outcome.IntersectingTriangles) });
    }
    outcome.OpenHoles = this->Last.FlatOutlines + this->Last.Unsuitable;
    this->WasClosed = before.IsClosed;
  }

  double FillingArea() const
  {
    TriangleMesh filling{ this->State.Mesh.Points, {} };
    const auto count = std::count(this->State.IsFilling.begin(), this->State.IsFilling.end(), true);
    filling.Triangles.resize(count, 3);
    for (Index f = 0, k = 0; f < this->State.Mesh.NumberOfTriangles(); ++f)
    {
      if (this->State.IsFilling[f])
      {
        filling.Triangles.row(k++) = this->State.Mesh.Triangles.row(f);
      }
    }
    return SurfaceArea(filling);
  }

  void Warn()
  {
    this->WarnOfDefects();
    this->WarnOfLosses();
    const std::vector<std::string>& warnings = this->Surface.Outcome.Warnings;
    if (this->Options.Strict && !warnings.empty())
    {
      throw SolverFailure(std::accumulate(std::next(warnings.begin()), warnings.end(), warnings.front(),
        [](const std::string& all, const std::string& text) { return all + " " + text; }));
    }
  }

  void WarnOfDefects()
  {
    const RepairOutcome& outcome = this->Surface.Outcome;
    if (outcome.IntersectingTriangles > 0)
    {
      const double refused = this->Last.Removal.RefusedLoss;
      this->AddWarning(std::to_string(outcome.IntersectingTriangles) + " triangle(s) still intersect others" +
        (refused > 0.0 ? ": their removal would change area, volume or number of components by " + Percent(refused) +
              ", more than MaximumLoss (" + Percent(this->Options.MaximumLoss) + ")"
                       : "") +
        ". vtkVDBSurfaceFilter makes a closed surface without intersections of any triangles.");
    }
    if (this->Last.Unsuitable > 0)
    {
      this->AddWarning(std::to_string(this->Last.Unsuitable) +
        " hole(s) are left open, because triangles that close them would intersect others or have no area.");
    }
    if (this->Last.FlatOutlines > 0)
    {
      this->AddWarning(std::to_string(this->Last.FlatOutlines) +
        " outline(s) of flat pieces are left open, because closing them would double the pieces.");
    }
    if (!this->IsSettled)
    {
      this->AddWarning("The surface still changed in pass " + std::to_string(MaximumPasses) +
        " of the repair; another repair may change it again.");
    }
  }

  void WarnOfLosses()
  {
    const RepairOutcome& outcome = this->Surface.Outcome;
    const double bound = this->Options.MaximumLoss;
    const std::string more = ", more than MaximumLoss (" + Percent(bound) + ").";
    for (const RepairMeasure& measure : outcome.Measures)
    {
      const std::string change = FormatNumber(measure.Before) + " to " + FormatNumber(measure.After);
      if (measure.Name == "Area" && outcome.AreaLoss > bound)
      {
        this->AddWarning("The repair lost " + Percent(outcome.AreaLoss) + " of the area, from " + change + more);
      }
      if (measure.Name == "Volume" && outcome.VolumeLoss > bound)
      {
        this->AddWarning("The repair lost " + Percent(outcome.VolumeLoss) + " of the volume, from " + change + more);
      }
      if (measure.Name == "Components" && outcome.ComponentChange > bound)
      {
        this->AddWarning("The repair changed the number of components from " + change + more);
      }
    }
    if (this->WasClosed && !this->State.IsClosed)
    {
      this->AddWarning("The surface was closed before the repair and is open after it.");
    }
  }

  void AddWarning(const std::string& text) { this->Surface.Outcome.Warnings.push_back(text); }

  void Collect()
  {
    this->Surface.Mesh = std::move(this->State.Mesh);
    MeshRequirements requirements;
    requirements.ManifoldVertices = true;
    requirements.ConsistentWinding = true;
    const std::vector<MeshFinding> findings = CheckMesh(this->Surface.Mesh, requirements);
    if (!findings.empty())
    {
      throw SolverFailure("The surface could not be repaired. What is left has " + DescribeFindings(findings) +
        " vtkVDBSurfaceFilter makes a closed surface of any triangles.");
    }
    this->Surface.IsFilling = std::move(this->State.IsFilling);
    std::transform(this->Lines.begin(), this->Lines.end(), std::back_inserter(this->Surface.Report),
      [](const RepairLine& line) { return std::make_pair(line.Text, line.Count); });
    this->Locate();
  }

  void Locate()
  {
    const TriangleMesh& mesh = this->Surface.Mesh;
    const Eigen::Index points = mesh.Points.rows();
    PointMatrix wanted(points + mesh.Triangles.rows(), 3);
    wanted.topRows(points) = mesh.Points;
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      const auto t = mesh.Triangles.row(f);
      wanted.row(points + f) = (mesh.Points.row(t(0)) + mesh.Points.row(t(1)) + mesh.Points.row(t(2))) / 3.0;
    }
    this->Surface.PlaceOfPoint = this->Options.Finder(this->Input, wanted);
    this->Surface.OriginOfTriangle.resize(static_cast<std::size_t>(mesh.Triangles.rows()));
    std::transform(this->Surface.PlaceOfPoint.begin() + points, this->Surface.PlaceOfPoint.end(),
      this->Surface.OriginOfTriangle.begin(), [](const SurfacePlace& place) { return place.Triangle; });
    this->Surface.PlaceOfPoint.resize(static_cast<std::size_t>(points));
  }

  const TriangleMesh& Input;
  const ConversionLosses& Losses;
  const RepairOptions& Options;
  const std::atomic<bool>* Stop;
  RepairState State;
  bool IsSettled = false;
  bool WasClosed = false;
  PassReport First;
  PassReport Last;
  SurfaceExtent Removed; ///< components removed on request, in all passes
  std::vector<RepairLine> Lines;
  RepairedSurface Surface;
};
} // namespace

RepairedSurface RepairSurface(
  const TriangleMesh& mesh, const ConversionLosses& losses, const RepairOptions& options, const std::atomic<bool>* stop)
{
  return SurfaceRepairer(mesh, losses, options, stop).Result();
}

} // namespace surfsynth
