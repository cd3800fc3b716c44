// SPDX-License-Identifier: BSD-3-Clause
//
// vtkLatentDiffusionTrainer: the dataset of a textured surface, the model of the plain training, resuming, messages.
#include "FieldLatentPipelines.h"
#include "FileBytes.h"
#include "FilterContract.h"

#include "vtkFieldLatentTextureFilter.h"
#include "vtkLatentDiffusionTrainer.h"

#include "IO/Datasets/LatentDataset.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Learning/Training/LatentDiffusionTrainer.h"

#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPointData.h>
#include <vtkTable.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
constexpr int Iterations = 4;

const std::string& Autoencoder()
{
  static const std::string model = WriteFieldLatentModel("diffusion.autoencoder");
  return model;
}

/// A square with texture coordinates, labels and directions.
vtkSmartPointer<vtkPolyData> Square()
{
  auto grid = TexturedGrid(12);
  vtkNew<vtkIntArray> labels;
  labels->SetName("Part");
  vtkNew<vtkDoubleArray> directions;
  directions->SetName("Along");
  directions->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
  {
    labels->InsertNextValue(grid->GetPoint(p)[0] < 0.5 ? 0 : 1);
    directions->InsertNextTuple3(0.0, 3.0, 0.0);
  }
  grid->GetPointData()->AddArray(labels);
  grid->GetPointData()->AddArray(directions);
  return grid;
}

/// A training of a moment that begins anew and writes <name>.
vtkSmartPointer<vtkLatentDiffusionTrainer> TrainerFor(const std::string& name, bool withInputs = true)
{
  std::filesystem::remove(name);
  std::filesystem::remove(name + ".checkpoint");
  auto filter = vtkSmartPointer<vtkLatentDiffusionTrainer>::New();
  if (withInputs)
  {
    filter->SetInputDataObject(0, Square());
    filter->SetTextureData(Pattern());
  }
  filter->SetModelFileName(name.c_str());
  filter->SetAutoencoderFileName(Autoencoder().c_str());
  filter->SetLabelArrayName("Part");
  filter->SetDirectionArrayName("Along");
  filter->SetNumberOfTriangulations(2);
  filter->SetNumberOfPoints(90);
  filter->SetChannels(4);
  filter->SetCoarseChannels(6);
  filter->SetCoarseBlocks(1);
  filter->SetOutputBlocks(1);
  filter->SetEmbeddingDimension(4);
  filter->SetIterations(Iterations);
  filter->SetBatchSize(1);
  filter->SetDeviceToCPU();
  return filter;
}

LatentDiffusionTrainingOptions SameOptions()
{
  LatentDiffusionTrainingOptions options;
  options.Network.Channels = 4;
  options.Network.CoarseChannels = 6;
  options.Network.CoarseBlocks = 1;
  options.Network.OutputBlocks = 1;
  options.Network.EmbeddingDimension = 4;
  options.Iterations = Iterations;
  options.BatchSize = 1;
  options.Device = TrainingDevice::CPU;
  return options;
}

vtkTable* TableOf(vtkAlgorithm* filter) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(0)); }

std::string ErrorOfTraining(vtkLatentDiffusionTrainer* filter)
{
  const std::string error = surfsynthtest::ErrorOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  return error;
}
} // namespace

