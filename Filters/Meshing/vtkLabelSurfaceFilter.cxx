// SPDX-License-Identifier: BSD-3-Clause
#include "vtkLabelSurfaceFilter.h"

#include "FilterSupport.h"
#include "JointProcessing.h"
#include "LabelNames.h"
#include "SurfaceArrays.h"
#include "VolumeImages.h"

#include "Core/Common/Errors.h"
#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/LabelSurfaces.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkIndent.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

using surfsynth::ImageLattice;
using surfsynth::InvalidInput;
using surfsynth::LabelNameMap;
using surfsynth::LabelSurface;

vtkStandardNewMacro(vtkLabelSurfaceFilter);

namespace
{
constexpr std::size_t MostLabels = 4096;
/// Number of labels from which an image may be a scan, and the fraction of its adjacent samples other than background with
/// the same label below which it is: 0.09 to 0.24 in scans of MRIcron, 0.82 to 0.98 in its label maps.
constexpr std::size_t LabelsOfScans = 33;
constexpr double AgreementOfScans = 0.4;

/// Values of an array as labels. @throws InvalidInput for a value that is no integer of 32 bits
std::vector<std::int32_t> LabelsAt(vtkDataArray* values)
{
  std::vector<std::int32_t> labels(static_cast<std::size_t>(values->GetNumberOfTuples()));
  for (vtkIdType k = 0; k < values->GetNumberOfTuples(); ++k)
  {
    const double value = values->GetTuple1(k);
    if (!(value == std::floor(value) && std::abs(value) <= std::numeric_limits<std::int32_t>::max()))
    {
      throw InvalidInput("The array '" + std::string(values->GetName() ? values->GetName() : "") + "' has the value " +
        surfsynth::FormatNumber(value) + " at sample " + std::to_string(k) +
        ", which is no label; integers of 32 bits are needed. vtkVDBSurfaceFilter makes a surface of other volumes.");
    }
    labels[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(value);
  }
  return labels;
}

/// Fraction of the adjacent samples, along the three axes, with the same label, of those of which none is background.
double AgreementOfNeighbors(const std::vector<std::int32_t>& labels, const std::array<int, 3>& dimensions)
{
  std::int64_t pairs = 0;
  std::int64_t equal = 0;
  const std::array<std::int64_t, 3> steps{ 1, dimensions[0], std::int64_t{ 1 } * dimensions[0] * dimensions[1] };
  for (int axis = 0; axis < 3; ++axis)
  {
    const std::int64_t step = steps[axis];
    for (std::int64_t k = 0; k + step < static_cast<std::int64_t>(labels.size()); ++k)
    {
      const std::int32_t here = labels[k];
      const std::int32_t next = labels[k + step];
      const bool counted = here != 0 && next != 0 && k / step % dimensions[axis] + 1 < dimensions[axis];
      pairs += counted ? 1 : 0;
      equal += counted && here == next ? 1 : 0;
    }
  }
  return pairs == 0 ? 1.0 : static_cast<double>(equal) / static_cast<double>(pairs);
}

/// @throws InvalidInput for gray values: many labels, of which adjacent samples seldom have the same
void RefuseScans(std::size_t number, const std::vector<std::int32_t>& labels, const std::array<int, 3>& dimensions)
{
  const double agreement = number < LabelsOfScans ? 1.0 : AgreementOfNeighbors(labels, dimensions);
  if (agreement < AgreementOfScans)
  {
    throw InvalidInput("The image has " + std::to_string(number) + " labels, and only " +
      std::to_string(std::lround(100.0 * agreement)) +
      " percent of adjacent samples have the same label: these are the gray values of a scan; a label map is needed, "
      "or a choice of Labels. vtkVDBSurfaceFilter makes a surface of other volumes.");
  }
}

/// Turns all labels but the wanted ones into background. @throws InvalidInput for one that is not there, too many, or gray
/// values
void ChooseLabels(
  std::vector<std::int32_t>& labels, const std::vector<int>& wanted, const std::array<int, 3>& dimensions)
{
  std::set<std::int32_t> found;
  std::int32_t last = 0;
  for (const std::int32_t label : labels)
  {
    if (label != 0 && label != last && found.size() <= MostLabels)
    {
      found.insert(label);
    }
    last = label;
  }
  if (wanted.empty())
  {
    if (found.size() > MostLabels)
    {
      throw InvalidInput("The image has more than " + std::to_string(MostLabels) +
        " labels; a label map is needed, or a choice of Labels. vtkVDBSurfaceFilter makes a surface of other volumes.");
    }
    RefuseScans(found.size(), labels, dimensions);
    return;
  }
  const std::set<std::int32_t> chosen(wanted.begin(), wanted.end());
  for (const std::int32_t label : chosen)
  {
    if (label == 0 || std::find(labels.begin(), labels.end(), label) == labels.end())
    {
      throw InvalidInput("Labels has " + std::to_string(label) + ", which " +
        (label == 0 ? "is the background" : "no sample of the image has") + "; labels of the image are needed.");
    }
  }
  for (std::int32_t& label : labels)
  {
    label = label != 0 && chosen.count(label) == 0 ? 0 : label;
  }
}

template <typename Array, typename Value>
void AddField(vtkPolyData* surface, const char* name, const Value& value)
{
  vtkNew<Array> array;
  array->SetName(name);
  array->InsertNextValue(value);
  surface->GetFieldData()->AddArray(array);
}

void AddLabel(vtkPolyData* surface, const LabelSurface& made, const std::string& name)
{
  vtkNew<vtkIntArray> labels;
  labels->SetName("Label");
  labels->SetNumberOfValues(surface->GetNumberOfCells());
  labels->FillValue(made.Label);
  surface->GetCellData()->SetScalars(labels);
  AddField<vtkIntArray>(surface, "Label", made.Label);
  AddField<vtkStringArray>(surface, "LabelName", name);
  AddField<vtkDoubleArray>(surface, "SampleVolume", made.SampleVolume);
}
} // namespace

/// Work of one update.
class vtkLabelSurfaceFilter::Internals
{
public:
  explicit Internals(vtkLabelSurfaceFilter* self)
    : Self(self)
  {}

