// SPDX-License-Identifier: BSD-3-Clause
#include "Learning/Training/TrainingCheckpoint.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <nlohmann/json.hpp>

#include <locale>
#include <sstream>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr const char* Architecture = "training_checkpoint";
constexpr const char* HistoryName = "history";
constexpr const char* RecipeKey = "recipe";

std::map<std::string, std::string> ParseRecipe(const SafetensorsFile& file)
{
  std::map<std::string, std::string> recipe;
  const auto found = file.Metadata().find(RecipeKey);
  const nlohmann::json json = found == file.Metadata().end() ? nlohmann::json()
                                                             : nlohmann::json::parse(found->second, nullptr, false);
  bool valid = json.is_object();
  for (auto entry = json.begin(); valid && entry != json.end(); ++entry)
  {
    valid = entry->is_string();
    recipe[entry.key()] = valid ? entry->get<std::string>() : "";
  }
  if (!valid)
  {
    throw ModelMismatch(file.Name() + ": the metadata \"recipe\" is no JSON object of strings; expected a checkpoint.");
  }
  return recipe;
}

/// Number of rows of the history.
std::int64_t RequireHistory(const SafetensorsFile& file)
{
  const std::vector<std::int64_t>& shape = file.Entry(HistoryName).Shape;
  if (shape.size() != 2 || shape[1] != static_cast<std::int64_t>(NetworkLossHistory().Columns().size()))
  {
    throw ModelMismatch(file.Name() + ": \"history\" is no table of six columns; expected a checkpoint.");
  }
  return shape[0];
}

CheckpointHeader HeaderOf(const SafetensorsFile& file)
{
  const auto architecture = file.Metadata().find("architecture");
  if (architecture == file.Metadata().end() || architecture->second != Architecture)
  {
    throw ModelMismatch(file.Name() + ": the metadata \"architecture\" is " +
      (architecture == file.Metadata().end() ? "missing" : "\"" + architecture->second + "\"") + "; expected \"" +
      Architecture + "\".");
  }
  CheckpointHeader header;
  header.Recipe = ParseRecipe(file);
  header.Iterations = RequireHistory(file);
  for (const auto& [name, entry] : file.Tensors())
  {
    header.Numbers += name == HistoryName ? 0 : entry.NumberOfElements();
  }
  return header;
}

LossHistory ReadHistory(const SafetensorsFile& file)
{
  LossHistory history = NetworkLossHistory();
  const std::size_t columns = history.Columns().size();
  const auto rows = static_cast<std::size_t>(RequireHistory(file));
  const std::vector<double> numbers = file.Float64(HistoryName);
  for (std::size_t k = 0; k < rows; ++k)
  {
    const double* row = numbers.data() + k * columns;
    if (row[0] != static_cast<double>(k + 1))
    {
      throw ModelMismatch(file.Name() + ": row " + std::to_string(k) +
        " of \"history\" is of another iteration; expected all iterations from 1 on.");
    }
    history.Append({ row, row + columns });
  }
  return history;
}
} // namespace

LossHistory NetworkLossHistory()
{
  return { { "iteration" }, { "loss", "vertex_loss", "jacobian_loss", "gradient_norm", "learning_rate" }, "loss" };
}

std::map<std::string, std::string> RecipeOf(const TrainingOptions& options, const std::string& training)
{
  std::map<std::string, std::string> recipe = { { "training", training },
    { "learning_rate", FormatExact(options.LearningRate) },
    { "learning_rate_factor", FormatExact(options.LearningRateFactor) },
    { "gradient_clip", FormatExact(options.GradientClip) },
    { "weight_averaging", FormatExact(options.WeightAveraging) }, { "seed", std::to_string(options.Seed) },
    { "width", std::to_string(options.Width) }, { "blocks", std::to_string(options.Blocks) },
    { "complex_layers", std::to_string(options.ComplexLayers) },
    { "inner_products", options.InnerProducts ? "yes" : "no" },
    { "poisson_shift", ShiftOfTrainings == PoissonShift::Mass ? "mass" : "identity" } };
  if (options.Optimizer == TrainingOptimizer::Muon) // no entry in recipes of earlier versions
  {
    recipe["optimizer"] = "muon";
  }
  return recipe;
}

std::string FormatExact(double number)
{
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  text << number;
  return text.str();
}

void RequireSameRecipe(const std::string& file, const std::map<std::string, std::string>& expected,
  const std::map<std::string, std::string>& found)
{
  for (const auto& [key, value] : expected)
  {
    const auto entry = found.find(key);
    if (entry == found.end() || entry->second != value)
    {
      throw ModelMismatch(file + ": the checkpoint was written with " + key + " = " +
        (entry == found.end() ? "nothing" : entry->second) + "; expected " + value +
        " as in this training. Train with the same recipe and dataset, or begin anew with another checkpoint file.");
    }
  }
  for (const auto& [key, value] : found)
  {
    if (expected.count(key) == 0)
    {
      throw ModelMismatch(file + ": the checkpoint was written with " + key + " = " + value +
        "; expected a checkpoint without " + key +
        ", as this training. Train with the same recipe and dataset, or begin anew with another checkpoint file.");
    }
  }
}

void WriteCheckpoint(const std::string& path, const TrainingCheckpoint& checkpoint)
{
  std::map<std::string, TensorData> tensors;
  for (const auto& [name, tensor] : checkpoint.Tensors)
  {
    tensors[name] = TensorData::FromFloat32(tensor.Shape, tensor.Values);
  }
  const std::size_t rows = checkpoint.History.Size();
  const std::size_t columns = checkpoint.History.Columns().size();
  std::vector<double> history;
  history.reserve(rows * columns);
  for (std::size_t k = 0; k < rows; ++k)
  {
    const std::vector<double>& row = checkpoint.History.Row(k);
    history.insert(history.end(), row.begin(), row.end());
  }
  tensors[HistoryName] = TensorData::FromFloat64(
    { static_cast<std::int64_t>(rows), static_cast<std::int64_t>(columns) }, history);
  WriteSafetensors(path, tensors,
    { { "architecture", Architecture }, { "format_version", "1" }, { "producer", "SurfaceSynthesis" },
      { RecipeKey, nlohmann::json(checkpoint.Recipe).dump() } });
}

CheckpointHeader ReadCheckpointHeader(const std::string& path) { return HeaderOf(SafetensorsFile(path)); }

TrainingCheckpoint ReadCheckpoint(const std::string& path)
{
  const SafetensorsFile file(path);
  TrainingCheckpoint checkpoint;
  checkpoint.Recipe = HeaderOf(file).Recipe;
  checkpoint.History = ReadHistory(file);
  for (const auto& [name, entry] : file.Tensors())
  {
    if (name != HistoryName)
    {
      file.RequireFinite(name);
      checkpoint.Tensors[name] = { entry.Shape, file.Float32(name) };
    }
  }
  return checkpoint;
}

} // namespace surfsynth
