// SPDX-License-Identifier: BSD-3-Clause
#include "vtkShapeModelSampler.h"

#include "EnsembleReading.h"
#include "JointProcessing.h"
#include "SampleMemory.h"
#include "StatisticsOutput.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"

#include "Core/Common/Errors.h"
#include "Core/Statistics/ShapeModel.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

using surfsynth::Ensemble;
using surfsynth::InvalidInput;
using surfsynth::ShapeModel;

vtkStandardNewMacro(vtkShapeModelSampler);

namespace
{
Eigen::VectorXd ValuesOf(vtkDataArray* array)
{
  const int components = array->GetNumberOfComponents();
  Eigen::VectorXd values(array->GetNumberOfTuples() * components);
  for (vtkIdType tuple = 0; tuple < array->GetNumberOfTuples(); ++tuple)
  {
    array->GetTuple(tuple, values.data() + tuple * components);
  }
  return values;
}

/// A model as it lies in a surface.
struct StoredModel
{
  /// @param modes number of modes that are used; -1 for all
  /// @throws InvalidInput for a surface without modes, or with arrays that do not fit
  StoredModel(vtkPolyData* surface, int modes)
    : Surface(surface)
    , Array(ArrayNameOf(surface))
    , Mean(MeanOf(surface, this->Array))
    , Model(ValuesOf(this->Mean), ModesOf(surface, this->Mean, modes))
  {}

  static std::string ArrayNameOf(vtkPolyData* surface)
  {
    auto* name = vtkStringArray::SafeDownCast(surface->GetFieldData()->GetAbstractArray(surfsynth::EnsembleArrayField));
    return name && name->GetNumberOfValues() > 0 ? std::string(name->GetValue(0)) : std::string();
  }

  static vtkDataArray* MeanOf(vtkPolyData* surface, const std::string& array)
  {
    vtkDataArray* mean = array.empty() ? surface->GetPoints()->GetData()
                                       : surface->GetPointData()->GetArray(surfsynth::MeanName);
    if (!mean || mean->GetNumberOfTuples() != surface->GetNumberOfPoints())
    {
      throw InvalidInput("The model has no point array \"" + std::string(surfsynth::MeanName) +
        "\", which models of an array have; connect the first output of vtkEnsembleStatistics.");
    }
    return mean;
  }

  static Eigen::MatrixXd ModesOf(vtkPolyData* surface, vtkDataArray* mean, int wanted)
  {
    std::vector<vtkDataArray*> arrays;
    const auto named = [surface](std::size_t k) {
      return surface->GetPointData()->GetArray((std::string(surfsynth::ModeName) + "_" + std::to_string(k)).c_str());
    };
    while (vtkDataArray* mode = named(arrays.size()))
    {
      if (mode->GetNumberOfComponents() != mean->GetNumberOfComponents() ||
        mode->GetNumberOfTuples() != mean->GetNumberOfTuples())
      {
        throw InvalidInput("The model's array " + std::string(mode->GetName()) + " has " +
          std::to_string(mode->GetNumberOfTuples()) + " tuples of " + std::to_string(mode->GetNumberOfComponents()) +
          " components and its mean " + std::to_string(mean->GetNumberOfTuples()) + " of " +
          std::to_string(mean->GetNumberOfComponents()) + "; both must be the same.");
      }
      arrays.push_back(mode);
    }
    if (arrays.empty())
    {
      throw InvalidInput("The model has no point array \"Mode_0\"; connect the first output of vtkEnsembleStatistics "
                         "with NumberOfModes other than 0.");
    }
    const std::size_t kept = wanted < 0 ? arrays.size() : std::min(arrays.size(), static_cast<std::size_t>(wanted));
    Eigen::MatrixXd modes(mean->GetNumberOfValues(), static_cast<Eigen::Index>(kept));
    for (std::size_t k = 0; k < kept; ++k)
    {
      modes.col(static_cast<Eigen::Index>(k)) = ValuesOf(arrays[k]);
    }
    return modes;
  }

