// SPDX-License-Identifier: BSD-3-Clause
//
// TargetPreparation REMESH of vtkGeometricTextureSynthesizer: sizes of triangles, arrays, masks, blocks, what is kept,
// messages; and what it says without CGAL.
#include "FilterContract.h"
#include "GeometricTexturePipelines.h"

#include "SurfaceBridge.h"

#include "Core/Common/FormatNumber.h"
#include "Core/Mesh/MeshStatistics.h"

#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Filter = vtkGeometricTextureSynthesizer;

namespace
{
vtkSmartPointer<Filter> Remeshing(vtkDataObject* target, double scale = 1.0)
{
  static const std::string model = WriteRandomGeometricTexture("remeshing.model");
  auto filter = SynthesizerOn(target, model);
  filter->SetTargetPreparationToRemesh();
  filter->SetTextureScale(scale);
  return filter;
}

#ifdef SURFACE_SYNTHESIS_CGAL
/// The output without the texture.
TriangleMesh Bare(vtkPolyData* output)
{
  TriangleMesh mesh = ConvertSurface(output).Mesh;
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    mesh.Points.row(p) -= Eigen::Map<const Eigen::RowVector3d>(PointArray(output, "Displacement")->GetTuple3(p));
  }
  return mesh;
}

/// Standard deviation of the edge lengths over their mean.
double Unevenness(const TriangleMesh& mesh)
{
  const double mean = MeanSideLength(mesh);
  double squares = 0.0;
  for (Eigen::Index f = 0; f < mesh.Triangles.rows(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const double edge =
        (mesh.Points.row(mesh.Triangles(f, k)) - mesh.Points.row(mesh.Triangles(f, (k + 1) % 3))).norm();
      squares += (edge - mean) * (edge - mean);
    }
  }
  return std::sqrt(squares / static_cast<double>(3 * mesh.Triangles.rows())) / mean;
}

/// Cost of one more update: numbers of remeshings and of synthesized textures.
struct Cost
{
  vtkTypeInt64 Remeshings;
  vtkTypeInt64 Syntheses;
  bool operator==(const Cost& other) const
  {
    return this->Remeshings == other.Remeshings && this->Syntheses == other.Syntheses;
  }
};

std::ostream& operator<<(std::ostream& os, const Cost& cost)
{
  return os << cost.Remeshings << " remeshings, " << cost.Syntheses << " syntheses";
}

Cost CostOf(Filter* filter)
{
  const Cost before{ filter->GetNumberOfRemeshings(), filter->GetNumberOfSyntheses() };
  EXPECT_TRUE(Update(filter));
  return { filter->GetNumberOfRemeshings() - before.Remeshings, filter->GetNumberOfSyntheses() - before.Syntheses };
}
#endif
} // namespace

TEST(GeometricTextureRemeshing, TheAutomaticStartIsLevelOneOnATargetAndLevelZeroWithoutInput)
{
  const auto target = Icosphere(1).ToPolyData();
  for (const bool hasTarget : { true, false })
  {
    const auto filter = Remeshing(hasTarget ? target.Get() : nullptr);
    filter->SetTargetPreparationToAsIs();
    filter->SetStartLevel(-1);
    const vtkSmartPointer<vtkPolyData> automatic = SurfaceOf(filter);
    filter->SetStartLevel(hasTarget ? 1 : 0);
    EXPECT_TRUE(SameBits(automatic->GetPoints()->GetData(), SurfaceOf(filter)->GetPoints()->GetData()));
  }
}

TEST(GeometricTextureRemeshing, LeavesTheTemplateAsItIs)
{
  const auto filter = Remeshing(nullptr, 0.3);
  const auto output = SurfaceOf(filter);
  filter->SetTargetPreparationToAsIs();
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), output->GetPoints()->GetData()));
  EXPECT_EQ(filter->GetNumberOfRemeshings(), 0);
}

TEST(GeometricTextureRemeshing, ScalesThatAreNoNumbers)
{
  const auto filter = Remeshing(Icosphere(1).ToPolyData());
  filter->SetTextureScale(NAN);
  EXPECT_THAT(ErrorOf(filter), HasSubstr("TextureScale is not a number"));
}

