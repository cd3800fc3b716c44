// SPDX-License-Identifier: BSD-3-Clause
//
// From arrays to what networks take: PointRows.h and NetworkInput.h.
#include "FilterChecks.h"
#include "ThrownText.h"
#include "VtkSurfaces.h"

#include "NetworkInput.h"
#include "NewArray.h"
#include "PointRows.h"
#include "SurfaceBridge.h"

#include "Core/Common/Errors.h"

#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

using namespace surfsynthtest;
using surfsynth::InvalidInput;
using surfsynth::MakeNetworkInput;
using surfsynth::MeshNormalization;
using surfsynth::NewArray;
using surfsynth::PoissonNetHead;
using surfsynth::PoissonNetInput;
using surfsynth::PoissonNetModel;
using surfsynth::ReadPointRows;
using surfsynth::UsedPoints;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
/// An unused point before a sphere, and the array "Array" of two integers at each point: (p, 10 p).
struct Fixture
{
  Fixture()
  {
    Soup soup;
    soup.AddPoint(9.0, 9.0, 9.0);
    const Soup sphere = Icosphere(1);
    soup.Points.insert(soup.Points.end(), sphere.Points.begin(), sphere.Points.end());
    for (auto polygon : sphere.Polys)
    {
      std::for_each(polygon.begin(), polygon.end(), [](vtkIdType& id) { ++id; });
      soup.Polys.push_back(polygon);
    }
    this->PolyData = soup.ToPolyData();
    const auto array = NewArray<vtkIntArray>("Array", 43, 2);
    for (vtkIdType p = 0; p < 43; ++p)
    {
      array->SetTuple2(p, p, 10.0 * p);
    }
    this->PolyData->GetPointData()->AddArray(array);
  }

  UsedPoints Used() const { return UsedPoints(surfsynth::ConvertSurface(this->PolyData).Mesh); }

  PoissonNetInput Input(const surfsynth::NetworkInputRequest& request) const
  {
    return MakeNetworkInput(this->Model, request, this->PolyData, this->Used(), this->Normalization);
  }

  std::string Error(const surfsynth::NetworkInputRequest& request) const
  {
    return TextOf<InvalidInput>([&] { this->Input(request); });
  }

  vtkSmartPointer<vtkPolyData> PolyData;
  PoissonNetModel Model;
  MeshNormalization Normalization;
};
} // namespace

// --- PointRows -------------------------------------------------------------------------------------------------------

TEST(PointRows, AreTheTuplesOfUsedPoints)
{
  const Fixture fixture;
  const surfsynth::PointRows rows = ReadPointRows(fixture.PolyData, fixture.Used(), { "Array", "Name" }, 2);
  ASSERT_EQ(rows.rows(), 42);
  ASSERT_EQ(rows.cols(), 2);
  EXPECT_EQ(rows(0, 0), 1.0);
  EXPECT_EQ(rows(41, 1), 420.0);
}

TEST(PointRows, ErrorsNameArrayAndProperty)
{
  const Fixture fixture;
  const auto errorOf = [&](const char* name, int components) {
    return TextOf<InvalidInput>([&] {
      ReadPointRows(fixture.PolyData, fixture.Used(), { name, "HeatArrayName" }, components);
    });
  };
  EXPECT_THAT(errorOf("Nothing", 1),
    AllOf(HasSubstr("There is no point array \"Nothing\", which HeatArrayName names; the model needs one with 1 "
                    "component and a tuple for each point."),
      HasSubstr("MPI ranks")));
  EXPECT_THAT(errorOf("Array", 3),
    AllOf(HasSubstr("has 2 components and 43 tuples for 43 points"), HasSubstr("needs one with 3 components")));
  fixture.PolyData->GetPointData()->AddArray(NewArray<vtkDoubleArray>("Short", 42, 1));
  EXPECT_THAT(errorOf("Short", 1), HasSubstr("has 1 component and 42 tuples for 43 points"));
}

