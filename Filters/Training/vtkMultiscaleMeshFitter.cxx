// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMultiscaleMeshFitter.h"

#include "Announcement.h"
#include "BackgroundJob.h"
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
#ifdef SURFACE_SYNTHESIS_CGAL
#include "MeshProcessing/Repair/SelfIntersections.h"
#endif

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
#include <mutex>
#include <optional>
#include <sstream>
#include <utility>
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
    AddFieldValue(level, "SymmetricMeanDistance", fit.Distances[k].SymmetricMean);
    AddFieldValue(level, "SymmetricPercentile95", fit.Distances[k].SymmetricPercentile95);
    AddFieldValue(level, "MeanNormalAngle", fit.Distances[k].NormalAngle);
#ifdef SURFACE_SYNTHESIS_CGAL
    const auto pairs = surfsynth::FindIntersectingPairs(fit.Dataset.Levels[k]).size();
    AddFieldValue(level, "NumberOfSelfIntersections", static_cast<double>(pairs));
#endif
    const auto block = static_cast<unsigned int>(k);
    output->SetBlock(block, level);
    output->GetMetaData(block)->Set(vtkCompositeDataSet::NAME(), ("Level " + std::to_string(k)).c_str());
  }
}
} // namespace

/// A fit on a thread of its own.
class vtkMultiscaleMeshFitter::BackgroundFit
{
public:
  using Fit = std::function<MultiscaleFit(const surfsynth::Progress&)>;

  /// Starts @p fit, whose progress @p clock follows over @p iterations, after a stop.
  void Start(Fit fit, std::int64_t iterations, const surfsynth::TrainingClock& clock)
  {
    this->Job.Stop();
    this->Result.reset();
    this->Job.Start(
      [this, fit = std::move(fit), iterations, clock](const surfsynth::Progress& progress) {
        MultiscaleFit result = fit(this->Described(progress, iterations, clock));
        const std::lock_guard<std::mutex> lock(this->Mutex);
        this->Result = std::move(result);
      },
      "0 % of all iterations");
  }
  /// Returns the fit when it has ended; it is no longer pending then. @throws its error.
  std::optional<MultiscaleFit> Look()
  {
    const bool ended = this->Job.Look();
    const std::lock_guard<std::mutex> lock(this->Mutex);
    return ended ? this->Result : std::nullopt;
  }
  void Stop() { this->Job.Stop(); }
  bool IsPending() const { return this->Job.IsPending(); }
  std::string State() const { return this->Job.State(); }

private:
  surfsynth::Progress Described(
    const surfsynth::Progress& progress, std::int64_t iterations, surfsynth::TrainingClock clock)
  {
    return [this, &progress, iterations, clock](double done) mutable {
      clock.Add(std::llround(done * static_cast<double>(iterations)));
      std::string text = surfsynth::FormatNumber(std::floor(100.0 * done)) + " % of all iterations";
      const double seconds = clock.SecondsLeft();
      text += seconds > 0.0 ? ", " + surfsynth::FormatDuration(seconds) + " left" : "";
      this->Job.Describe(text);
      return progress(done);
    };
  }

  std::mutex Mutex; ///< of Result
  std::optional<MultiscaleFit> Result;
  surfsynth::BackgroundJob Job; ///< ends first
};

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
    const auto fit = [mesh = MeshOfUsedPoints(reference, RequirementsOfReference()),
                       options = this->Options(surfsynth::SurfaceOn(inputVector[1])),
                       name = this->Self->DatasetFileName](const surfsynth::Progress& report) {
      MultiscaleFit found = surfsynth::FitMultiscaleMesh(mesh, options, report);
      if (!name.empty())
      {
        surfsynth::WriteMultiscaleDataset(name, found.Dataset);
      }
      return found;
    };
    if (this->Self->Background)
    {
      this->Self->Task->Start(fit, this->AllIterations(), this->Clock());
      this->ShowBackground(outputVector);
      return;
    }
    this->Self->Task->Stop();
    this->Show(fit(this->WithForecast(progress)), outputVector);
  }

  /// Fills the outputs when the fit in the background has ended. @throws its error.
  void ShowBackground(vtkInformationVector* outputVector) const
  {
    if (const auto fit = this->Self->Task->Look())
    {
      this->Show(*fit, outputVector);
    }
  }