#ifndef SURFACE_SYNTHESIS_CGAL
TEST(GeometricTextureRemeshing, NeedsCgal)
{
  EXPECT_THAT(ErrorOf(Remeshing(Icosphere(2).ToPolyData())),
    AllOf(HasSubstr("TargetPreparation is REMESH, which needs CGAL"), HasSubstr("AS_IS or SUBDIVIDE")));
}
#else

TEST(GeometricTextureRemeshing, EdgesAreAsLongAsTheScaleSays)
{
  const auto target = RingSphere(20, 90); // long triangles at the equator, thin ones at the poles
  const TriangleMesh given = ConvertSurface(target).Mesh;
  const std::uint64_t before = HashOf(target);
  for (const double scale : { 0.6, 1.0, 2.0, 3.1 })
  {
    const auto filter = Remeshing(target, scale);
    filter->SetEndLevel(0);
    const TriangleMesh bare = Bare(SurfaceOf(filter));
    EXPECT_NEAR(MeanSideLength(bare) / MeanSideLength(given), scale, 0.03 * scale) << scale;
    EXPECT_LT(Unevenness(bare), 0.25);
    // A triangle is below the sphere by up to 1 - cos of half its longest side, the diagonal of a quad at the equator.
    const double below = 1.0 - std::cos(0.5 * std::hypot(M_PI / 20.0, 2.0 * M_PI / 90.0));
    EXPECT_LT((bare.Points.rowwise().norm().array() - 1.0).abs().maxCoeff(), 1.1 * below) << "points lie on the target";
    filter->SetEndLevel(-1);
    EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPolys(), 4 * bare.NumberOfTriangles());
    EXPECT_EQ(PointArray(SurfaceOf(filter), "Level")->GetTuple1(0), 0.0);
  }
  EXPECT_GT(Unevenness(given), 0.4);
  EXPECT_EQ(HashOf(target), before);
}

TEST(GeometricTextureRemeshing, TheAutomaticScaleBeginsWithTheSameTrianglesOnEveryTarget)
{
  for (const int levels : { 2, 5 })
  {
    const auto filter = Remeshing(Icosphere(levels).ToPolyData(), 0.0);
    filter->SetEndLevel(0);
    const auto output = SurfaceOf(filter);
    EXPECT_NEAR(static_cast<double>(output->GetNumberOfPolys()), 7000.0, 700.0) << levels;
  }
}

namespace
{
/// The largest relative error of the mean edge length in slices of the height z of a bare surface, which is to be
/// @p wanted(z).
double ErrorOfEdges(const TriangleMesh& bare, const std::function<double(double z)>& wanted)
{
  constexpr int Slices = 8;
  double found[Slices] = {}, asked[Slices] = {};
  for (Index f = 0; f < bare.NumberOfTriangles(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      const Eigen::RowVector3d a = bare.Points.row(bare.Triangles(f, k));
      const Eigen::RowVector3d b = bare.Points.row(bare.Triangles(f, (k + 1) % 3));
      const double z = 0.5 * (a[2] + b[2]);
      const int slice = std::clamp(static_cast<int>((z + 1.0) / 2.0 * Slices), 0, Slices - 1);
      found[slice] += (b - a).norm();
      asked[slice] += wanted(z);
    }
  }
  double error = 0.0;
  for (int slice = 0; slice < Slices; ++slice)
  {
    error = std::max(error, std::abs(found[slice] / asked[slice] - 1.0));
  }
  return error;
}
} // namespace

