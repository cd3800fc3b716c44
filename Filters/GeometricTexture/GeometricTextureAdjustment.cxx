// SPDX-License-Identifier: BSD-3-Clause
#include "GeometricTextureAdjustment.h"

#include "GeometricTextureMask.h"

#include "Core/Common/Errors.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "MeshProcessing/Repair/DisplacementReduction.h"
#endif

#include <atomic>
#include <memory>

namespace surfsynth
{

bool GeometricTextureAdjustment::operator==(const GeometricTextureAdjustment& other) const
{
  return this->Strength == other.Strength && this->Printable == other.Printable &&
    SameValues(this->StrengthOfPoint, other.StrengthOfPoint);
}

void ScaleDisplacement(GeometricTextureLevel& level, double strength, const Eigen::VectorXf& strengthOfPoint)
{
  for (Eigen::Index p = 0; p < level.Base.rows(); ++p)
  {
    const double factor = strength * (strengthOfPoint.size() > 0 ? static_cast<double>(strengthOfPoint[p]) : 1.0);
    if (factor != 1.0)
    {
      level.Mesh.Points.row(p) = level.Base.row(p) + factor * (level.Mesh.Points.row(p) - level.Base.row(p));
    }
  }
}

#ifdef SURFACE_SYNTHESIS_CGAL
void RequirePrintability() {}

GeometricTexturePrintability MakePrintable(GeometricTextureLevel& level, const Progress& progress)
{
  // Shared with the work, which outlives this call when it is cancelled.
  struct Shared
  {
    TriangleMesh Base;
    PointMatrix Displacement;
    ReducedDisplacement Result;
  };
  const auto shared = std::make_shared<Shared>();
  shared->Base = { level.Base, level.Mesh.Triangles };
  shared->Displacement = level.Mesh.Points - level.Base;
  const auto work = [shared](const std::atomic<bool>& stop) {
    shared->Result = ReduceDisplacement(shared->Base, shared->Displacement, &stop);
  };
  RunCancellable(work, 0.1 + 2e-5 * level.Mesh.NumberOfTriangles(), progress);
  const ReducedDisplacement& reduced = shared->Result;
  if (reduced.NumberOfRounds > 0) // else the points keep their bits
  {
    level.Mesh.Points = level.Base + reduced.Displacement;
  }
  return { reduced.NumberOfPairsLeft, reduced.Height, reduced.HeightBefore };
}
#else
void RequirePrintability()
{
  throw InvalidInput("Printable needs CGAL, and this library was built without (SURFACE_SYNTHESIS_CGAL is off). "
                     "A build with CGAL, or Printable off, is needed.");
}

GeometricTexturePrintability MakePrintable(GeometricTextureLevel&, const Progress&)
{
  RequirePrintability();
  return {};
}
#endif

} // namespace surfsynth
