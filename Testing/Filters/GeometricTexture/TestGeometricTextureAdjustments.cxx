// SPDX-License-Identifier: BSD-3-Clause
//
// Changes of a synthesized texture by vtkGeometricTextureSynthesizer: strengths, blends, and printable surfaces.
#include "FilterContract.h"
#include "GeometricTexturePipelines.h"
#include "RandomGeometricTexture.h"

#include "SurfaceBridge.h"

#ifdef SURFACE_SYNTHESIS_CGAL
#include "MeshProcessing/Repair/SelfIntersections.h"
#endif

#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Filter = vtkGeometricTextureSynthesizer;

namespace
{
PointMatrix PointsOf(vtkPolyData* surface) { return ConvertPoints(surface); }

PointMatrix VectorsOf(vtkDataArray* array)
{
  PointMatrix matrix(array->GetNumberOfTuples(), 3);
  for (vtkIdType t = 0; t < array->GetNumberOfTuples(); ++t)
  {
    array->GetTuple(t, matrix.row(t).data());
  }
  return matrix;
}

#ifdef SURFACE_SYNTHESIS_CGAL
/// A texture whose displacements are @p factor times those of WriteRandomGeometricTexture(), so that triangles intersect.
std::string WriteRoughTexture(const std::string& name, double factor)
{
  return WriteRandomGeometricTexture(name, 1, [factor](GeometricTextureModel& model) {
    const auto last = static_cast<std::int64_t>(model.Options.Layers) - 2;
    for (std::int64_t level = 0; level < model.Options.Levels; ++level)
    {
      const GeometricTextureTensorNames names = NamesOfConvolution(level, last, model.Options.Layers);
      for (const std::string& tensor : { names.Weight, names.Bias })
      {
        for (float& value : model.Generator.at(tensor).Values)
        {
          value *= static_cast<float>(factor);
        }
      }
    }
  });
}

std::size_t PairsIn(vtkPolyData* surface) { return FindIntersectingPairs(ConvertSurface(surface).Mesh).size(); }
#endif
} // namespace

// --- Strength -------------------------------------------------------------------------------------------------------

TEST(GeometricTextureStrength, MultipliesTheDisplacementsAndOneAndZeroAreExact)
{
  const auto target = Icosphere(2).ToPolyData();
  const auto strength = [](const double* p) { return p[2] > 0.3 ? 1.0 : p[2] < -0.3 ? 0.0 : 2.5; };
  AddPointField(target, "Height", strength);
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("strength.model"));
  filter->SetSeed(3);
  const vtkSmartPointer<vtkPolyData> plain = SurfaceOf(filter);
  const PointMatrix ways = VectorsOf(PointArray(plain, "Displacement"));
  const PointMatrix bare = PointsOf(plain) - ways;
  filter->SetStrength(1.75);
  EXPECT_TRUE(VectorsOf(PointArray(SurfaceOf(filter), "Displacement")).isApprox(1.75 * ways, 1e-12));
  filter->SetStrength(2.0);
  filter->SetStrengthArrayName("Height");
  const vtkSmartPointer<vtkPolyData> scaled = SurfaceOf(filter);
  const PointMatrix found = VectorsOf(PointArray(scaled, "Displacement"));
  for (Eigen::Index p = 0; p < ways.rows(); ++p)
  {
    const double factor = PointArray(scaled, "Height")->GetTuple1(p); // linear between the points of the target
    EXPECT_LT((found.row(p) - 2.0 * factor * ways.row(p)).norm(), 1e-6) << p;
  }
  filter->SetStrength(1.0);
  const vtkSmartPointer<vtkPolyData> same = SurfaceOf(filter);
  for (vtkIdType p = 0; p < same->GetNumberOfPoints(); ++p)
  {
    const double factor = PointArray(same, "Height")->GetTuple1(p);
    for (int k = 0; k < 3; ++k)
    {
      EXPECT_TRUE(factor != 1.0 || same->GetPoint(p)[k] == plain->GetPoint(p)[k]);
      EXPECT_TRUE(factor != 0.0 || PointArray(same, "Displacement")->GetComponent(p, k) == 0.0);
    }
  }
  EXPECT_EQ(filter->GetNumberOfSyntheses(), 1) << "the texture is kept";
  filter->SetStrengthArrayName("");
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), plain->GetPoints()->GetData()));
  EXPECT_LT((bare.rowwise().norm().array() - 1.0).abs().maxCoeff(), 0.1);
}

