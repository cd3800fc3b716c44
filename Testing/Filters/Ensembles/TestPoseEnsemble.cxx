// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkPoseEnsembleFilter for a shape with six limbs.
#include "SurfaceChecks.h"

#include "SurfaceArrays.h"

#include "vtkIsotropicRemeshFilter.h"
#include "vtkPoseEnsembleFilter.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSMPTools.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

using namespace surfsynthtest;
using Poses = vtkPoseEnsembleFilter;
using surfsynth::PointMatrix;

namespace
{
/// Directions and lengths of the limbs: none like another, so that the farthest is always clear.
const std::array<std::array<double, 4>, 6> Limbs{ { { 1.0, 0.1, 0.0, 1.9 }, { -1.0, 0.2, 0.1, 1.7 },
  { 0.0, 1.0, 0.1, 1.8 }, { 0.1, -1.0, 0.0, 1.6 }, { 0.0, 0.1, 1.0, 1.5 }, { 0.2, 0.0, -1.0, 1.4 } } };

Eigen::Vector3d Direction(std::size_t limb)
{
  return Eigen::Vector3d(Limbs[limb][0], Limbs[limb][1], Limbs[limb][2]).normalized();
}

/// The surface r(n) = 0.3 + sum of the limbs' bumps over the unit sphere: the same shape for every mesh of the sphere.
vtkSmartPointer<vtkPolyData> Creature(vtkSmartPointer<vtkPolyData> sphere)
{
  vtkPoints* points = sphere->GetPoints();
  for (vtkIdType p = 0; p < points->GetNumberOfPoints(); ++p)
  {
    const Eigen::Vector3d n = Eigen::Vector3d(points->GetPoint(p)).normalized();
    double radius = 0.3;
    for (std::size_t limb = 0; limb < Limbs.size(); ++limb)
    {
      radius += Limbs[limb][3] * std::exp(10.0 * (n.dot(Direction(limb)) - 1.0));
    }
    const Eigen::Vector3d moved = radius * n;
    points->SetPoint(p, moved.data());
  }
  return sphere;
}

vtkSmartPointer<vtkPolyData> Creature(int levels = 3) { return Creature(Icosphere(levels).ToPolyData()); }

/// The same shape with about so many points, evenly spread.
vtkSmartPointer<vtkPolyData> EvenCreature(int points)
{
  vtkNew<vtkIsotropicRemeshFilter> remesh;
  remesh->SetTargetNumberOfPoints(points);
  remesh->KeepFeatureEdgesOff();
  return OutputOf(remesh, Creature(5));
}

/// The output for @p input, or null after an error.
vtkSmartPointer<vtkMultiBlockDataSet> PosesOf(Poses* filter, vtkDataObject* input)
{
  EventRecorder events(filter);
  filter->SetInputDataObject(input);
  if (!Update(filter) || !events.Errors.empty())
  {
    ADD_FAILURE() << events.AllErrors();
    return nullptr;
  }
  auto output = vtkSmartPointer<vtkMultiBlockDataSet>::New();
  output->ShallowCopy(filter->GetOutputDataObject(0));
  return output;
}

vtkPolyData* Sample(vtkMultiBlockDataSet* poses, unsigned int k)
{
  return vtkPolyData::SafeDownCast(poses->GetBlock(k));
}

PointMatrix PointsOf(vtkPolyData* surface) { return surfsynth::ConvertPoints(surface); }

int RegionOf(vtkPolyData* pose, vtkIdType p)
{
  return static_cast<int>(pose->GetPointData()->GetArray("PoseRegion")->GetTuple1(p));
}

double SizeOf(vtkPolyData* surface) { return std::sqrt(AreaOf(surface)); }
} // namespace

