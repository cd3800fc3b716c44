// SPDX-License-Identifier: BSD-3-Clause
//
// vtkFieldLatentTrainer: the model of the plain training, its table, planar meshes, resuming, messages.
#include "FieldLatentPipelines.h"
#include "FileBytes.h"
#include "FilterContract.h"

#include "vtkFieldLatentTrainer.h"

#include "IO/Datasets/TextureDataset.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Learning/Training/FieldLatentTrainer.h"

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>
#include <thread>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

namespace
{
constexpr int Iterations = 6;

/// Triangles of a square grid of 8 x 8 cells.
PlanarMesh Grid()
{
  constexpr Index n = 8;
  PlanarMesh mesh;
  mesh.Points.resize((n + 1) * (n + 1), 2);
  mesh.Triangles.resize(2 * n * n, 3);
  for (Index p = 0; p < (n + 1) * (n + 1); ++p)
  {
    mesh.Points.row(p) = Eigen::RowVector2d(p % (n + 1), p / (n + 1)) / static_cast<double>(n);
  }
  for (Index c = 0; c < n * n; ++c)
  {
    const Index first = c / n * (n + 1) + c % n;
    mesh.Triangles.row(2 * c) << first, first + 1, first + n + 2;
    mesh.Triangles.row(2 * c + 1) << first, first + n + 2, first + n + 1;
  }
  return mesh;
}

/// The bytes of Pattern(), the row of the largest y first, and a grid.
TextureDataset PatternDataset()
{
  const auto pattern = Pattern();
  TextureDataset dataset;
  TextureImage image = { pattern->GetDimensions()[1], pattern->GetDimensions()[0], {} };
  for (std::int64_t row = image.Height - 1; row >= 0; --row)
  {
    for (std::int64_t k = 0; k < image.Width; ++k)
    {
      const double* color = pattern->GetPointData()->GetScalars()->GetTuple3(row * image.Width + k);
      image.Pixels.insert(image.Pixels.end(), color, color + 3);
    }
  }
  dataset.Images = { image };
  dataset.Meshes = { Grid() };
  return dataset;
}

/// A training of a moment that begins anew and writes <name>.
vtkSmartPointer<vtkFieldLatentTrainer> TrainerFor(const std::string& name, vtkDataObject* images = Pattern())
{
  std::filesystem::remove(name);
  std::filesystem::remove(name + ".checkpoint");
  auto filter = vtkSmartPointer<vtkFieldLatentTrainer>::New();
  filter->SetInputDataObject(0, images);
  filter->SetModelFileName(name.c_str());
  filter->SetNumberOfMeshes(2);
  filter->SetMeshPoints(60);
  filter->SetLatentDimension(2);
  filter->SetChannels(4);
  filter->SetEncoderLayers(1);
  filter->SetHeads(2);
  filter->SetSamplesPerRing(8);
  filter->SetDecoderLayers(2);
  filter->SetDecoderWidth(8);
  filter->SetIterations(Iterations);
  filter->SetBatchSize(12);
  filter->SetDeviceToCPU();
  return filter;
}

FieldLatentTrainingOptions SameOptions()
{
  FieldLatentTrainingOptions options;
  options.Network = SmallFieldLatents();
  options.Network.SamplesPerRing = 8;
  options.Network.DecoderLayers = 2;
  options.Network.DecoderWidth = 8;
  options.Iterations = Iterations;
  options.BatchSize = 12;
  options.Device = TrainingDevice::CPU;
  return options;
}

vtkTable* TableOf(vtkAlgorithm* filter) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(0)); }

std::string ErrorOfTraining(vtkFieldLatentTrainer* filter)
{
  const std::string error = surfsynthtest::ErrorOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), 0);
  return error;
}

vtkSmartPointer<vtkImageData> Sized(int width, int height, int depth)
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(width, height, depth);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  image->GetPointData()->GetScalars()->Fill(100);
  return image;
}
} // namespace