#ifdef SURFACE_SYNTHESIS_CGAL
TEST(LatentDiffusionTrainerFilter, SamplesAreWrittenAlongTheWay)
{
  std::filesystem::remove("sampled.png");
  const auto filter = TrainerFor("sampled.model");
  filter->SetSampleFileName("sampled.png");
  filter->SetCheckpointInterval(2);
  OutputOf(filter);
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName("sampled.png");
  reader->Update();
  EXPECT_EQ(reader->GetOutput()->GetDimensions()[0], 512);
  // The last one is that of the filter with the model.
  vtkNew<vtkFieldLatentTextureFilter> sampler;
  sampler->SetInputDataObject(0, Square());
  sampler->SetModelFileName("sampled.model");
  sampler->SetAutoencoderFileName(Autoencoder().c_str());
  sampler->SetLabelArrayName("Part");
  sampler->SetDirectionArrayName("Along");
  sampler->SetNumberOfSteps(20);
  sampler->SetResolution(512, 512);
  ASSERT_TRUE(Update(sampler));
  auto* image = vtkImageData::SafeDownCast(sampler->GetOutputDataObject(1));
  vtkDataArray* expected = image->GetPointData()->GetScalars();
  vtkDataArray* found = reader->GetOutput()->GetPointData()->GetScalars();
  ASSERT_EQ(found->GetNumberOfTuples(), expected->GetNumberOfTuples());
  for (vtkIdType k = 0; k < found->GetNumberOfTuples(); ++k)
  {
    for (int c = 0; c < 3; ++c)
    {
      ASSERT_EQ(found->GetComponent(k, c), expected->GetComponent(k, c)) << k;
    }
  }
}

TEST(LatentDiffusionTrainerFilter, ASampleNeedsASurfaceAndAFileOfItsOwn)
{
  auto filter = TrainerFor("unsampled.model", false);
  filter->SetDatasetFileName("unread.dataset");
  filter->SetSampleFileName("unsampled.png");
  EXPECT_THAT(ErrorOfTraining(filter), AllOf(HasSubstr("no surface on port 0"), HasSubstr("SampleFileName")));
  filter = TrainerFor("unsampled.model");
  filter->SetSampleFileName("unsampled.model");
  EXPECT_THAT(ErrorOfTraining(filter), AllOf(HasSubstr("file of both the model"), HasSubstr("sample")));
}

TEST(LatentDiffusionTrainerFilter, DatasetHasDifferentTriangulations)
{
  const auto filter = TrainerFor("");
  filter->SetIterations(0);
  filter->SetNumberOfTriangulations(4);
  filter->SetEncodedDatasetFileName("encoded.dataset");
  OutputOf(filter);
  const LatentDataset dataset = ReadLatentDataset("encoded.dataset");
  EXPECT_EQ(dataset.Autoencoder, Fingerprint(ReadFieldLatents(Autoencoder())));
  EXPECT_EQ(dataset.Dimension(), 2);
  EXPECT_EQ(dataset.NumberOfLabels(), 2);
  EXPECT_TRUE(dataset.IsDirected());
  ASSERT_EQ(dataset.Surfaces.size(), 4U);
  std::set<Index> sizes;
  for (const LatentSurface& surface : dataset.Surfaces)
  {
    sizes.insert(surface.Mesh.NumberOfPoints());
    EXPECT_NEAR(static_cast<double>(surface.Mesh.NumberOfPoints()), 90.0, 27.0);
    EXPECT_GT(surface.Means.cwiseAbs().maxCoeff(), 0.01F);
    EXPECT_NEAR(surface.Directions.rowwise().norm().minCoeff(), 1.0F, 1e-5F);
  }
  EXPECT_GT(sizes.size(), 1U);
}

