// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Fixture files with the numbers of the published implementations.
#pragma once

#include "IO/Weights/SafetensorsFile.h"
#include "Inference/PoissonNet/PoissonOperators.h"

#include <Eigen/Core>

#include <string>

namespace surfsynth::test
{

/// Path of a fixture that is kept in Testing/Data/Parity, else of the one in the folder that the cache variable
/// SURFACE_SYNTHESIS_PARITY_DIR names; "" when neither is there.
std::string FindFixture(const std::string& name);

/// Row-major matrix of a floating-point tensor; the first dimension is the rows.
using FixtureMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
FixtureMatrix ReadMatrix(const SafetensorsFile& file, const std::string& tensor);

/// mesh.faces with the vertices that the operators were computed from.
TriangleMesh ReadMesh(const SafetensorsFile& file);

/// op.*: the operators that the published code computed.
PoissonOperators ReadOperators(const SafetensorsFile& file);

/// The operators that this library computes for mesh.*.
PoissonOperators OwnOperators(const SafetensorsFile& file);

/// || a - b || / || b || in the Frobenius norm.
double RelativeError(const FixtureMatrix& a, const FixtureMatrix& b);

} // namespace surfsynth::test
