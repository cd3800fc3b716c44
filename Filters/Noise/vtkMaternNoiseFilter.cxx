// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMaternNoiseFilter.h"

#include "CoarseSurfaces.h"
#include "ConditionedNoise.h"
#include "DisplacementNoise.h"
#include "FieldArrays.h"
#include "FilterSupport.h"
#include "PieceNoise.h"
#include "RandomFields.h"
#include "Reporting.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"
#include "VolumeBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Noise/MaternField.h"

#include <vtkDataSet.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

using surfsynth::MaternField;
using surfsynth::MaternFieldOptions;
using surfsynth::Surface;

vtkStandardNewMacro(vtkMaternNoiseFilter);

namespace
{
/// Returns true when two sets of options share operators, factor and eigenpairs.
bool HaveSameFactor(const MaternFieldOptions& a, const MaternFieldOptions& b)
{
  return a.Model == b.Model && a.Mode == b.Mode && a.CorrelationRange == b.CorrelationRange &&
    a.Screening == b.Screening && a.NormalizedScreening == b.NormalizedScreening &&
    a.NumberOfEigenpairs == b.NumberOfEigenpairs && a.OperatorPower == b.OperatorPower &&
    a.VarianceCorrection == b.VarianceCorrection && a.Boundary == b.Boundary &&
    a.RobinCoefficient == b.RobinCoefficient && a.AnisotropyRatio == b.AnisotropyRatio &&
    a.CoherentNoise == b.CoherentNoise && a.Coupling == b.Coupling && a.Arrays == b.Arrays &&
    a.FactorMemoryLimit == b.FactorMemoryLimit;
}

/// Returns options with unused fields reset to their defaults, so that a change of them keeps the factor.
MaternFieldOptions WithoutIgnoredFields(MaternFieldOptions options)
{
  const MaternFieldOptions defaults;
  using surfsynth::NoiseModel;
  using surfsynth::ScaleMode;
  const bool hasScale = options.Model == NoiseModel::Matern || options.Model == NoiseModel::Spectral;
  const bool hasSolve = options.Model == NoiseModel::Matern || options.Model == NoiseModel::Unscreened;
  const auto keepFor = [&options, hasScale](ScaleMode mode) { return hasScale && options.Mode == mode; };
  options.CorrelationRange = keepFor(ScaleMode::CorrelationRange) ? options.CorrelationRange : 0.0;
  options.Screening = keepFor(ScaleMode::Screening) ? options.Screening : defaults.Screening;
  options.NormalizedScreening = keepFor(ScaleMode::NormalizedScreening) ? options.NormalizedScreening
                                                                        : defaults.NormalizedScreening;
  options.NumberOfEigenpairs = options.Model == NoiseModel::Spectral ? options.NumberOfEigenpairs
                                                                     : defaults.NumberOfEigenpairs;
  options.CoherentNoise = options.CoherentNoise && options.Model == NoiseModel::Matern;
  options.Mode = hasScale ? options.Mode : defaults.Mode;
  options.OperatorPower = hasScale ? options.OperatorPower : defaults.OperatorPower;
  if (!hasSolve)
  {
    options.FactorMemoryLimit = 0;
  }
  options.Coupling = hasScale || hasSolve ? options.Coupling : defaults.Coupling;
  if (options.Model != NoiseModel::Matern)
  {
    options.VarianceCorrection = defaults.VarianceCorrection;
    options.Boundary = defaults.Boundary;
    options.Arrays = defaults.Arrays;
  }
  options.RobinCoefficient = options.Boundary == surfsynth::BoundaryCondition::Robin ? options.RobinCoefficient
                                                                                     : defaults.RobinCoefficient;
  options.AnisotropyRatio = options.Arrays.Directions.size() > 0 ? options.AnisotropyRatio : defaults.AnisotropyRatio;
  return options;
}

/// Ratio of the correlation range to the longest side of the surface above which a warning is given.
constexpr double LongestRange = 5.0;
} // namespace