TEST(FieldLatentTrainerFilter, ModelAndTableAreThoseOfThePlainTraining)
{
  WriteTextureDataset("pattern.dataset", PatternDataset());
  const auto filter = TrainerFor("file.model", nullptr);
  filter->SetDatasetFileName("pattern.dataset");
  filter->SetLossTableFileName("file.csv");
  OutputOf(filter);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), Iterations);
  EXPECT_STREQ(filter->GetDeviceInUse(), "CPU");
  TrainingFiles files;
  files.Model = "plain.model";
  files.LossTable = "plain.csv";
  const FieldLatentTrainer plain = TrainFieldLatents(PatternDataset(), SameOptions(), files);
  EXPECT_EQ(BytesOf("file.model"), BytesOf("plain.model"));
  EXPECT_EQ(BytesOf("file.csv"), BytesOf("plain.csv"));
  vtkTable* table = TableOf(filter);
  ASSERT_EQ(table->GetNumberOfRows(), Iterations);
  ASSERT_EQ(table->GetNumberOfColumns(), 6);
  for (vtkIdType k = 0; k < Iterations; ++k)
  {
    EXPECT_EQ(table->GetValueByName(k, "iteration").ToInt(), k + 1);
    for (const char* column : { "loss", "reconstruction_loss", "divergence_loss", "gradient_norm", "learning_rate" })
    {
      EXPECT_EQ(table->GetValueByName(k, column).ToDouble(), plain.History().Value(static_cast<std::size_t>(k), column))
        << column;
    }
  }
  EXPECT_EQ(table->GetValueByName(0, "learning_rate").ToDouble(), 1e-3);
}

TEST(FieldLatentTrainerFilter, TheModelEncodesAndDecodesTextures)
{
  const auto filter = TrainerFor("applied.model");
  OutputOf(filter);
  const auto surface = TexturedGrid(3);
  const auto codes = Encoded(surface, Pattern(), "applied.model");
  EXPECT_TRUE(codes->GetPointData()->HasArray("FieldLatent_1"));
  const auto decoder = DecoderOn(codes, "applied.model");
  OutputOf(decoder);
  EXPECT_EQ(TexelsOf(decoder)->GetNumberOfTuples(), 64 * 64);
}

TEST(FieldLatentTrainerFilter, SeveralImagesAndTheSameSeedGiveTheSameBits)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Pattern());
  blocks->SetBlock(2, Pattern(1, VTK_FLOAT)); // block 1 is empty
  const auto first = TrainerFor("first.model", blocks);
  OutputOf(first);
  OutputOf(TrainerFor("second.model", blocks));
  EXPECT_EQ(BytesOf("first.model"), BytesOf("second.model"));
  OutputOf(TrainerFor("single.model"));
  EXPECT_NE(BytesOf("first.model"), BytesOf("single.model"));
  const auto seeded = TrainerFor("seeded.model", blocks);
  seeded->SetSeed(1);
  OutputOf(seeded);
  EXPECT_NE(BytesOf("first.model"), BytesOf("seeded.model"));
}

TEST(FieldLatentTrainerFilter, ImagesOfEachTypeThatHoldTheSameColorsGiveTheSameModel)
{
  OutputOf(TrainerFor("bytes.model"));
  OutputOf(TrainerFor("opaque.model", Pattern(4)));
  OutputOf(TrainerFor("floats.model", Pattern(3, VTK_DOUBLE)));
  EXPECT_EQ(BytesOf("opaque.model"), BytesOf("bytes.model"));
  EXPECT_EQ(BytesOf("floats.model"), BytesOf("bytes.model"));
  const auto translucent = Pattern(4);
  translucent->GetPointData()->GetScalars()->SetComponent(5, 3, 7.0);
  EXPECT_THAT(WarningsOf(TrainerFor("translucent.model", translucent)), ElementsAre(HasSubstr("alpha")));
}