TEST(PoseEnsemble, HandlesAreTheEndsOfTheLimbs)
{
  const auto creature = Creature();
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(1);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  std::array<bool, 6> isFound{};
  for (int handle = 0; handle < 6; ++handle)
  {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (vtkIdType p = 0; p < creature->GetNumberOfPoints(); ++p)
    {
      middle += RegionOf(Sample(poses, 0), p) == handle ? Eigen::Vector3d(creature->GetPoint(p))
                                                        : Eigen::Vector3d::Zero();
    }
    for (std::size_t limb = 0; limb < Limbs.size(); ++limb)
    {
      isFound[limb] = isFound[limb] || middle.normalized().dot(Direction(limb)) > 0.99;
    }
  }
  EXPECT_EQ(isFound, (std::array<bool, 6>{ true, true, true, true, true, true }));
}

TEST(PoseEnsemble, HandlesMoveAsOnePieceAndWhatStaysStays)
{
  const auto creature = Creature();
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(3);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  for (unsigned int k = 0; k < 3; ++k)
  {
    vtkPolyData* pose = Sample(poses, k);
    const PointMatrix rest = PointsOf(creature);
    const PointMatrix moved = PointsOf(pose);
    vtkIdType staying = 0;
    std::array<Eigen::Index, 6> first;
    first.fill(-1);
    std::array<double, 6> farthest{};
    for (Eigen::Index p = 0; p < rest.rows(); ++p)
    {
      const int region = RegionOf(pose, p);
      if (region == 6)
      {
        ++staying;
        EXPECT_LT((moved.row(p) - rest.row(p)).norm(), 1e-12);
      }
      else if (region >= 0)
      {
        first[region] = first[region] < 0 ? p : first[region];
        const double before = (rest.row(p) - rest.row(first[region])).norm();
        EXPECT_NEAR((moved.row(p) - moved.row(first[region])).norm(), before, 1e-12);
        farthest[region] = std::max(farthest[region], (moved.row(p) - rest.row(p)).norm());
      }
    }
    EXPECT_GT(staying, 20);
    for (const double distance : farthest)
    {
      EXPECT_GT(distance, 0.01 * SizeOf(creature)); // every limb swings
    }
  }
}

TEST(PoseEnsemble, LimbsKeepTheirThickness)
{
  const auto creature = EvenCreature(1500);
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(10);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  for (unsigned int k = 0; k < 10; ++k)
  {
    EXPECT_NEAR(VolumeOf(Sample(poses, k)) / VolumeOf(creature), 1.0, 0.15) << "sample " << k;
    EXPECT_NEAR(AreaOf(Sample(poses, k)) / AreaOf(creature), 1.0, 0.06) << "sample " << k;
    ExpectValid(Sample(poses, k), true);
  }
}

TEST(PoseEnsemble, WithoutAnglesTheShapeStaysAsItIs)
{
  const auto creature = Creature();
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(1);
  filter->SetMaximumAngle(0.0);
  filter->SetMaximumTwist(0.0);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  EXPECT_LT((PointsOf(Sample(poses, 0)) - PointsOf(creature)).cwiseAbs().maxCoeff(), 1e-9);
}

