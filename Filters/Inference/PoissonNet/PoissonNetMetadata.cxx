// SPDX-License-Identifier: BSD-3-Clause
// The options of a PoissonNet in the metadata of its model file.
#include "Inference/PoissonNet/PoissonNetOptions.h"

#include "Core/Common/Errors.h"

#include <nlohmann/json.hpp>

#include <utility>

namespace surfsynth
{

namespace
{
using Metadata = std::map<std::string, std::string>;

template <typename Value>
using Names = std::vector<std::pair<const char*, Value>>;

const Names<PoissonNetHead> HeadNames = { { "linear", PoissonNetHead::Linear },
  { "njf", PoissonNetHead::GradientDomain } };
// The first name of a value is the one that is written.
const Names<PoissonNetDomain> DomainNames = { { "vertices", PoissonNetDomain::Vertices },
  { "faces", PoissonNetDomain::Faces }, { "global_mean", PoissonNetDomain::Global },
  { "global", PoissonNetDomain::Global } };
const Names<LastActivation> ActivationNames = { { "identity", LastActivation::Identity },
  { "log_softmax", LastActivation::LogSoftmax } };

template <typename Value>
std::string NameOf(const Names<Value>& names, Value value)
{
  for (const auto& [name, named] : names)
  {
    if (named == value)
    {
      return name;
    }
  }
  return "";
}

const Names<PoissonShift> ShiftNames = { { "identity", PoissonShift::Identity }, { "mass", PoissonShift::Mass } };

/// Reads typed values from the metadata of one file.
class MetadataReader
{
public:
  MetadataReader(const std::string& file, const Metadata& metadata)
    : File(file)
    , Values(metadata)
  {
    const auto config = metadata.find("config");
    if (config == metadata.end())
    {
      this->Fail("config", "missing", "a JSON object with cmlp_nlayers and what else differs from the defaults");
    }
    this->Config = nlohmann::json::parse(config->second, nullptr, false);
    if (!this->Config.is_object())
    {
      this->Fail("config", "not a JSON object", "a JSON object");
    }
  }

  std::int64_t Number(const std::string& key, std::int64_t missing = -1) const
  {
    const auto found = this->Values.find(key);
    if (found == this->Values.end() && missing >= 0)
    {
      return missing;
    }
    const std::string text = found == this->Values.end() ? "" : found->second;
    if (text.empty() || text.size() > 9 || text.find_first_not_of("0123456789") != std::string::npos)
    {
      this->Fail(key, text.empty() ? "missing" : "\"" + text + "\"", "a whole number below 1e9");
    }
    return std::stoll(text);
  }
  template <typename Value>
  Value Choice(const std::string& key, const Names<Value>& names, const char* missing = nullptr) const
  {
    const auto found = this->Values.find(key);
    const std::string text = found != this->Values.end() ? found->second : missing ? missing : "";
    std::string known;
    for (const auto& [name, value] : names)
    {
      if (text == name)
      {
        return value;
      }
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    this->Fail(key, text.empty() ? "missing" : "\"" + text + "\"", "one of " + known);
  }
  bool Flag(const char* key, bool missing) const
  {
    const auto found = this->Config.find(key);
    if (found == this->Config.end() || found->is_null())
    {
      return missing;
    }
    if (!found->is_boolean())
    {
      this->Fail(std::string("config.") + key, found->dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
        "true or false");
    }
    return found->get<bool>();
  }
  std::int64_t ConfigNumber(const char* key) const
  {
    const auto found = this->Config.find(key);
    if (found == this->Config.end() || !found->is_number_unsigned() || found->get<std::uint64_t>() > 1000000000)
    {
      this->Fail(std::string("config.") + key, found == this->Config.end() ? "missing" : "something else",
        "a whole number below 1e9");
    }
    return found->get<std::int64_t>();
  }
  double Fraction(const char* key) const
  {
    const auto found = this->Config.find(key);
    if (found == this->Config.end() || found->is_null())
    {
      return 0.0;
    }
    if (!found->is_number())
    {
      this->Fail(std::string("config.") + key, "not a number", "a number in [0, 1)");
    }
    return found->get<double>();
  }

private:
  [[noreturn]] void Fail(const std::string& key, const std::string& found, const std::string& expected) const
  {
    throw ModelMismatch(this->File + ": the metadata \"" + key + "\" is " + found + "; expected " + expected + ".");
  }

  const std::string& File;
  const Metadata& Values;
  nlohmann::json Config;
};
} // namespace

PoissonNetOptions OptionsFromMetadata(const std::string& file, const Metadata& metadata)
{
  const MetadataReader reader(file, metadata);
  PoissonNetOptions options;
  options.InputChannels = reader.Number("C_in");
  options.OutputChannels = reader.Number("C_out");
  options.Width = reader.Number("C_width");
  options.Blocks = reader.Number("n_blocks");
  options.ExtraFeatures = reader.Number("extra_features", 0);
  options.Head = reader.Choice("head", HeadNames);
  options.Domain = reader.Choice("outputs_at", DomainNames, "vertices");
  options.Activation = reader.Choice("last_activation", ActivationNames, "identity");
  options.Shift = reader.Choice("poisson_shift", ShiftNames, "identity");
  options.ComplexLayers = reader.ConfigNumber("cmlp_nlayers");
  // Default of the published configurations: blocks are modulated and the head is not.
  options.Modulate = reader.Flag("cmlp_modulate", true);
  options.ModulateHead = reader.Flag("cmlp_modulate", false);
  options.InnerProducts = reader.Flag("inner_prod_features", false);
  options.Normalize = reader.Flag("mlp_norm", false);
  options.MassWeightedNorm = reader.Flag("mass_norm", false);
  options.Dropout = reader.Fraction("dropout_p");
  try
  {
    CheckOptions(options);
  }
  catch (const InvalidInput& error)
  {
    throw ModelMismatch(file + ": " + error.what());
  }
  return options;
}

Metadata MetadataFromOptions(const PoissonNetOptions& options)
{
  CheckOptions(options);
  if (options.Head == PoissonNetHead::GradientDomain && options.Modulate != options.ModulateHead &&
    options.ModulateHead)
  {
    throw InvalidInput(
      "PoissonNet: the head is modulated and the blocks are not; expected both or neither or the blocks "
      "only, which are what model files can tell.");
  }
  nlohmann::json config = { { "cmlp_nlayers", options.ComplexLayers }, { "inner_prod_features", options.InnerProducts },
    { "mlp_norm", options.Normalize }, { "mass_norm", options.MassWeightedNorm }, { "dropout_p", options.Dropout } };
  // Left out when only the blocks are modulated, which is the meaning of a missing key.
  if (options.Modulate == options.ModulateHead || options.Head == PoissonNetHead::Linear)
  {
    config["cmlp_modulate"] = options.Modulate;
  }
  return { { "config", config.dump() }, { "head", NameOf(HeadNames, options.Head) },
    { "C_in", std::to_string(options.InputChannels) }, { "C_out", std::to_string(options.ResultChannels()) },
    { "C_width", std::to_string(options.Width) }, { "n_blocks", std::to_string(options.Blocks) },
    { "extra_features", std::to_string(options.ExtraFeatures) }, { "outputs_at", NameOf(DomainNames, options.Domain) },
    { "last_activation", NameOf(ActivationNames, options.Activation) },
    { "poisson_shift", NameOf(ShiftNames, options.Shift) } };
}

} // namespace surfsynth
