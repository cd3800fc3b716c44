// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkFlowMatchingSampler and vtkFlowMatchingDeformer: the numbers of the plain sampler, their arrays, several
// samples, blocks, flow time.
#include "FlowMatchingPipelines.h"

#include "Core/Mesh/UsedPoints.h"
#include "Inference/FlowMatching/FlowMatchingSampler.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
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
#include <sstream>

using namespace surfsynth;
using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::HasSubstr;

namespace
{
constexpr int Steps = 4; // of DeformerOn()

TriangleMesh MeshOf(const Soup& soup)
{
  TriangleMesh mesh;
  mesh.Points = Eigen::Map<const PointMatrix>(soup.Points.data(), soup.NumberOfPoints(), 3);
  mesh.Triangles.resize(static_cast<Eigen::Index>(soup.Polys.size()), 3);
  for (std::size_t f = 0; f < soup.Polys.size(); ++f)
  {
    for (int k = 0; k < 3; ++k)
    {
      mesh.Triangles(static_cast<Eigen::Index>(f), k) = static_cast<Index>(soup.Polys[f][static_cast<std::size_t>(k)]);
    }
  }
  return mesh;
}

/// The plain sampler that a filter should equal.
FlowMatchingSampler PlainSampler(const std::string& model, const Soup& soup)
{
  return FlowMatchingSampler(std::make_shared<const FlowMatchingModel>(ReadFlowMatchingModel(model)), MeshOf(soup));
}

Eigen::MatrixXd MatrixOf(vtkDataArray* array)
{
  Eigen::MatrixXd matrix(array->GetNumberOfTuples(), array->GetNumberOfComponents());
  for (vtkIdType t = 0; t < array->GetNumberOfTuples(); ++t)
  {
    for (int c = 0; c < array->GetNumberOfComponents(); ++c)
    {
      matrix(t, c) = array->GetComponent(t, c);
    }
  }
  return matrix;
}

double LargestDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

double TriangleArea(vtkPolyData* surface, const std::vector<vtkIdType>& ids)
{
  Eigen::Vector3d p[3];
  for (int k = 0; k < 3; ++k)
  {
    surface->GetPoint(ids[static_cast<std::size_t>(k)], p[k].data());
  }
  const Eigen::Vector3d a = p[1] - p[0];
  const Eigen::Vector3d b = p[2] - p[0];
  return 0.5 *
    std::sqrt(std::pow(a.y() * b.z() - a.z() * b.y(), 2) + std::pow(a.z() * b.x() - a.x() * b.z(), 2) +
      std::pow(a.x() * b.y() - a.y() * b.x(), 2));
}

vtkPolyData* BlockOf(vtkDataObject* output, unsigned int k)
{
  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(output);
  EXPECT_TRUE(blocks && k < blocks->GetNumberOfBlocks());
  return vtkPolyData::SafeDownCast(blocks->GetBlock(k));
}

std::string NameOfBlock(vtkDataObject* output, unsigned int k)
{
  return vtkMultiBlockDataSet::SafeDownCast(output)->GetMetaData(k)->Get(vtkCompositeDataSet::NAME());
}

/// A sphere with times of its own, which remembers the time that it was asked for.
class TimedSphere : public vtkPolyDataAlgorithm
{
public:
  static TimedSphere* New();
  vtkTypeMacro(TimedSphere, vtkPolyDataAlgorithm);
  double AskedFor = -1.0;

protected:
  TimedSphere() { this->SetNumberOfInputPorts(0); }
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    const double times[2] = { 5.0, 6.0 };
    output->GetInformationObject(0)->Set(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times, 2);
    output->GetInformationObject(0)->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), times, 2);
    return 1;
  }
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* output) override
  {
    vtkInformation* info = output->GetInformationObject(0);
    const auto key = vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP();
    this->AskedFor = info->Has(key) ? info->Get(key) : -1.0;
    vtkPolyData::GetData(output)->ShallowCopy(Icosphere(1).ToPolyData());
    return 1;
  }
};
vtkStandardNewMacro(TimedSphere);

/// A sphere as quads: pairs of the triangles of a grid on latitude and longitude, closed by triangles at the poles.
Soup QuadSphere(int rings, int sectors)
{
  Soup soup;
  const double pi = std::acos(-1.0);
  for (int r = 1; r < rings; ++r)
  {
    for (int s = 0; s < sectors; ++s)
    {
      const double u = pi * r / rings;
      const double v = 2.0 * pi * s / sectors;
      soup.AddPoint(std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u));
    }
  }
  const vtkIdType north = soup.AddPoint(0, 0, 1);
  const vtkIdType south = soup.AddPoint(0, 0, -1);
  const auto id = [&](int r, int s) { return static_cast<vtkIdType>((r - 1) * sectors + s % sectors); };
  for (int s = 0; s < sectors; ++s)
  {
    soup.Polys.push_back({ north, id(1, s), id(1, s + 1) });
    for (int r = 1; r + 1 < rings; ++r)
    {
      soup.Polys.push_back({ id(r, s), id(r + 1, s), id(r + 1, s + 1), id(r, s + 1) });
    }
    soup.Polys.push_back({ id(rings - 1, s), south, id(rings - 1, s + 1) });
  }
  return soup;
}
} // namespace

