// SPDX-License-Identifier: BSD-3-Clause
#include "vtkElasticRestFilter.h"

#include "BlockBridge.h"
#include "BlockCache.h"
#include "ElasticDomain.h"
#include "EnsembleCopies.h"
#include "FilterSupport.h"
#include "Reporting.h"
#include "SampleMemory.h"
#include "ShapeReading.h"
#include "SurfaceBridge.h"
#include "VolumeBridge.h"

#include "Core/Common/Errors.h"
#include "Core/Elasticity/ElasticDrops.h"
#include "Core/Elasticity/ElasticSettling.h"

#include <vtkAlgorithmOutput.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointSet.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

using surfsynth::ElasticDomain;
using surfsynth::ElasticEquilibrium;
using surfsynth::PointMatrix;

vtkStandardNewMacro(vtkElasticRestFilter);

namespace
{
const surfsynth::BlockTypes BodyToRestStates{ { "vtkPolyData", "vtkUnstructuredGrid" }, "vtkMultiBlockDataSet" };

/// Ends messages about shapes of composite inputs.
constexpr const char* PlacesExpected =
  "; expected a composite dataset as the input, with moved copies of each block in its place.";

/// Diagonal of a body without a unit, meters.
constexpr double DefaultDiagonal = 0.5;

/// Between world units and meters with z upwards and the lowest point at height 0.
struct Frame
{
  Frame(const PointMatrix& points, const Eigen::Vector3d& up, double lengthUnit)
  {
    // Divided first, since the square of its length may be too large or too small for a number.
    const Eigen::Vector3d direction = (up / up.cwiseAbs().maxCoeff()).normalized();
    this->Turn = Eigen::Quaterniond::FromTwoVectors(direction, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::RowVector3d extent = points.colwise().maxCoeff() - points.colwise().minCoeff();
    this->Meters = lengthUnit > 0.0 ? lengthUnit : DefaultDiagonal / extent.norm();
    this->Floor = (points * this->Turn.transpose()).col(2).minCoeff();
  }
  PointMatrix ToMeters(const PointMatrix& points) const
  {
    PointMatrix turned = points * this->Turn.transpose();
    turned.col(2).array() -= this->Floor;
    return this->Meters * turned;
  }
  PointMatrix ToWorld(const PointMatrix& points) const
  {
    PointMatrix turned = points / this->Meters;
    turned.col(2).array() += this->Floor;
    return turned * this->Turn;
  }

  /// Lifts what is below the floor onto it.
  PointMatrix AboveFloor(const PointMatrix& points) const
  {
    PointMatrix turned = points * this->Turn.transpose();
    turned.col(2) = turned.col(2).cwiseMax(this->Floor);
    return turned * this->Turn;
  }

  Eigen::Matrix3d Turn;
  double Meters; ///< in a world unit
  double Floor;  ///< height of the lowest point, world units
};

/// A body in a domain, ready to be dropped.
struct PreparedBody
{
  std::uint64_t TetrahedraHash = 0; ///< of port 1
  int SurfacePoints = 0;
  std::shared_ptr<const ElasticDomain> Domain;
};

void AddNumber(vtkFieldData* data, const char* name, double value)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->InsertNextValue(value);
  data->AddArray(array);
}
} // namespace

/// Bodies of the last update, and the work of one update.
class vtkElasticRestFilter::Internals
{
public:
  explicit Internals(vtkElasticRestFilter* self)
    : Self(self)
  {}

  /// Starts an update with tetrahedra, or null, and shapes, or none.
  void Begin(vtkDataObject* input, vtkDataObject* tetrahedra, vtkDataObject* shapes)
  {
    this->Input = input;
    this->Grid = vtkUnstructuredGrid::SafeDownCast(tetrahedra);
    this->Shapes = shapes;
    this->Tetrahedra.reset();
    this->Blocks.Begin();
  }

  /// Ends an update: forgets what it has not used.
  void End()
  {
    this->Tetrahedra.reset();
    this->Grid = nullptr;
    this->Shapes = nullptr;
    this->Input = nullptr;
    this->Blocks.DropUnused();
  }

