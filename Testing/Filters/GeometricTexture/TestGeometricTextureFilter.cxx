// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkGeometricTextureSynthesizer for a target: the numbers of the plain sampler, the target's arrays on finer
// meshes, masks, subdivision, levels as blocks, time, the template.
#include "GeometricTexturePipelines.h"
#include "RandomGeometricTexture.h"

#include "SurfaceBridge.h"

#include "Core/Mesh/MidpointSubdivision.h"
#include "Inference/GeometricTexture/GeometricTextureSampler.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataAlgorithm.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <vector>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::HasSubstr;
using Pipeline = vtkStreamingDemandDrivenPipeline;

namespace
{
/// The plain sampler that a filter should equal.
GeometricTextureSampler PlainSampler(const std::string& model)
{
  return GeometricTextureSampler(std::make_shared<const GeometricTextureModel>(ReadGeometricTexture(model)));
}

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

double Distance(const PointMatrix& a, const PointMatrix& b)
{
  EXPECT_EQ(a.rows(), b.rows());
  return a.rows() == b.rows() ? (a - b).cwiseAbs().maxCoeff() : INFINITY;
}

vtkPolyData* BlockOf(vtkDataObject* output, unsigned int k)
{
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(output);
  EXPECT_TRUE(blocks && k < blocks->GetNumberOfBlocks());
  return blocks ? vtkPolyData::SafeDownCast(blocks->GetBlock(k)) : nullptr;
}

/// A sphere with times of its own, which remembers the time that it was asked for.
class TimedBall : public vtkPolyDataAlgorithm
{
public:
  static TimedBall* New();
  vtkTypeMacro(TimedBall, vtkPolyDataAlgorithm);
  double AskedFor = -1.0;

protected:
  TimedBall() { this->SetNumberOfInputPorts(0); }
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    const double times[2] = { 5.0, 6.0 };
    output->GetInformationObject(0)->Set(Pipeline::TIME_STEPS(), times, 2);
    output->GetInformationObject(0)->Set(Pipeline::TIME_RANGE(), times, 2);
    return 1;
  }
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    vtkInformation* info = output->GetInformationObject(0);
    this->AskedFor = info->Has(Pipeline::UPDATE_TIME_STEP()) ? info->Get(Pipeline::UPDATE_TIME_STEP()) : -1.0;
    vtkPolyData::GetData(output)->ShallowCopy(Icosphere(1).ToPolyData());
    return 1;
  }
};
vtkStandardNewMacro(TimedBall);
} // namespace

// --- The numbers ----------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, TheSurfaceIsThatOfThePlainSampler)
{
  const std::string model = WriteRandomGeometricTexture("plain.model");
  const auto target = Icosphere(2).ToPolyData();
  const auto filter = SynthesizerOn(target, model);
  filter->SetSeed(5);
  filter->SetSecondSeed(9);
  filter->SetInterpolation(0.25);
  filter->SetNoiseAmplitude(0.2);
  const auto output = SurfaceOf(filter);
  GeometricTextureRequest request;
  request.Seed = 5;
  request.SecondSeed = 9;
  request.Interpolation = 0.25;
  request.NoiseAmplitude = 0.2;
  const GeometricTextureLevel expected = PlainSampler(model).Synthesize(ConvertSurface(target).Mesh, request);
  EXPECT_EQ(Distance(PointsOf(output), expected.Mesh.Points), 0.0);
  EXPECT_TRUE(ConvertSurface(output).Mesh.Triangles == expected.Mesh.Triangles);
  vtkDataArray* displacement = PointArray(output, "Displacement");
  EXPECT_EQ(displacement->GetDataType(), VTK_DOUBLE);
  EXPECT_EQ(output->GetPointData()->GetVectors(), displacement);
  EXPECT_EQ(Distance(VectorsOf(displacement), expected.Mesh.Points - expected.Base), 0.0);
  EXPECT_GT(VectorsOf(displacement).cwiseAbs().maxCoeff(), 0.005);
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 2);
  EXPECT_EQ(output->GetCellData()->GetNumberOfArrays(), 0);
  EXPECT_EQ(output->GetNumberOfPolys(), 4 * target->GetNumberOfPolys());
}