/// Sample k on two triangulations of a shape is the same pose: the displacements of one, interpolated at the nearest
/// places of the other, agree with its own to 1 per cent of the size on average (root of the mean square) and to 5 per
/// cent everywhere. The limbs themselves move by a tenth of the size and more.
TEST(PoseEnsemble, WithATemplateOtherTriangulationsGetTheSamePoses)
{
  const auto shape = EvenCreature(4000);
  vtkNew<Poses> filter;
  filter->SetTemplateData(shape);
  filter->SetNumberOfSamples(2);
  filter->SetSeed(3);
  const auto coarse = EvenCreature(1200);
  const auto onCoarse = PosesOf(filter, coarse);
  ASSERT_TRUE(onCoarse);
  const surfsynth::TriangleMesh mesh = MeshOf(coarse);
  const surfsynth::NearestPlaces nearest(mesh);
  for (const auto& other : { shape, EvenCreature(2500) })
  {
    const auto onOther = PosesOf(filter, other);
    ASSERT_TRUE(onOther);
    const PointMatrix rest = PointsOf(other);
    const auto places = nearest.Find(rest);
    for (unsigned int k = 0; k < 2; ++k)
    {
      const PointMatrix moved = PointsOf(Sample(onCoarse, k)) - mesh.Points;
      const PointMatrix own = PointsOf(Sample(onOther, k)) - rest;
      double sum = 0.0;
      double worst = 0.0;
      for (Eigen::Index p = 0; p < rest.rows(); ++p)
      {
        Eigen::RowVector3d expected = Eigen::RowVector3d::Zero();
        for (int corner = 0; corner < 3; ++corner)
        {
          expected += places[p].Weights[corner] * moved.row(mesh.Triangles(places[p].Triangle, corner));
        }
        const double error = (own.row(p) - expected).norm() / SizeOf(shape);
        sum += error * error;
        worst = std::max(worst, error);
      }
      EXPECT_LT(std::sqrt(sum / static_cast<double>(rest.rows())), 0.01) << "sample " << k;
      EXPECT_LT(worst, 0.05) << "sample " << k;
      EXPECT_GT(own.rowwise().norm().maxCoeff() / SizeOf(shape), 0.1);
    }
  }
}

TEST(PoseEnsemble, ASampleHasTheSameBitsAloneInABatchAndForEveryNumberOfThreads)
{
  const auto creature = Creature(2);
  vtkNew<Poses> filter;
  filter->SetSeed(-5);
  filter->SetNumberOfSamples(6);
  const auto all = PosesOf(filter, creature);
  ASSERT_TRUE(all);
  for (const int threads : { 1, 4 })
  {
    vtkSMPTools::Initialize(threads);
    vtkNew<Poses> other;
    other->SetSeed(-5);
    other->SetFirstSample(4);
    other->SetNumberOfSamples(1);
    const auto one = PosesOf(other, creature);
    ASSERT_TRUE(one);
    EXPECT_STREQ(one->GetMetaData(0u)->Get(vtkCompositeDataSet::NAME()), "Sample 4");
    EXPECT_TRUE(SameBits(Sample(one, 0)->GetPoints()->GetData(), Sample(all, 4)->GetPoints()->GetData()));
    other->SetNumberOfSamples(6);
    other->SetFirstSample(0);
    const auto again = PosesOf(other, creature);
    ASSERT_TRUE(again);
    for (unsigned int k = 0; k < 6; ++k)
    {
      EXPECT_TRUE(SameBits(Sample(again, k)->GetPoints()->GetData(), Sample(all, k)->GetPoints()->GetData()));
    }
  }
  vtkSMPTools::Initialize(0);
  filter->SetSeed(6);
  const auto otherSeed = PosesOf(filter, creature);
  ASSERT_TRUE(otherSeed);
  EXPECT_FALSE(SameBits(Sample(otherSeed, 0)->GetPoints()->GetData(), Sample(all, 0)->GetPoints()->GetData()));
}

TEST(PoseEnsemble, OnlySeedAndSamplesKeepTheEquations)
{
  const auto creature = Creature(2);
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(2);
  ASSERT_TRUE(PosesOf(filter, creature));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetSeed(7);
  filter->SetFirstSample(3);
  filter->SetNumberOfSamples(1);
  ASSERT_TRUE(PosesOf(filter, creature));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 1);
  filter->SetHandleRadius(0.1);
  ASSERT_TRUE(PosesOf(filter, creature));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
  filter->SetTemplateData(Creature(3));
  ASSERT_TRUE(PosesOf(filter, creature));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 3);
}