/// Random fields of the last update, and their results.
class vtkMaternNoiseFilter::Internals
{
public:
  explicit Internals(vtkMaternNoiseFilter* self)
    : Self(self)
  {}

  void Begin()
  {
    this->SolverName = "None";
    this->NumberOfIterations = 0;
    this->EffectiveScreening = this->EffectiveCorrelationRange = this->Gamma = this->RelativeResidual = 0.0;
    this->Fields.Begin();
    this->Pieces.Begin();
    this->Displaced.Begin(this->Directions());
  }

  /// Null for a field with arrays, too, which are not known before the surface has been checked.
  const MaternField* Find(const Surface& surface)
  {
    return this->Names().Any() ? nullptr : this->Fields.Find(surface, this->Options(surface, nullptr));
  }

  void AddField(const Surface& surface, vtkDataSet* output, const surfsynth::Progress& progress)
  {
    this->RequireMatern();
    const auto displacement = this->Displaced.Of(surface);
    surfsynth::SampleRequest request = this->Request(surface);
    if (displacement)
    {
      request.NumberOfComponents = static_cast<std::uint32_t>(displacement->NumberOfFields());
    }
    const double columns = static_cast<double>(request.NumberOfSamples) * request.NumberOfComponents;
    const double factored = 10.0 / (10.0 + 0.1 * columns); // a factorisation costs about as much as 100 samples
    const MaternFieldOptions options = this->Options(surface, output);
    const MaternField* held = this->Fields.Find(surface, options);
    const double begin = held ? 0.0 : factored;
    const MaternField& field = held ? *held
                                    : this->Build(surface, options, surfsynth::SubProgress(progress, 0.0, factored));
    this->RequireFactor(field);
    const double drawn = this->Conditioned.HasObservations() ? 0.5 * (begin + 1.0) : 1.0;
    const auto draw = [&](const surfsynth::SampleDestination& destination) {
      std::vector<double*> samples;
      const auto remember = [&](std::uint32_t sample) { return samples.emplace_back(destination(sample)); };
      field.SampleInto(request, remember, surfsynth::SubProgress(progress, begin, drawn));
      if (this->Conditioned.HasObservations())
      {
        this->Warn(surface,
          this->Conditioned.Condition(
            surface, field, displacement, request, samples, surfsynth::SubProgress(progress, drawn, 0.95)));
      }
      if (displacement)
      {
        this->Warn(surface, this->Displaced.Finish(surface, *displacement, samples));
      }
    };
    surfsynth::AddSamples(this->Series(), draw, output);
    if (this->Conditioned.HasObservations())
    {
      this->Conditioned.AddPosterior(surface, output, surfsynth::SubProgress(progress, 0.95, 1.0));
    }
    this->EffectiveScreening = field.EffectiveScreening();
    this->EffectiveCorrelationRange = field.EffectiveCorrelationRange();
    this->Gamma = field.Gamma();
    this->SolverName = field.SolverName();
    this->NumberOfIterations = field.Iterations();
    this->RelativeResidual = std::max(this->RelativeResidual, field.RelativeResidual());
  }

  /// AddField() for a surface that stays in its pieces. Collective.
  void AddFieldInPieces(const surfsynth::SurfacePiece& piece, vtkPolyData* output, const surfsynth::Progress& progress)
  {
    this->RequirePieces();
    const Surface& surface = piece.Local;
    const surfsynth::PieceNoiseResults results = this->Pieces.AddSamples(
      piece, this->Options(surface, nullptr), HaveSameFactor, this->Request(surface), this->Series(), output, progress);
    if (results.IsNew)
    {
      ++this->NumberOfPieceFactorizations;
      const double range = results.EffectiveCorrelationRange;
      this->WarnOfLongEdges(surface, range, range > 0.0 ? results.LongestEdge / range : 0.0, results.LongestEdge);
      this->WarnOfLongRange(surface, range, results.LongestSide);
    }
    this->EffectiveScreening = results.EffectiveScreening;
    this->EffectiveCorrelationRange = results.EffectiveCorrelationRange;
    this->Gamma = results.Gamma;
    this->SolverName = "BoomerAMG";
    this->NumberOfIterations = results.Iterations;
    this->RelativeResidual = std::max(this->RelativeResidual, results.RelativeResidual);
  }