// --- The numbers ----------------------------------------------------------------------------------------------------

TEST(FlowMatchingSamplerFilter, SignalAndNoiseAreThoseOfThePlainSampler)
{
  const std::string model = WriteSignalModel("signal.model", 2);
  const Soup sphere = Icosphere(2);
  const auto filter = SamplerOn(sphere.ToPolyData(), model);
  filter->SetSeed(5);
  filter->SetFirstSample(3);
  const auto output = SurfaceOf(filter);
  const FlowMatchingSampler plain = PlainSampler(model, sphere);
  FlowSampleRequest request;
  request.Seed = 5;
  request.Sample = 3;
  request.Steps = Steps;
  const FeatureMatrix noise = plain.InitialNoise(request);
  vtkDataArray* signal = PointArray(output, "Mixture");
  EXPECT_EQ(signal->GetDataType(), VTK_DOUBLE);
  EXPECT_EQ(signal->GetNumberOfComponents(), 2);
  EXPECT_EQ(LargestDifference(MatrixOf(signal), plain.ToSignal(plain.Integrate(noise, request))), 0.0);
  EXPECT_EQ(LargestDifference(MatrixOf(PointArray(output, "InitialNoise")), plain.ToDeviation(noise)), 0.0);
  EXPECT_EQ(output->GetPointData()->GetScalars(), signal);
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 2);
  EXPECT_EQ(output->GetCellData()->GetNumberOfArrays(), 0);
}

TEST(FlowMatchingDeformerFilter, APartGetsTheNormalizationOfItsWhole)
{
  const std::string model = WriteDeformer("part.model");
  Soup part = Icosphere(2);
  const auto isAbove = [&part](const std::vector<vtkIdType>& polygon) {
    return part.Points[3 * static_cast<std::size_t>(polygon[0]) + 2] > 0.3;
  };
  part.Polys.erase(std::remove_if(part.Polys.begin(), part.Polys.end(), isAbove), part.Polys.end());
  const UsedPoints used(MeshOf(part));
  ASSERT_FALSE(used.All());
  const auto filter = DeformerOn(part.ToPolyData(), model);
  filter->MovePointsOff();
  filter->SetNormalizationArea(12.0);
  filter->SetNormalizationCenter(0.05, -0.1, 0.1);
  const auto output = SurfaceOf(filter);
  const TriangleMesh mesh = used.Compact(MeshOf(part));
  const FlowMatchingSampler plain(std::make_shared<const FlowMatchingModel>(ReadFlowMatchingModel(model)), mesh,
    nullptr, {}, {}, FlowNormalization(12.0, { 0.05, -0.1, 0.1 }));
  FlowSampleRequest request;
  request.Steps = Steps;
  const Eigen::MatrixXd expected = plain.ToSignal(plain.Integrate(plain.InitialNoise(request), request)) - mesh.Points;
  const Eigen::MatrixXd found = MatrixOf(PointArray(output, "Displacement"));
  for (Index k = 0; k < used.Count(); ++k)
  {
    EXPECT_EQ((found.row(used.Id(k)) - expected.row(k)).norm(), 0.0) << k;
  }
}

TEST(FlowMatchingSamplerFilter, GivenNoiseIsWhatTheFlowBeginsWith)
{
  const std::string model = WriteSignalModel("given.model", 2);
  const Soup sphere = Icosphere(2);
  const FlowMatchingSampler plain = PlainSampler(model, sphere);
  const auto input = sphere.ToPolyData();
  vtkNew<vtkFloatArray> given;
  given->SetName("Given");
  given->SetNumberOfComponents(2);
  given->SetNumberOfTuples(input->GetNumberOfPoints());
  for (vtkIdType k = 0; k < input->GetNumberOfPoints(); ++k)
  {
    given->SetTuple2(k, std::sin(0.3 * static_cast<double>(k)), 0.5);
  }
  input->GetPointData()->AddArray(given);
  const auto filter = SamplerOn(input, model);
  filter->SetInputNoiseArrayName("Given");
  FlowSampleRequest request;
  request.Steps = Steps;
  const FeatureMatrix noise = plain.FromDeviation(MatrixOf(given));
  EXPECT_LT(LargestDifference(plain.ToDeviation(noise), MatrixOf(given)), 1e-6);
  const Eigen::MatrixXd expected = plain.ToSignal(plain.Integrate(noise, request));
  EXPECT_EQ(LargestDifference(MatrixOf(PointArray(OutputOf(filter), "Mixture")), expected), 0.0);
  filter->SetSeed(77); // has no say
  EXPECT_EQ(LargestDifference(MatrixOf(PointArray(OutputOf(filter), "Mixture")), expected), 0.0);
  given->SetTuple2(5, 2.0, 2.0);
  given->Modified();
  input->Modified();
  EXPECT_GT(LargestDifference(MatrixOf(PointArray(OutputOf(filter), "Mixture")), expected), 1e-3);
  filter->SetInputNoiseArrayName("");
  filter->SetSeed(0);
  const FeatureMatrix seeded = plain.Integrate(plain.InitialNoise(request), request);
  EXPECT_EQ(LargestDifference(MatrixOf(PointArray(OutputOf(filter), "Mixture")), plain.ToSignal(seeded)), 0.0);
}