TEST(GeometricTextureStrength, IsThatOfTheTargetAtEachLevelAndAfterSubdivision)
{
  const auto target = Icosphere(1).ToPolyData();
  AddPointField(target, "Height", [](const double* p) { return 1.0 + p[0]; });
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("strength levels.model"));
  filter->SetTargetPreparationToSubdivide();
  filter->SetTextureScale(0.5);
  filter->OutputLevelsOn();
  std::vector<PointMatrix> ways[2];
  for (int scaled = 0; scaled < 2; ++scaled)
  {
    filter->SetStrengthArrayName(scaled ? "Height" : "");
    ASSERT_TRUE(Update(filter));
    auto* levels = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
    for (unsigned int k = 0; k < 2; ++k)
    {
      auto* level = vtkPolyData::SafeDownCast(levels->GetBlock(k));
      PointMatrix way = VectorsOf(PointArray(level, "Displacement"));
      for (Eigen::Index p = 0; p < way.rows() && !scaled; ++p)
      {
        way.row(p) *= PointArray(level, "Height")->GetTuple1(p);
      }
      ways[scaled].push_back(way);
    }
  }
  for (std::size_t k = 0; k < 2; ++k)
  {
    EXPECT_LT((ways[0][k] - ways[1][k]).cwiseAbs().maxCoeff(), 1e-6) << k;
  }
  AddPointField(target, "Height", [](const double* p) { return p[0]; });
  filter->Modified();
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("The strength array \"Height\" is -"), HasSubstr("values from 0")));
  filter->SetStrengthArrayName("None");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("The strength array \"None\" is missing"));
}

// --- Blend ----------------------------------------------------------------------------------------------------------

TEST(GeometricTextureBlend, LeadsFromOneModelToTheOtherAndIsExactAtBothEnds)
{
  const auto target = Icosphere(2).ToPolyData();
  const std::string models[] = { WriteRandomGeometricTexture("first.model", 1),
    WriteRandomGeometricTexture(
      "second.model", 2, [](GeometricTextureModel& model) { model.Options.NoiseAmplitude = 0.2; }) };
  PointMatrix alone[2];
  for (int k = 0; k < 2; ++k)
  {
    const auto filter = SynthesizerOn(target, models[k]);
    filter->SetSeed(4);
    alone[k] = PointsOf(SurfaceOf(filter));
  }
  ASSERT_GT((alone[0] - alone[1]).cwiseAbs().maxCoeff(), 1e-3);
  const auto filter = SynthesizerOn(target, models[0]);
  filter->SetSeed(4);
  filter->SetSecondModelFileName(models[1].c_str());
  filter->SetBlendArrayName("Share");
  PointMatrix before = alone[0];
  for (const double share : { 0.0, 0.5, 1.0 })
  {
    AddPointField(target, "Share", [share](const double*) { return share; });
    filter->Modified();
    const PointMatrix found = PointsOf(SurfaceOf(filter));
    EXPECT_EQ((found - alone[0]).isZero(0.0), share == 0.0) << share;
    EXPECT_EQ((found - alone[1]).isZero(0.0), share == 1.0) << share;
    EXPECT_LT((found - before).norm(), 0.9 * (alone[1] - alone[0]).norm()) << "between both at " << share;
    before = found;
  }
  EXPECT_EQ(filter->GetNumberOfModelLoads(), 2);
  EXPECT_EQ(filter->GetNumberOfSyntheses(), 3);
}