  vtkPolyData* Surface;
  std::string Array; ///< array of the ensemble; empty for positions
  vtkDataArray* Mean;
  ShapeModel Model;
};

void AddField(vtkPolyData* output, const char* name, const Eigen::VectorXd& values)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->SetNumberOfValues(values.size());
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  output->GetFieldData()->AddArray(array);
}

/// Surface of the model with the shape of the coefficients.
vtkSmartPointer<vtkPolyData> SurfaceOfCoefficients(const StoredModel& stored, const Eigen::VectorXd& coefficients)
{
  auto output = vtkSmartPointer<vtkPolyData>::New();
  output->CopyStructure(stored.Surface);
  output->GetCellData()->PassData(stored.Surface->GetCellData());
  const Eigen::VectorXd shape = stored.Model.Shape(coefficients);
  if (stored.Array.empty())
  {
    surfsynth::SetPositions(output, shape);
  }
  else
  {
    surfsynth::AddValues(output, stored.Array, shape, stored.Mean->GetNumberOfComponents());
    output->GetPointData()->SetActiveScalars(stored.Array.c_str());
  }
  Eigen::VectorXd all = Eigen::VectorXd::Zero(stored.Model.NumberOfModes());
  all.head(coefficients.size()) = coefficients;
  AddField(output, "Coefficients", all);
  return output;
}

void AddBlock(vtkMultiBlockDataSet* output, vtkPolyData* surface, int sample)
{
  const unsigned int block = output->GetNumberOfBlocks();
  output->SetBlock(block, surface);
  output->GetMetaData(block)->Set(vtkCompositeDataSet::NAME(), ("Sample " + std::to_string(sample)).c_str());
}
} // namespace

/// Work of one update.
class vtkShapeModelSampler::Internals
{
public:
  explicit Internals(vtkShapeModelSampler* self)
    : Self(self)
  {}

  void Fill(vtkInformationVector** inputVector, vtkMultiBlockDataSet* output, const surfsynth::Progress& progress) const
  {
    const auto surface = surfsynth::SurfaceOn(inputVector[0]);
    if (!surface || surface->GetNumberOfPoints() == 0)
    {
      return;
    }
    const StoredModel stored(surface, this->Self->NumberOfModes);
    if (this->Self->CoefficientSource == PROJECTED)
    {
      this->Project(stored, vtkDataObject::GetData(inputVector[1]), output, progress);
    }
    else if (this->Self->CoefficientSource == GIVEN)
    {
      const auto& given = this->Self->Coefficients;
      const Eigen::Map<const Eigen::VectorXd> coefficients(given.data(), static_cast<Eigen::Index>(given.size()));
      AddBlock(output, SurfaceOfCoefficients(stored, coefficients), 0);
    }
    else
    {
      this->Sample(stored, output, progress);
    }
  }

private:
  void Sample(const StoredModel& stored, vtkMultiBlockDataSet* output, const surfsynth::Progress& progress) const
  {
    const int count = this->Self->NumberOfSamples;
    if (count - 1 > VTK_INT_MAX - this->Self->FirstSample)
    {
      throw InvalidInput("FirstSample and NumberOfSamples together exceed the largest number of a sample, " +
        std::to_string(VTK_INT_MAX) + "; smaller numbers are needed.");
    }
    surfsynth::SampleMemory memory;
    memory.NumberOfSamples = count;
    memory.BytesOfPoint = 8.0 * stored.Mean->GetNumberOfComponents();
    const std::string problem = surfsynth::ProblemOfMemory(stored.Surface, memory);
    if (!problem.empty())
    {
      throw InvalidInput(problem);
    }
    for (int k = 0; k < count; ++k)
    {
      const int sample = this->Self->FirstSample + k;
      const Eigen::VectorXd coefficients = stored.Model.RandomCoefficients(
        static_cast<std::uint64_t>(this->Self->Seed), static_cast<std::uint32_t>(sample));
      AddBlock(output, SurfaceOfCoefficients(stored, coefficients), sample);
      surfsynth::Report(progress, (k + 1.0) / count);
    }
  }

