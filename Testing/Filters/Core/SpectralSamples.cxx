// SPDX-License-Identifier: BSD-3-Clause
#include "SpectralSamples.h"

#include "ExampleMeshes.h"

#include <cmath>
#include <cstdlib>
#include <utility>

namespace surfsynth::test
{

TriangleMesh Triangulation(int which)
{
  const char* full = std::getenv("SURFACE_SYNTHESIS_FULL");
  TriangleMesh surface = ScannedSurface();
  switch (which)
  {
    case 0:
      return Decimate(surface, 2000);
    case 1:
      return Decimate(surface, 8000);
    default:
      return full != nullptr && full[0] == '1' ? RefineToSize(surface, 50000) : surface;
  }
}

SpectralSurface WithEigenpairs(std::string name, TriangleMesh mesh, Index count)
{
  SpectralSurface surface;
  surface.Name = std::move(name);
  surface.Mesh = std::move(mesh);
  surface.Mass = LumpedMass(surface.Mesh);
  surface.Pairs = LowestLaplaceEigenpairs(CotangentStiffness(surface.Mesh), surface.Mass, count);
  return surface;
}

Eigen::MatrixXd SpectralCoefficients(
  const MaternField& field, const SpectralSurface& surface, const SampleRequest& request)
{
  const Eigen::MatrixXd weighted = surface.Mass.asDiagonal() * surface.Pairs.Vectors;
  Eigen::MatrixXd coefficients(weighted.cols(), request.NumberOfSamples);
  Eigen::MatrixXd block(weighted.rows(), 64);
  Eigen::Index done = 0;
  Eigen::Index filled = 0;
  const auto flush = [&] {
    coefficients.middleCols(done, filled).noalias() = weighted.transpose() * block.leftCols(filled);
    done += filled;
    filled = 0;
  };
  field.Sample(request, [&](std::uint32_t, const Eigen::Ref<const Eigen::MatrixXd>& values) {
    block.col(filled++) = values.col(0);
    if (filled == block.cols())
    {
      flush();
    }
  });
  flush();
  return coefficients;
}

double ChiSquareQuantile(double freedom, double z)
{
  const double spread = 2.0 / (9.0 * freedom);
  return freedom * std::pow(1.0 - spread + z * std::sqrt(spread), 3.0);
}

} // namespace surfsynth::test
