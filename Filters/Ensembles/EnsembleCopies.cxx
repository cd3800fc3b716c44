// SPDX-License-Identifier: BSD-3-Clause
#include "EnsembleCopies.h"

#include "EnsembleTranslation.h"
#include "SurfaceArrays.h"

#include "Core/Mesh/GridLayout.h"

#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>

#include <cstdint>

namespace surfsynth
{

namespace
{
/// Makes an array of three components from the rows of @p values.
vtkSmartPointer<vtkDataArray> VectorArray(const PointMatrix& values, bool doublePrecision)
{
  vtkSmartPointer<vtkDataArray> array;
  if (doublePrecision)
  {
    array = vtkSmartPointer<vtkDoubleArray>::New();
  }
  else
  {
    array = vtkSmartPointer<vtkFloatArray>::New();
  }
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(values.rows());
  for (Eigen::Index v = 0; v < values.rows(); ++v)
  {
    array->SetTuple(v, values.data() + 3 * v);
  }
  return array;
}

/// The translation of each sample; none without a spread.
std::vector<Eigen::Vector3d> Places(const CopyOptions& options, std::size_t samples)
{
  if (options.Spread == 0.0)
  {
    return {};
  }
  BoundingBox cell = options.Box;
  cell.Upper = cell.Lower + options.Spread * (cell.Upper - cell.Lower);
  GridLayoutOptions layout;
  layout.Spacing = 0.0;
  return LayOutInGrid(std::vector<BoundingBox>(samples, cell), layout);
}
} // namespace

void FillWithCopies(vtkMultiBlockDataSet* output, vtkPointSet* input, const PointMatrix& rest,
  std::vector<PointMatrix>& samples, const CopyOptions& options, const CopyDecorator& decorate,
  const Progress& progress)
{
  const bool doublePrecision = input->GetPoints() && input->GetPoints()->GetDataType() == VTK_DOUBLE;
  const std::vector<Eigen::Vector3d> places = Places(options, samples.size());
  const char* name = options.DisplacementArrayName.c_str();
  output->SetNumberOfBlocks(static_cast<unsigned int>(samples.size()));
  for (std::size_t k = 0; k < samples.size(); ++k)
  {
    const auto copy = vtkSmartPointer<vtkPointSet>::Take(input->NewInstance());
    copy->ShallowCopy(input);
    DropNormals(copy);
    vtkNew<vtkPoints> moved;
    moved->SetData(VectorArray(samples[k], doublePrecision));
    copy->SetPoints(moved);
    const auto displacement = VectorArray(samples[k] - rest, doublePrecision);
    displacement->SetName(name);
    copy->GetPointData()->AddArray(displacement);
    decorate(copy, k);
    if (!copy->GetPointData()->GetVectors())
    {
      copy->GetPointData()->SetActiveVectors(name);
    }
    samples[k].resize(0, 3);
    if (!places.empty())
    {
      TranslatePoints(copy, places[k]);
      AddTranslationField(copy, places[k]);
    }
    const auto block = static_cast<unsigned int>(k);
    output->SetBlock(block, copy);
    const std::string title = "Sample " + std::to_string(static_cast<std::int64_t>(options.FirstSample) + block);
    output->GetMetaData(block)->Set(vtkCompositeDataSet::NAME(), title.c_str());
    Report(progress, static_cast<double>(k + 1) / static_cast<double>(samples.size()));
  }
}

} // namespace surfsynth
