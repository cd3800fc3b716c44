// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The operators of a mesh on tensors: differentiable gradient, divergence, averages and Poisson solve.
///
/// Signals are [..., V, C] at vertices and [..., F, C] at faces: any leading dimensions, then places, then channels.
/// Everything is differentiable in the signal (float32 on the processor: once; else as often as wanted); the mesh is
/// constant.
#pragma once

#include "Inference/PoissonNet/PoissonOperators.h"

#include <torch/torch.h>

#include <memory>

namespace surfsynth
{

/// A complex signal: gradients in the frames of the faces, x + i y.
struct ComplexTensor
{
  torch::Tensor Real;
  torch::Tensor Imaginary;
};

struct FaceIncidence;

/// PoissonOperators as tensors of one floating-point type on one device.
struct MeshTensors
{
  torch::Tensor Corners[3];        ///< [F] int64 each
  torch::Tensor BasisGradientX[3]; ///< [F, 1] each: x components of the hat functions' gradients
  torch::Tensor BasisGradientY[3]; ///< [F, 1] each
  torch::Tensor FaceAreas;         ///< [F, 1]
  torch::Tensor VertexMass;        ///< [V, 1]
  torch::Tensor InverseArea;       ///< [V, 1], one over a third of the area around; 0 where no triangle is
  torch::Tensor Used;              ///< [V, 1], 1 where a triangle is, else 0; undefined when that is everywhere
  std::shared_ptr<const CholeskySolver> Solver;
  std::shared_ptr<const FaceIncidence> Incidence; ///< for what float32 on the processor does in one step; else null
  torch::Tensor DenseInverse;                     ///< [V, V] where UseDenseInverse() was called; else undefined

  MeshTensors() = default;
  /// Copies; @p options gives type (float32 or float64) and device.
  explicit MeshTensors(const PoissonOperators& operators, const torch::TensorOptions& options = torch::kFloat32);
};

/// A vertex signal at the faces.
struct FaceSignal
{
  ComplexTensor Gradient;
  torch::Tensor Mean;
};

/// FaceGradient() and FaceMean() together, which costs what one of them does.
FaceSignal AtFaces(const MeshTensors& mesh, const torch::Tensor& signal);

/// G x: gradients of a vertex signal in the frames of the faces.
ComplexTensor FaceGradient(const MeshTensors& mesh, const torch::Tensor& signal);

/// G^T (A g): the right-hand side of the Poisson equation whose solution has gradients closest to g.
torch::Tensor IntegratedDivergence(const MeshTensors& mesh, const ComplexTensor& gradients);

/// Mean of the three corners.
torch::Tensor FaceMean(const MeshTensors& mesh, const torch::Tensor& signal);

/// Area-weighted mean of the faces around each vertex; 0 where there is none.
torch::Tensor VertexMean(const MeshTensors& mesh, const torch::Tensor& faceSignal);

/// Mean over the vertices weighted by mass, [..., 1, C].
torch::Tensor MassMean(const MeshTensors& mesh, const torch::Tensor& signal);

/// (L + 1e-6 I)^-1 applied to each channel, in double on the processor whatever type and device of the signal. The
/// gradient is the same solve of the incoming gradient (the matrix is symmetric and constant). With a dense inverse, one
/// matrix product on the mesh's device.
///
/// The constant part of each channel is lifted by 1e-6 only and carries rounding noise: use WithoutMean().
/// @throws InvalidInput when a number is not finite.
torch::Tensor SolvePoisson(const MeshTensors& mesh, const torch::Tensor& rightHandSide);

/// The solution minus its mass-weighted mean; 0 at vertices that no face uses, where the equation says nothing.
torch::Tensor WithoutMean(const MeshTensors& mesh, const torch::Tensor& solution);

/// [..., 2 F, C] with the real parts in even rows and the imaginary ones in odd rows, as in the published code.
torch::Tensor Interleaved(const ComplexTensor& gradients);

} // namespace surfsynth