  surfsynth::SampleSeries Series() const
  {
    return { this->Self->OutputArrayName, this->Self->Seed, this->Self->FirstSample, this->Self->NumberOfSamples,
      this->Directions() ? 3 : this->Self->NumberOfComponents, this->Self->MemoryLimit, this->Self->ActiveResult };
  }

  /// RequestData of a volume, and of surfaces.
  int FillVolume(vtkInformationVector** inputVector, vtkInformationVector* outputVector)
  {
    return surfsynth::ProcessRandomFieldOfVolume(this->Self, inputVector, outputVector, this->Series(), *this);
  }
  int FillSurfaces(vtkInformationVector** inputVector, vtkInformationVector* outputVector)
  {
    vtkNew<vtkInformationVector> refined;
    vtkInformationVector* inputs = this->Refine(inputVector[0], refined) ? refined.Get() : inputVector[0];
    const surfsynth::PieceWorker addInPieces = [this](const surfsynth::SurfacePiece& piece, vtkPolyData* output,
                                                 const surfsynth::Progress& progress) {
      this->AddFieldInPieces(piece, output, progress);
    };
    return surfsynth::ProcessAsSurface(inputVector, outputVector, [&](vtkInformationVector* outputs) {
      return surfsynth::ProcessRandomFields(this->Self, &inputs, outputs, this->Series(), *this,
        this->IsWhole() ? 1 : this->Self->NumberOfSamples,
        this->Self->GatherPieces ? surfsynth::PieceWorker() : addInPieces);
    });
  }

  /// Puts the refined input into @p refined; false when the input is to be taken as it is.
  bool Refine(vtkInformationVector* input, vtkInformationVector* refined) const
  {
    const bool hasScale = this->Self->NoiseModel == MATERN || this->Self->NoiseModel == SPECTRAL;
    if (!this->Self->Refinement || !hasScale || this->Self->ScaleMode != CORRELATION_RANGE)
    {
      return false;
    }
    vtkNew<vtkInformation> information;
    information->Copy(input->GetInformationObject(0));
    information->Set(vtkDataObject::DATA_OBJECT(),
      surfsynth::RefineCoarseSurfaces(surfsynth::AsSurfaces(vtkDataObject::GetData(input)),
        this->Self->CorrelationRange, this->Names().Boundary, this->Names().Direction));
    refined->Append(information);
    return true;
  }

  /// Reads the observations on the second port, null for none. Throws on all ranks.
  void BeginConditioning(vtkInformationVector* port)
  {
    const vtkMaternNoiseFilter& self = *this->Self;
    this->Conditioned.Begin(surfsynth::ObservationsOn(port),
      { { self.ObservationArray, self.ObservationDeviationArray }, self.Tolerance, self.PosteriorMean,
        self.PosteriorStandardDeviation, self.MemoryLimit, self.OutputArrayName, self.ObservedTargets });
  }

  /// True when pieces of a surface on several ranks cannot be gathered with what the field needs, or the posterior is that of
  /// all samples.
  bool IsWhole() const { return this->Conditioned.HasObservations() || this->Names().Any(); }

  /// Moves the points of the output where that is asked for.
  void MovePoints(vtkDataObject* output) const
  {
    if (this->Directions() && this->Self->MovedPoints)
    {
      surfsynth::MovePointsBy(output, this->Self->OutputArrayName);
    }
  }

  /// Throws unless the properties of displacements fit each other.
  void RequireDisplacement() const
  {
    if (this->Directions() && this->Self->MovedPoints && this->Self->NumberOfSamples > 1)
    {
      throw surfsynth::InvalidInput("MovedPoints is on, and NumberOfSamples is " +
        std::to_string(this->Self->NumberOfSamples) + "; points can be moved by 1 sample only.");
    }
  }