TEST(FlowMatchingDeformer, TheNoiseOfASampleGivesItAgain)
{
  const auto first = DeformerOn(Icosphere(2).ToPolyData(), WriteDeformer("again.model"));
  first->SetSeed(9);
  first->MovePointsOff();
  const auto sample = SurfaceOf(first);
  ASSERT_GT(sample->GetPointData()->GetArray("InitialNoise")->GetMaxNorm(), 0.01);
  const auto second = DeformerOn(sample, WriteDeformer("again.model"));
  second->SetInputNoiseArrayName("InitialNoise");
  second->SetDisplacementArrayName("Again");
  const auto again = SurfaceOf(second);
  const double size = sample->GetPointData()->GetArray("Displacement")->GetMaxNorm();
  ASSERT_GT(size, 0.01);
  EXPECT_LT(LargestDifference(PointArray(again, "Again"), PointArray(sample, "Displacement")), 1e-5 * size);
}

TEST(FlowMatchingSamplerFilter, IntegratorsAreThoseOfThePlainSampler)
{
  const std::string model = WriteSignalModel("integrators.model", 1);
  const Soup sphere = Icosphere(1);
  const FlowMatchingSampler plain = PlainSampler(model, sphere);
  const auto filter = SamplerOn(sphere.ToPolyData(), model);
  for (int integrator = vtkFlowMatchingSampler::EULER; integrator <= vtkFlowMatchingSampler::RUNGE_KUTTA_4;
       ++integrator)
  {
    filter->SetIntegrator(integrator);
    FlowSampleRequest request;
    request.Steps = Steps;
    request.Integrator = static_cast<FlowIntegrator>(integrator);
    const FeatureMatrix expected = plain.Integrate(plain.InitialNoise(request), request);
    EXPECT_EQ(LargestDifference(MatrixOf(PointArray(OutputOf(filter), "Mixture")), plain.ToSignal(expected)), 0.0)
      << integrator;
  }
}

TEST(FlowMatchingDeformerFilter, CorrectionsAreThoseOfThePlainSamplerAndByDefaultThoseThatSuitTheModel)
{
  const Soup sphere = Icosphere(1);
  for (const bool data : { false, true })
  {
    const std::string model = WriteDeformer(data ? "data.model" : "velocity.model", 1,
      [&](FlowMatchingModel& made) { made.Prediction = data ? FlowPrediction::Data : FlowPrediction::Velocity; });
    const FlowMatchingSampler plain = PlainSampler(model, sphere);
    const auto filter = DeformerOn(sphere.ToPolyData(), model);
    EXPECT_EQ(filter->GetNumberOfCorrections(), -1);
    for (const int corrections : { -1, 0, 3 })
    {
      filter->SetNumberOfCorrections(corrections);
      FlowSampleRequest request;
      request.Steps = Steps;
      request.Corrections = corrections >= 0 ? corrections : data ? 2 : 0;
      const FeatureMatrix expected = plain.Integrate(plain.InitialNoise(request), request);
      EXPECT_LE(LargestDifference(MatrixOf(SurfaceOf(filter)->GetPoints()->GetData()), plain.ToSignal(expected)), 1e-12)
        << data << " " << corrections;
    }
  }
}

