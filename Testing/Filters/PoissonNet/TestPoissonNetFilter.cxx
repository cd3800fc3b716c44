// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkPoissonNetFilter: the numbers of the published implementation, their arrays, and the unchanged input.
#include "PoissonNetPipelines.h"

#include "Fixtures.h"

#include "IO/Weights/SafetensorsFile.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

using namespace surfsynth;
using namespace surfsynthtest;
using surfsynth::test::FindFixture;
using surfsynth::test::FixtureMatrix;
using surfsynth::test::ReadMatrix;
using surfsynth::test::RelativeError;

namespace
{
/// A network and mesh of the published implementation, as a filter: own operators, the model in a file of its own.
struct Published
{
  explicit Published(const std::string& name)
    : File(FindFixture("poissonnet/" + name))
    , Surface(vtkSmartPointer<vtkPolyData>::New())
  {
    WritePoissonNet(name + ".model", ReadPoissonNet(this->File, "weights."));
    const TriangleMesh mesh = surfsynth::test::ReadMesh(this->File);
    Soup soup;
    soup.Points.assign(mesh.Points.data(), mesh.Points.data() + mesh.Points.size());
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      soup.Polys.push_back({ mesh.Triangles(f, 0), mesh.Triangles(f, 1), mesh.Triangles(f, 2) });
    }
    this->Surface = soup.ToPolyData();
    this->Filter = PoissonNetOn(this->Surface, name + ".model");
  }

  void AddPointArray(const char* name, const FixtureMatrix& values)
  {
    vtkNew<vtkDoubleArray> array;
    array->SetName(name);
    array->SetNumberOfComponents(static_cast<int>(values.cols()));
    array->SetNumberOfTuples(values.rows());
    std::copy_n(values.data(), values.size(), array->GetPointer(0));
    this->Surface->GetPointData()->AddArray(array);
  }

  SafetensorsFile File;
  vtkSmartPointer<vtkPolyData> Surface;
  vtkSmartPointer<vtkPoissonNetFilter> Filter;
};

FixtureMatrix ToMatrix(vtkDataArray* array)
{
  FixtureMatrix matrix(array->GetNumberOfTuples(), array->GetNumberOfComponents());
  for (vtkIdType t = 0; t < array->GetNumberOfTuples(); ++t)
  {
    array->GetTuple(t, matrix.row(t).data());
  }
  return matrix;
}

vtkSmartPointer<vtkPolyData> OutputOf(vtkPoissonNetFilter* filter)
{
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_TRUE(events.Errors.empty()) << events.AllErrors();
  return vtkPolyData::SafeDownCast(filter->GetOutputDataObject(0));
}

/// The class of the largest component of each tuple.
void ExpectLabelsOfLargest(vtkDataArray* labels, vtkDataArray* values)
{
  ASSERT_TRUE(labels && values);
  ASSERT_EQ(labels->GetNumberOfTuples(), values->GetNumberOfTuples());
  EXPECT_EQ(labels->GetDataType(), VTK_INT);
  const FixtureMatrix matrix = ToMatrix(values);
  for (vtkIdType t = 0; t < labels->GetNumberOfTuples(); ++t)
  {
    Eigen::Index largest = 0;
    matrix.row(t).maxCoeff(&largest);
    EXPECT_EQ(labels->GetTuple1(t), largest) << t;
  }
}

double MaximumDifference(vtkDataArray* a, vtkDataArray* b) { return (ToMatrix(a) - ToMatrix(b)).cwiseAbs().maxCoeff(); }
} // namespace

// --- Parity: the limits of Testing/Parity for operators of our own. -------------------------------------------------

TEST(PoissonNetFilter, PublishedPositionsWithConditionsAtThePoints)
{
  Published published("random_A_ours_w32");
  published.AddPointArray("Features", ReadMatrix(published.File, "in.extra"));
  published.Filter->SetConditionArrayName("Features");
  const vtkSmartPointer<vtkPolyData> output = OutputOf(published.Filter);
  vtkDataArray* prediction = output->GetPointData()->GetArray("Prediction");
  ASSERT_TRUE(prediction);
  EXPECT_EQ(prediction->GetDataType(), VTK_DOUBLE);
  EXPECT_LE(RelativeError(ToMatrix(prediction), ReadMatrix(published.File, "ref.out")), 3e-5);
  EXPECT_EQ(output->GetPointData()->GetVectors(), output->GetPointData()->GetArray("Displacement"));
  EXPECT_FALSE(output->GetPointData()->HasArray("Label"));
}

