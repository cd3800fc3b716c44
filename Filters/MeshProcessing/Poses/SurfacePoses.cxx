// SPDX-License-Identifier: BSD-3-Clause
#include "MeshProcessing/Poses/SurfacePoses.h"

#include "MeshProcessing/Cgal/CgalMesh.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Common/Parallel.h"
#include "Core/Common/ScratchPool.h"
#include "Core/Operators/SurfaceOperators.h"
#include "Core/Random/CounterNormals.h"

#include <CGAL/Surface_mesh_deformation.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

namespace surfsynth
{

namespace
{
using Deformation = CGAL::Surface_mesh_deformation<CgalMesh, CGAL::Default, CGAL::Default, CGAL::SRE_ARAP>;

/// Handles turn in this many steps, each a start for the next, so that large rotations are found.
constexpr int Steps = 4;

/// A shape is destroyed when triangles whose area has changed by this factor ...
constexpr double LargestChange = 3.0;
/// ... make up more than this share of the surface.
constexpr double LargestShare = 0.05;

/// The motion x -> Joint + Swing (x - Joint), after a Twist about the handle's centre.
struct HandleMotion
{
  Eigen::Vector3d Swing; ///< axis times angle, radians
  Eigen::Vector3d Twist;
};

Eigen::Matrix3d Rotation(const Eigen::Vector3d& axisTimesAngle)
{
  const double angle = axisTimesAngle.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, axisTimesAngle / angle).toRotationMatrix()
                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
}

/// Uniform in the unit ball: three coordinates of a uniform point on the unit sphere of five dimensions.
Eigen::Vector3d RandomInBall(const NormalKey& key)
{
  Eigen::Matrix<double, 5, 1> normals;
  FillNormals(key, 0, 5, normals.data());
  return normals.head<3>() / normals.norm();
}

HandleMotion RandomMotion(const PoseRequest& request, std::uint32_t sample, int handle, const PoseOptions& options)
{
  const double radians = std::acos(-1.0) / 180.0;
  NormalKey key;
  key.Seed = request.Seed;
  key.Sample = sample;
  key.Stream = request.Stream;
  key.Component = 2 * static_cast<std::uint32_t>(handle);
  HandleMotion motion;
  motion.Swing = options.MaximumAngle * radians * RandomInBall(key);
  ++key.Component;
  motion.Twist = options.MaximumTwist * radians * RandomInBall(key);
  return motion;
}
} // namespace

class SurfacePoses::Internals
{
public:
  Internals(const TriangleMesh& mesh, const PoseHandles& handles, const PoseOptions& options)
    : Mesh(mesh)
    , Handles(handles.Handles())
    , RegionOfPoint(handles.Regions(mesh))
    , Areas(FaceAreas(mesh))
    , Options(options)
  {}

  /// A mesh that is deformed, with its factored equations.
  struct Worker
  {
    explicit Worker(const Internals& poses)
      : Mesh(ToCgalMesh(poses.Mesh))
      , Solver(Mesh)
    {
      this->Solver.set_sre_arap_alpha(poses.Options.Stiffness);
      for (const CgalVertex v : this->Mesh.vertices())
      {
        if (this->Mesh.is_isolated(v))
        {
          continue;
        }
        this->Solver.insert_roi_vertex(v);
        if (poses.RegionOfPoint[v.idx()] != PoseHandles::Free)
        {
          this->Solver.insert_control_vertex(v);
        }
      }
      if (!this->Solver.preprocess())
      {
        throw SolverFailure("SurfacePoses: the equations of the deformation cannot be factored.");
      }
    }

    CgalMesh Mesh;
    Deformation Solver;
  };

  /// @param goOn is called between iterations and throws to stop
  PointMatrix Pose(const PoseRequest& request, std::uint32_t sample, const std::function<void()>& goOn)
  {
    std::vector<HandleMotion> motions;
    for (std::size_t h = 0; h < this->Handles.size(); ++h)
    {
      motions.push_back(RandomMotion(request, sample, static_cast<int>(h), this->Options));
    }
    std::shared_ptr<Worker> worker = this->Workers.Borrow();
    if (!worker)
    {
      worker = std::make_shared<Worker>(*this);
    }
    PointMatrix pose = this->Deform(*worker, motions, goOn);
    this->Workers.Return(std::move(worker));
    return pose;
  }