TEST(GeometricTextureFilter, LevelsAreThoseWithWhichPointsCame)
{
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("levels.model"));
  const auto output = SurfaceOf(filter);
  vtkDataArray* level = PointArray(output, "Level");
  EXPECT_EQ(level->GetDataType(), VTK_INT);
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    EXPECT_EQ(level->GetTuple1(p), p < target->GetNumberOfPoints() ? 0 : 1);
  }
  filter->SetStartLevel(1);
  const auto last = SurfaceOf(filter);
  EXPECT_EQ(last->GetNumberOfPoints(), target->GetNumberOfPoints()) << "one level subdivides nothing";
  EXPECT_EQ(PointArray(last, "Level")->GetTuple1(0), 1);
  filter->SetStartLevel(0);
  filter->SetEndLevel(0);
  EXPECT_GT(LargestDifference(SurfaceOf(filter)->GetPoints()->GetData(), last->GetPoints()->GetData()), 1e-4);
}

TEST(GeometricTextureFilter, EachLevelCanDoWithoutNoise)
{
  const std::string model = WriteRandomGeometricTexture("quiet.model");
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, model);
  const GeometricTextureSampler sampler = PlainSampler(model);
  const TriangleMesh mesh = ConvertSurface(target).Mesh;
  const auto expected = [&](std::vector<bool> quiet) {
    GeometricTextureRequest request;
    request.LevelsWithoutNoise = std::move(quiet);
    return sampler.Synthesize(mesh, request).Mesh.Points;
  };
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected({})), 0.0);
  filter->SetLevelsWithoutNoise("0");
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected({ true, false })), 0.0);
  filter->SetLevelsWithoutNoise("1");
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected({ false, true })), 0.0);
  filter->SetLevelsWithoutNoise(" 1,0 12");
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected({ true, true })), 0.0);
  EXPECT_GT(Distance(expected({ true, true }), expected({})), 1e-4) << "noise matters";
  filter->SetLevelsWithoutNoise("");
  filter->SetNoiseAmplitude(0.0);
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected({ true, true })), 0.0);
  // Numbers are those of generator levels, whichever comes first.
  filter->SetNoiseAmplitude(-1.0);
  filter->SetStartLevel(1);
  filter->SetLevelsWithoutNoise("1");
  GeometricTextureRequest last;
  last.StartLevel = 1;
  last.LevelsWithoutNoise = { true };
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), sampler.Synthesize(mesh, last).Mesh.Points), 0.0);
}

TEST(GeometricTextureFilter, StatisticsOfTheNormsAreThoseOfTheModel)
{
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("plain-norms.model"));
  const auto plain = SurfaceOf(filter);
  ASSERT_TRUE(filter->WriteModelWithStatistics("norms.model", 2));
  filter->SetModelFileName("norms.model");
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), plain->GetPoints()->GetData()))
    << "those of the target by default";
  const vtkTypeInt64 before = filter->GetNumberOfSyntheses();
  filter->SetNormStatisticsToReference();
  const auto normalized = SurfaceOf(filter);
  EXPECT_GT(LargestDifference(normalized->GetPoints()->GetData(), plain->GetPoints()->GetData()), 1e-4);
  EXPECT_EQ(filter->GetNumberOfSyntheses(), before + 1);
  GeometricTextureRequest request;
  request.Statistics = surfsynth::NormStatistics::Reference;
  const GeometricTextureLevel expected = PlainSampler("norms.model").Synthesize(ConvertSurface(target).Mesh, request);
  EXPECT_EQ(Distance(PointsOf(normalized), expected.Mesh.Points), 0.0);
}

TEST(GeometricTextureFilter, AModelThatCannotBeMeasuredIsReported)
{
  vtkNew<vtkGeometricTextureSynthesizer> filter;
  const auto message = [&](const char* file, int samples) {
    EventRecorder events(filter);
    EXPECT_FALSE(filter->WriteModelWithStatistics(file, samples));
    return events.AllErrors();
  };
  EXPECT_THAT(message("measured.model", 2), HasSubstr("ModelFileName is empty"));
  filter->SetModelFileName(WriteRandomGeometricTexture("unmeasured.model").c_str());
  EXPECT_THAT(message("", 2), HasSubstr("the file to write is empty"));
  EXPECT_THAT(message(nullptr, 2), HasSubstr("the file to write is empty"));
  EXPECT_THAT(message("measured.model", 0), HasSubstr("of 0 samples"));
  EXPECT_THAT(message("measured.model", 1001), HasSubstr("1 to 1000"));
  EXPECT_THAT(message("no/such/folder/measured.model", 1), HasSubstr("no/such/folder"));
  GeometricTextureModel bare = surfsynth::test::RandomGeometricTexture();
  bare.Template = {};
  bare.ReconstructionNoise.resize(0, 3);
  surfsynth::WriteGeometricTexture("bare.model", bare);
  filter->SetModelFileName("bare.model");
  EXPECT_THAT(message("measured.model", 1), HasSubstr("no template"));
}

