// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Denoising network for field latents [Mitchel2024], section 9.2. No torch.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Tangent/TangentHierarchy.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Inference/FieldLatents/LatentDiffusionModel.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace surfsynth
{

/// Features of the vertices that guide a sample. Empty parts guide nothing.
struct LatentDiffusionConditions
{
  /// [V], from 0 to NumberOfLabels - 1, or -1 for a vertex without a label. Not empty only for models with labels. A
  /// coarse vertex has the label of the vertex at its center.
  std::vector<std::int32_t> Labels;
  /// [V, 2], a tangent vector at each vertex in its frame, without unit: unit vectors are advised. Not empty only for
  /// directed models. A coarse vertex has that of the vertex at its center.
  FieldLatentMatrix Directions;
};

/// Evaluator of the network, without LibTorch, for one model and one surface.
///
/// A two-level U-Net of FCResNet blocks: a complex linear map, blocks on the surface, mean pooling, blocks on the coarser
/// level, unpooling, blocks on the surface that also see the features before the pooling, a complex linear map. Pooling
/// and unpooling carry vectors by parallel transport. A block is x + conv(MLP(conv(MLP(x)))) (with a complex linear map
/// of x where the widths differ). An MLP is three vector neurons (equation 19), each after a normalization (equation 20)
/// whose mean runs over all vertices of the level. The second convolution of a block sees the embedding. Beyond the paper,
/// the channels of its result, of the first map and before the last have real factors 1 + G e with the embedding e of the
/// time: what the network has to add to its input grows and falls with the noise, and without factors it learned less
/// where noise is least than a linear map of single vertices can.
///
/// Field convolution (equation 35): with X_c(q) the features of q in the neighborhood of p (p itself among them),
/// carried to the frame of p, u = X / sqrt(|X|^2 + 1e-6) and w the share of q in the area of the neighborhood,
///   Y_o(p) = sum over q, c of  w X_c(q) f_oc(r, a, pi(q)),   a = conj(u) log_p q / |log_p q|,  r = |log_p q| / r~,
/// where r~ is the radius of the mean vertex area element (section 6.6) of the level. log_p q and X_c(q) are both taken
/// at p: seen from q, the aligned angle is the same but for a turn by pi, which the weights of the filter learn.
///
/// The filter is f_oc = sum over k of W_ock h_k: an MLP with the inputs (r, Re a, Im a, pi) and two layers of eight
/// channels with ReLU gives h, which all channels share; but its arguments are those of channel c, for a depends on the
/// direction of X_c(q). So h is computed for each edge and channel, 100 multiplications and additions, and the sums
///   S_kc(p) = sum over q of w X_c(q) h_k(q, c)
/// are taken first: the last layer of the filter is then one complex matrix product of W with S for each vertex, [8 C] to
/// [C] ([Wu2019], the PointConv factorization). Per vertex and C = 96 channels these are 64 C C = 590,000 operations; the
/// sums take 2 * 100 * 7 C = 134,000. The alternative, one MLP for each pair of channels, would take 7 C C * 200.
/// Time and labels reach h as a vector of eight numbers for each label, and directions d(q) as conj(u) d(q).
///
/// Beyond the paper, h sees m(q), the direction of the centroid of the ring of q (TangentNeighborhoods::Centroids), as it
/// sees d(q), and the first map sees m and d beside the state. The code of one flat color has no direction but those of its
/// ring: the shipped encoder, which turns with the frames, writes it along m (agreement 0.995). Codes of neighbors are
/// therefore as incoherent as their rings. A network that does not see m has to find it in the noisy state.
///
/// Results have the same bits for every number of threads, turn with the frames and do not depend on the numbers of the
/// vertices (to rounding errors). Sums of neighborhoods are held for one tile of vertices at a time: memory beyond that is
/// about eight times that of the features of the surface, V 2 C numbers.
class LatentDiffusionNetwork
{
public:
  /// Prepares the weights; @p model is not needed afterwards.
  /// @param surface the levels of the surface, shared
  /// @throws InvalidInput as CheckModel(), and without @p surface.
  LatentDiffusionNetwork(const LatentDiffusionModel& model, std::shared_ptr<const TangentHierarchy> surface);
  ~LatentDiffusionNetwork();
  LatentDiffusionNetwork(LatentDiffusionNetwork&&) noexcept;
  LatentDiffusionNetwork& operator=(LatentDiffusionNetwork&&) noexcept;

  /// Architecture of the model.
  const LatentDiffusionOptions& Options() const;
  /// Levels of the surface.
  const TangentHierarchy& Surface() const;

  /// Evaluates the network.
  /// @param state [V, 2 d], real and imaginary part of each scaled tangent vector in turn, in the frames of the vertices
  /// @param time 0 to T, a step of the forward process
  /// @return [V, 2 d], what LatentDiffusionOptions::Target says, in the units of @p state.
  /// @throws InvalidInput when sizes or labels do not fit, or an input or a result is not finite; Cancelled.
  FieldLatentMatrix Evaluate(const FieldLatentMatrix& state, double time,
    const LatentDiffusionConditions& conditions = {}, const Progress& progress = {}) const;

private:
  class Internals;
  std::unique_ptr<Internals> Impl;
};

/// Floating-point operations of the matrix products of one evaluation: two for each factor, a complex product four real
/// ones. Filters, norms, sums over neighborhoods and activations are not counted.
double LatentDiffusionOperations(const LatentDiffusionOptions& options, std::int64_t vertices, std::int64_t coarse);

} // namespace surfsynth