TEST(FieldLatentTrainerFilter, PlanarMeshesDependOnTheirProperties)
{
  OutputOf(TrainerFor("meshes.model"));
  const auto more = TrainerFor("more.model");
  more->SetNumberOfMeshes(3);
  OutputOf(more);
  EXPECT_NE(BytesOf("more.model"), BytesOf("meshes.model"));
  const auto finer = TrainerFor("finer.model");
  finer->SetMeshPoints(61);
  OutputOf(finer);
  EXPECT_NE(BytesOf("finer.model"), BytesOf("meshes.model"));
  for (const int points : { 16, 2500 }) // the smallest, and the default: CheckDataset() accepts both
  {
    const auto filter = TrainerFor("accepted.model");
    filter->SetMeshPoints(points);
    OutputOf(filter);
    EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), Iterations) << points;
  }
}

TEST(FieldLatentTrainerFilter, SizesAreThoseOfThePresetsWhereNoneIsGiven)
{
  for (const int sizes : { vtkFieldLatentTrainer::SMALL, vtkFieldLatentTrainer::PAPER })
  {
    const auto filter = TrainerFor("sizes.model");
    filter->SetSizes(sizes);
    filter->SetIterations(1);
    filter->SetBatchSize(3);
    filter->SetCoordinatesToBarycentric();
    filter->SetLatentDimension(0);
    filter->SetSamplesPerRing(0);
    filter->SetDecoderLayers(0);
    OutputOf(filter);
    FieldLatentOptions expected = sizes == vtkFieldLatentTrainer::PAPER ? FieldLatentOptions::Paper()
                                                                        : FieldLatentOptions::Small();
    expected.Channels = 4;
    expected.EncoderLayers = 1;
    expected.Heads = 2;
    expected.DecoderWidth = 8;
    expected.Coordinates = FieldLatentCoordinates::Barycentric;
    EXPECT_TRUE(ReadFieldLatents("sizes.model").Options == expected) << sizes;
  }
}

TEST(FieldLatentTrainerFilter, AnInterruptedTrainingGoesOn)
{
  OutputOf(TrainerFor("whole.model"));
  const auto filter = TrainerFor("parts.model");
  for (const double place : { 0.2, 0.6 })
  {
    EventRecorder events(filter);
    events.AbortAt = place;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0);
    EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
    EXPECT_TRUE(std::filesystem::exists("parts.model.checkpoint"));
  }
  OutputOf(filter);
  EXPECT_EQ(BytesOf("parts.model"), BytesOf("whole.model"));
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 0) << "nothing has changed";
  filter->SetDivergenceWeight(0.5);
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("divergence_weight"));
  filter->ResumeOff();
  OutputOf(filter);
  EXPECT_NE(BytesOf("parts.model"), BytesOf("whole.model"));
}

TEST(FieldLatentTrainerFilter, TrainsInTheBackground)
{
  OutputOf(TrainerFor("front.model"));
  const auto filter = TrainerFor("back.model");
  filter->BackgroundOn();
  OutputOf(filter);
  while (std::string(filter->GetBackgroundState()).find("running") == 0)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_THAT(filter->GetBackgroundState(), HasSubstr("finished"));
  filter->Modified(); // looks after the training
  OutputOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), Iterations);
  filter->BackgroundOff();
  EXPECT_EQ(BytesOf("back.model"), BytesOf("front.model"));
}

TEST(FieldLatentTrainerFilter, ProgressIsMonotone)
{
  const auto filter = TrainerFor("progress.model");
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
}

TEST(FieldLatentTrainerFilter, MessagesAboutImages)
{
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", nullptr)), HasSubstr("There is no image on port 0"));
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", Sized(16, 15, 1))),
    AllOf(HasSubstr("Image 0 has 16 x 15 x 1 pixels"), HasSubstr("16 x 16")));
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", Sized(16, 16, 2))), HasSubstr("vtkExtractVOI"));
  const auto bare = Sized(20, 20, 1);
  bare->GetPointData()->SetScalars(nullptr);
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", bare)), HasSubstr("no active point scalars"));
  const auto infinite = Pattern(3, VTK_FLOAT);
  infinite->GetPointData()->GetScalars()->SetComponent(9, 1, std::numeric_limits<double>::infinity());
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", infinite)), HasSubstr("not finite at place 9"));
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Pattern());
  blocks->SetBlock(1, TexturedGrid(2));
  EXPECT_THAT(ErrorOfTraining(TrainerFor("refused.model", blocks)), HasSubstr("Image 1 is a vtkPolyData"));
  EXPECT_FALSE(std::filesystem::exists("refused.model"));
}

