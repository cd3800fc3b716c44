// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMultiscaleMeshFitter.h"

#include "Announcement.h"
#include "FilterSupport.h"
#include "JointProcessing.h"
#include "NewArray.h"
#include "Reporting.h"
#include "SurfaceArrays.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/UsedPoints.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"
#include "Learning/Training/MultiscaleMeshFitter.h"
#include "Learning/Training/TrainingClock.h"

#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>

#include <cmath>
#include <sstream>
#include <vector>

using surfsynth::FitDistance;
using surfsynth::MultiscaleFit;
using surfsynth::MultiscaleFitOptions;
using surfsynth::TriangleMesh;

vtkStandardNewMacro(vtkMultiscaleMeshFitter);

namespace
{
/// The reference need not be manifold.
surfsynth::MeshRequirements RequirementsOfReference()
{
  surfsynth::MeshRequirements requirements;
  requirements.ManifoldEdges = false;
  return requirements;
}

/// The triangles of @p surface and the points that they use.
TriangleMesh MeshOfUsedPoints(vtkPolyData* surface, const surfsynth::MeshRequirements& requirements)
{
  const TriangleMesh mesh = surfsynth::ToSurface(surface, requirements).Mesh;
  return surfsynth::UsedPoints(mesh).Compact(mesh);
}

void AddFieldValue(vtkPolyData* surface, const char* name, double value)
{
  auto array = surfsynth::NewArray<vtkDoubleArray>(name, 1, 1);
  array->SetValue(0, value);
  surface->GetFieldData()->AddArray(array);
}

void FillLevels(const MultiscaleFit& fit, vtkMultiBlockDataSet* output)
{
  for (std::size_t k = 0; k < fit.Distances.size(); ++k)
  {
    vtkNew<vtkPolyData> level;
    surfsynth::SetGeometry(level, fit.Dataset.Levels[k], true);
    AddFieldValue(level, "MeanDistance", fit.Distances[k].Mean);
    AddFieldValue(level, "LargestDistance", fit.Distances[k].Largest);
    const auto block = static_cast<unsigned int>(k);
    output->SetBlock(block, level);
    output->GetMetaData(block)->Set(vtkCompositeDataSet::NAME(), ("Level " + std::to_string(k)).c_str());
  }
}
} // namespace

/// Fits with the parameters of the filter.
class vtkMultiscaleMeshFitter::Internals
{
public:
  explicit Internals(vtkMultiscaleMeshFitter* self)
    : Self(self)
  {}

  void Fit(vtkInformationVector** inputVector, vtkInformationVector* outputVector, const surfsynth::Progress& progress)
  {
    const auto reference = surfsynth::SurfaceOn(inputVector[0]);
    if (!reference)
    {
      throw surfsynth::InvalidInput("There is no reference on port 0; a vtkPolyData is needed.");
    }
    if (reference->GetNumberOfPoints() == 0 && reference->GetNumberOfCells() == 0)
    {
      return;
    }
    const MultiscaleFit fit = surfsynth::FitMultiscaleMesh(MeshOfUsedPoints(reference, RequirementsOfReference()),
      this->Options(surfsynth::SurfaceOn(inputVector[1])), this->WithForecast(progress));
    if (!this->Self->DatasetFileName.empty())
    {
      surfsynth::WriteMultiscaleDataset(this->Self->DatasetFileName, fit.Dataset);
    }
    this->WarnOfTime(fit);
    FillLevels(fit, vtkMultiBlockDataSet::GetData(outputVector, 0));
    surfsynth::SetGeometry(vtkPolyData::GetData(outputVector, 1), fit.Dataset.Template, true);
    auto* levels = vtkMultiBlockDataSet::GetData(outputVector, 0);
    vtkPolyData::GetData(outputVector, 2)->ShallowCopy(levels->GetBlock(levels->GetNumberOfBlocks() - 1));
  }

private:
  /// Says the time to expect beside @p progress. The time of an iteration grows with the samples of its level.
  surfsynth::Progress WithForecast(const surfsynth::Progress& progress) const
  {
    std::vector<double> costs;
    for (int level = 0; level < this->Self->NumberOfLevels; ++level)
    {
      costs.push_back(level + 1.0);
    }
    const std::int64_t all = static_cast<std::int64_t>(this->Self->Iterations) * this->Self->NumberOfLevels;
    return [self = this->Self, progress, all, clock = surfsynth::TrainingClock(all, costs)](double done) mutable {
      clock.Add(std::llround(done * static_cast<double>(all)));
      surfsynth::AnnounceTime(self, "", clock, self->TimeBudget);
      return !progress || progress(done);
    };
  }