TEST(PoissonNetFilter, PublishedClassesOfCells)
{
  Published published("random_C_norm_nomod");
  const vtkSmartPointer<vtkPolyData> output = OutputOf(published.Filter);
  vtkDataArray* prediction = output->GetCellData()->GetArray("Prediction");
  ASSERT_TRUE(prediction);
  EXPECT_EQ(prediction->GetDataType(), VTK_FLOAT);
  EXPECT_LE(RelativeError(ToMatrix(prediction), ReadMatrix(published.File, "ref.out")), 3e-5);
  ExpectLabelsOfLargest(output->GetCellData()->GetArray("Label"), prediction);
  EXPECT_EQ(output->GetCellData()->GetScalars(), output->GetCellData()->GetArray("Label"));
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 0);
}

TEST(PoissonNetFilter, PublishedClassesOfPointsWithSignalAndConditions)
{
  Published published("random_D_vertices");
  published.AddPointArray("Signal", ReadMatrix(published.File, "in.x"));
  published.Filter->SetSignalArrayName("Signal");
  published.Filter->SetNumberOfConditions(3);
  const FixtureMatrix conditions = ReadMatrix(published.File, "in.extra");
  for (int k = 0; k < 3; ++k)
  {
    published.Filter->SetCondition(k, conditions(0, k));
  }
  const vtkSmartPointer<vtkPolyData> output = OutputOf(published.Filter);
  vtkDataArray* prediction = output->GetPointData()->GetArray("Prediction");
  ASSERT_TRUE(prediction);
  EXPECT_LE(RelativeError(ToMatrix(prediction), ReadMatrix(published.File, "ref.out")), 3e-5);
  ExpectLabelsOfLargest(output->GetPointData()->GetArray("Label"), prediction);
}

// --- Where numbers go ----------------------------------------------------------------------------------------------

TEST(PoissonNetFilter, AGlobalHeadGivesFieldDataAndClassNames)
{
  PoissonNetModel model = ReadPoissonNet(
    WriteModel("global.model", SmallOptions(PoissonNetDomain::Global, LastActivation::LogSoftmax)));
  model.Classes = { "ant", "bear", "cat, wild", "dog", "elk" };
  WritePoissonNet("global.model", model);
  const auto filter = PoissonNetOn(UnitAreaSphere(2).ToPolyData(), "global.model");
  vtkFieldData* fields = OutputOf(filter)->GetFieldData();
  vtkDataArray* prediction = fields->GetArray("Prediction");
  ASSERT_TRUE(prediction);
  ASSERT_EQ(prediction->GetNumberOfTuples(), 1);
  EXPECT_NEAR(ToMatrix(prediction).array().exp().sum(), 1.0, 1e-5);
  EXPECT_STREQ(prediction->GetComponentName(2), "cat, wild");
  ExpectLabelsOfLargest(fields->GetArray("Label"), prediction);
  auto* names = vtkStringArray::SafeDownCast(fields->GetAbstractArray("ClassNames"));
  ASSERT_TRUE(names);
  ASSERT_EQ(names->GetNumberOfValues(), 5);
  EXPECT_EQ(names->GetValue(2), "cat, wild");
}