TEST(FlowMatchingDeformerFilter, TheTemperatureIsThatOfThePlainSamplerAndNotOfGivenNoise)
{
  const Soup sphere = Icosphere(1);
  const std::string model = WriteDeformer("warm.model");
  const FlowMatchingSampler plain = PlainSampler(model, sphere);
  const auto filter = DeformerOn(sphere.ToPolyData(), model);
  for (const double temperature : { 0.0, 1.3 })
  {
    filter->SetTemperature(temperature);
    FlowSampleRequest request;
    request.Steps = Steps;
    request.Temperature = temperature;
    const FeatureMatrix expected = plain.Integrate(plain.InitialNoise(request), request);
    EXPECT_LE(LargestDifference(MatrixOf(SurfaceOf(filter)->GetPoints()->GetData()), plain.ToSignal(expected)), 1e-12)
      << temperature;
  }
  vtkSmartPointer<vtkPolyData> warm = vtkSmartPointer<vtkPolyData>::New();
  warm->DeepCopy(SurfaceOf(filter));
  const auto again = sphere.ToPolyData();
  again->GetPointData()->AddArray(warm->GetPointData()->GetArray("InitialNoise"));
  const auto given = DeformerOn(again, model);
  given->SetInputNoiseArrayName("InitialNoise");
  given->SetInitialNoiseArrayName("Noise");
  given->SetTemperature(5.0);
  EXPECT_LE(
    LargestDifference(MatrixOf(SurfaceOf(given)->GetPoints()->GetData()), MatrixOf(warm->GetPoints()->GetData())),
    1e-5);
}

TEST(FlowMatchingSamplerFilter, PositionsAreASignalToo)
{
  const std::string model = WriteDeformer("positions.model");
  const auto sphere = Icosphere(2).ToPolyData();
  const auto sampled = SurfaceOf(SamplerOn(sphere, model));
  const auto deformed = SurfaceOf(DeformerOn(sphere, model));
  EXPECT_LE(LargestDifference(PointArray(sampled, "Position"), deformed->GetPoints()->GetData()), 1e-12);
  EXPECT_EQ(sampled->GetPoints(), sphere->GetPoints()) << "the sampler moves nothing";
}