  void MakeRestStates(const surfsynth::Block& block, const surfsynth::Progress& progress)
  {
    const std::vector<surfsynth::MovedCopy> copies = this->CopiesOf(block);
    const ElasticDomain& domain = this->DomainOf(block, surfsynth::SubProgress(progress, 0.0, 0.1));
    const Frame frame(
      domain.Mesh.Points, Eigen::Map<const Eigen::Vector3d>(this->Self->UpDirection), this->Self->LengthUnit);
    const surfsynth::Progress simulating = surfsynth::SubProgress(progress, 0.1, 0.94);
    std::vector<ElasticEquilibrium> states = copies.empty() ? this->Dropped(block, domain, frame, simulating)
                                                            : this->Settled(copies, domain, frame, simulating);
    const surfsynth::Progress following = surfsynth::SubProgress(progress, 0.94, 0.97);
    std::vector<PointMatrix> points;
    for (ElasticEquilibrium& state : states)
    {
      points.push_back(frame.AboveFloor(domain.Follow(frame.ToWorld(state.Points))));
      state.Points.resize(0, 3);
      surfsynth::Report(following, static_cast<double>(points.size()) / static_cast<double>(states.size()));
    }
    const surfsynth::CopyOptions options{ this->Self->DisplacementArrayName, this->Self->FirstSample,
      this->Self->Spread, ComputeBoundingBox(domain.Mesh) };
    const auto addNumbers = [&](vtkPointSet* copy, std::size_t k) { this->AddNumbers(copy, states[k], frame.Floor); };
    surfsynth::FillWithCopies(vtkMultiBlockDataSet::SafeDownCast(block.Output), vtkPointSet::SafeDownCast(block.Input),
      domain.Points, points, options, addNumbers, surfsynth::SubProgress(progress, 0.97, 1.0));
  }

  /// What is wrong with properties and memory, or "": the same on all MPI ranks.
  std::string ProblemOf(vtkDataObject* input, vtkDataObject* given) const
  {
    if (this->Self->DisplacementArrayName.empty())
    {
      return "DisplacementArrayName is empty; a name for the point array is needed.";
    }
    if (this->Self->MinimumSpin > this->Self->MaximumSpin)
    {
      return "MinimumSpin is above MaximumSpin; expected a lower bound of at most the upper one.";
    }
    if (const Eigen::Map<const Eigen::Vector3d> up(this->Self->UpDirection); !up.allFinite() || up.isZero(0.0))
    {
      return "UpDirection is not finite, or has no length; expected a direction.";
    }
    const surfsynth::ShapeCounts shapes = surfsynth::CountShapes(input, given);
    if (shapes.Lost > 0)
    {
      return std::to_string(shapes.Lost) + " of the shapes stand in no place of a block of the input" + PlacesExpected;
    }
    const int samples = given ? static_cast<int>(std::max<std::size_t>(shapes.Most, 1)) : this->Self->NumberOfSamples;
    // Points and displacements, in double precision while they are made and afterwards in that of the input.
    std::string problem = surfsynth::ProblemOfMemory(input, { samples, 48.0, 0.0, 8192.0, this->Self->MemoryLimit });
    const std::string advice = "A NumberOfSamples of ";
    if (const std::size_t place = problem.find(advice); given && place != std::string::npos)
    {
      problem.replace(place, advice.size(), "A number of shapes of ");
    }
    return problem;
  }

  surfsynth::BlockCache<PreparedBody> Blocks;
  vtkTypeInt64 NumberOfPreparations = 0;

private:
  /// The shapes of a block, judged before long work; none without port 2.
  std::vector<surfsynth::MovedCopy> CopiesOf(const surfsynth::Block& block) const
  {
    if (!this->Shapes)
    {
      return {};
    }
    vtkDataObject* shapes = surfsynth::ShapesOfBlock(this->Input, this->Shapes, block.FlatIndex);
    if (!shapes)
    {
      throw surfsynth::InvalidInput(std::string("There are no shapes in the place of this block") + PlacesExpected);
    }
    return surfsynth::MovedCopies(shapes, vtkPointSet::SafeDownCast(block.Input));
  }

  /// Rest states after random drops.
  std::vector<ElasticEquilibrium> Dropped(const surfsynth::Block& block, const ElasticDomain& domain,
    const Frame& frame, const surfsynth::Progress& progress) const
  {
    const surfsynth::ElasticDrops drops(
      { frame.ToMeters(domain.Mesh.Points), domain.Mesh.Tetrahedra }, this->Options());
    surfsynth::NormalKey key;
    key.Seed = static_cast<std::uint64_t>(this->Self->Seed);
    key.Sample = static_cast<std::uint32_t>(this->Self->FirstSample);
    key.Stream = block.FlatIndex;
    return drops.Sample(key, this->Self->NumberOfSamples, progress);
  }