TEST(GeometricTextureRemeshing, SizesVaryFromPlaceToPlace)
{
  const auto target = Icosphere(4).ToPolyData();
  const auto size = [](double z) { return 1.0 + 0.6 * z; };
  AddPointField(target, "Size", [&](const double* p) { return size(p[2]); });
  const double edge = MeanSideLength(ConvertSurface(target).Mesh);
  const auto filter = Remeshing(target, 1.3);
  filter->SetSizeArrayName("Size");
  filter->SetEndLevel(0);
  const vtkSmartPointer<vtkPolyData> output = SurfaceOf(filter);
  EXPECT_LT(ErrorOfEdges(Bare(output), [&](double z) { return 1.3 * edge * size(z); }), 0.15);
  EXPECT_GT(ErrorOfEdges(Bare(output), [&](double) { return 1.3 * edge; }), 0.3) << "of one size";
  EXPECT_EQ(CostOf(filter), (Cost{ 0, 0 }));
  AddPointField(target, "Size", [](const double*) { return 0.8; });
  filter->Modified();
  EXPECT_EQ(CostOf(filter), (Cost{ 1, 1 })) << "other sizes are another remeshing";
  AddPointField(target, "Size", [](const double*) { return 0.0; });
  filter->Modified();
  EXPECT_THAT(
    ErrorOf(filter), HasSubstr("The size array \"Size\" is 0 at point 0; values from 0.01 to 100 are needed"));
}

TEST(GeometricTextureRemeshing, ArraysAreCarriedOver)
{
  const auto target = Grid(9, 4).ToPolyData(VTK_FLOAT);
  AddPointField(target, "Linear", [](const double* p) { return 1.0 + 2.0 * p[0] - 3.0 * p[1]; });
  vtkNew<vtkIntArray> column;
  column->SetName("Column");
  for (vtkIdType f = 0; f < target->GetNumberOfCells(); ++f)
  {
    double box[6];
    target->GetCellBounds(f, box);
    column->InsertNextValue(static_cast<int>(std::lround(9.0 * box[0])));
  }
  target->GetCellData()->AddArray(column);
  vtkNew<vtkIntArray> field;
  field->SetName("Field");
  field->InsertNextValue(3);
  target->GetFieldData()->AddArray(field);
  const auto output = SurfaceOf(Remeshing(target, 0.5));
  EXPECT_EQ(output->GetPoints()->GetDataType(), VTK_FLOAT);
  EXPECT_TRUE(output->GetFieldData()->HasArray("Field"));
  const TriangleMesh bare = Bare(output);
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double expected = 1.0 + 2.0 * bare.Points(p, 0) - 3.0 * bare.Points(p, 1);
    EXPECT_NEAR(PointArray(output, "Linear")->GetTuple1(p), expected, 1e-5);
  }
  vtkDataArray* columns = output->GetCellData()->GetArray("Column");
  ASSERT_TRUE(columns && columns->GetNumberOfTuples() == bare.NumberOfTriangles());
  int right = 0;
  for (vtkIdType f = 0; f < bare.NumberOfTriangles(); ++f)
  {
    const auto t = bare.Triangles.row(f);
    const double x = (bare.Points(t(0), 0) + bare.Points(t(1), 0) + bare.Points(t(2), 0)) / 3.0;
    EXPECT_NEAR(columns->GetTuple1(f) + 0.5, 9.0 * x, 0.5 + 0.5) << "of the cell beneath the coarse triangle";
    right += std::floor(9.0 * x) == columns->GetTuple1(f) ? 1 : 0;
  }
  EXPECT_GT(right, bare.NumberOfTriangles() / 2);
}

TEST(GeometricTextureRemeshing, MasksLimitTheTexture)
{
  const auto target = Icosphere(3).ToPolyData();
  AddPointField(target, "Upper", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const auto filter = Remeshing(target, 0.7);
  filter->SetMaskArrayName("Upper");
  for (const double falloff : { 0.0, 0.5 })
  {
    filter->SetMaskFalloff(falloff);
    const auto output = SurfaceOf(filter);
    int still = 0;
    int moved = 0;
    for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
    {
      const bool bare = PointArray(output, "Upper")->GetTuple1(p) == 0.0;
      const double* d = PointArray(output, "Displacement")->GetTuple3(p);
      const bool rests = d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0;
      EXPECT_TRUE(rests || !bare) << p;
      still += rests ? 1 : 0;
      moved += rests ? 0 : 1;
    }
    EXPECT_GT(still, 500);
    EXPECT_GT(moved, 500);
  }
  EXPECT_EQ(filter->GetNumberOfRemeshings(), 1);
  AddPointField(target, "Upper", [](const double* p) { return p[2] > 0.9 ? 1.5 : 0.0; });
  filter->Modified();
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("\"Upper\" is 1.5 at point"), HasSubstr("from 0")));
}

