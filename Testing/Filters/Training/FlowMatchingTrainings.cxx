// SPDX-License-Identifier: BSD-3-Clause
#include "FlowMatchingTrainings.h"

#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTable.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace surfsynthtest
{

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

vtkSmartPointer<vtkPolyData> Stretched(double stretch, int pointType)
{
  Soup soup = Icosphere(1);
  for (std::size_t k = 2; k < soup.Points.size(); k += 3)
  {
    soup.Points[k] *= stretch;
  }
  auto surface = soup.ToPolyData(pointType);
  vtkNew<vtkFloatArray> heat;
  heat->SetName("Heat");
  heat->SetNumberOfComponents(2);
  for (vtkIdType k = 0; k < surface->GetNumberOfPoints(); ++k)
  {
    const double* point = surface->GetPoint(k);
    heat->InsertNextTuple2(20.0 + point[0] * stretch, point[2]);
  }
  surface->GetPointData()->AddArray(heat);
  return surface;
}

const std::vector<double> Stretches = { 1.2, 1.5, 0.7 };

Surfaces Samples()
{
  Surfaces samples;
  for (const double stretch : Stretches)
  {
    samples.push_back(Stretched(stretch));
  }
  return samples;
}

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const std::vector<vtkSmartPointer<vtkDataObject>>& leaves)
{
  auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  for (const auto& leaf : leaves)
  {
    blocks->SetBlock(blocks->GetNumberOfBlocks(), leaf);
  }
  return blocks;
}

vtkSmartPointer<vtkMultiBlockDataSet> Blocks(const Surfaces& surfaces)
{
  return Blocks(std::vector<vtkSmartPointer<vtkDataObject>>(surfaces.begin(), surfaces.end()));
}

surfsynth::SignalSource SourceOf(vtkPolyData* surface, const Surfaces& samples, const char* array)
{
  surfsynth::SignalSource source;
  const vtkIdType points = surface->GetNumberOfPoints();
  source.Mesh.Points.resize(points, 3);
  for (vtkIdType k = 0; k < points; ++k)
  {
    surface->GetPoint(k, source.Mesh.Points.row(k).data());
  }
  source.Mesh.Triangles.resize(surface->GetNumberOfCells(), 3);
  for (vtkIdType f = 0; f < surface->GetNumberOfCells(); ++f)
  {
    vtkNew<vtkIdList> ids;
    surface->GetCellPoints(f, ids);
    for (int c = 0; c < 3; ++c)
    {
      source.Mesh.Triangles(f, c) = static_cast<surfsynth::Index>(ids->GetId(c));
    }
  }
  for (std::size_t n = 0; n < samples.size(); ++n)
  {
    vtkDataArray* values = array[0] ? samples[n]->GetPointData()->GetArray(array) : samples[n]->GetPoints()->GetData();
    const int components = values->GetNumberOfComponents();
    source.Samples.conservativeResize(static_cast<Eigen::Index>(n) + 1, points * components);
    for (vtkIdType k = 0; k < points * components; ++k)
    {
      source.Samples(static_cast<Eigen::Index>(n), k) = static_cast<float>(
        values->GetComponent(k / components, static_cast<int>(k % components)));
    }
  }
  return source;
}

vtkTable* TableOf(vtkAlgorithm* filter) { return vtkTable::SafeDownCast(filter->GetOutputDataObject(0)); }

void FlowMatchingTrainerFilter::SetUp()
{
  std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::replace(name.begin(), name.end(), '/', '_');
  this->Folder = fs::path("FlowMatchingTrainerFilter") / name;
  fs::remove_all(this->Folder);
  fs::create_directories(this->Folder);
}

vtkSmartPointer<vtkFlowMatchingTrainer> FlowMatchingTrainerFilter::Tiny(const std::string& name, int iterations) const
{
  auto filter = vtkSmartPointer<vtkFlowMatchingTrainer>::New();
  filter->SetModelFileName(this->File(name).c_str());
  filter->SetIterations(iterations);
  filter->SetWidth(8);
  filter->SetBlocks(2);
  filter->SetComplexLayers(2);
  filter->SetBatchSize(2);
  filter->SetDeviceToCPU();
  return filter;
}

vtkSmartPointer<vtkFlowMatchingTrainer> FlowMatchingTrainerFilter::OnBlocks(
  const std::string& name, int iterations) const
{
  auto filter = this->Tiny(name, iterations);
  filter->SetInputDataObject(0, Stretched(1.0));
  filter->SetInputDataObject(1, Blocks(Samples()));
  return filter;
}

std::string FlowMatchingTrainerFilter::ModelBytes(vtkFlowMatchingTrainer* filter) const
{
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter)) << events.AllErrors();
  EXPECT_THAT(events.Errors, IsEmpty());
  EXPECT_EQ(events.Executions, 1);
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
  EXPECT_FALSE(events.ForeignThread);
  EXPECT_EQ(TableOf(filter)->GetNumberOfRows(), filter->GetIterations());
  return BytesOf(filter->GetModelFileName());
}

std::string FlowMatchingTrainerFilter::DatasetBytes(
  const surfsynth::SignalDataset& dataset, const vtkSmartPointer<vtkFlowMatchingTrainer>& filter) const
{
  surfsynth::WriteSignalDataset(this->File("dataset.safetensors"), dataset);
  filter->SetDatasetFileName(this->File("dataset.safetensors").c_str());
  return this->ModelBytes(filter);
}

void FlowMatchingTrainerFilter::ExpectRefusal(
  vtkFlowMatchingTrainer* filter, const std::vector<std::string>& parts) const
{
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u) << events.AllErrors() << ::testing::PrintToString(parts);
  for (const std::string& part : parts)
  {
    EXPECT_THAT(events.Errors[0], HasSubstr(part));
  }
  EXPECT_EQ(TableOf(filter)->GetNumberOfColumns(), 0);
  EXPECT_EQ(filter->GetNumberOfIterationsDone(), 0);
  EXPECT_FALSE(fs::exists(this->File("refused")));
}

} // namespace surfsynthtest