TEST(GeometricTextureFilter, SubdividingTheTargetMakesTheTextureSmaller)
{
  const std::string model = WriteRandomGeometricTexture("scale.model");
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, model);
  filter->SetTextureScale(0.5);
  EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPolys(), 4 * target->GetNumberOfPolys()) << "as it is";
  filter->SetTargetPreparationToSubdivide();
  const TriangleMesh once = SubdivideAtMidpoints(ConvertSurface(target).Mesh).Mesh;
  const PointMatrix expected = PlainSampler(model).Synthesize(once, {}).Mesh.Points;
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected), 0.0);
  filter->SetTextureScale(0.6);
  EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), expected), 0.0) << "the nearest power of a half";
  filter->SetTextureScale(0.25);
  EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPolys(), 64 * target->GetNumberOfPolys());
  filter->SetTextureScale(3.0);
  EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPolys(), 4 * target->GetNumberOfPolys());
}

// --- Masks ----------------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, WhereTheMaskIsZeroPointsStay)
{
  const auto target = Icosphere(3).ToPolyData();
  AddPointField(target, "Upper", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("mask.model"));
  const auto full = SurfaceOf(filter);
  filter->SetMaskArrayName("Upper");
  const auto output = SurfaceOf(filter);
  vtkDataArray* mask = PointArray(output, "Upper");
  vtkDataArray* displacement = PointArray(output, "Displacement");
  int still = 0;
  int moved = 0;
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double* d = displacement->GetTuple3(p);
    const bool bare = mask->GetTuple1(p) == 0.0;
    const bool rests = d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0;
    EXPECT_TRUE(rests || !bare) << p;
    still += rests ? 1 : 0;
    moved += rests ? 0 : 1;
  }
  EXPECT_GT(still, 200);
  EXPECT_GT(moved, 200);
  EXPECT_GT(LargestDifference(full->GetPoints()->GetData(), output->GetPoints()->GetData()), 1e-4);
}

TEST(GeometricTextureFilter, AMaskRisesOverItsFalloff)
{
  const auto target = Icosphere(3).ToPolyData();
  AddPointField(target, "Upper", [](const double* p) { return p[2] > 0.0 ? 1.0 : 0.0; });
  const std::string model = WriteRandomGeometricTexture("falloff.model");
  const auto filter = SynthesizerOn(target, model);
  filter->SetEndLevel(0);
  filter->SetMaskArrayName("Upper");
  const auto sharp = SurfaceOf(filter);
  const double falloff = 0.8;
  filter->SetMaskFalloff(falloff);
  const auto soft = SurfaceOf(filter);
  int between = 0;
  for (vtkIdType p = 0; p < target->GetNumberOfPoints(); ++p)
  {
    const Eigen::Map<const Eigen::Vector3d> a(PointArray(sharp, "Displacement")->GetTuple3(p));
    const double whole = a.norm();
    const Eigen::Map<const Eigen::Vector3d> b(PointArray(soft, "Displacement")->GetTuple3(p));
    const double height = target->GetPoint(p)[2];
    EXPECT_LE(b.norm(), whole * (1.0 + 1e-6));
    if (std::asin(std::clamp(height, -1.0, 1.0)) > falloff + 0.2)
    {
      EXPECT_NEAR(b.norm(), whole, 1e-6 * whole) << "full strength beyond the falloff";
    }
    between += whole > 0.0 && b.norm() < 0.9 * whole ? 1 : 0;
  }
  EXPECT_GT(between, 50);
  AddPointField(target, "Upper", [](const double*) { return 1.0; });
  filter->SetInputDataObject(target);
  const auto everywhere = SurfaceOf(filter);
  filter->SetMaskArrayName("");
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), everywhere->GetPoints()->GetData()))
    << "a mask without zeros has no edge to rise from";
}