TEST(GeometricTextureBlend, VariesFromPlaceToPlaceByTheStatisticsOfTheReference)
{
  const auto target = Icosphere(3).ToPolyData();
  AddPointField(target, "Share", [](const double* p) { return std::min(1.0, std::max(0.0, 0.5 + 4.0 * p[2])); });
  const std::string models[] = { "first measured.model", "second measured.model" };
  PointMatrix alone[2];
  vtkSmartPointer<Filter> filter;
  for (int k = 0; k < 2; ++k)
  {
    const std::string plain = WriteRandomGeometricTexture("unmeasured.model", static_cast<std::uint64_t>(k + 1));
    ASSERT_TRUE(SynthesizerOn(nullptr, plain)->WriteModelWithStatistics(models[k].c_str(), 1));
    filter = SynthesizerOn(target, models[k]);
    filter->SetNormStatisticsToReference();
    alone[k] = PointsOf(SurfaceOf(filter));
  }
  filter->SetSecondModelFileName(models[0].c_str());
  filter->SetBlendArrayName("Share");
  const vtkSmartPointer<vtkPolyData> mixed = SurfaceOf(filter);
  int first = 0;
  int second = 0;
  for (vtkIdType p = 0; p < mixed->GetNumberOfPoints(); ++p)
  {
    const Eigen::RowVector3d point = Eigen::Map<const Eigen::RowVector3d>(mixed->GetPoint(p));
    const double z = point.normalized()[2];
    first += z < -0.8 && (point - alone[1].row(p)).norm() < 1e-6 ? 1 : 0;
    second += z > 0.8 && (point - alone[0].row(p)).norm() < 1e-6 ? 1 : 0;
    EXPECT_TRUE(z > -0.8 || (point - alone[1].row(p)).norm() < 1e-6) << p;
    EXPECT_TRUE(z < 0.8 || (point - alone[0].row(p)).norm() < 1e-6) << p;
  }
  EXPECT_GT(first, 100);
  EXPECT_GT(second, 100);
}

TEST(GeometricTextureBlend, SaysWhatIsWrong)
{
  const auto target = Icosphere(1).ToPolyData();
  AddPointField(target, "Share", [](const double* p) { return p[0]; });
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("two levels.model"));
  GeometricTextureOptions options = surfsynth::test::SmallGeometricTexture();
  options.Levels = 3;
  WriteGeometricTexture("three levels.model", surfsynth::test::RandomGeometricTexture(options));
  filter->SetSecondModelFileName("three levels.model");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("BlendArrayName is empty"));
  filter->SetBlendArrayName("Share");
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("The blend array \"Share\" is"), HasSubstr("SecondModelFileName")));
  AddPointField(target, "Share", [](const double*) { return 0.5; });
  filter->Modified();
  EXPECT_THAT(
    ErrorOf(filter), AllOf(HasSubstr("the first model has 2 levels and the second 3"), HasSubstr("same number")));
  filter->SetSecondModelFileName("absent.model");
  EXPECT_THAT(ErrorOf(filter), HasSubstr("absent.model"));
}

// --- Printable ------------------------------------------------------------------------------------------------------

#ifndef SURFACE_SYNTHESIS_CGAL
TEST(GeometricTexturePrintable, NeedsCgal)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("without.model"));
  filter->PrintableOn();
  EXPECT_THAT(ErrorOf(filter), HasSubstr("Printable needs CGAL"));
  EXPECT_EQ(filter->GetNumberOfSyntheses(), 0) << "before any work";
}
#else
TEST(GeometricTexturePrintable, NoTrianglesIntersectAndNothingElseMoves)
{
  const std::string model = WriteRoughTexture("rough.model", 12.0);
  for (const int precision : { VTK_FLOAT, VTK_DOUBLE })
  {
    const auto target = Icosphere(3).ToPolyData(precision);
    AddPointField(target, "Upper", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
    const auto filter = SynthesizerOn(target, model);
    filter->SetMaskArrayName("Upper");
    const vtkSmartPointer<vtkPolyData> rough = SurfaceOf(filter);
    EXPECT_EQ(filter->GetNumberOfSelfIntersections(), -1);
    EXPECT_EQ(filter->GetHeightKept(), 1.0);
    ASSERT_GT(PairsIn(rough), 20U);
    filter->PrintableOn();
    const auto printed = SurfaceOf(filter);
    EXPECT_EQ(PairsIn(printed), 0U);
    EXPECT_EQ(filter->GetNumberOfSelfIntersections(), 0);
    EXPECT_EQ(filter->GetNumberOfSyntheses(), 1) << "the texture is kept";
    EXPECT_LT(filter->GetHeightKept(), 1.0 + 1e-12);
    EXPECT_GT(filter->GetHeightKept(), 0.7);
    for (vtkIdType p = 0; p < printed->GetNumberOfPoints(); ++p)
    {
      const double* way = PointArray(printed, "Displacement")->GetTuple3(p);
      const bool isBare = PointArray(printed, "Upper")->GetTuple1(p) == 0.0;
      EXPECT_TRUE(!isBare || (way[0] == 0.0 && way[1] == 0.0 && way[2] == 0.0)) << p;
    }
    filter->PrintableOff();
    EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), rough->GetPoints()->GetData()));
  }
}