TEST(GeometricTextureRemeshing, IsDoneOnceForEachTargetAndScale)
{
  const auto target = Icosphere(2).ToPolyData();
  AddPointField(target, "Mask", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const auto filter = Remeshing(target);
  EXPECT_EQ(CostOf(filter), (Cost{ 1, 1 }));
  filter->SetDisplacementArrayName("Motion");
  EXPECT_EQ(CostOf(filter), (Cost{ 0, 0 }));
  filter->SetSeed(4);
  EXPECT_EQ(CostOf(filter), (Cost{ 0, 1 }));
  filter->SetMaskArrayName("Mask");
  EXPECT_EQ(CostOf(filter), (Cost{ 0, 1 }));
  AddPointField(target, "Mask", [](const double* p) { return p[1] > 0.0 ? 1.0 : 0.0; });
  target->Modified();
  EXPECT_EQ(CostOf(filter), (Cost{ 0, 1 })) << "another mask of that name";
  filter->SetTextureScale(0.8);
  EXPECT_EQ(CostOf(filter), (Cost{ 1, 1 }));
  filter->SetAnimationToLevels();
  Update(filter);
  const vtkTypeInt64 syntheses = filter->GetNumberOfSyntheses();
  EXPECT_TRUE(filter->UpdateTimeStep(1.0));
  EXPECT_EQ(filter->GetNumberOfSyntheses(), syntheses);
  EXPECT_EQ(CostOf(filter).Remeshings, 0);
  target->GetPoints()->SetPoint(0, 0.0, 0.0, 1.1);
  target->GetPoints()->Modified();
  EXPECT_EQ(CostOf(filter), (Cost{ 1, 1 }));
}

TEST(GeometricTextureRemeshing, SplitNormalsDoNotCutTheSurfaceOpenAndSeamsDo)
{
  // A sphere whose triangles share no point, with the normals of the triangles at their corners.
  const Soup sphere = Icosphere(2);
  Soup soup;
  vtkNew<vtkFloatArray> normals;
  normals->SetName("Normals");
  normals->SetNumberOfComponents(3);
  for (const auto& triangle : sphere.Polys)
  {
    std::vector<vtkIdType> corners;
    for (const vtkIdType p : triangle)
    {
      const double* x = sphere.Points.data() + 3 * p;
      corners.push_back(soup.AddPoint(x[0], x[1], x[2]));
      const double* first = sphere.Points.data() + 3 * triangle[0];
      normals->InsertNextTuple3(first[0], first[1], first[2]);
    }
    soup.Polys.push_back(corners);
  }
  const auto target = soup.ToPolyData();
  target->GetPointData()->SetNormals(normals);
  const auto closed = SurfaceOf(Remeshing(target));
  EXPECT_EQ(closed->GetNumberOfPolys(), 2 * (closed->GetNumberOfPoints() - 2)) << "a closed surface without handles";
  EXPECT_FALSE(closed->GetPointData()->GetNormals());
  normals->SetName("Facets");
  target->GetPointData()->SetNormals(nullptr);
  target->GetPointData()->AddArray(normals);
  const auto open = SurfaceOf(Remeshing(target));
  EXPECT_LT(open->GetNumberOfPolys(), 2 * (open->GetNumberOfPoints() - 2) - 100);
}

TEST(GeometricTextureRemeshing, BlocksAreRemeshedOneByOne)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  Soup fan = Icosphere(1); // two spheres that share a point
  const Soup other = Icosphere(1);
  for (const auto& triangle : other.Polys)
  {
    fan.Polys.push_back({});
    for (const vtkIdType p : triangle)
    {
      const double* x = other.Points.data() + 3 * p;
      const double* tip = other.Points.data();
      fan.Polys.back().push_back(p == 0 ? 0 : fan.AddPoint(2 * tip[0] - x[0], 2 * tip[1] - x[1], 2 * tip[2] - x[2]));
    }
  }
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(1, fan.ToPolyData());
  blocks->SetBlock(2, Icosphere(2).ToPolyData());
  const auto filter = Remeshing(blocks, 0.8);
  filter->OutputLevelsOn();
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_THAT(events.Errors, SizeIs(1));
  EXPECT_THAT(events.AllErrors(), AllOf(HasSubstr("Block 2"), HasSubstr("vtkSurfaceRepairFilter")));
  auto* levels = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  auto* last = vtkMultiBlockDataSet::SafeDownCast(levels->GetBlock(1));
  auto* first = vtkPolyData::SafeDownCast(last->GetBlock(0));
  auto* third = vtkPolyData::SafeDownCast(last->GetBlock(2));
  EXPECT_GT(first->GetNumberOfPolys(), 4 * Icosphere(2).ToPolyData()->GetNumberOfPolys());
  EXPECT_GT(LargestDifference(first->GetPoints()->GetData(), third->GetPoints()->GetData()), 1e-4) << "other noise";
  EXPECT_EQ(filter->GetNumberOfRemeshings(), 2);
}