  void Fill(vtkImageData* image, vtkMultiBlockDataSet* output, const surfsynth::Progress& progress) const
  {
    if (!image || image->GetNumberOfPoints() == 0)
    {
      return;
    }
    bool onCells = false;
    vtkDataArray* values = this->Values(image, onCells);
    const ImageLattice lattice(image, onCells);
    std::vector<std::int32_t> labels = LabelsAt(values);
    ChooseLabels(labels, this->Self->Labels, lattice.Dimensions);
    const LabelNameMap names = this->Names();
    surfsynth::LabelVolume volume;
    volume.Dimensions = lattice.Dimensions;
    volume.Spacing = lattice.Spacing;
    volume.Labels = labels.data();
    surfsynth::LabelSurfaceOptions options;
    options.SmoothingIterations = this->Self->SmoothingIterations;
    options.PreserveVolume = this->Self->PreserveVolume;
    options.SharedBorders = this->Self->SharedBorders;
    for (LabelSurface& made : surfsynth::MakeLabelSurfaces(volume, options, surfsynth::SubProgress(progress, 0.1, 1.0)))
    {
      const auto name = names.find(made.Label);
      AddBlock(output, made, lattice, name == names.end() ? "Label " + std::to_string(made.Label) : name->second);
    }
  }

private:
  /// Array of labels; the flag is true for an array of the cells.
  vtkDataArray* Values(vtkImageData* image, bool& onCells) const
  {
    int association = vtkDataObject::FIELD_ASSOCIATION_POINTS;
    vtkDataArray* values = this->Self->GetInputArrayToProcess(0, image, association);
    onCells = association == vtkDataObject::FIELD_ASSOCIATION_CELLS;
    if (!values || (!onCells && association != vtkDataObject::FIELD_ASSOCIATION_POINTS))
    {
      throw InvalidInput("The image has no such array of numbers on its points or cells; choose the labels with "
                         "SetInputArrayToProcess.");
    }
    const vtkIdType needed = onCells ? image->GetNumberOfCells() : image->GetNumberOfPoints();
    if (values->GetNumberOfComponents() != 1 || values->GetNumberOfTuples() != needed)
    {
      throw InvalidInput("The array '" + std::string(values->GetName() ? values->GetName() : "") + "' has " +
        std::to_string(values->GetNumberOfTuples()) + " values of " + std::to_string(values->GetNumberOfComponents()) +
        " component(s); " + std::to_string(needed) + " of one component are needed.");
    }
    return values;
  }

