// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Assembly of the rows of a distributed matrix. Private to the library.
#pragma once

#include "Core/Operators/SurfaceOperators.h"
#include "Distributed/DistributedSystem.h"
#include "Distributed/VertexOwners.h"

namespace surfsynth
{

/// Sums a symmetric matrix over ranks: each rank gets its rows, every diagonal entry among them. Collective.
/// @param matrix [U, U], the part of the rank's triangles, every diagonal entry present
DistributedRows AssembleRows(const VertexOwners& owners, const SparseMatrix& matrix);

/// Adds factor * diagonal to the diagonal, and 1 to that of rows whose entry in @p diagonal is 0.
void AddToDiagonal(DistributedRows& rows, const Eigen::VectorXd& diagonal, double factor);

/// Square of the Frobenius norm of the rank's rows of M^-1 L: see LaplaceBeltramiNorm().
double SquaredLaplacian(const DistributedRows& stiffness, const Eigen::VectorXd& mass);

} // namespace surfsynth