TEST(FieldLatentTrainerFilter, MessagesAboutOptionsAndFiles)
{
  const auto unnamed = TrainerFor("refused.model");
  unnamed->SetModelFileName("");
  EXPECT_THAT(ErrorOfTraining(unnamed), HasSubstr("ModelFileName is empty"));
  EXPECT_THAT(ErrorOfTraining(TrainerFor("nowhere/refused.model")), HasSubstr("nowhere"));
  const auto missing = TrainerFor("refused.model", nullptr);
  missing->SetDatasetFileName("none.dataset");
  EXPECT_THAT(ErrorOfTraining(missing), HasSubstr("none.dataset"));
  const auto heads = TrainerFor("refused.model");
  heads->SetHeads(3);
  EXPECT_THAT(ErrorOfTraining(heads), AllOf(HasSubstr("Heads is 3"), HasSubstr("divisor")));
  const auto batch = TrainerFor("refused.model");
  batch->SetCoordinatesToBarycentric();
  batch->SetBatchSize(4);
  EXPECT_THAT(ErrorOfTraining(batch), AllOf(HasSubstr("BatchSize"), HasSubstr("multiple of 3")));
  const auto texels = TrainerFor("refused.model");
  texels->SetMaximumTexels(5.0);
  EXPECT_THAT(ErrorOfTraining(texels), HasSubstr("MaximumTexels"));
  EXPECT_FALSE(std::filesystem::exists("refused.model"));
  const auto kept = TrainerFor("kept.model", nullptr);
  WriteTextureDataset("kept.model", PatternDataset());
  const std::string bytes = BytesOf("kept.model");
  kept->SetDatasetFileName("kept.model");
  EXPECT_THAT(ErrorOfTraining(kept), HasSubstr("is one that the training is made from"));
  EXPECT_TRUE(BytesOf("kept.model") == bytes);
}

TEST(FieldLatentTrainerFilter, EmptyImagesAreNoErrorAndInputsAreUnchanged)
{
  vtkNew<vtkImageData> none;
  const auto filter = TrainerFor("empty.model", none);
  OutputOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  EXPECT_FALSE(std::filesystem::exists("empty.model"));
  const auto image = Pattern();
  const vtkMTimeType before = image->GetMTime();
  OutputOf(TrainerFor("unchanged.model", image));
  EXPECT_EQ(image->GetMTime(), before);
}

TEST(FieldLatentTrainerFilter, PropertiesAreClampedAndPrinted)
{
  vtkNew<vtkFieldLatentTrainer> filter;
  filter->SetNumberOfMeshes(0);
  EXPECT_EQ(filter->GetNumberOfMeshes(), 1);
  filter->SetMeshPoints(2);
  EXPECT_EQ(filter->GetMeshPoints(), 16);
  filter->SetSizes(7);
  EXPECT_EQ(filter->GetSizes(), vtkFieldLatentTrainer::PAPER);
  filter->SetHeads(-1);
  EXPECT_EQ(filter->GetHeads(), 0);
  filter->SetCoordinates(-3);
  EXPECT_EQ(filter->GetCoordinates(), vtkFieldLatentTrainer::LOGARITHMIC);
  filter->SetIterations(0);
  EXPECT_EQ(filter->GetIterations(), 1);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line :
    { "LearningRate: 0.001", "NumberOfMeshes: 1", "MeshPoints: 16", "Sizes: 1", "LatentDimension: 0", "Channels: 0",
      "EncoderLayers: 0", "Heads: 0", "SamplesPerRing: 0", "DecoderLayers: 0", "DecoderWidth: 0", "Coordinates: 0",
      "Iterations: 1", "BatchSize: 48", "FinalLearningRate: 1e-05", "DivergenceWeight: 0.01", "MinimumTexels: 10",
      "MaximumTexels: 150", "TargetPower: 0", "ColorAugmentation: 0", "GradientClip: 1" })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}