  PointMatrix Deform(Worker& worker, const std::vector<HandleMotion>& motions, const std::function<void()>& goOn) const
  {
    worker.Solver.reset();
    for (int step = 1; step <= Steps; ++step)
    {
      this->MoveHandles(worker, motions, static_cast<double>(step) / Steps);
      const int iterations = step < Steps ? std::max(this->Options.NumberOfIterations / Steps, 1)
                                          : this->Options.NumberOfIterations;
      for (int k = 0; k < iterations; ++k)
      {
        goOn();
        worker.Solver.deform(1, 0.0);
      }
    }
    PointMatrix points(this->Mesh.Points.rows(), 3);
    for (const CgalVertex v : worker.Mesh.vertices())
    {
      points.row(v.idx()) = FromCgalPoint(worker.Mesh.point(v)).transpose();
    }
    return points;
  }

  /// @throws SolverFailure when @p pose is not finite, or when much of its surface lies in triangles unlike those of
  /// the shape.
  void RequireShape(const PointMatrix& pose, std::uint32_t sample) const
  {
    if (!pose.allFinite())
    {
      throw SolverFailure("The pose of sample " + std::to_string(sample) + " is not finite.");
    }
    const Eigen::VectorXd areas = FaceAreas({ pose, this->Mesh.Triangles });
    const auto ratio = areas.array() / this->Areas.array();
    const double distorted =
      (ratio > LargestChange || ratio < 1.0 / LargestChange).select(this->Areas.array(), 0.0).sum();
    if (distorted > LargestShare * this->Areas.sum())
    {
      throw SolverFailure("The pose of sample " + std::to_string(sample) +
        " has destroyed the shape: " + FormatNumber(100.0 * distorted / this->Areas.sum()) +
        " per cent of the surface lie in triangles whose area has become " + FormatNumber(LargestChange) +
        " times as large or as small; a smaller MaximumAngle, or other handles, are needed.");
    }
  }

  void MoveHandles(Worker& worker, const std::vector<HandleMotion>& motions, double fraction) const
  {
    for (std::size_t h = 0; h < motions.size(); ++h)
    {
      const PoseHandle& handle = this->Handles[h];
      const Eigen::Matrix3d swing = Rotation(fraction * motions[h].Swing);
      const Eigen::Matrix3d twist = Rotation(fraction * motions[h].Twist);
      for (const CgalVertex v : worker.Mesh.vertices())
      {
        if (this->RegionOfPoint[v.idx()] == static_cast<int>(h))
        {
          const Eigen::Vector3d rest = this->Mesh.Points.row(v.idx()).transpose();
          const Eigen::Vector3d twisted = handle.Center + twist * (rest - handle.Center);
          const Eigen::Vector3d moved = handle.Pivot + swing * (twisted - handle.Pivot);
          worker.Solver.set_target_position(v, ToCgalPoint(moved));
        }
      }
    }
  }

  TriangleMesh Mesh;
  std::vector<PoseHandle> Handles;
  std::vector<int> RegionOfPoint;
  Eigen::VectorXd Areas;
  PoseOptions Options;
  ScratchPool<std::shared_ptr<Worker>> Workers;
};

SurfacePoses::SurfacePoses(const TriangleMesh& mesh, const PoseHandles& handles, const PoseOptions& options)
  : Impl(std::make_unique<Internals>(mesh, handles, options))
{}

SurfacePoses::~SurfacePoses() = default;
SurfacePoses::SurfacePoses(SurfacePoses&&) noexcept = default;

const std::vector<int>& SurfacePoses::Regions() const { return this->Impl->RegionOfPoint; }

void SurfacePoses::Sample(const PoseRequest& request, const Consumer& consume, const Progress& progress) const
{
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<std::int64_t> done{ 0 };
  std::atomic<bool> stop{ false };
  const auto report = [&] {
    try
    {
      Report(progress, static_cast<double>(done) / request.NumberOfSamples);
    }
    catch (...)
    {
      stop = true;
      throw;
    }
  };
  const auto goOn = [&] {
    if (std::this_thread::get_id() == caller)
    {
      report();
    }
    else if (stop)
    {
      throw Cancelled("Stopped on request.");
    }
  };
  const auto makePose = [&](std::int64_t k) {
    const std::uint32_t sample = request.FirstSample + static_cast<std::uint32_t>(k);
    PointMatrix pose = this->Impl->Pose(request, sample, goOn);
    this->Impl->RequireShape(pose, sample);
    consume(sample, std::move(pose));
    ++done;
  };
  ParallelTasks(request.NumberOfSamples, makePose, report);
  Report(progress, 1.0);
}

} // namespace surfsynth