TEST(FlowMatchingDeformerFilter, MovesThePointsByTheDisplacement)
{
  const std::string model = WriteDeformer("moves.model");
  const Soup sphere = Icosphere(2);
  const auto input = sphere.ToPolyData();
  const auto output = SurfaceOf(DeformerOn(input, model));
  const FlowMatchingSampler plain = PlainSampler(model, sphere);
  FlowSampleRequest request;
  request.Steps = Steps;
  const FeatureMatrix noise = plain.InitialNoise(request);
  const Eigen::MatrixXd expected = plain.ToSignal(plain.Integrate(noise, request));
  vtkDataArray* displacement = PointArray(output, "Displacement");
  EXPECT_EQ(displacement->GetDataType(), VTK_DOUBLE);
  EXPECT_EQ(output->GetPointData()->GetVectors(), displacement);
  EXPECT_LE(LargestDifference(MatrixOf(output->GetPoints()->GetData()), expected), 1e-14);
  const Eigen::MatrixXd moved = MatrixOf(input->GetPoints()->GetData()) + MatrixOf(displacement);
  EXPECT_EQ(LargestDifference(MatrixOf(output->GetPoints()->GetData()), moved), 0.0);
  EXPECT_GT(MatrixOf(displacement).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_EQ(LargestDifference(MatrixOf(PointArray(output, "InitialNoise")), plain.ToDeviation(noise)), 0.0);
}

TEST(FlowMatchingDeformerFilter, WithoutMovePointsTheSurfaceStays)
{
  const auto input = Icosphere(2).ToPolyData();
  const auto filter = DeformerOn(input, WriteDeformer("stays.model"));
  const auto moved = SurfaceOf(filter);
  filter->MovePointsOff();
  const auto output = SurfaceOf(filter);
  EXPECT_EQ(output->GetPoints(), input->GetPoints());
  EXPECT_TRUE(SameBits(PointArray(output, "Displacement"), PointArray(moved, "Displacement")));
  EXPECT_TRUE(SameBits(output->GetCellData()->GetArray("AreaRatio"), moved->GetCellData()->GetArray("AreaRatio")));
}

TEST(FlowMatchingDeformerFilter, AreaRatiosAreThoseOfThePolygons)
{
  Soup soup = QuadSphere(8, 12);
  soup.Verts.push_back({ 0 });
  soup.Lines.push_back({ 0, 1 });
  const auto input = soup.ToPolyData();
  const auto output = SurfaceOf(DeformerOn(input, WriteDeformer("areas.model")));
  vtkDataArray* ratios = output->GetCellData()->GetArray("AreaRatio");
  ASSERT_TRUE(ratios);
  ASSERT_EQ(ratios->GetNumberOfTuples(), 2 + static_cast<vtkIdType>(soup.Polys.size()));
  EXPECT_EQ(ratios->GetTuple1(0), 1.0);
  EXPECT_EQ(ratios->GetTuple1(1), 1.0);
  for (std::size_t k = 0; k < soup.Polys.size(); ++k)
  {
    const std::vector<vtkIdType>& ids = soup.Polys[k];
    const double found = ratios->GetTuple1(2 + static_cast<vtkIdType>(k));
    if (ids.size() == 3)
    {
      EXPECT_NEAR(found, TriangleArea(output, ids) / TriangleArea(input, ids), 1e-9);
      continue;
    }
    // A quad may be cut along either diagonal.
    const auto area = [&](vtkPolyData* of, int first) {
      const auto at = [&](int c) { return ids[static_cast<std::size_t>((first + c) % 4)]; };
      return TriangleArea(of, { at(0), at(1), at(2) }) + TriangleArea(of, { at(0), at(2), at(3) });
    };
    const double one = area(output, 0) / area(input, 0);
    const double other = area(output, 1) / area(input, 1);
    EXPECT_TRUE(std::abs(found - one) < 1e-9 || std::abs(found - other) < 1e-9) << found << " " << one << " " << other;
  }
}

TEST(FlowMatchingDeformerFilter, TheCentroidStays)
{
  Soup sphere = Icosphere(3);
  for (double& coordinate : sphere.Points)
  {
    coordinate = 3.0 * coordinate + 50.0;
  }
  const auto output = SurfaceOf(DeformerOn(sphere.ToPolyData(), WriteDeformer("centroid.model")));
  const auto input = sphere.ToPolyData();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (const std::vector<vtkIdType>& ids : sphere.Polys)
  {
    const double area = TriangleArea(input, ids);
    total += area;
    for (const vtkIdType id : ids)
    {
      shift += area / 3.0 * Eigen::Map<const Eigen::Vector3d>(PointArray(output, "Displacement")->GetTuple3(id));
    }
  }
  EXPECT_LE((shift / total).norm(), 1e-5);
}

// --- Input and output -----------------------------------------------------------------------------------------------

TEST(FlowMatchingDeformerFilter, PrecisionOfThePointsStays)
{
  const std::string model = WriteDeformer("precision.model");
  const auto single = SurfaceOf(DeformerOn(Icosphere(2).ToPolyData(VTK_FLOAT), model));
  const auto fine = SurfaceOf(DeformerOn(Icosphere(2).ToPolyData(VTK_DOUBLE), model));
  EXPECT_EQ(single->GetPoints()->GetDataType(), VTK_FLOAT);
  EXPECT_EQ(fine->GetPoints()->GetDataType(), VTK_DOUBLE);
  EXPECT_LE(LargestDifference(single->GetPoints()->GetData(), fine->GetPoints()->GetData()), 1e-4);
}

TEST(FlowMatchingDeformerFilter, TheInputIsNotModifiedAndItsArraysPassThroughButForNormals)
{
  const auto input = Icosphere(2).ToPolyData();
  const auto add = [&](vtkDataSetAttributes* data, const char* name, int components, vtkIdType tuples) {
    vtkNew<vtkFloatArray> array;
    array->SetName(name);
    array->SetNumberOfComponents(components);
    array->SetNumberOfTuples(tuples);
    array->Fill(1.0);
    data->AddArray(array);
  };
  add(input->GetPointData(), "Mine", 1, input->GetNumberOfPoints());
  add(input->GetPointData(), "Directions", 3, input->GetNumberOfPoints());
  add(input->GetPointData(), "Normals", 3, input->GetNumberOfPoints());
  add(input->GetCellData(), "Part", 1, input->GetNumberOfCells());
  add(input->GetCellData(), "FaceNormals", 3, input->GetNumberOfCells());
  input->GetPointData()->SetActiveNormals("Directions");
  input->GetCellData()->SetActiveNormals("FaceNormals");
  input->GetPointData()->SetActiveScalars("Mine");
  const std::uint64_t before = HashOf(input);
  const auto filter = DeformerOn(input, WriteDeformer("through.model"));
  const auto output = SurfaceOf(filter);
  EXPECT_EQ(HashOf(input), before);
  EXPECT_EQ(output->GetPolys(), input->GetPolys());
  EXPECT_EQ(output->GetPointData()->GetArray("Mine"), input->GetPointData()->GetArray("Mine"));
  EXPECT_EQ(output->GetPointData()->GetScalars(), input->GetPointData()->GetArray("Mine"));
  filter->ActiveResultOn();
  const auto colored = SurfaceOf(filter);
  EXPECT_EQ(colored->GetPointData()->GetScalars(), colored->GetPointData()->GetArray("Displacement"));
  EXPECT_EQ(output->GetCellData()->GetArray("Part"), input->GetCellData()->GetArray("Part"));
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 3) << "Mine, Displacement, InitialNoise";
  EXPECT_EQ(output->GetCellData()->GetNumberOfArrays(), 2) << "Part, AreaRatio";
  filter->MovePointsOff();
  EXPECT_TRUE(SurfaceOf(filter)->GetPointData()->GetNormals()) << "of a surface that was not moved they are right";
}