// --- Arrays ---------------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, ArraysOfTheTargetAreInterpolated)
{
  const auto target = Icosphere(2).ToPolyData();
  AddPointField(target, "Linear", [](const double* p) { return 1.0 + 2.0 * p[0] - 3.0 * p[1] + p[2]; });
  vtkNew<vtkIntArray> label;
  label->SetName("Label");
  vtkNew<vtkIntArray> cell;
  cell->SetName("Cell");
  vtkNew<vtkFloatArray> normals;
  normals->SetName("Normals");
  normals->SetNumberOfComponents(3);
  for (vtkIdType p = 0; p < target->GetNumberOfPoints(); ++p)
  {
    label->InsertNextValue(static_cast<int>(1000 + p));
    normals->InsertNextTuple(target->GetPoint(p));
  }
  for (vtkIdType f = 0; f < target->GetNumberOfCells(); ++f)
  {
    cell->InsertNextValue(static_cast<int>(f));
  }
  target->GetPointData()->AddArray(label);
  target->GetPointData()->SetNormals(normals);
  target->GetCellData()->AddArray(cell);
  vtkNew<vtkIntArray> field;
  field->SetName("Field");
  field->InsertNextValue(3);
  target->GetFieldData()->AddArray(field);
  const std::uint64_t before = HashOf(target);
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("arrays.model"));
  filter->SetTargetPreparationToSubdivide();
  filter->SetTextureScale(0.5);
  const auto output = SurfaceOf(filter);
  EXPECT_EQ(HashOf(target), before);
  EXPECT_FALSE(output->GetPointData()->GetNormals());
  EXPECT_FALSE(output->GetPointData()->HasArray("Normals"));
  EXPECT_TRUE(output->GetFieldData()->HasArray("Field"));
  const PointMatrix bare = PointsOf(output) - VectorsOf(PointArray(output, "Displacement"));
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    const double expected = 1.0 + 2.0 * bare(p, 0) - 3.0 * bare(p, 1) + bare(p, 2);
    EXPECT_NEAR(PointArray(output, "Linear")->GetTuple1(p), expected, 1e-6);
  }
  for (vtkIdType p = 0; p < target->GetNumberOfPoints(); ++p)
  {
    EXPECT_EQ(PointArray(output, "Label")->GetTuple1(p), 1000 + p);
  }
  vtkDataArray* cells = output->GetCellData()->GetArray("Cell");
  ASSERT_TRUE(cells);
  for (vtkIdType f = 0; f < output->GetNumberOfCells(); ++f)
  {
    EXPECT_EQ(cells->GetTuple1(f), f % target->GetNumberOfCells());
  }
}

TEST(GeometricTextureFilter, PolygonsAndStrayPointsOfEitherPrecision)
{
  Soup quads = Grid(5, 4);
  const auto plain = SurfaceOf(SynthesizerOn(quads.ToPolyData(), WriteRandomGeometricTexture("quads.model")));
  EXPECT_EQ(plain->GetNumberOfPolys(), 4 * 2 * 25);
  Soup strays = quads;
  strays.AddPoint(NAN, 3.0, INFINITY);
  strays.Verts.push_back({ strays.NumberOfPoints() - 1 });
  const auto target = strays.ToPolyData();
  AddPointField(target, "Height", [](const double* p) { return p[2]; });
  const auto output = SurfaceOf(SynthesizerOn(target, "quads.model"));
  EXPECT_TRUE(SameBits(output->GetPoints()->GetData(), plain->GetPoints()->GetData())) << "strays are left out";
  EXPECT_EQ(output->GetNumberOfVerts(), 0);
  const auto single = SurfaceOf(SynthesizerOn(quads.ToPolyData(VTK_FLOAT), "quads.model"));
  EXPECT_EQ(single->GetPoints()->GetDataType(), VTK_FLOAT);
  EXPECT_EQ(plain->GetPoints()->GetDataType(), VTK_DOUBLE);
  EXPECT_LE(LargestDifference(single->GetPoints()->GetData(), plain->GetPoints()->GetData()), 1e-4);
}

TEST(GeometricTextureFilter, NamesOfArraysAreProperties)
{
  const auto filter = SynthesizerOn(Icosphere(0).ToPolyData(), WriteRandomGeometricTexture("names.model"));
  filter->SetDisplacementArrayName("Motion");
  filter->SetLevelArrayName("Born");
  const auto output = SurfaceOf(filter);
  EXPECT_TRUE(output->GetPointData()->HasArray("Motion"));
  EXPECT_TRUE(output->GetPointData()->HasArray("Born"));
}

