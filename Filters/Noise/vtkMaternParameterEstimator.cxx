// SPDX-License-Identifier: BSD-3-Clause
#include "vtkMaternParameterEstimator.h"

#include "FilterSupport.h"
#include "JointProcessing.h"
#include "ObservationReading.h"
#include "SurfaceBridge.h"
#include "SurfaceInputs.h"
#include "TableColumns.h"

#include "Core/Common/Errors.h"
#include "Core/Noise/FieldConditioning.h"
#include "Core/Noise/MaternEstimation.h"

#include <vtkDataObject.h>
#include <vtkDoubleArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPointSet.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <array>
#include <numeric>
#include <vector>

using surfsynth::AddColumn;
using surfsynth::EstimatedParameter;
using surfsynth::MaternEstimate;

vtkStandardNewMacro(vtkMaternParameterEstimator);

namespace
{
/// Values of fields at places of a surface.
struct ObservedFields
{
  surfsynth::SparseRowMatrix Matrix; ///< [n, V]
  Eigen::MatrixXd Values;            ///< [n, fields]
};

/// The fields at the points of the surface that triangles use.
ObservedFields FieldsOfSurface(const surfsynth::Surface& surface, vtkPolyData* data, const std::string& name)
{
  std::vector<surfsynth::Index> used;
  for (surfsynth::Index v = 0; v < surface.Mesh.NumberOfPoints(); ++v)
  {
    if (surface.Topology->VertexTriangleStart[v] < surface.Topology->VertexTriangleStart[v + 1])
    {
      used.push_back(v);
    }
  }
  const Eigen::MatrixXd all = surfsynth::ReadFields(data, name, "ObservationArray", used);
  ObservedFields fields;
  fields.Values.resize(static_cast<Eigen::Index>(used.size()), all.cols());
  fields.Matrix.resize(static_cast<surfsynth::Index>(used.size()), surface.Mesh.NumberOfPoints());
  for (std::size_t k = 0; k < used.size(); ++k)
  {
    fields.Values.row(static_cast<Eigen::Index>(k)) = all.row(used[k]);
    fields.Matrix.insert(static_cast<surfsynth::Index>(k), used[k]) = 1.0;
  }
  fields.Matrix.makeCompressed();
  return fields;
}

/// The fields at the points of a second dataset.
ObservedFields FieldsOfPoints(
  const surfsynth::Surface& surface, vtkPolyData* data, const std::string& name, double tolerance)
{
  std::vector<surfsynth::Index> all(static_cast<std::size_t>(data->GetNumberOfPoints()));
  std::iota(all.begin(), all.end(), surfsynth::Index(0));
  ObservedFields fields;
  fields.Values = surfsynth::ReadFields(data, name, "ObservationArray", all);
  fields.Matrix = surfsynth::ObservationMatrix(
    surface.Mesh, surfsynth::AttachToSurface(surface.Mesh, surfsynth::ConvertPoints(data), tolerance));
  return fields;
}

void FillTable(vtkTable* table, const MaternEstimate& estimate)
{
  const std::array<EstimatedParameter, 3> parameters = { estimate.CorrelationRange, estimate.StandardDeviation,
    estimate.NoiseDeviation };
  const auto add = [&](const char* name, double EstimatedParameter::*field) {
    std::vector<double> values;
    for (const EstimatedParameter& parameter : parameters)
    {
      values.push_back(parameter.*field);
    }
    AddColumn<vtkDoubleArray>(table, name, values);
  };
  AddColumn<vtkStringArray>(
    table, "Parameter", std::vector<std::string>{ "CorrelationRange", "StandardDeviation", "NoiseDeviation" });
  add("Estimate", &EstimatedParameter::Value);
  add("StandardError", &EstimatedParameter::StandardError);
  add("Lower", &EstimatedParameter::Lower);
  add("Upper", &EstimatedParameter::Upper);
}
} // namespace

/// Estimate of the last update.
class vtkMaternParameterEstimator::Internals
{
public:
  MaternEstimate Estimate;
};

vtkMaternParameterEstimator::vtkMaternParameterEstimator()
  : Impl(std::make_unique<Internals>())
{
  this->SetNumberOfInputPorts(2);
}

vtkMaternParameterEstimator::~vtkMaternParameterEstimator() = default;

void vtkMaternParameterEstimator::SetObservationArray(const char* name)
{
  surfsynth::SetString(this, this->ObservationArray, name);
}

int vtkMaternParameterEstimator::FillInputPortInformation(int port, vtkInformation* info)
{
  return port == 0 ? surfsynth::AcceptSurface(info) : surfsynth::AcceptObservations(info);
}

int vtkMaternParameterEstimator::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->Impl->Estimate = MaternEstimate();
  const auto estimate = [&](const surfsynth::Progress& progress) {
    const auto input = surfsynth::SurfaceOn(inputVector[0]);
    if (!input)
    {
      throw surfsynth::InvalidInput("The input is " + surfsynth::DescribeInput(vtkDataObject::GetData(inputVector[0])) +
        "; a vtkPolyData is needed.");
    }
    if (input->GetNumberOfPoints() == 0)
    {
      return;
    }
    const surfsynth::Surface surface = surfsynth::ToSurface(input, surfsynth::MeshRequirements());
    const auto points = surfsynth::ObservationsHere(inputVector[1]);
    const ObservedFields fields = points ? FieldsOfPoints(surface, points, this->ObservationArray, this->Tolerance)
                                         : FieldsOfSurface(surface, input, this->ObservationArray);
    surfsynth::MaternEstimationOptions options;
    options.OperatorPower = this->OperatorPower;
    options.Noise = this->NoiseEstimation;
    options.Mean = this->MeanEstimation;
    this->Impl->Estimate = surfsynth::EstimateMatern(
      surface.Mesh, *surface.Topology, fields.Matrix, fields.Values, options, progress);
    FillTable(vtkTable::GetData(outputVector), this->Impl->Estimate);
  };
  return surfsynth::ProcessJointly(this, inputVector, outputVector, estimate);
}

double vtkMaternParameterEstimator::GetCorrelationRange() const { return this->Impl->Estimate.CorrelationRange.Value; }

double vtkMaternParameterEstimator::GetStandardDeviation() const
{
  return this->Impl->Estimate.StandardDeviation.Value;
}

double vtkMaternParameterEstimator::GetNoiseDeviation() const { return this->Impl->Estimate.NoiseDeviation.Value; }

double vtkMaternParameterEstimator::GetLogLikelihood() const { return this->Impl->Estimate.LogLikelihood; }

vtkTypeInt64 vtkMaternParameterEstimator::GetNumberOfObservations() const { return this->Impl->Estimate.Observations; }

vtkTypeInt64 vtkMaternParameterEstimator::GetNumberOfFields() const { return this->Impl->Estimate.Fields; }

void vtkMaternParameterEstimator::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ObservationArray: " << this->ObservationArray << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "OperatorPower: " << this->OperatorPower << "\n";
  os << indent << "NoiseEstimation: " << this->NoiseEstimation << "\n";
  os << indent << "MeanEstimation: " << this->MeanEstimation << "\n";
  os << indent << "CorrelationRange: " << this->GetCorrelationRange() << "\n";
  os << indent << "StandardDeviation: " << this->GetStandardDeviation() << "\n";
  os << indent << "NoiseDeviation: " << this->GetNoiseDeviation() << "\n";
  os << indent << "LogLikelihood: " << this->GetLogLikelihood() << "\n";
  os << indent << "NumberOfObservations: " << this->GetNumberOfObservations() << "\n";
  os << indent << "NumberOfFields: " << this->GetNumberOfFields() << "\n";
}