  surfsynth::ConditionedNoise Conditioned;
  surfsynth::PieceNoise Pieces;
  vtkTypeInt64 NumberOfPieceFactorizations = 0;
  surfsynth::DisplacementNoise Displaced;
  surfsynth::RandomFieldCache<MaternField, MaternFieldOptions, HaveSameFactor> Fields;
  double EffectiveScreening = 0.0;
  double EffectiveCorrelationRange = 0.0;
  double Gamma = 0.0;
  double RelativeResidual = 0.0;
  const char* SolverName = "None";
  int NumberOfIterations = 0;

private:
  /// Directions of the displacement; none for NO_DISPLACEMENT.
  std::optional<surfsynth::DisplacementDirections> Directions() const
  {
    return this->Self->Displacement == NO_DISPLACEMENT
      ? std::nullopt
      : std::optional(static_cast<surfsynth::DisplacementDirections>(this->Self->Displacement - FREE));
  }

  void Warn(const Surface& surface, const std::string& text) const
  {
    if (!text.empty())
    {
      surfsynth::ReportWarning(this->Self, surface.Where, text);
    }
  }

  /// Names of the arrays in use.
  surfsynth::FieldArrayNames Names() const
  {
    return this->Self->NoiseModel == MATERN
      ? surfsynth::FieldArrayNames{ this->Self->RangeFactorArrayName, this->Self->DirectionArrayName,
          this->Self->BoundaryCondition == NEUMANN ? std::string() : this->Self->BoundaryArrayName,
          this->Self->BarrierArrayName }
      : surfsynth::FieldArrayNames{};
  }

  /// Options with unit standard deviation: the deviation only multiplies the samples and is applied to the output.
  /// @param dataset holds the arrays; null when there are none
  MaternFieldOptions Options(const Surface& surface, vtkDataSet* dataset) const
  {
    MaternFieldOptions options;
    options.Model = static_cast<surfsynth::NoiseModel>(this->Self->NoiseModel);
    options.Mode = static_cast<surfsynth::ScaleMode>(this->Self->ScaleMode);
    options.CorrelationRange = this->Self->CorrelationRange;
    options.Screening = this->Self->Screening;
    options.NormalizedScreening = this->Self->NormalizedScreening;
    options.NumberOfEigenpairs = this->Self->NumberOfEigenpairs;
    options.OperatorPower = this->Self->OperatorPower;
    options.FactorMemoryLimit = static_cast<std::uint64_t>(this->Self->MemoryLimit) << 20U;
    options.VarianceCorrection = this->Self->VarianceCorrection;
    options.Boundary = static_cast<surfsynth::BoundaryCondition>(this->Self->BoundaryCondition);
    options.RobinCoefficient = this->Self->RobinCoefficient;
    options.AnisotropyRatio = this->Self->AnisotropyRatio;
    options.Arrays = surfsynth::ReadFieldArrays(dataset, surface, this->Names());
    options.CoherentNoise = this->Self->CoherentNoise;
    options.Coupling = { this->Self->ComponentCoupling, this->Self->CouplingWeight, this->Self->CouplingDistance };
    return WithoutIgnoredFields(options);
  }

  /// Factor of the samples of unit deviation.
  double Scale() const
  {
    const bool inRangeMode = this->Self->ScaleMode == CORRELATION_RANGE &&
      (this->Self->NoiseModel == MATERN || this->Self->NoiseModel == SPECTRAL);
    const bool isCorrected = this->Self->VarianceCorrection && this->Self->NoiseModel == MATERN;
    if (!inRangeMode && !isCorrected && this->Self->NoiseModel != PER_VERTEX)
    {
      return 1.0;
    }
    if (!std::isfinite(this->Self->StandardDeviation))
    {
      throw surfsynth::InvalidInput("StandardDeviation is " + surfsynth::FormatNumber(this->Self->StandardDeviation) +
        "; a finite number of at least 0 is needed.");
    }
    return this->Self->StandardDeviation;
  }

