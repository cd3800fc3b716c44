// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Linear maps between the latents of an autoencoder and those of a diffusion. No torch.
#pragma once

#include "Inference/Common/ModelTensor.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"

#include <Eigen/Core>

#include <complex>

namespace surfsynth
{

/// Complex matrix [d, d] that maps the tangent vectors of a latent code, as complex numbers, to those of the diffusion. A
/// complex map commutes with turns of the frames.
using LatentMap = Eigen::MatrixXcd;

/// Map with the factors of equation 39 of [Mitchel2024] on its diagonal: sqrt(pi / 2) over the mean length of each tangent
/// vector, so that lengths have the mean of those of noise; 1 where the mean is 0.
/// @param latents [V, 2 d]
LatentMap ScalingMap(const FieldLatentMatrix& latents);

/// Map after which the tangent vectors of a code are uncorrelated and each component has the variance 1, as in noise:
/// C^(-1/2) S with S of ScalingMap() and the covariance C of the scaled latents, whose eigenvalues count at least as 1e-4 of the
/// largest. The best linear denoiser of such latents is a factor that depends on the time alone, and that of the velocity
/// is 0: all that a network learns is beyond it.
/// @param latents [V, 2 d]
LatentMap WhiteningMap(const FieldLatentMatrix& latents);

/// Maps the codes of all vertices. @param latents [V, 2 d]
FieldLatentMatrix Mapped(const LatentMap& map, const FieldLatentMatrix& latents);

/// The real matrix [2 d, 2 d] that does the same from the right to rows [V, 2 d].
Eigen::MatrixXf RealMatrix(const LatentMap& map);

/// A map as a tensor [2, d, d], real part, then imaginary part, and back.
ModelTensor TensorOf(const LatentMap& map);
LatentMap MapOfTensor(const ModelTensor& tensor);

} // namespace surfsynth