// --- Blocks ---------------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, BlocksGetTheirOwnNoiseAndABadOneIsLeftEmpty)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  Soup broken = Icosphere(1);
  broken.Polys[3] = { 0, 0, 1 };
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(1, broken.ToPolyData());
  blocks->SetBlock(2, Icosphere(1).ToPolyData());
  const auto filter = SynthesizerOn(blocks, WriteRandomGeometricTexture("blocks.model"));
  for (const bool levels : { false, true })
  {
    filter->SetOutputLevels(levels);
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter));
    ASSERT_THAT(events.Errors, ::testing::SizeIs(1));
    EXPECT_THAT(events.AllErrors(), HasSubstr("Block 2"));
    vtkDataObject* output = filter->GetOutputDataObject(0);
    vtkDataObject* tree = levels ? vtkMultiBlockDataSet::SafeDownCast(output)->GetBlock(1) : output;
    EXPECT_EQ(BlockOf(tree, 1)->GetNumberOfPoints(), 0);
    EXPECT_GT(
      LargestDifference(BlockOf(tree, 0)->GetPoints()->GetData(), BlockOf(tree, 2)->GetPoints()->GetData()), 1e-4);
  }
}

TEST(GeometricTextureFilter, LevelsAreBlocks)
{
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("blocks_of_levels.model"));
  const auto last = SurfaceOf(filter);
  filter->SetEndLevel(0);
  const auto first = SurfaceOf(filter);
  filter->SetEndLevel(-1);
  filter->OutputLevelsOn();
  auto* output = vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter));
  ASSERT_TRUE(output);
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  EXPECT_STREQ(output->GetMetaData(0u)->Get(vtkCompositeDataSet::NAME()), "Level 0");
  EXPECT_STREQ(output->GetMetaData(1u)->Get(vtkCompositeDataSet::NAME()), "Level 1");
  EXPECT_TRUE(SameBits(BlockOf(output, 0)->GetPoints()->GetData(), first->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(BlockOf(output, 1)->GetPoints()->GetData(), last->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(PointArray(BlockOf(output, 1), "Displacement"), PointArray(last, "Displacement")));
  filter->OutputLevelsOff();
  EXPECT_TRUE(OutputOf(filter)->IsA("vtkPolyData")) << "the type follows";
}

TEST(GeometricTextureFilter, LevelsOfBlocksAreTrees)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(2, Icosphere(2).ToPolyData());
  blocks->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "Second");
  const auto filter = SynthesizerOn(blocks, WriteRandomGeometricTexture("trees.model"));
  vtkNew<vtkMultiBlockDataSet> last;
  last->ShallowCopy(OutputOf(filter));
  filter->OutputLevelsOn();
  auto* output = vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter));
  ASSERT_TRUE(output && output->GetNumberOfBlocks() == 2);
  auto* tree = vtkMultiBlockDataSet::SafeDownCast(output->GetBlock(1));
  ASSERT_TRUE(tree && tree->GetNumberOfBlocks() == 3);
  EXPECT_FALSE(tree->GetBlock(1));
  EXPECT_STREQ(tree->GetMetaData(2u)->Get(vtkCompositeDataSet::NAME()), "Second");
  for (const unsigned int k : { 0u, 2u })
  {
    EXPECT_TRUE(SameBits(BlockOf(tree, k)->GetPoints()->GetData(), BlockOf(last, k)->GetPoints()->GetData()));
  }
}