  surfsynth::SampleRequest Request(const Surface& surface) const
  {
    auto request = surfsynth::RequestPart<surfsynth::SampleRequest>(this->Series(), surface);
    request.NumberOfComponents = static_cast<std::uint32_t>(this->Self->NumberOfComponents);
    request.Scale = this->Scale();
    return request;
  }

  /// Throws for properties that a surface in pieces is not solved with.
  void RequirePieces() const
  {
    const vtkMaternNoiseFilter& self = *this->Self;
    const std::pair<bool, const char*> refused[] = { { self.NoiseModel != MATERN, "NoiseModel is another than MATERN" },
      { self.OperatorPower != 2.0 && self.OperatorPower != 4.0, "OperatorPower is another than 2 and 4" },
      { self.VarianceCorrection, "VarianceCorrection is on" },
      { self.BoundaryCondition != NEUMANN, "BoundaryCondition is another than NEUMANN" },
      { self.Refinement, "Refinement is on" }, { self.CoherentNoise, "CoherentNoise is on" },
      { self.ComponentCoupling, "ComponentCoupling is on" },
      { self.Displacement != NO_DISPLACEMENT, "there is a Displacement" },
      { this->Conditioned.HasObservations(), "there are observations" },
      { this->Names().Any(), "arrays vary the field" } };
    for (const auto& [isRefused, text] : refused)
    {
      if (isRefused)
      {
        throw surfsynth::InvalidInput(std::string("GatherPieces is off, and ") + text +
          ", which a surface in pieces on several MPI ranks cannot be solved with; change it, or switch GatherPieces "
          "on.");
      }
    }
  }

  void RequireMatern() const
  {
    if (this->Conditioned.HasObservations() && this->Self->NoiseModel != MATERN)
    {
      throw surfsynth::InvalidInput("There are observations, which NoiseModel MATERN takes only.");
    }
  }

  void RequireFactor(const MaternField& field) const
  {
    if (this->Conditioned.HasObservations() && this->Self->PosteriorStandardDeviation &&
      std::string(field.SolverName()) == "Multigrid")
    {
      throw surfsynth::InvalidInput(
        "PosteriorStandardDeviation is on, which takes the Cholesky factor, but MemoryLimit is "
        "too low for it; raise MemoryLimit, or switch PosteriorStandardDeviation off.");
    }
  }

  const MaternField& Build(
    const Surface& surface, const MaternFieldOptions& options, const surfsynth::Progress& progress)
  {
    this->Conditioned.Drop(surface);
    const MaternField& field = this->Fields.Build(surface, options, progress);
    const double range = field.EffectiveCorrelationRange();
    this->WarnOfLongEdges(surface, range, field.LongestEdgeOverRange(), field.LongestEdge());
    this->WarnOfLongRange(surface, range,
      (surface.Volume ? surfsynth::ComputeBoundingBox(*surface.Volume) : surfsynth::ComputeBoundingBox(surface.Mesh))
        .LongestSide());
    return field;
  }

  /// @param ratio largest length of an edge over the range at its place
  void WarnOfLongEdges(const Surface& surface, double range, double ratio, double longestEdge) const
  {
    if (this->Self->ScaleMode == CORRELATION_RANGE && ratio > 1.0 / 3.0)
    {
      std::ostringstream text;
      if (this->Names().Any())
      {
        text << "The longest edge for its place has " << ratio
             << " times the correlation range there, more than a third";
      }
      else
      {
        text << "The longest edge is " << longestEdge << ", more than a third of the correlation range " << range;
      }
      text << ": the mesh is too coarse to carry the field. "
           << (surface.Volume ? "Fill the volume with smaller tetrahedra (TargetEdgeLength of vtkTetrahedralizeFilter; "
                                "Refinement divides triangles only)"
                              : "Switch Refinement on, refine it with vtkAdaptiveSubdivisionFilter")
           << ", or choose a range of at least " << 3.0 * ratio * range << ".";
      surfsynth::ReportWarning(this->Self, surface.Where, text.str());
    }
  }

