// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Spectral coefficients of sampled fields and the statistics they must follow.
#pragma once

#include "Core/Noise/MaternField.h"
#include "Core/Solvers/LaplaceEigenpairs.h"

#include <string>
#include <vector>

namespace surfsynth::test
{

/// A surface with its mass and lowest eigenpairs.
struct SpectralSurface
{
  std::string Name;
  TriangleMesh Mesh;
  Eigen::VectorXd Mass;
  Eigenpairs Pairs;
};

/// Triangulations 0, 1 and 2 of ScannedSurface(): two decimated ones and the original; with SURFACE_SYNTHESIS_FULL=1 in
/// the environment the last is refined to 50,000 points.
TriangleMesh Triangulation(int which);

SpectralSurface WithEigenpairs(std::string name, TriangleMesh mesh, Index count);

/// f^T M phi_i for each eigenpair (rows) and sample (columns) of component 0.
Eigen::MatrixXd SpectralCoefficients(
  const MaternField& field, const SpectralSurface& surface, const SampleRequest& request);

/// Upper bound of a chi-square variable with @p freedom degrees of freedom that is exceeded with the probability of
/// @p z standard deviations of a normal one; lower bound for z < 0 [Wilson1931].
double ChiSquareQuantile(double freedom, double z);

} // namespace surfsynth::test