// --- Time -----------------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, TimeSynthesizesLevelByLevel)
{
  const auto target = Icosphere(1).ToPolyData();
  const auto filter = SynthesizerOn(target, WriteRandomGeometricTexture("time.model"));
  const auto end = SurfaceOf(filter);
  filter->SetEndLevel(0);
  const auto first = SurfaceOf(filter);
  filter->SetEndLevel(-1);
  filter->SetAnimationToLevels();
  filter->UpdateInformation();
  vtkInformation* info = filter->GetOutputInformation(0);
  ASSERT_EQ(info->Length(Pipeline::TIME_STEPS()), 3);
  EXPECT_EQ(info->Get(Pipeline::TIME_STEPS())[2], 2.0);
  EXPECT_EQ(info->Get(Pipeline::TIME_RANGE())[1], 2.0);
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), end->GetPoints()->GetData())) << "no time asked for";
  const auto bare = SurfaceOf(filter, 0.0);
  EXPECT_LE(LargestDifference(bare->GetPoints()->GetData(), target->GetPoints()->GetData()), 1e-12);
  const auto one = SurfaceOf(filter, 1.0);
  EXPECT_TRUE(SameBits(one->GetPoints()->GetData(), first->GetPoints()->GetData()));
  EXPECT_EQ(filter->GetOutputDataObject(0)->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()), 1.0);
  const auto quarter = SurfaceOf(filter, 0.25);
  EXPECT_LE(Distance(PointsOf(quarter), 0.75 * PointsOf(bare) + 0.25 * PointsOf(one)), 1e-12);
  const auto later = SurfaceOf(filter, 1.5);
  EXPECT_EQ(later->GetNumberOfPoints(), end->GetNumberOfPoints());
  const auto two = SurfaceOf(filter, 2.0);
  EXPECT_TRUE(SameBits(two->GetPoints()->GetData(), end->GetPoints()->GetData()));
  EXPECT_GT(Distance(PointsOf(later), PointsOf(two)), 1e-5);
  EXPECT_TRUE(SameBits(SurfaceOf(filter, 9.0)->GetPoints()->GetData(), end->GetPoints()->GetData()));
  filter->SetAnimationToNoAnimation();
  filter->UpdateInformation();
  EXPECT_FALSE(filter->GetOutputInformation(0)->Has(Pipeline::TIME_STEPS()));
}

TEST(GeometricTextureFilter, BlocksOfLevelsThatHaveNotBegunAreEmpty)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("growing.model"));
  filter->SetAnimationToLevels();
  filter->OutputLevelsOn();
  OutputOf(filter, 0.5);
  EXPECT_EQ(BlockOf(filter->GetOutputDataObject(0), 0)->GetNumberOfPoints(), 42);
  EXPECT_EQ(BlockOf(filter->GetOutputDataObject(0), 1)->GetNumberOfPoints(), 0);
  OutputOf(filter, 1.5);
  EXPECT_EQ(BlockOf(filter->GetOutputDataObject(0), 1)->GetNumberOfPoints(), 162);
}

TEST(GeometricTextureFilter, TimeLeadsFromSeedToSeed)
{
  const auto filter = SynthesizerOn(Icosphere(1).ToPolyData(), WriteRandomGeometricTexture("seeds.model"));
  filter->SetSeed(3);
  filter->SetSecondSeed(4);
  const auto first = SurfaceOf(filter);
  filter->SetSeed(4);
  const auto second = SurfaceOf(filter);
  filter->SetSeed(3);
  filter->SetInterpolation(0.3);
  const auto between = SurfaceOf(filter);
  filter->SetInterpolation(0.0);
  filter->SetAnimationToSeeds();
  filter->UpdateInformation();
  EXPECT_EQ(filter->GetOutputInformation(0)->Get(Pipeline::TIME_RANGE())[1], 1.0);
  EXPECT_TRUE(SameBits(SurfaceOf(filter, 0.0)->GetPoints()->GetData(), first->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(SurfaceOf(filter, 1.0)->GetPoints()->GetData(), second->GetPoints()->GetData()));
  EXPECT_TRUE(SameBits(SurfaceOf(filter, 0.3)->GetPoints()->GetData(), between->GetPoints()->GetData()));
  EXPECT_GT(LargestDifference(first->GetPoints()->GetData(), between->GetPoints()->GetData()), 1e-5);
}

TEST(GeometricTextureFilter, TheTimeOfAnAnimationIsNoTimeOfTheInput)
{
  vtkNew<TimedBall> source;
  const auto filter = SynthesizerOn(nullptr, WriteRandomGeometricTexture("timed.model"));
  filter->SetInputConnection(source->GetOutputPort());
  filter->SetAnimationToLevels();
  SurfaceOf(filter, 0.5);
  EXPECT_EQ(source->AskedFor, -1.0) << "for no time";
  filter->SetAnimationToNoAnimation();
  SurfaceOf(filter, 6.0);
  EXPECT_EQ(source->AskedFor, 6.0);
  EXPECT_EQ(filter->GetOutputInformation(0)->Length(Pipeline::TIME_STEPS()), 2);
}

// --- The template ---------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, WithoutInputItSynthesizesOnTheTemplate)
{
  const std::string model = WriteRandomGeometricTexture("template.model");
  const auto filter = SynthesizerOn(nullptr, model);
  filter->SetSeed(2);
  const GeometricTextureSampler sampler = PlainSampler(model);
  GeometricTextureRequest request;
  request.Seed = 2;
  for (const int from : { 0, 1, 2 })
  {
    filter->SetRandomFromLevel(from);
    EXPECT_EQ(Distance(PointsOf(SurfaceOf(filter)), sampler.Generate(from, request).Mesh.Points), 0.0) << from;
  }
  const auto reconstruction = SurfaceOf(filter);
  filter->SetRandomFromLevel(1000);
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), reconstruction->GetPoints()->GetData()));
  filter->SetSeed(8);
  EXPECT_TRUE(SameBits(SurfaceOf(filter)->GetPoints()->GetData(), reconstruction->GetPoints()->GetData()))
    << "there is one reconstruction";
  filter->OutputLevelsOn();
  auto* levels = vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter));
  ASSERT_TRUE(levels && levels->GetNumberOfBlocks() == 2);
  EXPECT_EQ(BlockOf(levels, 0)->GetNumberOfPoints(), 12);
  EXPECT_EQ(BlockOf(levels, 1)->GetNumberOfPoints(), 42);
  filter->OutputLevelsOff();
  filter->SetInputDataObject(Icosphere(2).ToPolyData());
  EXPECT_EQ(SurfaceOf(filter)->GetNumberOfPoints(), 642) << "with an input, on it";
}