TEST(PointRows, NumbersMustBeFiniteInSinglePrecisionAtUsedPoints)
{
  const Fixture fixture;
  const auto array = NewArray<vtkDoubleArray>("Heat", 43, 1);
  fixture.PolyData->GetPointData()->AddArray(array);
  array->SetValue(0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_NO_THROW(ReadPointRows(fixture.PolyData, fixture.Used(), { "Heat", "Name" }, 1)) << "no polygon uses it";
  array->SetValue(5, 1e39);
  EXPECT_THAT(TextOf<InvalidInput>([&] {
    ReadPointRows(fixture.PolyData, fixture.Used(), { "Heat", "HeatArrayName" }, 1);
  }),
    AllOf(HasSubstr("\"Heat\", which HeatArrayName names, is not finite in single precision at point 5")));
}

// --- NetworkInput ----------------------------------------------------------------------------------------------------

TEST(NetworkInput, PositionsWithoutConditionsNeedNothing)
{
  const Fixture fixture;
  const PoissonNetInput input = fixture.Input({});
  EXPECT_EQ(input.Signal.size(), 0);
  EXPECT_EQ(input.Extra.size(), 0);
}

TEST(NetworkInput, ConditionsAreARowForAllPoints)
{
  Fixture fixture;
  fixture.Model.Options.ExtraFeatures = 2;
  const PoissonNetInput input = fixture.Input({ { 0.5, -2.0 }, "", "" });
  ASSERT_EQ(input.Extra.rows(), 1);
  EXPECT_EQ(input.Extra(0, 0), 0.5F);
  EXPECT_EQ(input.Extra(0, 1), -2.0F);
}

TEST(NetworkInput, AnArrayOfConditionsGoesBeforeTheNumbers)
{
  Fixture fixture;
  fixture.Model.Options.ExtraFeatures = 2;
  const PoissonNetInput input = fixture.Input({ { 0.5 }, "Array", "" });
  ASSERT_EQ(input.Extra.rows(), 42);
  EXPECT_EQ(input.Extra(1, 1), 20.0F);
}

TEST(NetworkInput, TheSignalOfAGradientDomainHeadIsNormalized)
{
  Fixture fixture;
  const auto positions = NewArray<vtkDoubleArray>("Moved", 43, 3);
  positions->SetTuple3(2, 3.0, 4.0, 5.0);
  fixture.PolyData->GetPointData()->AddArray(positions);
  fixture.Normalization.Center << 1.0, 2.0, 3.0;
  fixture.Normalization.Scale = 2.0;
  EXPECT_EQ(fixture.Input({ {}, "", "Moved" }).Signal.row(1), Eigen::RowVector3f(1.0F, 1.0F, 1.0F));
  fixture.Model.Options.Head = PoissonNetHead::Linear;
  EXPECT_EQ(fixture.Input({ {}, "", "Moved" }).Signal.row(1), Eigen::RowVector3f(3.0F, 4.0F, 5.0F));
  fixture.Model.Options.InputChannels = 2;
  EXPECT_EQ(fixture.Input({ {}, "", "Array" }).Signal.row(1), Eigen::RowVector2f(2.0F, 20.0F));
}

TEST(NetworkInput, ErrorsAreInTermsOfTheProperties)
{
  Fixture fixture;
  EXPECT_EQ(
    fixture.Error({ { 1.0 }, "", "" }), "The model takes no conditions; Conditions holds 1. Leave Conditions empty.");
  EXPECT_EQ(fixture.Error({ {}, "Array", "" }),
    "The model takes no conditions; ConditionArrayName is \"Array\". Leave it empty.");
  fixture.Model.Options.ExtraFeatures = 1;
  EXPECT_EQ(fixture.Error({}),
    "The model takes 1 condition; Conditions holds none. Set 1, or name a point array with 1 component by "
    "ConditionArrayName.");
  EXPECT_THAT(fixture.Error({ { 1e39 }, "", "" }), HasSubstr("not finite in single precision"));
  EXPECT_THAT(fixture.Error({ {}, "Array", "" }), HasSubstr("which ConditionArrayName names, has 2 components"));
  fixture.Model.Options.ExtraFeatures = 0;
  fixture.Model.Options.InputChannels = 4;
  EXPECT_EQ(fixture.Error({}),
    "The model takes 4 channels at each point, and positions have 3; SignalArrayName must name a point array with 4 "
    "components.");
  EXPECT_THAT(fixture.Error({ {}, "", "Array" }), HasSubstr("which SignalArrayName names, has 2 components"));
}