TEST(PoissonNetFilter, FeaturesThatAreNoClassesHaveNoLabels)
{
  const std::string model = WriteModel(
    "features.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  const vtkSmartPointer<vtkPolyData> output = OutputOf(PoissonNetOn(UnitAreaSphere(2).ToPolyData(), model));
  EXPECT_TRUE(output->GetPointData()->HasArray("Prediction"));
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_FALSE(output->GetFieldData()->HasArray("ClassNames"));
}

namespace
{
/// Quads in the plane, wider at the top, so that each is cut from its second to its fourth corner, the shorter
/// diagonal, into triangles of different areas; with a vertex and a line in front.
Soup WideningQuads()
{
  Soup quads = Grid(4, 4);
  quads.Verts = { { 0 } };
  quads.Lines = { { 0, 1 } };
  for (std::size_t k = 0; k < quads.Points.size(); k += 3)
  {
    quads.Points[k] *= 1.0 + 0.3 * quads.Points[k + 1];
  }
  return quads;
}

Soup CutIntoTriangles(const Soup& quads)
{
  Soup triangles;
  triangles.Points = quads.Points;
  for (const auto& quad : quads.Polys)
  {
    triangles.Polys.push_back({ quad[0], quad[1], quad[3] });
    triangles.Polys.push_back({ quad[1], quad[2], quad[3] });
  }
  return triangles;
}

double PlaneArea(const Soup& soup, const std::vector<vtkIdType>& triangle)
{
  const auto at = [&](int corner, int k) { return soup.Points[static_cast<std::size_t>(3 * triangle[corner] + k)]; };
  return 0.5 * ((at(1, 0) - at(0, 0)) * (at(2, 1) - at(0, 1)) - (at(2, 0) - at(0, 0)) * (at(1, 1) - at(0, 1)));
}
} // namespace

TEST(PoissonNetFilter, APolygonGetsTheMeanLogitsOfItsTriangles)
{
  const std::string model = WriteModel(
    "faces.model", SmallOptions(PoissonNetDomain::Faces, LastActivation::LogSoftmax));
  const Soup quads = WideningQuads();
  const Soup triangles = CutIntoTriangles(quads);
  const FixtureMatrix values = ToMatrix(
    OutputOf(PoissonNetOn(triangles.ToPolyData(), model))->GetCellData()->GetArray("Prediction"));
  const vtkSmartPointer<vtkPolyData> output = OutputOf(PoissonNetOn(quads.ToPolyData(), model));
  const FixtureMatrix found = ToMatrix(output->GetCellData()->GetArray("Prediction"));
  vtkDataArray* labels = output->GetCellData()->GetArray("Label");
  ASSERT_EQ(found.rows(), 18);
  for (int cell = 0; cell < 2; ++cell)
  {
    EXPECT_EQ(found.row(cell).norm(), 0.0) << "a vertex or a line";
    EXPECT_EQ(labels->GetTuple1(cell), -1);
  }
  for (Eigen::Index q = 0; q < 16; ++q)
  {
    const double a = PlaneArea(triangles, triangles.Polys[static_cast<std::size_t>(2 * q)]);
    const double b = PlaneArea(triangles, triangles.Polys[static_cast<std::size_t>(2 * q + 1)]);
    EXPECT_GT(b / a, 1.01);
    const Eigen::RowVectorXd mean = (a * values.row(2 * q) + b * values.row(2 * q + 1)) / (a + b);
    const Eigen::RowVectorXd expected = mean.array() - std::log(mean.array().exp().sum());
    EXPECT_LE((found.row(q + 2) - expected).cwiseAbs().maxCoeff(), 1e-5) << q;
    EXPECT_GE(labels->GetTuple1(q + 2), 0);
  }
}

TEST(PoissonNetFilter, StrayPointsChangeNothingAndGetNothing)
{
  const std::string model = WriteModel(
    "stray.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::LogSoftmax));
  const Soup sphere = UnitAreaSphere(2);
  Soup strays = sphere;
  strays.Points.insert(strays.Points.begin(), { std::nan(""), 7.0, 1e300 });
  strays.AddPoint(50.0, 60.0, 70.0);
  for (auto& polygon : strays.Polys)
  {
    for (vtkIdType& id : polygon)
    {
      ++id;
    }
  }
  for (int normalization : { vtkPoissonNetFilter::MODEL, vtkPoissonNetFilter::UNIT_SPHERE })
  {
    const auto plain = PoissonNetOn(sphere.ToPolyData(), model);
    plain->SetInputNormalization(normalization);
    const auto filter = PoissonNetOn(strays.ToPolyData(), model);
    filter->SetInputNormalization(normalization);
    const FixtureMatrix expected = ToMatrix(OutputOf(plain)->GetPointData()->GetArray("Prediction"));
    const vtkSmartPointer<vtkPolyData> output = OutputOf(filter);
    const FixtureMatrix found = ToMatrix(output->GetPointData()->GetArray("Prediction"));
    ASSERT_EQ(found.rows(), expected.rows() + 2);
    EXPECT_EQ(found.middleRows(1, expected.rows()), expected);
    EXPECT_EQ(found.row(0).norm() + found.bottomRows(1).norm(), 0.0);
    EXPECT_EQ(output->GetPointData()->GetArray("Label")->GetTuple1(0), -1);
  }
}

// --- Normalisation -------------------------------------------------------------------------------------------------

// Prediction of a moved and scaled sphere is the prediction moved and scaled.
TEST(PoissonNetFilter, NormalizedPositionsComeBackInTheCoordinatesOfTheInput)
{
  const std::string model = WriteModel("normalised.model", SmallGradientOptions(), 1, InputNormalization::SurfaceArea);
  const Soup sphere = UnitAreaSphere(3);
  Soup moved = sphere;
  for (std::size_t k = 0; k < moved.Points.size(); ++k)
  {
    moved.Points[k] = 50.0 * moved.Points[k] + 7.0;
  }
  for (const int mode :
    { vtkPoissonNetFilter::MODEL, vtkPoissonNetFilter::SURFACE_AREA, vtkPoissonNetFilter::UNIT_SPHERE })
  {
    const auto small = PoissonNetOn(sphere.ToPolyData(), model);
    const auto large = PoissonNetOn(moved.ToPolyData(), model);
    small->SetInputNormalization(mode);
    large->SetInputNormalization(mode);
    vtkPointData* a = OutputOf(small)->GetPointData();
    vtkPointData* b = OutputOf(large)->GetPointData();
    const FixtureMatrix expected = (50.0 * ToMatrix(a->GetArray("Prediction"))).array() + 7.0;
    EXPECT_LE((ToMatrix(b->GetArray("Prediction")) - expected).cwiseAbs().maxCoeff(), 50.0 * 1e-4) << mode;
    const FixtureMatrix displacement = 50.0 * ToMatrix(a->GetArray("Displacement"));
    EXPECT_LE((ToMatrix(b->GetArray("Displacement")) - displacement).cwiseAbs().maxCoeff(), 50.0 * 1e-4) << mode;
    EXPECT_GT(displacement.norm(), 1.0) << "the random network moves points";
  }
}

TEST(PoissonNetFilter, TheDisplacementLeadsToThePredictedShapeWithTheCentroidInPlace)
{
  Soup sphere = UnitAreaSphere(2);
  for (double& coordinate : sphere.Points)
  {
    coordinate += 0.4;
  }
  const auto surface = sphere.ToPolyData();
  const auto filter = PoissonNetOn(surface, WriteModel("displacement.model", SmallGradientOptions()));
  vtkPointData* data = OutputOf(filter)->GetPointData();
  const FixtureMatrix moved = ToMatrix(surface->GetPoints()->GetData()) + ToMatrix(data->GetArray("Displacement"));
  const FixtureMatrix shift = moved - ToMatrix(data->GetArray("Prediction"));
  const Eigen::RowVectorXd first = shift.row(0);
  EXPECT_LE((shift.rowwise() - first).cwiseAbs().maxCoeff(), 1e-12) << "a translation";
  EXPECT_LE((first.array() - 0.4).abs().maxCoeff(), 1e-4) << "of the origin to the centroid of the sphere";
}

// --- Input and output ----------------------------------------------------------------------------------------------

TEST(PoissonNetFilter, FloatAndDoublePointsAgree)
{
  const std::string model = WriteModel(
    "precision.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::Identity));
  const auto single = PoissonNetOn(UnitAreaSphere(2).ToPolyData(VTK_FLOAT), model);
  const auto fine = PoissonNetOn(UnitAreaSphere(2).ToPolyData(VTK_DOUBLE), model);
  vtkDataArray* a = OutputOf(single)->GetPointData()->GetArray("Prediction");
  vtkDataArray* b = OutputOf(fine)->GetPointData()->GetArray("Prediction");
  EXPECT_LE(MaximumDifference(a, b), 1e-4);
}

TEST(PoissonNetFilter, TheInputIsNotModifiedAndItsArraysPassThrough)
{
  const auto surface = UnitAreaSphere(2).ToPolyData();
  vtkNew<vtkDoubleArray> mine;
  mine->SetName("Mine");
  mine->SetNumberOfTuples(surface->GetNumberOfPoints());
  mine->FillValue(2.0);
  surface->GetPointData()->SetScalars(mine);
  const std::uint64_t before = HashOf(surface);
  for (const PoissonNetDomain domain :
    { PoissonNetDomain::Vertices, PoissonNetDomain::Faces, PoissonNetDomain::Global })
  {
    PoissonNetModel model = ReadPoissonNet(
      WriteModel("through.model", SmallOptions(domain, LastActivation::LogSoftmax)));
    model.Classes = { "a", "b", "c", "d", "e" };
    WritePoissonNet("through.model", model);
    const vtkSmartPointer<vtkPolyData> output = OutputOf(PoissonNetOn(surface, "through.model"));
    EXPECT_EQ(output->GetPointData()->GetScalars(), mine) << "active scalars stay";
    EXPECT_EQ(output->GetPoints(), surface->GetPoints());
    EXPECT_EQ(HashOf(surface), before);
    const auto filter = PoissonNetOn(surface, "through.model");
    filter->ActiveResultOn();
    const vtkSmartPointer<vtkPolyData> colored = OutputOf(filter);
    vtkDataArray* found[] = { colored->GetPointData()->GetScalars(), colored->GetCellData()->GetScalars() };
    vtkDataArray* const atPoints = colored->GetPointData()->GetArray("Label");
    vtkDataArray* const none = domain == PoissonNetDomain::Global ? mine.Get() : nullptr;
    EXPECT_EQ(found[0], atPoints ? atPoints : none);
    EXPECT_EQ(found[1], colored->GetCellData()->GetArray("Label"));
    EXPECT_EQ(HashOf(surface), before);
  }
}

TEST(PoissonNetFilter, BlocksAreIndependentAndABadOneIsLeftEmpty)
{
  const std::string model = WriteModel(
    "blocks.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::LogSoftmax));
  Soup two = UnitAreaSphere(1);
  const Soup second = UnitAreaSphere(1);
  for (const auto& polygon : second.Polys)
  {
    two.Polys.push_back({ polygon[0] + 42, polygon[1] + 42, polygon[2] + 42 });
  }
  two.Points.insert(two.Points.end(), second.Points.begin(), second.Points.end());
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, UnitAreaSphere(2).ToPolyData());
  blocks->SetBlock(1, two.ToPolyData());
  blocks->SetBlock(2, UnitAreaSphere(3).ToPolyData());
  const auto filter = PoissonNetOn(blocks, model);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  ASSERT_THAT(events.Errors, ::testing::SizeIs(1));
  EXPECT_THAT(events.AllErrors(),
    ::testing::AllOf(::testing::HasSubstr("Block 2"), ::testing::HasSubstr("2 connected components")));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  for (const unsigned int k : { 0u, 2u })
  {
    auto* block = vtkPolyData::SafeDownCast(output->GetBlock(k));
    const vtkSmartPointer<vtkPolyData> alone = OutputOf(PoissonNetOn(blocks->GetBlock(k), model));
    EXPECT_TRUE(SameBits(block->GetPointData()->GetArray("Prediction"), alone->GetPointData()->GetArray("Prediction")));
  }
  EXPECT_EQ(vtkPolyData::SafeDownCast(output->GetBlock(1))->GetNumberOfPoints(), 0);
}

TEST(PoissonNetFilter, NamesOfArraysAreProperties)
{
  PoissonNetModel model = ReadPoissonNet(
    WriteModel("names.model", SmallOptions(PoissonNetDomain::Vertices, LastActivation::LogSoftmax)));
  model.Classes = { "a", "b", "c", "d", "e" };
  WritePoissonNet("names.model", model);
  const auto filter = PoissonNetOn(UnitAreaSphere(1).ToPolyData(), "names.model");
  filter->SetPredictionArrayName("LogProbability");
  filter->SetLabelArrayName("Part");
  filter->SetClassNamesArrayName("Parts");
  const vtkSmartPointer<vtkPolyData> output = OutputOf(filter);
  EXPECT_TRUE(output->GetPointData()->HasArray("LogProbability"));
  EXPECT_TRUE(output->GetPointData()->HasArray("Part"));
  EXPECT_TRUE(output->GetFieldData()->HasArray("Parts"));
  filter->SetModelFileName(WriteModel("names2.model", SmallGradientOptions()).c_str());
  filter->SetDisplacementArrayName("Motion");
  EXPECT_TRUE(OutputOf(filter)->GetPointData()->HasArray("Motion"));
}

TEST(PoissonNetFilter, ConditionsAreSetOneByOneAndOutOfRangeIsIgnored)
{
  vtkNew<vtkPoissonNetFilter> filter;
  EXPECT_EQ(filter->GetNumberOfConditions(), 0);
  filter->SetNumberOfConditions(2);
  filter->SetCondition(1, 0.25);
  EXPECT_EQ(filter->GetCondition(0), 0.0);
  EXPECT_EQ(filter->GetCondition(1), 0.25);
  const vtkMTimeType before = filter->GetMTime();
  filter->SetCondition(2, 1.0);
  filter->SetCondition(-1, 1.0);
  filter->SetCondition(1, 0.25);
  filter->SetNumberOfConditions(2);
  EXPECT_EQ(filter->GetMTime(), before);
  EXPECT_EQ(filter->GetCondition(2), 0.0);
  filter->SetNumberOfConditions(-3);
  EXPECT_EQ(filter->GetNumberOfConditions(), 0);
  filter->SetInputNormalization(17);
  EXPECT_EQ(filter->GetInputNormalization(), vtkPoissonNetFilter::UNIT_SPHERE);
  filter->SetInputNormalization(-1);
  EXPECT_EQ(filter->GetInputNormalization(), vtkPoissonNetFilter::MODEL);
  filter->SetModelFileName(nullptr);
  EXPECT_STREQ(filter->GetModelFileName(), "");
}

TEST(PoissonNetFilter, FormerNamesOfTheNormalizationWork)
{
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
  vtkNew<vtkPoissonNetFilter> filter;
  filter->SetInputNormalisation(vtkPoissonNetFilter::NONE);
  EXPECT_EQ(filter->GetInputNormalization(), vtkPoissonNetFilter::NONE);
  filter->SetInputNormalisationToUnitSphere();
  EXPECT_EQ(filter->GetInputNormalisation(), vtkPoissonNetFilter::UNIT_SPHERE);
  filter->SetInputNormalisationToSurfaceArea();
  EXPECT_EQ(filter->GetInputNormalization(), vtkPoissonNetFilter::SURFACE_AREA);
  filter->SetInputNormalisationToNone();
  EXPECT_EQ(filter->GetInputNormalization(), vtkPoissonNetFilter::NONE);
  filter->SetInputNormalisationToModel();
  EXPECT_EQ(filter->GetInputNormalization(), vtkPoissonNetFilter::MODEL);
#pragma GCC diagnostic pop
}

TEST(PoissonNetFilter, PrintsEveryProperty)
{
  const auto filter = PoissonNetOn(UnitAreaSphere(1).ToPolyData(), WriteModel("print.model", SmallGradientOptions(2)));
  filter->SetNumberOfConditions(2);
  filter->SetCondition(1, 0.5);
  OutputOf(filter);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "ModelFileName: print.model", "InputNormalization: 0", "Conditions: 0 0.5",
         "ConditionArrayName: \n", "SignalArrayName: \n", "PredictionArrayName: Prediction", "LabelArrayName: Label",
         "ClassNamesArrayName: ClassNames", "DisplacementArrayName: Displacement", "ActiveResult: 0",
         "ModelDescription: positions at the points, 3 channels; 2 blocks, width 16, 3 input channels, 2 conditions",
         "NumberOfModelLoads: 1", "NumberOfFactorizations: 1" })
  {
    EXPECT_THAT(text.str(), ::testing::HasSubstr(line));
  }
}