TEST(PoseEnsemble, KeepsArraysAndPrecisionAndDropsNormals)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto creature = Creature(Icosphere(2).ToPolyData(type));
    AddPointArray(creature, "height", [](const double* x) { return x[2]; });
    vtkNew<vtkFloatArray> normals;
    normals->SetName("Normals");
    normals->SetNumberOfComponents(3);
    normals->SetNumberOfTuples(creature->GetNumberOfPoints());
    normals->Fill(1.0);
    creature->GetPointData()->SetNormals(normals);
    const std::uint64_t before = HashOf(creature);
    vtkNew<Poses> filter;
    filter->SetNumberOfSamples(1);
    filter->SetDisplacementArrayName("moved");
    const auto poses = PosesOf(filter, creature);
    ASSERT_TRUE(poses);
    EXPECT_EQ(HashOf(creature), before);
    vtkPolyData* pose = Sample(poses, 0);
    EXPECT_EQ(pose->GetPoints()->GetDataType(), type);
    EXPECT_TRUE(SameBits(pose->GetPointData()->GetArray("height"), creature->GetPointData()->GetArray("height")));
    EXPECT_FALSE(pose->GetPointData()->GetNormals());
    vtkDataArray* moved = pose->GetPointData()->GetArray("moved");
    ASSERT_TRUE(moved);
    EXPECT_EQ(moved->GetDataType(), type);
    for (vtkIdType p = 0; p < pose->GetNumberOfPoints(); ++p)
    {
      for (int c = 0; c < 3; ++c)
      {
        EXPECT_NEAR(creature->GetPoint(p)[c] + moved->GetComponent(p, c), pose->GetPoint(p)[c], 1e-6);
      }
    }
  }
}

TEST(PoseEnsemble, SpreadMovesTheSamplesApartAndNothingElse)
{
  const auto creature = Creature(2);
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(3);
  filter->SetNumberOfIterations(2);
  const auto piled = PosesOf(filter, creature);
  EXPECT_EQ(Sample(piled, 1)->GetFieldData()->GetArray("Translation"), nullptr);
  filter->SetSpread(1.5);
  const auto spread = PosesOf(filter, creature);
  double box[6];
  creature->GetBounds(box);
  for (unsigned int k = 0; k < 3; ++k)
  {
    vtkDataArray* translation = Sample(spread, k)->GetFieldData()->GetArray("Translation");
    ASSERT_NE(translation, nullptr);
    const Eigen::RowVector3d moved(translation->GetTuple3(0));
    const Eigen::RowVector3d size(box[1] - box[0], box[3] - box[2], 0.0);
    const Eigen::RowVector3d cells = moved.cwiseQuotient((1.5 * size).cwiseMax(1e-9));
    EXPECT_LT((cells - cells.array().round().matrix()).cwiseAbs().maxCoeff(), 1e-9) << cells;
    EXPECT_EQ(moved.isZero(), k == 0);
    const PointMatrix back = PointsOf(Sample(spread, k)).rowwise() - moved;
    EXPECT_LT((back - PointsOf(Sample(piled, k))).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_TRUE(SameBits(Sample(spread, k)->GetPointData()->GetArray("Displacement"),
      Sample(piled, k)->GetPointData()->GetArray("Displacement")));
  }
  EXPECT_EQ(creature->GetFieldData()->GetArray("Translation"), nullptr);
}

TEST(PoseEnsemble, PointsWithoutTrianglesStay)
{
  auto creature = Creature(2);
  const vtkIdType lonely = creature->GetPoints()->InsertNextPoint(Direction(0).data()); // inside a limb
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(1);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  EXPECT_EQ(RegionOf(Sample(poses, 0), lonely), -1);
  EXPECT_LT((PointsOf(Sample(poses, 0)).row(lonely) - PointsOf(creature).row(lonely)).norm(), 1e-15);
}

TEST(PoseEnsemble, ReadsTheUnitOfLengthAsItIs)
{
  const auto creature = Creature(2);
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(1);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  for (const double unit : { 1e-6, 1e6 })
  {
    auto scaled = Creature(2);
    for (vtkIdType p = 0; p < scaled->GetNumberOfPoints(); ++p)
    {
      const Eigen::Vector3d point = unit * Eigen::Vector3d(scaled->GetPoint(p));
      scaled->GetPoints()->SetPoint(p, point.data());
    }
    const auto other = PosesOf(filter, scaled);
    ASSERT_TRUE(other);
    const PointMatrix difference = PointsOf(Sample(other, 0)) / unit - PointsOf(Sample(poses, 0));
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-5) << unit;
  }
}