TEST(GeometricTextureRemeshing, TooManyTriangles)
{
  const auto filter = Remeshing(Icosphere(5).ToPolyData(), 0.001);
  const double begin = Now();
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("Remeshed with edges of length"), HasSubstr("larger TextureScale")));
  EXPECT_LT(Now() - begin, 5.0) << "before any work";
}

TEST(GeometricTextureRemeshing, EdgesLongerThanTheSurface)
{
  const auto filter = Remeshing(Icosphere(2).ToPolyData(), 1000.0);
  EXPECT_THAT(ErrorOf(filter), AllOf(HasSubstr("longer than the surface"), HasSubstr("smaller TextureScale is")));
}

TEST(GeometricTextureRemeshing, SizesDecideWhetherEdgesFit)
{
  const auto target = Icosphere(2).ToPolyData();
  const double edge = MeanSideLength(ConvertSurface(target).Mesh);
  const auto withSizes = [&](double scale, const std::function<double(const double* point)>& size) {
    AddPointField(target, "Size", size);
    auto filter = Remeshing(target, scale);
    filter->SetSizeArrayName("Size");
    filter->SetEndLevel(0);
    return filter;
  };
  const double begin = Now();
  EXPECT_THAT(ErrorOf(withSizes(1.0, [](const double* p) { return p[2] > 0.9 ? 100.0 : 1.0; })),
    AllOf(HasSubstr("Edges of length " + FormatNumber(edge) + " to " + FormatNumber(100.0 * edge) +
            " are longer than the surface, whose longest side is 2"),
      HasSubstr("smaller TextureScale, or other sizes, is needed")));
  EXPECT_THAT(ErrorOf(withSizes(0.001, [](const double*) { return 0.5; })),
    AllOf(HasSubstr("Remeshed with edges of length " + FormatNumber(0.0005 * edge) + " to "),
      HasSubstr("A larger TextureScale, or other sizes, is needed")));
  EXPECT_LT(Now() - begin, 5.0) << "before any work";
  const auto fitting = withSizes(100.0, [](const double*) { return 0.01; });
  EXPECT_NEAR(MeanSideLength(Bare(SurfaceOf(fitting))) / edge, 1.0, 0.1) << "a hundred times a hundredth";
}

TEST(GeometricTextureRemeshing, MoreThanTheShapeAllowsIsStillASurface)
{
  const auto filter = Remeshing(Icosphere(2).ToPolyData(), 8.0);
  EventRecorder events(filter);
  if (Update(filter))
  {
    const auto output = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
    EXPECT_GE(output->GetNumberOfPolys(), 16);
    EXPECT_EQ(output->GetNumberOfPolys(), 2 * (output->GetNumberOfPoints() - 2));
  }
  else
  {
    EXPECT_THAT(events.Errors, SizeIs(1));
    EXPECT_THAT(events.AllErrors(), HasSubstr("Once remeshed: "));
  }
}

TEST(GeometricTextureRemeshing, CanBeStoppedAndReportsProgress)
{
  const auto filter = Remeshing(RingSphere(80, 80), 0.5);
  {
    EventRecorder events(filter);
    events.AbortAt = 0.01;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, 1.0) << "R9";
    EXPECT_EQ(filter->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
  }
  filter->SetInputDataObject(RingSphere(40, 40));
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end()));
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
}
#endif
