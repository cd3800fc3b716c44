// SPDX-License-Identifier: BSD-3-Clause
//
// vtkSkinningFilter: both forms of weights, columns of tables, names, what else the body holds, messages.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkSkinningFilter.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSMPTools.h>
#include <vtkStringArray.h>
#include <vtkTable.h>
#include <vtkTetra.h>
#include <vtkUnstructuredGrid.h>

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
template <typename Array, typename Value>
void AddTo(vtkFieldData* data, const char* name, int components, const std::vector<Value>& values)
{
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()) / components);
  for (std::size_t k = 0; k < values.size(); ++k)
  {
    array->SetComponent(static_cast<vtkIdType>(k) / components, static_cast<int>(k) % components, values[k]);
  }
  data->AddArray(array);
}

void AddNames(vtkTable* table, const std::vector<std::string>& names)
{
  vtkNew<vtkStringArray> array;
  array->SetName("Name");
  for (const std::string& name : names)
  {
    array->InsertNextValue(name);
  }
  table->AddColumn(array);
}

/// Two bones along the x axis: the second begins at x = 0 and hangs on the first.
vtkSmartPointer<vtkTable> Bones()
{
  auto bones = vtkSmartPointer<vtkTable>::New();
  AddTo<vtkDoubleArray>(bones->GetRowData(), "Head", 3, std::vector<double>{ -1, 0, 0, 0, 0, 0 });
  AddTo<vtkIntArray>(bones->GetRowData(), "Parent", 1, std::vector<double>{ -1, 0 });
  AddNames(bones, { "upper", "lower" });
  return bones;
}

/// The second bone turned by a right angle about the z axis.
vtkSmartPointer<vtkTable> Pose()
{
  auto pose = vtkSmartPointer<vtkTable>::New();
  const double half = std::sqrt(0.5);
  AddTo<vtkDoubleArray>(pose->GetRowData(), "Rotation", 4, std::vector<double>{ 1, 0, 0, 0, half, 0, 0, half });
  return pose;
}

/// A sphere whose points go with the second bone where x > 0, and with both where x is 0.
vtkSmartPointer<vtkPolyData> Body(int type = VTK_DOUBLE, int level = 2)
{
  auto body = Icosphere(level).ToPolyData(type);
  std::vector<double> indices, weights, all;
  for (vtkIdType p = 0; p < body->GetNumberOfPoints(); ++p)
  {
    const double x = body->GetPoint(p)[0];
    const double second = x > 1e-9 ? 1.0 : x < -1e-9 ? 0.0 : 0.5;
    indices.insert(indices.end(), { 1.0, 0.0 });
    weights.insert(weights.end(), { second, 1.0 - second });
    all.insert(all.end(), { 1.0 - second, second });
  }
  AddTo<vtkIntArray>(body->GetPointData(), "BoneIndices", 2, indices);
  AddTo<vtkFloatArray>(body->GetPointData(), "BoneWeights", 2, weights);
  AddTo<vtkDoubleArray>(body->GetPointData(), "AllWeights", 2, all);
  AddTo<vtkFloatArray>(body->GetPointData(), "Normals", 3, std::vector<double>(3 * body->GetNumberOfPoints(), 0.0));
  return body;
}

vtkSmartPointer<vtkSkinningFilter> Filter(vtkDataObject* body, vtkTable* bones, vtkTable* pose)
{
  auto filter = vtkSmartPointer<vtkSkinningFilter>::New();
  filter->SetInputDataObject(body);
  filter->SetBonesData(bones);
  filter->SetPoseData(pose);
  return filter;
}

vtkPointSet* OutputOf(vtkSkinningFilter* filter) { return vtkPointSet::SafeDownCast(filter->GetOutputDataObject(0)); }

/// Expects the pose of Pose().
void ExpectBent(vtkPointSet* body, vtkPointSet* output, double tolerance)
{
  ASSERT_EQ(output->GetNumberOfPoints(), body->GetNumberOfPoints());
  for (vtkIdType p = 0; p < body->GetNumberOfPoints(); ++p)
  {
    double rest[3], moved[3];
    body->GetPoint(p, rest);
    output->GetPoint(p, moved);
    if (std::abs(rest[0]) < 1e-9)
    {
      continue; // both bones: TestSkinning of the core
    }
    const bool isTurned = rest[0] > 0.0;
    EXPECT_NEAR(moved[0], isTurned ? -rest[1] : rest[0], tolerance);
    EXPECT_NEAR(moved[1], isTurned ? rest[0] : rest[1], tolerance);
    EXPECT_NEAR(moved[2], rest[2], tolerance);
  }
}

std::string ErrorWith(vtkDataObject* body, vtkTable* bones, vtkTable* pose)
{
  return ErrorOf(Filter(body, bones, pose));
}
} // namespace