TEST(FlowMatchingDeformerFilter, PointsThatNoPolygonUsesStay)
{
  const std::string model = WriteDeformer("stray.model");
  Soup sphere = Icosphere(2);
  const auto without = SurfaceOf(DeformerOn(sphere.ToPolyData(), model));
  const vtkIdType stray = sphere.AddPoint(7.0, 8.0, 9.0);
  const auto with = SurfaceOf(DeformerOn(sphere.ToPolyData(), model));
  double place[3];
  with->GetPoint(stray, place);
  EXPECT_EQ(place[0], 7.0);
  EXPECT_EQ(place[1], 8.0);
  EXPECT_EQ(place[2], 9.0);
  for (int c = 0; c < 3; ++c)
  {
    EXPECT_EQ(PointArray(with, "Displacement")->GetComponent(stray, c), 0.0);
    EXPECT_EQ(PointArray(with, "InitialNoise")->GetComponent(stray, c), 0.0);
  }
  with->GetPoints()->GetData()->Resize(stray);
  with->GetPoints()->GetData()->SetNumberOfTuples(stray);
  EXPECT_TRUE(SameBits(with->GetPoints()->GetData(), without->GetPoints()->GetData())) << "and do not matter to others";
}

TEST(FlowMatchingDeformerFilter, NamesOfArraysAreProperties)
{
  const auto deformer = DeformerOn(Icosphere(1).ToPolyData(), WriteDeformer("names.model"));
  deformer->SetDisplacementArrayName("Motion");
  deformer->SetInitialNoiseArrayName("Start");
  deformer->SetAreaRatioArrayName("Stretch");
  const auto deformed = SurfaceOf(deformer);
  EXPECT_TRUE(deformed->GetPointData()->HasArray("Motion"));
  EXPECT_TRUE(deformed->GetPointData()->HasArray("Start"));
  EXPECT_TRUE(deformed->GetCellData()->HasArray("Stretch"));
  const auto sampler = SamplerOn(Icosphere(1).ToPolyData(), WriteSignalModel("names2.model"));
  sampler->SetSignalArrayName("Heat");
  EXPECT_TRUE(SurfaceOf(sampler)->GetPointData()->HasArray("Heat"));
}

// --- Samples and blocks ---------------------------------------------------------------------------------------------

TEST(FlowMatchingDeformerFilter, SeveralSamplesAreBlocksThatEqualSingleOnes)
{
  const std::string model = WriteDeformer("samples.model");
  const auto sphere = Icosphere(2).ToPolyData();
  const auto batch = DeformerOn(sphere, model);
  batch->SetFirstSample(4);
  batch->SetNumberOfSamples(3);
  const auto output = OutputOf(batch);
  ASSERT_TRUE(output->IsA("vtkMultiBlockDataSet"));
  ASSERT_EQ(vtkMultiBlockDataSet::SafeDownCast(output)->GetNumberOfBlocks(), 3u);
  for (unsigned int k = 0; k < 3; ++k)
  {
    const auto alone = DeformerOn(sphere, model);
    alone->SetFirstSample(4 + static_cast<int>(k));
    const auto expected = SurfaceOf(alone);
    vtkPolyData* block = BlockOf(output, k);
    EXPECT_EQ(NameOfBlock(output, k), "Sample " + std::to_string(4 + k));
    EXPECT_TRUE(SameBits(block->GetPoints()->GetData(), expected->GetPoints()->GetData()));
    EXPECT_TRUE(SameBits(PointArray(block, "InitialNoise"), PointArray(expected, "InitialNoise")));
    EXPECT_TRUE(SameBits(block->GetCellData()->GetArray("AreaRatio"), expected->GetCellData()->GetArray("AreaRatio")));
    EXPECT_EQ(block->GetPointData()->GetNumberOfArrays(), 2);
  }
  EXPECT_GT(
    LargestDifference(BlockOf(output, 0)->GetPoints()->GetData(), BlockOf(output, 1)->GetPoints()->GetData()), 0.01);
  batch->SetNumberOfSamples(1);
  EXPECT_TRUE(OutputOf(batch)->IsA("vtkPolyData")) << "the type follows the number";
}

TEST(FlowMatchingDeformerFilter, BlocksGetTheirOwnNoiseAndABadOneIsLeftEmpty)
{
  const std::string model = WriteDeformer("blocks.model");
  vtkNew<vtkMultiBlockDataSet> blocks;
  Soup broken = Icosphere(1);
  broken.Polys[3] = { 0, 0, 1 };
  blocks->SetBlock(0, Icosphere(2).ToPolyData());
  blocks->SetBlock(1, broken.ToPolyData());
  blocks->SetBlock(2, Icosphere(2).ToPolyData());
  const auto filter = DeformerOn(blocks, model);
  {
    EventRecorder events(filter);
    EXPECT_TRUE(Update(filter));
    ASSERT_THAT(events.Errors, ::testing::SizeIs(1));
    EXPECT_THAT(events.AllErrors(), HasSubstr("Block 2"));
  }
  vtkDataObject* output = filter->GetOutputDataObject(0);
  EXPECT_EQ(BlockOf(output, 1)->GetNumberOfPoints(), 0);
  EXPECT_GT(
    LargestDifference(PointArray(BlockOf(output, 0), "InitialNoise"), PointArray(BlockOf(output, 2), "InitialNoise")),
    0.001);
}

