// SPDX-License-Identifier: BSD-3-Clause
#include "vtkSkinningFilter.h"

#include "FilterSupport.h"
#include "ProcessingSupport.h"
#include "Reporting.h"
#include "SkeletonTables.h"
#include "SurfaceArrays.h"

#include "Core/Common/Errors.h"
#include "Core/Mesh/Skinning.h"

#include <vtkAlgorithmOutput.h>
#include <vtkDataArray.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkTable.h>

#include <string>

vtkStandardNewMacro(vtkSkinningFilter);

namespace
{
surfsynth::PointMatrix PointsOf(vtkPointSet* body)
{
  surfsynth::PointMatrix points(body->GetNumberOfPoints(), 3);
  for (vtkIdType v = 0; v < body->GetNumberOfPoints(); ++v)
  {
    body->GetPoint(v, points.row(v).data());
    if (!points.row(v).allFinite())
    {
      throw surfsynth::InvalidInput(
        "Point " + std::to_string(v) + " of the body is not finite; finite coordinates are needed.");
    }
  }
  return points;
}

/// Replaces the points by @p moved, in the same precision.
void ReplacePoints(vtkPointSet* body, const surfsynth::PointMatrix& moved)
{
  vtkNew<vtkPoints> points;
  points->SetDataType(body->GetPoints()->GetDataType() == VTK_DOUBLE ? VTK_DOUBLE : VTK_FLOAT);
  points->SetNumberOfPoints(body->GetNumberOfPoints());
  points->GetData()->SetName(body->GetPoints()->GetData()->GetName());
  for (vtkIdType v = 0; v < body->GetNumberOfPoints(); ++v)
  {
    points->SetPoint(v, moved.row(v).data());
  }
  body->SetPoints(points);
  surfsynth::DropNormals(body);
}
} // namespace

vtkSkinningFilter::vtkSkinningFilter() { this->SetNumberOfInputPorts(3); }

vtkSkinningFilter::~vtkSkinningFilter() = default;

void vtkSkinningFilter::SetBoneIndexArrayName(const char* name)
{
  surfsynth::SetString(this, this->BoneIndexArrayName, name);
}

void vtkSkinningFilter::SetBoneWeightArrayName(const char* name)
{
  surfsynth::SetString(this, this->BoneWeightArrayName, name);
}

void vtkSkinningFilter::SetBonesConnection(vtkAlgorithmOutput* port) { this->SetInputConnection(1, port); }

void vtkSkinningFilter::SetBonesData(vtkTable* bones) { this->SetInputDataObject(1, bones); }

void vtkSkinningFilter::SetPoseConnection(vtkAlgorithmOutput* port) { this->SetInputConnection(2, port); }

void vtkSkinningFilter::SetPoseData(vtkTable* pose) { this->SetInputDataObject(2, pose); }

int vtkSkinningFilter::FillInputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), port == 0 ? "vtkPointSet" : "vtkTable");
  return 1;
}

int vtkSkinningFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPointSet* body = vtkPointSet::GetData(inputVector[0]);
  vtkPointSet* output = vtkPointSet::GetData(outputVector);
  vtkTable* bones = vtkTable::GetData(inputVector[1]);
  vtkTable* pose = vtkTable::GetData(inputVector[2]);
  output->ShallowCopy(body);
  if (body->GetNumberOfPoints() == 0)
  {
    return 1;
  }
  surfsynth::PipelineProgress steps(this);
  const auto poseBody = [&] {
    surfsynth::Report(steps.Within(0.0, 0.0), 0.0);
    const auto motions = surfsynth::ComputeBoneMotions(
      surfsynth::ReadSkeleton(bones), surfsynth::ReadSkeletonPose(pose, bones));
    const auto weights = surfsynth::ReadSkinWeights(body, this->BoneIndexArrayName, this->BoneWeightArrayName);
    ReplacePoints(output,
      surfsynth::SkinPoints(PointsOf(body), weights, motions,
        static_cast<surfsynth::SkinningMethod>(this->SkinningMethod), steps.Within(0.2, 1.0)));
  };
  return surfsynth::RunGuarded(this, outputVector, [&] {
    const std::string error = surfsynth::Attempt(body, poseBody);
    if (!error.empty())
    {
      surfsynth::ReportError(this, "", error);
      output->Initialize();
    }
    return error.empty();
  });
}

void vtkSkinningFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SkinningMethod: " << this->SkinningMethod << "\n";
  os << indent << "BoneIndexArrayName: " << this->BoneIndexArrayName << "\n";
  os << indent << "BoneWeightArrayName: " << this->BoneWeightArrayName << "\n";
}