  void WarnOfTime(const MultiscaleFit& fit) const
  {
    std::string done;
    bool early = false;
    for (const std::int64_t iterations : fit.Iterations)
    {
      done += (done.empty() ? "" : ", ") + std::to_string(iterations);
      early = early || iterations < this->Self->Iterations;
    }
    if (early)
    {
      std::ostringstream text;
      text << "The TimeBudget of " << surfsynth::FormatNumber(this->Self->TimeBudget)
           << " minutes ended levels before their " << this->Self->Iterations
           << " iterations; done at each level: " << done << ". All of them take about "
           << surfsynth::FormatDuration(fit.SecondsForAll) << ". A larger TimeBudget, or 0 for no limit, fits closer.";
      surfsynth::ReportWarning(this->Self, "", text.str());
    }
  }

  MultiscaleFitOptions Options(vtkPolyData* given) const
  {
    const vtkMultiscaleMeshFitter& self = *this->Self;
    MultiscaleFitOptions options;
    options.Levels = self.NumberOfLevels;
    options.Template = static_cast<surfsynth::FitTemplate>(self.Template);
    options.IcosphereLevel = self.IcosphereLevel;
    options.TorusSegments = self.TorusSegments;
    options.Iterations = self.Iterations;
    options.TriangulationSteps = self.TriangulationSteps;
    options.ChamferSteps = self.ChamferSteps;
    options.LearningRate = self.LearningRate;
    options.LearningRateDecay = self.LearningRateDecay;
    options.Samples = self.Samples;
    options.PublishedNormals = self.PublishedNormals;
    options.TimeBudget = self.TimeBudget;
    options.Seed = static_cast<std::uint64_t>(self.Seed);
    if (self.Template == GIVEN)
    {
      if (!given || given->GetNumberOfCells() == 0)
      {
        throw surfsynth::InvalidInput(
          "There is no template on port 1, which Template GIVEN needs; a vtkPolyData of the topology of the reference, "
          "or another Template, is needed.");
      }
      options.GivenTemplate = this->GivenTemplate(given);
    }
    return options;
  }

  TriangleMesh GivenTemplate(vtkPolyData* given) const
  {
    try
    {
      return MeshOfUsedPoints(given, surfsynth::GeometricTextureSampler::Requirements());
    }
    catch (const surfsynth::InvalidInput& error)
    {
      throw surfsynth::InvalidInput(std::string("The template on port 1: ") + error.what());
    }
  }

  vtkMultiscaleMeshFitter* Self;
};

vtkMultiscaleMeshFitter::vtkMultiscaleMeshFitter()
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(3);
}

vtkMultiscaleMeshFitter::~vtkMultiscaleMeshFitter() = default;

void vtkMultiscaleMeshFitter::SetDatasetFileName(const char* name)
{
  surfsynth::SetString(this, this->DatasetFileName, name);
}

int vtkMultiscaleMeshFitter::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  }
  return surfsynth::AcceptSurface(info);
}

int vtkMultiscaleMeshFitter::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkMultiBlockDataSet" : "vtkPolyData");
  return 1;
}

int vtkMultiscaleMeshFitter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  Internals fitting(this);
  return surfsynth::ProcessJointly(this, inputVector, outputVector,
    [&](const surfsynth::Progress& progress) { fitting.Fit(inputVector, outputVector, progress); });
}

void vtkMultiscaleMeshFitter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfLevels: " << this->NumberOfLevels << "\n";
  os << indent << "Template: " << this->Template << "\n";
  os << indent << "IcosphereLevel: " << this->IcosphereLevel << "\n";
  os << indent << "TorusSegments: " << this->TorusSegments << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "TriangulationSteps: " << this->TriangulationSteps << "\n";
  os << indent << "ChamferSteps: " << this->ChamferSteps << "\n";
  os << indent << "LearningRate: " << this->LearningRate << "\n";
  os << indent << "LearningRateDecay: " << this->LearningRateDecay << "\n";
  os << indent << "Samples: " << this->Samples << "\n";
  os << indent << "PublishedNormals: " << this->PublishedNormals << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "TimeBudget: " << this->TimeBudget << "\n";
  os << indent << "DatasetFileName: " << this->DatasetFileName << "\n";
}