TEST(FlowMatchingDeformerFilter, SeveralSamplesOfBlocksAreTrees)
{
  const std::string model = WriteDeformer("trees.model");
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(1).ToPolyData());
  blocks->SetBlock(2, Icosphere(2).ToPolyData());
  blocks->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "Second");
  const auto filter = DeformerOn(blocks, model);
  const auto single = OutputOf(filter);
  vtkNew<vtkMultiBlockDataSet> first;
  first->ShallowCopy(single);
  filter->SetNumberOfSamples(2);
  auto* output = vtkMultiBlockDataSet::SafeDownCast(OutputOf(filter));
  ASSERT_TRUE(output);
  ASSERT_EQ(output->GetNumberOfBlocks(), 2u);
  auto* sample = vtkMultiBlockDataSet::SafeDownCast(output->GetBlock(0));
  ASSERT_TRUE(sample && sample->GetNumberOfBlocks() == 3);
  EXPECT_FALSE(sample->GetBlock(1));
  EXPECT_EQ(NameOfBlock(sample, 2), "Second");
  for (const unsigned int k : { 0u, 2u })
  {
    EXPECT_TRUE(SameBits(BlockOf(sample, k)->GetPoints()->GetData(), BlockOf(first, k)->GetPoints()->GetData()));
  }
}

// --- Flow time ------------------------------------------------------------------------------------------------------

TEST(FlowMatchingDeformerFilter, TheTimeOfThePipelineIsFlowTime)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  const std::string model = WriteDeformer("time.model");
  const auto filter = DeformerOn(Icosphere(2).ToPolyData(), model);
  const auto end = SurfaceOf(filter);
  filter->UpdateInformation();
  EXPECT_FALSE(filter->GetOutputInformation(0)->Has(Pipeline::TIME_STEPS()));
  filter->OutputTrajectoryOn();
  filter->UpdateInformation();
  vtkInformation* info = filter->GetOutputInformation(0);
  ASSERT_EQ(info->Length(Pipeline::TIME_STEPS()), Steps + 1);
  for (int k = 0; k <= Steps; ++k)
  {
    EXPECT_EQ(info->Get(Pipeline::TIME_STEPS())[k], 0.25 * k);
  }
  EXPECT_EQ(info->Get(Pipeline::TIME_RANGE())[0], 0.0);
  EXPECT_EQ(info->Get(Pipeline::TIME_RANGE())[1], 1.0);

  const auto untimed = SurfaceOf(filter);
  EXPECT_TRUE(SameBits(untimed->GetPoints()->GetData(), end->GetPoints()->GetData())) << "flow time 1";
  const auto start = SurfaceOf(filter, 0.0);
  EXPECT_EQ(filter->GetOutputDataObject(0)->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()), 0.0);
  EXPECT_LE(LargestDifference(start->GetPoints()->GetData(), PointArray(start, "InitialNoise")), 1e-9)
    << "about the centroid, which is the origin";
  const auto one = SurfaceOf(filter, 0.25);
  const auto two = SurfaceOf(filter, 0.5);
  const auto between = SurfaceOf(filter, 0.3125);
  EXPECT_EQ(filter->GetOutputDataObject(0)->GetInformation()->Get(vtkDataObject::DATA_TIME_STEP()), 0.3125);
  const Eigen::MatrixXd linear = 0.75 * MatrixOf(one->GetPoints()->GetData()) +
    0.25 * MatrixOf(two->GetPoints()->GetData());
  EXPECT_LE(LargestDifference(MatrixOf(between->GetPoints()->GetData()), linear), 1e-6);
  EXPECT_GT(LargestDifference(one->GetPoints()->GetData(), two->GetPoints()->GetData()), 1e-3);
  const auto last = SurfaceOf(filter, 1.0);
  EXPECT_TRUE(SameBits(last->GetPoints()->GetData(), end->GetPoints()->GetData()));
  const auto after = SurfaceOf(filter, 7.0);
  EXPECT_TRUE(SameBits(after->GetPoints()->GetData(), end->GetPoints()->GetData()));

  filter->OutputTrajectoryOff();
  filter->UpdateInformation();
  EXPECT_FALSE(filter->GetOutputInformation(0)->Has(Pipeline::TIME_STEPS()));
  EXPECT_FALSE(filter->GetOutputInformation(0)->Has(Pipeline::TIME_RANGE()));
}

