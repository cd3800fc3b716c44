// SPDX-License-Identifier: BSD-3-Clause
#include "vtkFlowMatchingDeformer.h"

#include "DeformedSurface.h"
#include "FilterSupport.h"

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIndent.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

vtkStandardNewMacro(vtkFlowMatchingDeformer);

vtkFlowMatchingDeformer::vtkFlowMatchingDeformer() = default;
vtkFlowMatchingDeformer::~vtkFlowMatchingDeformer() = default;

void vtkFlowMatchingDeformer::SetDisplacementArrayName(const char* name)
{
  surfsynth::SetString(this, this->DisplacementArrayName, name);
}

void vtkFlowMatchingDeformer::SetAreaRatioArrayName(const char* name)
{
  surfsynth::SetString(this, this->AreaRatioArrayName, name);
}

std::string vtkFlowMatchingDeformer::GeneratedArrayName() { return this->DisplacementArrayName; }

std::vector<std::pair<std::string, std::string>> vtkFlowMatchingDeformer::OutputArrayNames()
{
  return { { "InitialNoiseArrayName", this->GetInitialNoiseArrayName() },
    { "DisplacementArrayName", this->DisplacementArrayName }, { "AreaRatioArrayName", this->AreaRatioArrayName } };
}

void vtkFlowMatchingDeformer::AddSample(vtkPolyData* output, vtkDoubleArray* displacement, vtkDoubleArray* noise)
{
  output->GetCellData()->AddArray(surfsynth::AreaRatios(output, displacement, this->AreaRatioArrayName));
  if (this->MovePoints)
  {
    surfsynth::MovePoints(output, displacement);
  }
  displacement->SetName(this->DisplacementArrayName.c_str());
  noise->SetName(this->GetInitialNoiseArrayName());
  output->GetPointData()->AddArray(noise);
  output->GetPointData()->AddArray(displacement);
  if (!output->GetPointData()->GetVectors())
  {
    output->GetPointData()->SetActiveVectors(displacement->GetName());
  }
}

void vtkFlowMatchingDeformer::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MovePoints: " << this->MovePoints << "\n";
  os << indent << "DisplacementArrayName: " << this->DisplacementArrayName << "\n";
  os << indent << "AreaRatioArrayName: " << this->AreaRatioArrayName << "\n";
}
