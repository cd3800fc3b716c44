// SPDX-License-Identifier: BSD-3-Clause
#include "RandomFlowMatching.h"

#include "RandomPoissonNet.h"

namespace surfsynth::test
{

namespace
{
PoissonNetOptions SmallOptions()
{
  PoissonNetOptions options;
  options.Width = 16;
  options.Blocks = 2;
  options.ComplexLayers = 2;
  return options;
}

PoissonNetOptions LinearOptions(std::int64_t inputs, std::int64_t outputs)
{
  PoissonNetOptions options = SmallOptions();
  options.Head = PoissonNetHead::Linear;
  options.InputChannels = inputs;
  options.OutputChannels = outputs;
  return options;
}

FlowMatchingModel ModelOf(const PoissonNetOptions& options, const TriangleMesh& shape, std::uint64_t seed)
{
  FlowMatchingModel model;
  model.Velocity = RandomModel(options, seed);
  model.SignalMean = Eigen::RowVectorXd::Zero(options.InputChannels);
  model.SignalScale = Eigen::RowVectorXd::Ones(options.InputChannels);
  model.Shape.Mean = SecondMoments(Normalized(shape, FlowNormalization(shape)));
  return model;
}
} // namespace

FlowMatchingModel RandomDeformer(const TriangleMesh& shape, std::uint64_t seed)
{
  PoissonNetOptions options = SmallOptions();
  options.ModulateHead = true;
  options.InnerProducts = true;
  options.ExtraFeatures = FlowMatchingModel::PlainConditions;
  return ModelOf(options, shape, seed);
}

FlowMatchingModel RandomSignalModel(const TriangleMesh& shape, std::int64_t components, std::uint64_t seed)
{
  PoissonNetOptions options = LinearOptions(components, components);
  options.ExtraFeatures = FlowMatchingModel::PlainConditions;
  FlowMatchingModel model = ModelOf(options, shape, seed);
  model.SignalName = "Mixture";
  model.SignalMean = Eigen::RowVectorXd::LinSpaced(components, 2.0, 1.0 + static_cast<double>(components));
  model.SignalScale = Eigen::RowVectorXd::LinSpaced(components, 0.5, 0.5 * static_cast<double>(components));
  return model;
}

void AddRandomEncoder(FlowMatchingModel& model, std::int64_t channels, std::uint64_t seed)
{
  model.Encoder = RandomModel(LinearOptions(3, channels), seed + 1);
  PoissonNetOptions options = model.Velocity.Options;
  options.ExtraFeatures = FlowMatchingModel::PlainConditions + channels;
  model.Velocity = RandomModel(options, seed);
}

} // namespace surfsynth::test