// --- Properties -----------------------------------------------------------------------------------------------------

TEST(GeometricTextureFilter, PropertiesAreClampedAndModifyOnlyOnChange)
{
  vtkNew<vtkGeometricTextureSynthesizer> filter;
  filter->SetStartLevel(-3);
  EXPECT_EQ(filter->GetStartLevel(), -1) << "automatic";
  filter->SetEndLevel(-3);
  EXPECT_EQ(filter->GetEndLevel(), -1);
  filter->SetInterpolation(2.0);
  EXPECT_EQ(filter->GetInterpolation(), 1.0);
  filter->SetNoiseAmplitude(-5.0);
  EXPECT_EQ(filter->GetNoiseAmplitude(), -1.0);
  filter->SetNumberOfRestarts(-5);
  EXPECT_EQ(filter->GetNumberOfRestarts(), -1);
  filter->SetTextureScale(-1.0);
  EXPECT_EQ(filter->GetTextureScale(), 0.0) << "automatic";
  filter->SetMaskFalloff(-1.0);
  EXPECT_EQ(filter->GetMaskFalloff(), 0.0);
  filter->SetRandomFromLevel(-1);
  EXPECT_EQ(filter->GetRandomFromLevel(), 0);
  filter->SetNormStatistics(9);
  EXPECT_EQ(filter->GetNormStatistics(), vtkGeometricTextureSynthesizer::REFERENCE);
  filter->SetAnimation(9);
  EXPECT_EQ(filter->GetAnimation(), vtkGeometricTextureSynthesizer::SEEDS);
  filter->SetTargetPreparation(9);
  EXPECT_EQ(filter->GetTargetPreparation(), vtkGeometricTextureSynthesizer::REMESH);
  const vtkMTimeType before = filter->GetMTime();
  filter->SetModelFileName(nullptr);
  filter->SetLevelsWithoutNoise("");
  filter->SetMaskArrayName(nullptr);
  filter->SetDisplacementArrayName("Displacement");
  filter->SetLevelArrayName("Level");
  filter->OutputLevelsOff();
  EXPECT_EQ(filter->GetMTime(), before);
}

TEST(GeometricTextureFilter, PrintsEveryProperty)
{
  const auto filter = SynthesizerOn(Icosphere(0).ToPolyData(), WriteRandomGeometricTexture("print.model"));
  OutputOf(filter);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "ModelFileName: print.model", "StartLevel: 0", "EndLevel: -1", "Seed: 0", "SecondSeed: 1",
         "Interpolation: 0", "NoiseAmplitude: -1", "NumberOfRestarts: -1", "NormStatistics: 0",
         "LevelsWithoutNoise: \n", "TargetPreparation: 0", "TextureScale: 1", "MaskArrayName: \n", "MaskFalloff: 0",
         "RandomFromLevel: 0", "OutputLevels: 0", "Animation: 0", "DisplacementArrayName: Displacement",
         "LevelArrayName: Level", "ModelDescription: \"pebbles\": 2 levels of 4 convolutions", "NumberOfModelLoads: 1",
         "NumberOfSyntheses: 1", "NumberOfRemeshings: 0" })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}