private:
  void Show(const MultiscaleFit& fit, vtkInformationVector* outputVector) const
  {
    this->WarnOfTime(fit);
    auto* levels = vtkMultiBlockDataSet::GetData(outputVector, 0);
    FillLevels(fit, levels);
    surfsynth::SetGeometry(vtkPolyData::GetData(outputVector, 1), fit.Dataset.Template, true);
    vtkPolyData::GetData(outputVector, 2)->ShallowCopy(levels->GetBlock(levels->GetNumberOfBlocks() - 1));
  }

  std::int64_t AllIterations() const
  {
    return static_cast<std::int64_t>(this->Self->Iterations) * this->Self->NumberOfLevels;
  }

  /// The time of an iteration grows with the samples of its level.
  surfsynth::TrainingClock Clock() const
  {
    std::vector<double> costs;
    for (int level = 0; level < this->Self->NumberOfLevels; ++level)
    {
      costs.push_back(level + 1.0);
    }
    return surfsynth::TrainingClock(this->AllIterations(), costs);
  }

  /// Says the time to expect beside @p progress.
  surfsynth::Progress WithForecast(const surfsynth::Progress& progress) const
  {
    return [self = this->Self, progress, all = this->AllIterations(), clock = this->Clock()](double done) mutable {
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
    options.TemplateTriangles = self.TemplateTriangles;
    options.SmoothingLength = self.SmoothingLength;
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
  : Task(std::make_unique<BackgroundFit>())
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(3);
}

vtkMultiscaleMeshFitter::~vtkMultiscaleMeshFitter() = default;

void vtkMultiscaleMeshFitter::SetDatasetFileName(const char* name)
{
  surfsynth::SetString(this, this->DatasetFileName, name);
}

const char* vtkMultiscaleMeshFitter::GetBackgroundState() const
{
  this->BackgroundState = this->Task->State();
  return this->BackgroundState.c_str();
}

void vtkMultiscaleMeshFitter::StopBackground()
{
  this->Task->Stop();
  this->Modified();
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
  return surfsynth::ProcessJointly(this, inputVector, outputVector, [&](const surfsynth::Progress& progress) {
    if (this->Background && this->Task->IsPending())
    {
      fitting.ShowBackground(outputVector);
    }
    else
    {
      fitting.Fit(inputVector, outputVector, progress);
    }
  });
}

void vtkMultiscaleMeshFitter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NumberOfLevels: " << this->NumberOfLevels << "\n";
  os << indent << "Template: " << this->Template << "\n";
  os << indent << "IcosphereLevel: " << this->IcosphereLevel << "\n";
  os << indent << "TorusSegments: " << this->TorusSegments << "\n";
  os << indent << "TemplateTriangles: " << this->TemplateTriangles << "\n";
  os << indent << "SmoothingLength: " << this->SmoothingLength << "\n";
  os << indent << "Iterations: " << this->Iterations << "\n";
  os << indent << "TriangulationSteps: " << this->TriangulationSteps << "\n";
  os << indent << "ChamferSteps: " << this->ChamferSteps << "\n";
  os << indent << "LearningRate: " << this->LearningRate << "\n";
  os << indent << "LearningRateDecay: " << this->LearningRateDecay << "\n";
  os << indent << "Samples: " << this->Samples << "\n";
  os << indent << "PublishedNormals: " << this->PublishedNormals << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "TimeBudget: " << this->TimeBudget << "\n";
  os << indent << "Background: " << this->Background << "\n";
  os << indent << "BackgroundState: " << this->GetBackgroundState() << "\n";
  os << indent << "DatasetFileName: " << this->DatasetFileName << "\n";
}