TEST(SkinningFilter, PosesABodyInItsPrecision)
{
  for (const int type : { VTK_DOUBLE, VTK_FLOAT })
  {
    const auto body = Body(type);
    const auto filter = Filter(body, Bones(), Pose());
    ASSERT_TRUE(Update(filter));
    vtkPointSet* output = OutputOf(filter);
    EXPECT_EQ(output->GetPoints()->GetDataType(), type);
    ExpectBent(body, output, type == VTK_DOUBLE ? 1e-15 : 1e-6);
    EXPECT_EQ(vtkPolyData::SafeDownCast(output)->GetNumberOfPolys(), body->GetNumberOfPolys());
    EXPECT_TRUE(output->GetPointData()->HasArray("BoneWeights"));
    EXPECT_FALSE(output->GetPointData()->HasArray("Normals")); // those of the body at rest
    EXPECT_TRUE(body->GetPointData()->HasArray("Normals"));
  }
}

TEST(SkinningFilter, TakesAnArrayOfAllBones)
{
  const auto body = Body();
  const auto filter = Filter(body, Bones(), Pose());
  filter->SetBoneIndexArrayName("");
  filter->SetBoneWeightArrayName("AllWeights");
  ASSERT_TRUE(Update(filter));
  ExpectBent(body, OutputOf(filter), 1e-15);
}

TEST(SkinningFilter, MethodsDifferWhereBonesMeet)
{
  const auto filter = Filter(Body(), Bones(), Pose());
  const auto farthest = [&] {
    EXPECT_TRUE(Update(filter));
    double least = 1.0;
    for (vtkIdType p = 0; p < 162; ++p)
    {
      double* moved = OutputOf(filter)->GetPoint(p);
      least = std::min(least, std::hypot(std::hypot(moved[0], moved[1]), moved[2]));
    }
    return least;
  };
  EXPECT_NEAR(farthest(), 1.0, 1e-15); // rigid motions about the origin
  filter->SetSkinningMethodToLinearBlend();
  EXPECT_NEAR(farthest(), std::sqrt(0.5), 1e-2); // the mean of two points a quarter of a turn apart
}

TEST(SkinningFilter, TakesColumnsOfFilesAndNames)
{
  vtkNew<vtkTable> bones;
  for (int c = 0; c < 3; ++c)
  {
    AddTo<vtkDoubleArray>(
      bones->GetRowData(), ("Head:" + std::to_string(c)).c_str(), 1, std::vector<double>{ c == 0 ? -1.0 : 0.0, 0.0 });
  }
  AddTo<vtkDoubleArray>(bones->GetRowData(), "Parent", 1, std::vector<double>{ -1, 0 });
  AddNames(bones, { "upper", "lower" });
  vtkNew<vtkTable> pose; // of the second bone only
  const double half = std::sqrt(0.5);
  AddTo<vtkDoubleArray>(pose->GetRowData(), "Rotation", 4, std::vector<double>{ 3 * half, 0, 0, 3 * half });
  AddNames(pose, { "lower" });
  const auto body = Body();
  const auto filter = Filter(body, bones, pose);
  ASSERT_TRUE(Update(filter));
  ExpectBent(body, OutputOf(filter), 1e-15);
}

TEST(SkinningFilter, TranslatesARoot)
{
  const auto pose = Pose();
  AddTo<vtkDoubleArray>(pose->GetRowData(), "Translation", 3, std::vector<double>{ 0, 0, 2, 0, 0, 0 });
  const auto body = Body();
  const auto filter = Filter(body, Bones(), pose);
  ASSERT_TRUE(Update(filter));
  for (vtkIdType p = 0; p < body->GetNumberOfPoints(); ++p)
  {
    EXPECT_NEAR(OutputOf(filter)->GetPoint(p)[2], body->GetPoint(p)[2] + 2.0, 1e-15);
  }
}

TEST(SkinningFilter, PosesVolumesBlocksAndNothing)
{
  vtkNew<vtkUnstructuredGrid> grid;
  const auto body = Body();
  grid->SetPoints(body->GetPoints());
  grid->GetPointData()->ShallowCopy(body->GetPointData());
  const vtkIdType ids[4] = { 0, 1, 2, 3 };
  grid->InsertNextCell(VTK_TETRA, 4, ids);
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, body);
  blocks->SetBlock(1, grid);
  const auto filter = Filter(blocks, Bones(), Pose());
  ASSERT_TRUE(Update(filter));
  const auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_NE(output, nullptr);
  for (unsigned int k = 0; k < 2; ++k)
  {
    ExpectBent(body, vtkPointSet::SafeDownCast(const_cast<vtkMultiBlockDataSet*>(output)->GetBlock(k)), 1e-15);
  }
  vtkNew<vtkPolyData> empty;
  const auto none = Filter(empty, Bones(), Pose());
  ASSERT_TRUE(Update(none));
  EXPECT_EQ(OutputOf(none)->GetNumberOfPoints(), 0);
}