  /// Rest states next to the shapes.
  std::vector<ElasticEquilibrium> Settled(const std::vector<surfsynth::MovedCopy>& copies, const ElasticDomain& domain,
    const Frame& frame, const surfsynth::Progress& progress) const
  {
    std::vector<PointMatrix> shapes;
    for (const surfsynth::MovedCopy& copy : copies)
    {
      shapes.push_back(frame.ToMeters(PointsOfCopy(copy, domain.Points)));
    }
    const surfsynth::DropOptions options = this->Options();
    const surfsynth::ElasticSettling settling({ frame.ToMeters(domain.Mesh.Points), domain.Mesh.Tetrahedra },
      domain.Places, frame.Meters * domain.Offsets * frame.Turn.transpose(), domain.Weights,
      { options.Material, options.Surroundings, options.Motion, options.Align });
    return settling.Settle(shapes, this->Self->FirstSample, progress);
  }

  surfsynth::DropOptions Options() const
  {
    surfsynth::DropOptions options;
    options.Material = { this->Self->YoungsModulus, this->Self->PoissonsRatio, this->Self->Density };
    options.Surroundings.Gravity = this->Self->Gravity;
    options.Surroundings.Friction = this->Self->Friction;
    options.Surroundings.Damping = this->Self->Damping;
    options.Surroundings.HasSelfContact = this->Self->SelfContact;
    options.Motion.TimeStep = this->Self->TimeStep;
    options.Motion.MaximumTime = this->Self->MaximumTime;
    options.DropHeight = this->Self->DropHeight;
    options.MinimumSpin = this->Self->MinimumSpin;
    options.MaximumSpin = this->Self->MaximumSpin;
    options.RandomOrientation = this->Self->RandomOrientation;
    options.Align = this->Self->Align;
    return options;
  }

  const ElasticDomain& DomainOf(const surfsynth::Block& block, const surfsynth::Progress& progress)
  {
    surfsynth::Surface content = this->ContentOf(block);
    const surfsynth::TetrahedralMesh* given = content.Volume ? nullptr : this->GivenTetrahedra();
    PreparedBody body;
    body.TetrahedraHash = given ? surfsynth::ContentHash(*given) : 0;
    body.SurfacePoints = given || content.Volume ? 0 : this->Self->NumberOfSurfacePoints;
    const auto isCurrent = [&body](const PreparedBody& held) {
      return held.TetrahedraHash == body.TetrahedraHash && held.SurfacePoints == body.SurfacePoints;
    };
    if (const PreparedBody* held = this->Blocks.Find(content, isCurrent))
    {
      return *held->Domain;
    }
    this->Blocks.Drop(content);
    body.Domain = std::make_shared<const ElasticDomain>(
      surfsynth::MakeElasticDomain(content, given, body.SurfacePoints, progress));
    ++this->NumberOfPreparations;
    return *this->Blocks.Insert(content, std::move(body)).Domain;
  }

  /// The converted block, which the cache knows it by.
  surfsynth::Surface ContentOf(const surfsynth::Block& block) const
  {
    auto* grid = vtkUnstructuredGrid::SafeDownCast(block.Input);
    surfsynth::Surface content = grid ? surfsynth::ConvertVolume(grid)
                                      : surfsynth::ConvertSurface(vtkPolyData::SafeDownCast(block.Input));
    content.FlatIndex = block.FlatIndex;
    return content;
  }

  /// The tetrahedra of port 1, converted at the first call of an update; null for none.
  const surfsynth::TetrahedralMesh* GivenTetrahedra()
  {
    try
    {
      if (this->Grid && !this->Tetrahedra)
      {
        this->Tetrahedra = surfsynth::TetrahedraOf(surfsynth::ConvertVolume(this->Grid));
      }
      return this->Tetrahedra ? &*this->Tetrahedra : nullptr;
    }
    catch (const surfsynth::InvalidInput& error)
    {
      throw surfsynth::InvalidInput(std::string("The tetrahedra: ") + error.what());
    }
  }

  /// Adds what is known of a rest state to field data of the copy's own.
  void AddNumbers(vtkPointSet* copy, const ElasticEquilibrium& state, double floor) const
  {
    vtkNew<vtkFieldData> data;
    data->ShallowCopy(copy->GetFieldData());
    AddNumber(data, "SettlingTime", state.Time);
    AddNumber(data, "ForceImbalance", state.Imbalance);
    AddNumber(data, "SmallestVolumeRatio", state.SmallestVolumeRatio);
    AddNumber(data, "EnergyRise", state.LargestEnergyRise);
    AddNumber(data, "FloorHeight", floor);
    copy->SetFieldData(data);
  }