TEST(FlowMatchingDeformerFilter, FlowTimeIsNoTimeOfTheInput)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  vtkNew<TimedSphere> source;
  const auto filter = DeformerOn(nullptr, WriteDeformer("timed.model"));
  filter->SetInputConnection(source->GetOutputPort());
  filter->OutputTrajectoryOn();
  SurfaceOf(filter, 0.5);
  EXPECT_EQ(source->AskedFor, -1.0) << "for no time";
  EXPECT_EQ(filter->GetOutputInformation(0)->Length(Pipeline::TIME_STEPS()), Steps + 1);
  filter->OutputTrajectoryOff();
  SurfaceOf(filter, 6.0);
  EXPECT_EQ(source->AskedFor, 6.0) << "without a trajectory, time is that of the input";
  EXPECT_EQ(filter->GetOutputInformation(0)->Length(Pipeline::TIME_STEPS()), 2);
  filter->OutputTrajectoryOn();
  SurfaceOf(filter, 0.25);
  EXPECT_EQ(source->AskedFor, 6.0) << "what the source holds is taken";
}

TEST(FlowMatchingDeformerFilter, SignalsFlowInTimeToo)
{
  const auto filter = SamplerOn(Icosphere(2).ToPolyData(), WriteSignalModel("flow.model", 2)); // mean 2, 3
  filter->OutputTrajectoryOn();
  const auto start = SurfaceOf(filter, 0.0);
  Eigen::MatrixXd expected = MatrixOf(PointArray(start, "InitialNoise"));
  expected.rowwise() += Eigen::RowVector2d(2.0, 3.0);
  EXPECT_LE(LargestDifference(MatrixOf(PointArray(start, "Mixture")), expected), 1e-12);
}

// --- Properties -----------------------------------------------------------------------------------------------------

TEST(FlowMatchingDeformerFilter, PropertiesAreClampedAndModifyOnlyOnChange)
{
  vtkNew<vtkFlowMatchingDeformer> filter;
  filter->SetNumberOfSteps(0);
  EXPECT_EQ(filter->GetNumberOfSteps(), 1);
  filter->SetNumberOfSteps(20000);
  EXPECT_EQ(filter->GetNumberOfSteps(), 10000);
  filter->SetNumberOfSamples(-1);
  EXPECT_EQ(filter->GetNumberOfSamples(), 1);
  filter->SetFirstSample(-1);
  EXPECT_EQ(filter->GetFirstSample(), 0);
  filter->SetIntegrator(9);
  EXPECT_EQ(filter->GetIntegrator(), vtkFlowMatchingSampler::RUNGE_KUTTA_4);
  filter->SetIntegratorToEuler();
  EXPECT_EQ(filter->GetIntegrator(), vtkFlowMatchingSampler::EULER);
  filter->SetNumberOfCorrections(-7);
  EXPECT_EQ(filter->GetNumberOfCorrections(), -1);
  filter->SetNumberOfCorrections(1000);
  EXPECT_EQ(filter->GetNumberOfCorrections(), 20);
  filter->SetTemperature(-1.0);
  EXPECT_EQ(filter->GetTemperature(), 0.0);
  filter->SetTemperature(1000.0);
  EXPECT_EQ(filter->GetTemperature(), 10.0);
  filter->SetNormalizationArea(-2.0);
  EXPECT_EQ(filter->GetNormalizationArea(), 0.0);
  const vtkMTimeType before = filter->GetMTime();
  filter->SetNormalizationCenter(0.0, 0.0, 0.0);
  filter->SetModelFileName(nullptr);
  filter->SetDisplacementArrayName("Displacement");
  filter->SetAreaRatioArrayName("AreaRatio");
  filter->SetInitialNoiseArrayName("InitialNoise");
  filter->SetSignalArrayName("");
  filter->MovePointsOn();
  EXPECT_EQ(filter->GetMTime(), before);
}

TEST(FlowMatchingDeformerFilter, PrintsEveryProperty)
{
  const auto filter = DeformerOn(Icosphere(1).ToPolyData(), WriteDeformer("print.model"));
  OutputOf(filter);
  std::ostringstream text;
  filter->Print(text);
  for (const char* line :
    { "ModelFileName: print.model", "Seed: 0", "FirstSample: 0", "NumberOfSamples: 1", "NumberOfSteps: 4",
      "Integrator: 1", "NumberOfCorrections: -1", "Temperature: 1", "NormalizationArea: 0",
      "NormalizationCenter: 0 0 0", "OutputTrajectory: 0", "ActiveResult: 0", "SignalArrayName: \n",
      "InitialNoiseArrayName: InitialNoise", "ModelDescription: deformations from matern noise; 2 blocks of width 16",
      "NumberOfModelLoads: 1", "NumberOfFactorizations: 1", "NumberOfEvaluations: 8", "MovePoints: 1",
      "DisplacementArrayName: Displacement", "AreaRatioArrayName: AreaRatio" })
  {
    EXPECT_THAT(text.str(), HasSubstr(line));
  }
}