  void Project(const StoredModel& stored, vtkDataObject* shapes, vtkMultiBlockDataSet* output,
    const surfsynth::Progress& progress) const
  {
    const Ensemble ensemble = surfsynth::ReadEnsemble(shapes, "projected", stored.Array);
    const int components = stored.Mean->GetNumberOfComponents();
    surfsynth::RequireOneTriangulation(ensemble, { stored.Surface, "the model" }, components);
    int sample = 0;
    for (const surfsynth::EnsembleSample& shape : ensemble.Samples)
    {
      const Eigen::VectorXd values = ValuesOf(shape.Values);
      const auto surface = SurfaceOfCoefficients(stored, stored.Model.Project(values));
      vtkDataArray* made = stored.Array.empty() ? surface->GetPoints()->GetData()
                                                : surface->GetPointData()->GetArray(stored.Array.c_str());
      const Eigen::MatrixXd difference = (values - ValuesOf(made)).reshaped(components, values.size() / components);
      const Eigen::VectorXd residual = difference.colwise().norm().transpose();
      surfsynth::AddValues(surface, "Residual", residual, 1);
      AddField(surface, "RMSResidual",
        Eigen::VectorXd::Constant(1, residual.norm() / std::sqrt(static_cast<double>(residual.size()))));
      AddBlock(output, surface, sample++);
      surfsynth::Report(progress, static_cast<double>(sample) / static_cast<double>(ensemble.Samples.size()));
    }
  }

  vtkShapeModelSampler* Self;
};

vtkShapeModelSampler::vtkShapeModelSampler()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetNumberOfInputPorts(2);
}

vtkShapeModelSampler::~vtkShapeModelSampler() = default;

void vtkShapeModelSampler::SetNumberOfCoefficients(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->Coefficients.size() != wanted)
  {
    this->Coefficients.resize(wanted, 0.0);
    this->Modified();
  }
}

void vtkShapeModelSampler::SetCoefficient(int index, double value)
{
  if (index < 0 || index >= this->GetNumberOfCoefficients())
  {
    return;
  }
  double& coefficient = this->Coefficients[static_cast<std::size_t>(index)];
  if (coefficient != value)
  {
    coefficient = value;
    this->Modified();
  }
}

double vtkShapeModelSampler::GetCoefficient(int index) const
{
  return index >= 0 && index < this->GetNumberOfCoefficients() ? this->Coefficients[static_cast<std::size_t>(index)]
                                                               : 0.0;
}

int vtkShapeModelSampler::FillInputPortInformation(int port, vtkInformation* info)
{
  if (port == 0)
  {
    return surfsynth::AcceptSurface(info);
  }
  info->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return surfsynth::AcceptSurfaces(info);
}

int vtkShapeModelSampler::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* output = vtkMultiBlockDataSet::GetData(outputVector);
  return surfsynth::ProcessJointly(this, inputVector, outputVector,
    [&](const surfsynth::Progress& progress) { this->Impl->Fill(inputVector, output, progress); });
}

void vtkShapeModelSampler::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "CoefficientSource: " << this->CoefficientSource << "\n";
  os << indent << "Coefficients:";
  for (const double coefficient : this->Coefficients)
  {
    os << " " << coefficient;
  }
  os << "\n";
  os << indent << "NumberOfModes: " << this->NumberOfModes << "\n";
  os << indent << "NumberOfSamples: " << this->NumberOfSamples << "\n";
  os << indent << "FirstSample: " << this->FirstSample << "\n";
  os << indent << "Seed: " << this->Seed << "\n";
}