  LabelNameMap Names() const
  {
    LabelNameMap names;
    if (!this->Self->NamesFileName.empty())
    {
      names = surfsynth::ReadLabelNames(this->Self->NamesFileName);
    }
    for (const auto& [label, name] : this->Self->LabelNames)
    {
      names[label] = name;
    }
    return names;
  }

  static void AddBlock(
    vtkMultiBlockDataSet* output, LabelSurface& made, const ImageLattice& lattice, const std::string& name)
  {
    made.Mesh.Points = lattice.ToWorld(made.Mesh.Points);
    if (lattice.IsMirrored())
    {
      made.Mesh.Triangles.col(1).swap(made.Mesh.Triangles.col(2));
    }
    vtkNew<vtkPolyData> surface;
    surfsynth::SetGeometry(surface, made.Mesh, true);
    AddLabel(surface, made, name);
    const unsigned int block = output->GetNumberOfBlocks();
    output->SetBlock(block, surface);
    output->GetMetaData(block)->Set(vtkCompositeDataSet::NAME(), name.c_str());
  }

  vtkLabelSurfaceFilter* Self;
};

vtkLabelSurfaceFilter::vtkLabelSurfaceFilter()
  : Impl(std::make_unique<Internals>(this))
{
  this->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, vtkDataSetAttributes::SCALARS);
}

vtkLabelSurfaceFilter::~vtkLabelSurfaceFilter() = default;

void vtkLabelSurfaceFilter::SetNamesFileName(const char* name)
{
  surfsynth::SetString(this, this->NamesFileName, name);
}

void vtkLabelSurfaceFilter::SetLabelName(int label, const char* name)
{
  const std::string text = name ? name : "";
  if (text != this->GetLabelName(label))
  {
    this->LabelNames[label] = text;
    if (text.empty())
    {
      this->LabelNames.erase(label);
    }
    this->Modified();
  }
}

std::string vtkLabelSurfaceFilter::GetLabelName(int label) const
{
  const auto found = this->LabelNames.find(label);
  return found == this->LabelNames.end() ? std::string() : found->second;
}

void vtkLabelSurfaceFilter::SetNumberOfLabels(int number)
{
  const auto wanted = static_cast<std::size_t>(std::max(number, 0));
  if (this->Labels.size() != wanted)
  {
    this->Labels.resize(wanted, 1);
    this->Modified();
  }
}

void vtkLabelSurfaceFilter::SetLabel(int index, int label)
{
  if (index < 0 || index >= this->GetNumberOfLabels())
  {
    return;
  }
  int& place = this->Labels[static_cast<std::size_t>(index)];
  if (place != label)
  {
    place = label;
    this->Modified();
  }
}

int vtkLabelSurfaceFilter::GetLabel(int index) const
{
  return index >= 0 && index < this->GetNumberOfLabels() ? this->Labels[static_cast<std::size_t>(index)] : 0;
}

int vtkLabelSurfaceFilter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  return 1;
}

int vtkLabelSurfaceFilter::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* image = vtkImageData::GetData(inputVector[0]);
  auto* output = vtkMultiBlockDataSet::GetData(outputVector);
  return surfsynth::ProcessJointly(this, inputVector, outputVector,
    [&](const surfsynth::Progress& progress) { this->Impl->Fill(image, output, progress); });
}

void vtkLabelSurfaceFilter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "NamesFileName: " << this->NamesFileName << "\n";
  os << indent << "LabelNames: " << this->LabelNames.size() << "\n";
  os << indent << "Labels:";
  for (const int label : this->Labels)
  {
    os << " " << label;
  }
  os << "\n";
  os << indent << "SmoothingIterations: " << this->SmoothingIterations << "\n";
  os << indent << "PreserveVolume: " << this->PreserveVolume << "\n";
  os << indent << "SharedBorders: " << this->SharedBorders << "\n";
}