  /// A range of several times the surface is mostly one in other units: the field is then nearly constant.
  /// @param side longest side of the box around the surface
  void WarnOfLongRange(const Surface& surface, double range, double side) const
  {
    const char* const what = surface.Volume ? "volume" : "surface";
    if (this->Self->ScaleMode == CORRELATION_RANGE && range > LongestRange * side)
    {
      std::ostringstream text;
      text << "The correlation range " << range << " is " << range / side << " times the longest side of the " << what
           << ", " << side << ": the field is nearly constant. Choose a CorrelationRange in the units of the " << what
           << ", as a rule below " << side << ".";
      surfsynth::ReportWarning(this->Self, surface.Where, text.str());
    }
  }

  vtkMaternNoiseFilter* Self;
};

vtkMaternNoiseFilter::vtkMaternNoiseFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkMaternNoiseFilter::~vtkMaternNoiseFilter() = default;

void vtkMaternNoiseFilter::SetOutputArrayName(const char* name)
{
  surfsynth::SetString(this, this->OutputArrayName, name);
}

void vtkMaternNoiseFilter::SetRangeFactorArrayName(const char* name)
{
  surfsynth::SetString(this, this->RangeFactorArrayName, name);
}

void vtkMaternNoiseFilter::SetDirectionArrayName(const char* name)
{
  surfsynth::SetString(this, this->DirectionArrayName, name);
}

void vtkMaternNoiseFilter::SetBoundaryArrayName(const char* name)
{
  surfsynth::SetString(this, this->BoundaryArrayName, name);
}

void vtkMaternNoiseFilter::SetBarrierArrayName(const char* name)
{
  surfsynth::SetString(this, this->BarrierArrayName, name);
}

void vtkMaternNoiseFilter::SetObservationArray(const char* name)
{
  surfsynth::SetString(this, this->ObservationArray, name);
}

void vtkMaternNoiseFilter::SetObservationDeviationArray(const char* name)
{
  surfsynth::SetString(this, this->ObservationDeviationArray, name);
}

int vtkMaternNoiseFilter::FillInputPortInformation(int port, vtkInformation* info)
{
  return port == 0 ? surfsynth::AcceptSurfaces(info) : surfsynth::AcceptObservations(info);
}

int vtkMaternNoiseFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequireSurfaces(this, inputVector)
    ? surfsynth::RequestSurfacesOrVolumes(vtkDataObject::GetData(inputVector[0]), outputVector)
    : 0;
}

int vtkMaternNoiseFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  try
  {
    this->Impl->RequireDisplacement();
    this->Impl->BeginConditioning(inputVector[1]);
  }
  catch (const surfsynth::Error& error)
  {
    surfsynth::ReportError(this, "", error.what());
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  const int success = surfsynth::IsVolumeOnAnyRank(inputVector) ? this->Impl->FillVolume(inputVector, outputVector)
                                                                : this->Impl->FillSurfaces(inputVector, outputVector);
  if (success && !this->GetAbortExecute())
  {
    this->Impl->Conditioned.DropUnused();
    this->Impl->Pieces.DropUnused();
    this->Impl->Displaced.DropUnused();
    this->Impl->MovePoints(vtkDataObject::GetData(outputVector));
  }
  return success;
}

double vtkMaternNoiseFilter::GetEffectiveScreening() const { return this->Impl->EffectiveScreening; }

double vtkMaternNoiseFilter::GetEffectiveCorrelationRange() const { return this->Impl->EffectiveCorrelationRange; }

double vtkMaternNoiseFilter::GetGamma() const { return this->Impl->Gamma; }

double vtkMaternNoiseFilter::GetRelativeResidual() const { return this->Impl->RelativeResidual; }

const char* vtkMaternNoiseFilter::GetSolverName() const { return this->Impl->SolverName; }

vtkTypeInt64 vtkMaternNoiseFilter::GetNumberOfIterations() const { return this->Impl->NumberOfIterations; }