  vtkElasticRestFilter* Self;
  vtkSmartPointer<vtkUnstructuredGrid> Grid;
  std::optional<surfsynth::TetrahedralMesh> Tetrahedra; ///< of this update
  vtkDataObject* Input = nullptr;                       ///< of this update
  vtkDataObject* Shapes = nullptr;                      ///< of this update
};

vtkElasticRestFilter::vtkElasticRestFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(3);
}

vtkElasticRestFilter::~vtkElasticRestFilter() = default;

void vtkElasticRestFilter::SetTetrahedraConnection(vtkAlgorithmOutput* port) { this->SetInputConnection(1, port); }

void vtkElasticRestFilter::SetTetrahedraData(vtkDataObject* tetrahedra) { this->SetInputDataObject(1, tetrahedra); }

void vtkElasticRestFilter::SetShapesConnection(vtkAlgorithmOutput* port) { this->SetInputConnection(2, port); }

void vtkElasticRestFilter::SetShapesData(vtkDataObject* shapes) { this->SetInputDataObject(2, shapes); }

void vtkElasticRestFilter::SetDisplacementArrayName(const char* name)
{
  surfsynth::SetString(this, this->DisplacementArrayName, name);
}

int vtkElasticRestFilter::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 0)
  {
    return surfsynth::AcceptBlocks(info, BodyToRestStates);
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  }
  else
  {
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPointSet");
    info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  }
  return 1;
}

int vtkElasticRestFilter::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  return surfsynth::RequestBlocks(this, inputVector, outputVector, BodyToRestStates);
}

int vtkElasticRestFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* shapes = vtkDataObject::GetData(inputVector[2]);
  const std::string problem = this->Impl->ProblemOf(vtkDataObject::GetData(inputVector[0]), shapes);
  if (!problem.empty())
  {
    surfsynth::ReportError(this, "", problem);
    vtkDataObject::GetData(outputVector)->Initialize();
    return 0;
  }
  this->Impl->Begin(vtkDataObject::GetData(inputVector[0]), vtkDataObject::GetData(inputVector[1]), shapes);
  const auto makeRestStates = [this](const surfsynth::Block& block, const surfsynth::Progress& progress) {
    this->Impl->MakeRestStates(block, progress);
  };
  const int success = surfsynth::ProcessBlocks(this, inputVector, outputVector, BodyToRestStates, makeRestStates);
  this->Impl->End();
  return success;
}

vtkTypeInt64 vtkElasticRestFilter::GetNumberOfPreparations() const { return this->Impl->NumberOfPreparations; }

void vtkElasticRestFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Seed: " << this->Seed << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "MemoryLimit: " << this->MemoryLimit << "\n";
  os << indent << "Spread: " << this->Spread << "\n";
  os << indent << "NumberOfSurfacePoints: " << this->NumberOfSurfacePoints << "\n";
  os << indent << "LengthUnit: " << this->LengthUnit << "\n";
  os << indent << "YoungsModulus: " << this->YoungsModulus << "\n";
  os << indent << "PoissonsRatio: " << this->PoissonsRatio << "\n";
  os << indent << "Density: " << this->Density << "\n";
  os << indent << "Friction: " << this->Friction << "\n";
  os << indent << "Gravity: " << this->Gravity << "\n";
  os << indent << "Damping: " << this->Damping << "\n";
  os << indent << "DropHeight: " << this->DropHeight << "\n";
  os << indent << "MinimumSpin: " << this->MinimumSpin << "\n";
  os << indent << "MaximumSpin: " << this->MaximumSpin << "\n";
  os << indent << "RandomOrientation: " << this->RandomOrientation << "\n";
  os << indent << "Align: " << this->Align << "\n";
  os << indent << "SelfContact: " << this->SelfContact << "\n";
  os << indent << "UpDirection: (" << this->UpDirection[0] << ", " << this->UpDirection[1] << ", "
     << this->UpDirection[2] << ")\n";
  os << indent << "TimeStep: " << this->TimeStep << "\n";
  os << indent << "MaximumTime: " << this->MaximumTime << "\n";
  os << indent << "DisplacementArrayName: " << this->DisplacementArrayName << "\n";
  os << indent << "NumberOfPreparations: " << this->GetNumberOfPreparations() << "\n";
}
