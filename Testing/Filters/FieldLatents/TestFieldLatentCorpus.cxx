// SPDX-License-Identifier: BSD-3-Clause
//
// R1, R2, R3 and R6 of vtkFieldLatentEncoder and vtkFieldLatentDecoder, on the corpus of malformed inputs, to which the
// arrays that the filters need are added.
#include "FieldLatentPipelines.h"
#include "MalformedCorpus.h"

#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace surfsynth;
using namespace surfsynthtest;

namespace
{
/// A number in [0, 1] for any coordinate.
float Fraction(double coordinate)
{
  const double bounded = std::isfinite(coordinate) ? std::clamp(coordinate, -1e6, 1e6) : 0.0;
  return static_cast<float>(0.5 + std::atan(bounded) / 3.2);
}

/// Adds an array with @p components numbers for each point.
void AddNumbers(vtkPointSet* surface, const char* name, int components, float shift)
{
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(surface->GetNumberOfPoints());
  for (vtkIdType p = 0; p < surface->GetNumberOfPoints(); ++p)
  {
    double x[3];
    surface->GetPoint(p, x);
    for (int c = 0; c < components; ++c)
    {
      array->SetTypedComponent(p, c, shift + Fraction(x[c]));
    }
  }
  surface->GetPointData()->AddArray(array);
}

/// A copy of @p data with colors, texture coordinates and codes of dimension 2.
vtkSmartPointer<vtkDataObject> WithArrays(vtkDataObject* data)
{
  if (!data)
  {
    return nullptr;
  }
  auto copy = vtkSmartPointer<vtkDataObject>::Take(data->NewInstance());
  copy->ShallowCopy(data);
  if (auto* tree = vtkDataObjectTree::SafeDownCast(copy))
  {
    tree->CopyStructure(vtkDataObjectTree::SafeDownCast(data));
    const auto place = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(
      vtkDataObjectTree::SafeDownCast(data)->NewTreeIterator());
    for (place->InitTraversal(); !place->IsDoneWithTraversal(); place->GoToNextItem())
    {
      tree->SetDataSet(place, WithArrays(place->GetCurrentDataObject()));
    }
  }
  else if (auto* surface = vtkPointSet::SafeDownCast(copy))
  {
    AddNumbers(surface, "Color", 3, 0.0F);
    AddNumbers(surface, "Coordinates", 2, 0.0F);
    AddNumbers(surface, "FieldLatent_0", 3, -0.5F);
    AddNumbers(surface, "FieldLatent_1", 3, -0.3F);
    AddNumbers(surface, "FieldLatentRadius", 1, 0.1F);
    surface->GetPointData()->SetActiveTCoords("Coordinates");
  }
  return copy;
}

/// The filter @p Filter on its input with arrays.
template <typename Filter>
class WithOwnArrays : public Filter
{
public:
  static WithOwnArrays* New() { VTK_STANDARD_NEW_BODY(WithOwnArrays); }

protected:
  int RequestData(
    vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector) override
  {
    const auto given = WithArrays(vtkDataObject::GetData(inputVector[0]));
    vtkNew<vtkInformation> information;
    information->Set(vtkDataObject::DATA_OBJECT(), given);
    vtkNew<vtkInformationVector> port;
    port->Append(information);
    vtkInformationVector* ports[] = { port, inputVector[1] };
    return Filter::RequestData(request, ports, outputVector);
  }
};

const char* Model()
{
  static const std::string model = WriteFieldLatentModel("corpus.model");
  return model.c_str();
}

vtkSmartPointer<vtkAlgorithm> MakeEncoder()
{
  const auto filter = vtkSmartPointer<WithOwnArrays<vtkFieldLatentEncoder>>::New();
  filter->SetModelFileName(Model());
  filter->SetColorArrayName("Color");
  return filter;
}

vtkSmartPointer<vtkAlgorithm> MakeEncoderOfImages()
{
  const auto filter = vtkSmartPointer<WithOwnArrays<vtkFieldLatentEncoder>>::New();
  filter->SetModelFileName(Model());
  filter->SetTextureData(Pattern());
  return filter;
}

vtkSmartPointer<vtkAlgorithm> MakeDecoder()
{
  const auto filter = vtkSmartPointer<WithOwnArrays<vtkFieldLatentDecoder>>::New();
  filter->SetModelFileName(Model());
  filter->SetResolution(24, 16);
  return filter;
}

/// The filters require manifold points and consistent winding beyond a valid surface.
FilterTraits Traits(const std::string& settings)
{
  FilterTraits traits;
  traits.AcceptsEveryValidSurface = false;
  traits.Settings = settings;
  return traits;
}

class MalformedInput : public ::testing::TestWithParam<MalformedCase>
{};

std::string NameOfCase(const ::testing::TestParamInfo<MalformedCase>& info) { return info.param.Name; }
} // namespace

TEST(FieldLatentCorpus, GoodSurfacesPass)
{
  for (const auto& make : { MakeEncoder, MakeEncoderOfImages, MakeDecoder })
  {
    const auto filter = make();
    filter->SetInputDataObject(Icosphere(2).ToPolyData());
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter));
    EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
    EXPECT_GT(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
  }
}

TEST_P(MalformedInput, ToAnEncoder) { CheckAlone(GetParam(), MakeEncoder, Traits("encoder")); }

TEST_P(MalformedInput, ToAnEncoderOfImages) { CheckAlone(GetParam(), MakeEncoderOfImages, Traits("images")); }

TEST_P(MalformedInput, ToADecoder) { CheckAlone(GetParam(), MakeDecoder, Traits("decoder")); }

TEST_P(MalformedInput, BetweenGoodBlocksToAnEncoder) { CheckAsBlock(GetParam(), MakeEncoder, Traits("encoder")); }

TEST_P(MalformedInput, BetweenGoodBlocksToADecoder) { CheckAsBlock(GetParam(), MakeDecoder, Traits("decoder")); }

INSTANTIATE_TEST_SUITE_P(Corpus, MalformedInput, ::testing::ValuesIn(MalformedCorpus()), NameOfCase);