vtkTypeInt64 vtkMaternNoiseFilter::GetNumberOfFactorizations() const
{
  return this->Impl->Fields.NumberOfFactorizations() + this->Impl->NumberOfPieceFactorizations;
}

vtkTypeInt64 vtkMaternNoiseFilter::GetNumberOfInvertedTriangles() const
{
  return this->Impl->Displaced.NumberOfInvertedTriangles();
}

double vtkMaternNoiseFilter::GetUnreachedDistance() const { return this->Impl->Conditioned.LargestUnreachedDistance(); }

void vtkMaternNoiseFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NoiseModel: " << this->NoiseModel << "\n";
  os << indent << "ScaleMode: " << this->ScaleMode << "\n";
  os << indent << "CorrelationRange: " << this->CorrelationRange << "\n";
  os << indent << "StandardDeviation: " << this->StandardDeviation << "\n";
  os << indent << "Screening: " << this->Screening << "\n";
  os << indent << "NormalizedScreening: " << this->NormalizedScreening << "\n";
  os << indent << "NumberOfEigenpairs: " << this->NumberOfEigenpairs << "\n";
  os << indent << "OperatorPower: " << this->OperatorPower << "\n";
  os << indent << "VarianceCorrection: " << this->VarianceCorrection << "\n";
  os << indent << "BoundaryCondition: " << this->BoundaryCondition << "\n";
  os << indent << "RobinCoefficient: " << this->RobinCoefficient << "\n";
  os << indent << "BoundaryArrayName: " << this->BoundaryArrayName << "\n";
  os << indent << "RangeFactorArrayName: " << this->RangeFactorArrayName << "\n";
  os << indent << "DirectionArrayName: " << this->DirectionArrayName << "\n";
  os << indent << "AnisotropyRatio: " << this->AnisotropyRatio << "\n";
  os << indent << "BarrierArrayName: " << this->BarrierArrayName << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfComponents: " << this->NumberOfComponents << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "Refinement: " << this->Refinement << "\n";
  os << indent << "ActiveResult: " << this->ActiveResult << "\n";
  os << indent << "GatherPieces: " << this->GatherPieces << "\n";
  os << indent << "CoherentNoise: " << this->CoherentNoise << "\n";
  os << indent << "ComponentCoupling: " << this->ComponentCoupling << "\n";
  os << indent << "CouplingWeight: " << this->CouplingWeight << "\n";
  os << indent << "CouplingDistance: " << this->CouplingDistance << "\n";
  os << indent << "ObservationArray: " << this->ObservationArray << "\n";
  os << indent << "ObservationDeviationArray: " << this->ObservationDeviationArray << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "PosteriorMean: " << this->PosteriorMean << "\n";
  os << indent << "PosteriorStandardDeviation: " << this->PosteriorStandardDeviation << "\n";
  os << indent << "Displacement: " << this->Displacement << "\n";
  os << indent << "MovedPoints: " << this->MovedPoints << "\n";
  os << indent << "ObservedTargets: " << this->ObservedTargets << "\n";
  os << indent << "OutputArrayName: " << this->OutputArrayName << "\n";
  os << indent << "EffectiveScreening: " << this->GetEffectiveScreening() << "\n";
  os << indent << "EffectiveCorrelationRange: " << this->GetEffectiveCorrelationRange() << "\n";
  os << indent << "Gamma: " << this->GetGamma() << "\n";
  os << indent << "RelativeResidual: " << this->GetRelativeResidual() << "\n";
  os << indent << "SolverName: " << this->GetSolverName() << "\n";
  os << indent << "NumberOfIterations: " << this->GetNumberOfIterations() << "\n";
  os << indent << "NumberOfFactorizations: " << this->GetNumberOfFactorizations() << "\n";
  os << indent << "NumberOfInvertedTriangles: " << this->GetNumberOfInvertedTriangles() << "\n";
  os << indent << "UnreachedDistance: " << this->GetUnreachedDistance() << "\n";
}