TEST(GeometricTexturePrintable, LevelsAndTimesBetweenThemLeadFromOnePrintableSurfaceToTheNext)
{
  const auto filter = SynthesizerOn(Icosphere(2).ToPolyData(), WriteRoughTexture("rough levels.model", 12.0));
  filter->PrintableOn();
  const vtkSmartPointer<vtkPolyData> last = SurfaceOf(filter);
  filter->OutputLevelsOn();
  ASSERT_TRUE(Update(filter));
  auto* levels = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  std::vector<vtkSmartPointer<vtkPolyData>> surfaces;
  for (unsigned int k = 0; k < 2; ++k)
  {
    surfaces.push_back(vtkPolyData::SafeDownCast(levels->GetBlock(k)));
    EXPECT_EQ(PairsIn(surfaces.back()), 0U) << k;
  }
  EXPECT_TRUE(SameBits(surfaces[1]->GetPoints()->GetData(), last->GetPoints()->GetData()));
  filter->OutputLevelsOff();
  filter->SetAnimationToLevels();
  ASSERT_TRUE(filter->UpdateTimeStep(1.0));
  const PointMatrix first = PointsOf(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0)));
  EXPECT_EQ((first - PointsOf(surfaces[0])).cwiseAbs().maxCoeff(), 0.0);
  ASSERT_TRUE(filter->UpdateTimeStep(1.0 + 1e-9));
  const PointMatrix next = PointsOf(vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0)));
  EXPECT_LT((next.topRows(first.rows()) - first).cwiseAbs().maxCoeff(), 1e-6) << "no jump between levels";
}

TEST(GeometricTexturePrintable, ComponentsBlocksAndTargetsThatIntersectThemselves)
{
  Soup crossing = Icosphere(2);
  const Soup other = Icosphere(2);
  for (const auto& triangle : other.Polys)
  {
    crossing.Polys.push_back({});
    for (const vtkIdType p : triangle)
    {
      const double* x = other.Points.data() + 3 * p;
      crossing.Polys.back().push_back(crossing.AddPoint(x[0] + 0.9, x[1] + 0.05, x[2] + 0.02));
    }
  }
  Soup apart = Icosphere(2); // spheres that their textures push into one another
  for (const auto& triangle : other.Polys)
  {
    apart.Polys.push_back({});
    for (const vtkIdType p : triangle)
    {
      const double* x = other.Points.data() + 3 * p;
      apart.Polys.back().push_back(apart.AddPoint(x[0] + 2.01, x[1], x[2]));
    }
  }
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, apart.ToPolyData());
  blocks->SetBlock(1, crossing.ToPolyData());
  const auto filter = SynthesizerOn(blocks, WriteRoughTexture("rough blocks.model", 6.0));
  filter->PrintableOn();
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_THAT(events.Errors, IsEmpty());
  ASSERT_THAT(events.Warnings, SizeIs(1));
  EXPECT_THAT(
    events.Warnings[0], AllOf(HasSubstr("Block 2"), HasSubstr("pairs of triangles intersect where the target")));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_EQ(PairsIn(vtkPolyData::SafeDownCast(output->GetBlock(0))), 0U);
  const std::size_t left = PairsIn(vtkPolyData::SafeDownCast(output->GetBlock(1)));
  EXPECT_GT(left, 10U);
  EXPECT_EQ(static_cast<std::size_t>(filter->GetNumberOfSelfIntersections()), left);
}
#endif