TEST(PoseEnsemble, BlocksArePosedEachByItself)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Creature(2));
  blocks->SetBlock(1, Creature(2));
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(2);
  const auto output = PosesOf(filter, blocks);
  ASSERT_TRUE(output);
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  auto* first = vtkMultiBlockDataSet::SafeDownCast(output->GetBlock(0));
  auto* second = vtkMultiBlockDataSet::SafeDownCast(output->GetBlock(1));
  ASSERT_TRUE(first && second);
  ASSERT_EQ(second->GetNumberOfBlocks(), 2u);
  EXPECT_FALSE(SameBits(Sample(first, 0)->GetPoints()->GetData(), Sample(second, 0)->GetPoints()->GetData()));
}

TEST(PoseEnsemble, SaysWhatIsWrong)
{
  vtkNew<Poses> filter;
  const auto sphere = Icosphere(2).ToPolyData();
  filter->SetHandleRadius(1.0);
  ExpectRefusal(filter, sphere, { "There is no room for handle 1 of 6", "fewer or smaller handles" });
  filter->SetHandleRadius(0.3);
  filter->SetNumberOfHandles(1);
  ExpectRefusal(filter, sphere, { "Nothing of the shape stays", "AnchorRadius" });
  filter->SetHandleRadius(0.001);
  filter->SetTemplateData(Icosphere(4).ToPolyData());
  ExpectRefusal(filter, sphere, { "has no point of the surface", "template is of another shape" });

  Soup two = Icosphere(1);
  const vtkIdType offset = two.NumberOfPoints();
  const Soup other = Icosphere(1);
  two.Points.insert(two.Points.end(), other.Points.begin(), other.Points.end());
  for (std::vector<vtkIdType> triangle : other.Polys)
  {
    std::for_each(triangle.begin(), triangle.end(), [offset](vtkIdType& id) { id += offset; });
    two.Polys.push_back(triangle);
  }
  filter->SetTemplateData(two.ToPolyData());
  ExpectRefusal(filter, sphere, { "The template: ", "component" });
  filter->RemoveTemplate();
  ExpectRefusal(filter, two.ToPolyData(), { "component" });
  filter->SetRegionArrayName("");
  ExpectRefusal(filter, sphere, { "RegionArrayName is empty" });
}

TEST(PoseEnsemble, AnAbortLeavesNothingAndTheNextUpdateIsComplete)
{
  const auto creature = Creature(4);
  vtkNew<Poses> filter;
  filter->SetNumberOfSamples(30);
  filter->SetInputDataObject(creature);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.4;
    Update(filter);
    EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
    EXPECT_LT(events.SecondsAfterAbort, 1.0);
    EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
    EXPECT_FALSE(events.ForeignThread);
    auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
    EXPECT_TRUE(!output || output->GetNumberOfBlocks() == 0u);
  }
  filter->SetNumberOfSamples(2);
  const auto poses = PosesOf(filter, creature);
  ASSERT_TRUE(poses);
  EXPECT_EQ(poses->GetNumberOfBlocks(), 2u);
}

TEST(PoseEnsemble, PrintsItsProperties)
{
  vtkNew<Poses> filter;
  std::ostringstream text;
  filter->Print(text);
  for (const char* name :
    { "Seed: 0", "NumberOfSamples: 12", "FirstSample: 0", "Spread: 0", "NumberOfHandles: 6", "MaximumAngle: 60",
      "MaximumTwist: 20", "HandleRadius: 0.08", "AnchorRadius: 0.12", "PivotPosition: 0.8", "NumberOfIterations: 40",
      "Stiffness: 0.0002", "DisplacementArrayName: Displacement", "RegionArrayName: PoseRegion" })
  {
    EXPECT_NE(text.str().find(name), std::string::npos) << name;
  }
}
