// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Operators of a mesh on tensors [Maesumi2025]: differentiable gradient, divergence, averages and Poisson solve.
///
/// Signals are [..., V, C] at vertices and [..., F, C] at faces: any leading dimensions, then places, then channels.
/// All operators are differentiable in the signal (float32 on the processor: once; else as often as wanted); the mesh
/// is constant.
#pragma once

#include "Inference/PoissonNet/PoissonOperators.h"

#include <torch/torch.h>

#include <memory>

namespace surfsynth
{

/// A complex signal: gradients in the frames of the faces, x + i y.
struct ComplexTensor
{
  torch::Tensor Real;      ///< x
  torch::Tensor Imaginary; ///< y
};

struct FaceIncidence;
struct PoissonTables;

/// PoissonOperators as tensors of one floating-point type on one device.
struct MeshTensors
{
  torch::Tensor Corners[3];        ///< [F] int64 each
  torch::Tensor BasisGradientX[3]; ///< [F, 1] each: x components of the basis gradients
  torch::Tensor BasisGradientY[3]; ///< [F, 1] each: y components of the basis gradients
  torch::Tensor FaceAreas;         ///< [F, 1]
  torch::Tensor VertexMass;        ///< [V, 1]
  torch::Tensor InverseArea;       ///< [V, 1], one over a third of the area around; 0 where no triangle is
  torch::Tensor Used;              ///< [V, 1], 1 at vertices of triangles, else 0; undefined when all are used
  std::shared_ptr<const CholeskySolver> Solver; ///< factor of L plus its shift
  std::shared_ptr<const FaceIncidence>
    Incidence;                                 ///< tables of the fused layers, for float32 on the processor; else null
  std::shared_ptr<const PoissonTables> Tables; ///< tables of FusedPoisson.h, where Incidence is; else null
  torch::Tensor DenseInverse;                  ///< [V, V] after UseDenseInverse(); else undefined

  MeshTensors() = default;
  /// Copies the operators; @p options gives type (float32 or float64) and device. With the @p points of the mesh, [V, 3],
  /// parts of it that are computed at a time are compact; results differ by rounding only.
  explicit MeshTensors(const PoissonOperators& operators, const torch::TensorOptions& options = torch::kFloat32,
    const PointMatrix& points = PointMatrix());
};

/// A vertex signal at the faces.
struct FaceSignal
{
  ComplexTensor Gradient; ///< FaceGradient()
  torch::Tensor Mean;     ///< FaceMean()
};

/// Computes FaceGradient() and FaceMean() together, at the cost of one of them.
FaceSignal AtFaces(const MeshTensors& mesh, const torch::Tensor& signal);

/// G x: gradients of a vertex signal in the frames of the faces.
ComplexTensor FaceGradient(const MeshTensors& mesh, const torch::Tensor& signal);

/// G^T (A g): the right-hand side of the Poisson equation whose solution has gradients closest to g.
torch::Tensor IntegratedDivergence(const MeshTensors& mesh, const ComplexTensor& gradients);

/// Mean of the three corners of each face.
torch::Tensor FaceMean(const MeshTensors& mesh, const torch::Tensor& signal);

/// Area-weighted mean of the faces around each vertex; 0 at unused vertices.
torch::Tensor VertexMean(const MeshTensors& mesh, const torch::Tensor& faceSignal);

/// Mean over the vertices weighted by mass, [..., 1, C].
torch::Tensor MassMean(const MeshTensors& mesh, const torch::Tensor& signal);

/// Applies the inverse of L plus its shift to each channel, in double on the processor for any type and device of the signal. The
/// gradient is the same solve of the incoming gradient (the matrix is symmetric and constant). With a dense inverse,
/// one matrix product on the mesh's device.
///
/// The constant part of each channel is lifted by the shift only and carries rounding noise: use WithoutMean().
/// @throws InvalidInput when a number is not finite.
torch::Tensor SolvePoisson(const MeshTensors& mesh, const torch::Tensor& rightHandSide);

/// Subtracts the mass-weighted mean of a solution; 0 at unused vertices, which the equation does not determine.
torch::Tensor WithoutMean(const MeshTensors& mesh, const torch::Tensor& solution);

/// Interleaves gradients: [..., 2 F, C] with the real parts in even rows and the imaginary ones in odd rows, as in the
/// published code.
torch::Tensor Interleaved(const ComplexTensor& gradients);

} // namespace surfsynth