TEST(LatentDiffusionTrainerFilter, TriangulationsShareFewInnerVertices)
{
  const auto filter = TrainerFor("");
  filter->SetIterations(0);
  filter->SetNumberOfTriangulations(6);
  filter->SetEncodedDatasetFileName("shared.dataset");
  OutputOf(filter);
  const LatentDataset dataset = ReadLatentDataset("shared.dataset");
  const double edge = std::sqrt(2.0 / (std::sqrt(3.0) * 90.0)); // of 90 vertices on the unit square
  int inner = 0;
  int shared = 0;
  for (const LatentSurface& one : dataset.Surfaces)
  {
    for (const LatentSurface& other : dataset.Surfaces)
    {
      for (Index v = 0; &one != &other && v < one.Mesh.NumberOfPoints(); ++v)
      {
        const auto place = one.Mesh.Points.row(v);
        if (place.head<2>().minCoeff() > 0.3 * edge && place.head<2>().maxCoeff() < 1.0 - 0.3 * edge)
        {
          ++inner;
          shared += (other.Mesh.Points.rowwise() - place).rowwise().norm().minCoeff() < 0.05 * edge ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(inner, 1000);
  EXPECT_LT(shared, inner / 10); // those of independent places: 1 in 100
}

TEST(LatentDiffusionTrainerFilter, ModelIsThatOfThePlainTrainingAndSamples)
{
  const auto filter = TrainerFor("surface.model");
  filter->SetEncodedDatasetFileName("surface.dataset");
  OutputOf(filter);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), Iterations);
  EXPECT_EQ(TableOf(filter)->GetNumberOfColumns(), 12);
  TrainingFiles files;
  files.Model = "plain.model";
  TrainLatentDiffusion(ReadLatentDataset("surface.dataset"), SameOptions(), files);
  EXPECT_EQ(BytesOf("surface.model"), BytesOf("plain.model"));
  const auto fromFile = TrainerFor("file.model", false);
  fromFile->SetDatasetFileName("surface.dataset");
  OutputOf(fromFile);
  EXPECT_EQ(BytesOf("file.model"), BytesOf("plain.model"));
  // The sampler takes the model with its autoencoder.
  vtkNew<vtkFieldLatentTextureFilter> sampler;
  sampler->SetInputData(Square());
  sampler->SetModelFileName("surface.model");
  sampler->SetAutoencoderFileName(Autoencoder().c_str());
  sampler->SetLabelArrayName("Part");
  sampler->SetDirectionArrayName("Along");
  sampler->SetNumberOfSteps(2);
  sampler->SetResolution(16, 16);
  SurfaceOf(sampler);
  EXPECT_NEAR(static_cast<double>(sampler->GetNumberOfVertices()), 90.0, 20.0);
}

TEST(LatentDiffusionTrainerFilter, GoesOnFromTheCheckpoint)
{
  const auto whole = TrainerFor("whole.model");
  OutputOf(whole);
  const auto parts = TrainerFor("parts.model");
  parts->SetTimeBudget(1e-9);
  WarningsOf(parts);
  EXPECT_LT(parts->GetNumberOfIterationsDone(), Iterations);
  parts->SetTimeBudget(0.0);
  OutputOf(parts);
  EXPECT_EQ(BytesOf("whole.model"), BytesOf("parts.model"));
}
#endif

TEST(LatentDiffusionTrainerFilter, NamesWhatIsWrong)
{
  const auto filter = TrainerFor("messages.model");
  filter->SetAutoencoderFileName("");
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("AutoencoderFileName is empty"));
  filter->SetAutoencoderFileName("nowhere.model");
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("nowhere.model"));
  filter->SetAutoencoderFileName(Autoencoder().c_str());
  filter->SetIterations(0);
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("EncodedDatasetFileName is empty"));
  filter->SetIterations(Iterations);
  filter->SetEmbeddingDimension(5);
  EXPECT_THAT(ErrorOfTraining(filter), HasSubstr("EmbeddingDimension is 5"));
  filter->SetEmbeddingDimension(4);
#ifdef SURFACE_SYNTHESIS_CGAL
  filter->SetLabelArrayName("Along");
  EXPECT_THAT(ErrorOfTraining(filter), AllOf(HasSubstr("\"Along\""), HasSubstr("LabelArrayName")));
#endif
  filter->RemoveAllInputs();
  EXPECT_THAT(ErrorOfTraining(filter), AllOf(HasSubstr("port 0"), HasSubstr("DatasetFileName")));
  std::ostringstream text;
  filter->Print(text);
  EXPECT_THAT(text.str(), AllOf(HasSubstr("NumberOfTriangulations: 2"), HasSubstr("ConditionDropout: 0.1")));
}

TEST(LatentDiffusionTrainerFilter, EmptyInputGivesAnEmptyTable)
{
  const auto filter = TrainerFor("empty.model");
  filter->SetInputDataObject(0, vtkSmartPointer<vtkPolyData>::New());
  OutputOf(filter);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), 0);
  EXPECT_FALSE(std::filesystem::exists("empty.model"));
}