TEST(SkinningFilter, ReportsProgressAndStopsOnRequest)
{
  const auto body = Body(VTK_DOUBLE, 7); // 163,842 points
  const auto complete = Filter(body, Bones(), Pose());
  EventRecorder events(complete);
  ASSERT_TRUE(Update(complete));
  ExpectMonotone(events.Progress);
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
  vtkSMPTools::Initialize(1); // two threads may do the rest between two reports of one of them
  for (const double fraction : { 0.0, 0.3, 0.9 })
  {
    ExpectAbortAndRecovery(Filter(body, Bones(), Pose()), fraction, 1.0);
  }
  vtkSMPTools::Initialize(0);
}

TEST(SkinningFilter, HasTheSameBitsForEveryNumberOfThreads)
{
  const auto body = Body(VTK_DOUBLE, 6);
  const FilterMaker make = [&body]() -> vtkSmartPointer<vtkAlgorithm> { return Filter(body, Bones(), Pose()); };
  ExpectSameBitsForAllThreads(
    make, [](vtkAlgorithm* f) { return OutputOf(vtkSkinningFilter::SafeDownCast(f))->GetPoints()->GetData(); });
}

TEST(SkinningFilter, NamesWhatIsWrong)
{
  const auto body = Body();
  const auto pose = Pose();
  vtkNew<vtkTable> empty;
  EXPECT_THAT(ErrorWith(Icosphere(1).ToPolyData(), Bones(), pose), AllOf(HasSubstr("BoneWeights"), HasSubstr("body")));
  EXPECT_THAT(ErrorWith(body, empty, pose), HasSubstr("0 bone(s)"));
  const auto headless = Bones();
  headless->RemoveColumnByName("Head");
  EXPECT_THAT(ErrorWith(body, headless, pose), AllOf(HasSubstr("\"Head\""), HasSubstr("3 components")));
  const auto looped = Bones();
  looped->GetColumnByName("Parent")->SetVariantValue(0, 1);
  EXPECT_THAT(ErrorWith(body, looped, pose), HasSubstr("loop"));
  const auto named = Pose();
  AddNames(named, { "upper", "tail" });
  EXPECT_THAT(ErrorWith(body, Bones(), named), AllOf(HasSubstr("\"tail\""), HasSubstr("does not have")));
  const auto twice = Pose();
  AddNames(twice, { "upper", "upper" });
  EXPECT_THAT(ErrorWith(body, Bones(), twice), HasSubstr("another row is for"));
  const auto flat = Pose();
  flat->RemoveColumnByName("Rotation");
  AddTo<vtkDoubleArray>(flat->GetRowData(), "Rotation", 3, std::vector<double>(6, 1.0));
  EXPECT_THAT(ErrorWith(body, Bones(), flat), HasSubstr("3 component(s); 4 are needed"));
  const auto partial = Pose();
  AddTo<vtkDoubleArray>(partial->GetRowData(), "Translation:0", 1, std::vector<double>{ 1, 0 });
  AddTo<vtkDoubleArray>(partial->GetRowData(), "Translation:2", 1, std::vector<double>{ 1, 0 });
  EXPECT_THAT(
    ErrorWith(body, Bones(), partial), AllOf(HasSubstr("\"Translation:1\""), HasSubstr("3 are needed, or none")));
  const auto text = Pose();
  vtkNew<vtkStringArray> words;
  words->SetName("Translation");
  words->SetNumberOfValues(2);
  text->AddColumn(words);
  EXPECT_THAT(ErrorWith(body, Bones(), text), HasSubstr("\"Translation\" of the pose is not numeric"));
  const auto unknown = Body();
  unknown->GetPointData()->GetArray("BoneIndices")->SetComponent(9, 0, 7.0);
  unknown->GetPointData()->GetArray("BoneWeights")->SetComponent(9, 0, 1.0);
  unknown->GetPointData()->GetArray("BoneWeights")->SetComponent(9, 1, 0.0);
  EXPECT_THAT(ErrorWith(unknown, Bones(), pose), AllOf(HasSubstr("unknown bone"), HasSubstr("point 9")));
  const auto negative = Body();
  negative->GetPointData()->GetArray("BoneWeights")->SetComponent(3, 0, -0.25);
  EXPECT_THAT(ErrorWith(negative, Bones(), pose), AllOf(HasSubstr("negative weight"), HasSubstr("point 3")));
}

TEST(SkinningFilter, RunsOnceForEachChangeAndPrintsItsProperties)
{
  const auto filter = Filter(Body(), Bones(), Pose());
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  ExpectOneExecutionEach<vtkSkinningFilter>(filter,
    { { "SkinningMethod", [](vtkSkinningFilter* f) { f->SetSkinningMethodToLinearBlend(); } },
      { "BoneIndexArrayName", [](vtkSkinningFilter* f) { f->SetBoneIndexArrayName(""); } },
      { "BoneWeightArrayName", [](vtkSkinningFilter* f) { f->SetBoneWeightArrayName("AllWeights"); } } },
    events);
  std::ostringstream text;
  filter->Print(text);
  EXPECT_THAT(text.str(), AllOf(HasSubstr("SkinningMethod: 0"), HasSubstr("BoneWeightArrayName: AllWeights")));
}
