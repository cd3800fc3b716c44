// SPDX-License-Identifier: BSD-3-Clause
//
// Output of vtkMaternNoiseFilter for valid inputs.
#include "FilterChecks.h"
#include "FilterContract.h"
#include "VtkSurfaces.h"

#include "vtkMaternNoiseFilter.h"

#include "Core/Noise/MaternField.h"
#include "SurfaceBridge.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

using namespace surfsynthtest;

namespace
{
vtkDataArray* NoiseOf(vtkDataObject* output, const char* name = "MaternNoise")
{
  auto* polyData = vtkPolyData::SafeDownCast(output);
  return polyData ? polyData->GetPointData()->GetArray(name) : nullptr;
}

vtkSmartPointer<vtkMaternNoiseFilter> Filter(vtkDataObject* input, double range = 1.0)
{
  auto filter = vtkSmartPointer<vtkMaternNoiseFilter>::New();
  filter->SetInputDataObject(input);
  filter->SetCorrelationRange(range);
  return filter;
}
} // namespace

TEST(MaternNoiseFilter, IsTheFieldOfTheCore)
{
  const auto sphere = Icosphere(3).ToPolyData();
  const auto filter = Filter(sphere, 0.8);
  filter->SetSeed(7);
  filter->SetNumberOfComponents(2);
  filter->SetStandardDeviation(2.0);
  ASSERT_TRUE(Update(filter));
  surfsynth::MaternFieldOptions options;
  options.CorrelationRange = 0.8;
  const surfsynth::MaternField field(surfsynth::ToSurface(sphere, surfsynth::MeshRequirements()).Mesh, options);
  surfsynth::SampleRequest request;
  request.Seed = 7;
  request.NumberOfComponents = 2;
  const Eigen::MatrixXd expected = field.Sample(request);
  vtkDataArray* noise = NoiseOf(filter->GetOutput());
  ASSERT_TRUE(noise);
  ASSERT_EQ(noise->GetNumberOfTuples(), sphere->GetNumberOfPoints());
  ASSERT_EQ(noise->GetNumberOfComponents(), 2);
  for (vtkIdType p = 0; p < noise->GetNumberOfTuples(); ++p)
  {
    ASSERT_EQ(noise->GetComponent(p, 0), 2.0 * expected(p, 0));
    ASSERT_EQ(noise->GetComponent(p, 1), 2.0 * expected(p, 1));
  }
  EXPECT_NEAR(filter->GetEffectiveScreening(), 8.0 / 0.64, 1e-12);
  EXPECT_NEAR(filter->GetEffectiveCorrelationRange(), 0.8, 1e-12);
  EXPECT_NEAR(filter->GetGamma(), field.Gamma(), 1e-9 * field.Gamma());
}

TEST(MaternNoiseFilter, StandardDeviationIsTheOneAskedForOnAClosedSphere)
{
  // Edges are a twenty-fifth of the range: linear elements with lumped mass add 7 % to the variance at a sixth, 2 % at
  // a twelfth.
  const auto filter = Filter(Icosphere(5).ToPolyData(), 1.0);
  filter->SetNumberOfSamples(400);
  filter->SetStandardDeviation(3.0);
  ASSERT_TRUE(Update(filter));
  double sum = 0.0;
  double count = 0.0;
  for (int k = 0; k < 400; ++k)
  {
    vtkDataArray* noise = NoiseOf(filter->GetOutput(), ("MaternNoise_" + std::to_string(k)).c_str());
    ASSERT_TRUE(noise);
    for (vtkIdType p = 0; p < noise->GetNumberOfTuples(); ++p, count += 1.0)
    {
      sum += noise->GetComponent(p, 0) * noise->GetComponent(p, 0);
    }
  }
  EXPECT_NEAR(sum / count, 9.0, 0.05 * 9.0) << "R13: variance within 5 %";
}

TEST(MaternNoiseFilter, DefaultRangeIsAFifthOfTheLongestSide)
{
  Soup grid = Grid(40);
  for (std::size_t k = 0; k < grid.Points.size(); k += 3)
  {
    grid.Points[k] *= 3.0;
  }
  const auto filter = Filter(grid.ToPolyData(), 0.0);
  ASSERT_TRUE(Update(filter));
  EXPECT_NEAR(filter->GetEffectiveCorrelationRange(), 0.6, 1e-12);
}

TEST(MaternNoiseFilter, ScalingTheMeshLeavesNormalizedNoiseUnchanged)
{
  const Soup sphere = Icosphere(3);
  const auto noiseAtScale = [&](double scale) {
    Soup scaled = sphere;
    for (double& x : scaled.Points)
    {
      x *= scale;
    }
    const auto filter = Filter(scaled.ToPolyData());
    filter->SetScaleModeToNormalizedScreening();
    EXPECT_TRUE(Update(filter));
    return vtkSmartPointer<vtkDataArray>(NoiseOf(filter->GetOutput()));
  };
  const auto one = noiseAtScale(1.0);
  for (const double scale : { 0.1, 2.0 })
  {
    const auto other = noiseAtScale(scale);
    double difference = 0.0;
    double norm = 0.0;
    for (vtkIdType p = 0; p < one->GetNumberOfTuples(); ++p)
    {
      difference += std::pow(other->GetComponent(p, 0) - one->GetComponent(p, 0), 2);
      norm += std::pow(one->GetComponent(p, 0), 2);
    }
    ASSERT_GT(norm, 0.0);
    EXPECT_LT(std::sqrt(difference / norm), 1e-9) << "scale " << scale;
  }
}

TEST(MaternNoiseFilter, EveryModelAndModeHasItsResidualAndFiniteOutput)
{
  const auto sphere = Icosphere(3).ToPolyData();
  for (int model = vtkMaternNoiseFilter::MATERN; model <= vtkMaternNoiseFilter::SPECTRAL; ++model)
  {
    for (int mode = vtkMaternNoiseFilter::CORRELATION_RANGE; mode <= vtkMaternNoiseFilter::NORMALIZED_SCREENING; ++mode)
    {
      const auto filter = Filter(sphere);
      filter->SetNoiseModel(model);
      filter->SetScaleMode(mode);
      filter->SetNumberOfEigenpairs(20);
      EventRecorder events(filter);
      ASSERT_TRUE(Update(filter)) << events.AllErrors();
      double range[2];
      NoiseOf(filter->GetOutput())->GetRange(range);
      EXPECT_TRUE(std::isfinite(range[0]) && std::isfinite(range[1]));
      EXPECT_LT(range[0], range[1]);
      const bool solves = model == vtkMaternNoiseFilter::MATERN || model == vtkMaternNoiseFilter::UNSCREENED;
      EXPECT_LE(filter->GetRelativeResidual(), 1e-10) << "R14";
      EXPECT_EQ(filter->GetRelativeResidual() > 0.0, solves);
      const bool hasTau = model == vtkMaternNoiseFilter::MATERN || model == vtkMaternNoiseFilter::SPECTRAL;
      EXPECT_EQ(filter->GetEffectiveScreening() > 0.0, hasTau);
    }
  }
}

TEST(MaternNoiseFilter, DeviationOnlyScalesTheModelsThatUseIt)
{
  const auto sphere = Icosphere(2).ToPolyData();
  for (int model = vtkMaternNoiseFilter::MATERN; model <= vtkMaternNoiseFilter::SPECTRAL; ++model)
  {
    const auto filter = Filter(sphere);
    filter->SetNoiseModel(model);
    filter->SetNumberOfEigenpairs(20);
    ASSERT_TRUE(Update(filter));
    const vtkSmartPointer<vtkDataArray> one = NoiseOf(filter->GetOutput());
    filter->SetStandardDeviation(4.0);
    ASSERT_TRUE(Update(filter));
    const bool scales = model != vtkMaternNoiseFilter::WHITE && model != vtkMaternNoiseFilter::UNSCREENED;
    for (vtkIdType p = 0; p < one->GetNumberOfTuples(); ++p)
    {
      ASSERT_EQ(NoiseOf(filter->GetOutput())->GetComponent(p, 0), (scales ? 4.0 : 1.0) * one->GetComponent(p, 0));
    }
  }
}

TEST(MaternNoiseFilter, FloatAndDoublePointsAgree)
{
  const Soup sphere = Icosphere(3);
  const auto single = Filter(sphere.ToPolyData(VTK_FLOAT));
  const auto doubles = Filter(sphere.ToPolyData(VTK_DOUBLE));
  ASSERT_TRUE(Update(single));
  ASSERT_TRUE(Update(doubles));
  EXPECT_EQ(single->GetPolyDataOutput()->GetPoints()->GetDataType(), VTK_FLOAT) << "the caller's points are kept";
  vtkDataArray* a = NoiseOf(single->GetOutput());
  vtkDataArray* b = NoiseOf(doubles->GetOutput());
  double range[2];
  b->GetRange(range);
  for (vtkIdType p = 0; p < b->GetNumberOfTuples(); ++p)
  {
    ASSERT_NEAR(a->GetComponent(p, 0), b->GetComponent(p, 0), 1e-5 * (range[1] - range[0]));
  }
}

TEST(MaternNoiseFilter, ArraysAreNamedAfterTheirSamples)
{
  const auto filter = Filter(Icosphere(1).ToPolyData(), 2.0);
  filter->SetOutputArrayName("Bumps");
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(NoiseOf(filter->GetOutput(), "Bumps"));
  filter->SetNumberOfSamples(3);
  filter->SetFirstSample(5);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetPolyDataOutput()->GetPointData()->GetNumberOfArrays(), 3);
  for (const char* name : { "Bumps_5", "Bumps_6", "Bumps_7" })
  {
    EXPECT_TRUE(NoiseOf(filter->GetOutput(), name)) << name;
  }
}

TEST(MaternNoiseFilter, PolygonsAndStripsKeepTheCallersCellsAndArrays)
{
  Soup soup = Grid(6, 4);
  soup.Lines = { { 0, 1, 2 } };
  soup.Verts = { { 3 } };
  const vtkIdType first = soup.NumberOfPoints();
  for (int k = 0; k < 6; ++k)
  {
    soup.AddPoint(3.0 + 0.1 * k, 0.2 * (k % 2), 0.0);
  }
  soup.Strips = { { first, first + 1, first + 2, first + 3, first + 4, first + 5 } };
  const auto input = soup.ToPolyData();
  vtkNew<vtkDoubleArray> material;
  material->SetName("Material");
  material->SetNumberOfTuples(input->GetNumberOfCells());
  material->Fill(3.0);
  input->GetCellData()->AddArray(material);
  const auto filter = Filter(input, 1.0);
  ASSERT_TRUE(Update(filter));
  vtkPolyData* output = filter->GetPolyDataOutput();
  EXPECT_EQ(output->GetVerts(), input->GetVerts());
  EXPECT_EQ(output->GetLines(), input->GetLines());
  EXPECT_EQ(output->GetPolys(), input->GetPolys());
  EXPECT_EQ(output->GetStrips(), input->GetStrips());
  EXPECT_EQ(output->GetPoints(), input->GetPoints());
  EXPECT_EQ(output->GetCellData()->GetArray("Material"), material.Get());
  EXPECT_FALSE(NoiseOf(input)) << "the input is not modified";
  for (vtkIdType p = 0; p < output->GetNumberOfPoints(); ++p)
  {
    EXPECT_NE(NoiseOf(output)->GetComponent(p, 0), 0.0);
  }
}

TEST(MaternNoiseFilter, PointsOfNoPolygonGetZero)
{
  Soup soup = Icosphere(2);
  const vtkIdType free = soup.AddPoint(9, 9, 9);
  const auto filter = Filter(soup.ToPolyData());
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(NoiseOf(filter->GetOutput())->GetComponent(free, 0), 0.0);
}

TEST(MaternNoiseFilter, ActiveScalarsAreOnlySetWhereThereAreNone)
{
  const auto input = Icosphere(1).ToPolyData();
  const auto plain = Filter(input, 2.0);
  ASSERT_TRUE(Update(plain));
  EXPECT_EQ(plain->GetPolyDataOutput()->GetPointData()->GetScalars(), NoiseOf(plain->GetOutput()));
  vtkNew<vtkDoubleArray> pressure;
  pressure->SetName("Pressure");
  pressure->SetNumberOfTuples(input->GetNumberOfPoints());
  pressure->Fill(1.0);
  input->GetPointData()->SetScalars(pressure);
  const auto filter = Filter(input, 2.0);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetPolyDataOutput()->GetPointData()->GetScalars(), pressure.Get());
}

TEST(MaternNoiseFilter, TheActiveResultIsActiveAlsoWhereThereAreScalars)
{
  const auto input = Icosphere(1).ToPolyData();
  vtkNew<vtkDoubleArray> pressure;
  pressure->SetName("Pressure");
  pressure->SetNumberOfTuples(input->GetNumberOfPoints());
  pressure->Fill(1.0);
  input->GetPointData()->SetScalars(pressure);
  const auto filter = Filter(input, 2.0);
  filter->ActiveResultOn();
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetPolyDataOutput()->GetPointData()->GetScalars(), NoiseOf(filter->GetOutput()));
  EXPECT_EQ(input->GetPointData()->GetScalars(), pressure.Get());
}

TEST(MaternNoiseFilter, RefinementDividesEdgesThatAreTooLongForTheRange)
{
  const auto input = Icosphere(0).ToPolyData();
  vtkNew<vtkDoubleArray> height;
  height->SetName("Height");
  for (vtkIdType p = 0; p < input->GetNumberOfPoints(); ++p)
  {
    height->InsertNextValue(input->GetPoint(p)[2]);
  }
  input->GetPointData()->AddArray(height);
  const std::uint64_t before = HashOf(input);
  const auto filter = Filter(input, 0.8);
  {
    EventRecorder events(filter);
    ASSERT_TRUE(Update(filter));
    ASSERT_EQ(events.Warnings.size(), 1u);
    EXPECT_THAT(events.Warnings[0], ::testing::HasSubstr("Switch Refinement on"));
  }
  filter->RefinementOn();
  EventRecorder events(filter);
  ASSERT_TRUE(Update(filter));
  EXPECT_TRUE(events.Warnings.empty());
  vtkPolyData* refined = filter->GetPolyDataOutput();
  EXPECT_GT(refined->GetNumberOfPoints(), 200);
  EXPECT_EQ(HashOf(input), before);
  vtkDataArray* heights = refined->GetPointData()->GetArray("Height");
  ASSERT_EQ(heights->GetNumberOfTuples(), refined->GetNumberOfPoints());
  for (vtkIdType p = 0; p < refined->GetNumberOfPoints(); ++p)
  {
    EXPECT_NEAR(heights->GetTuple1(p), refined->GetPoint(p)[2], 1e-6);
  }
  const vtkTypeInt64 factorizations = filter->GetNumberOfFactorizations();
  filter->SetSeed(5);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(filter->GetNumberOfFactorizations(), factorizations);
}

TEST(MaternNoiseFilter, RefinementLeavesFineMeshesAndOtherScalesAsTheyAre)
{
  const auto fine = Icosphere(3).ToPolyData();
  const auto plain = Filter(fine);
  const auto filter = Filter(fine);
  filter->RefinementOn();
  ASSERT_TRUE(Update(plain) && Update(filter));
  EXPECT_TRUE(SameBits(NoiseOf(plain->GetOutput()), NoiseOf(filter->GetOutput())));
  const auto coarse = Filter(Icosphere(0).ToPolyData());
  coarse->RefinementOn();
  coarse->SetScaleModeToScreening();
  ASSERT_TRUE(Update(coarse));
  EXPECT_EQ(coarse->GetPolyDataOutput()->GetNumberOfPoints(), 12);
}

TEST(MaternNoiseFilter, DefectsAreThoseOfTheMeshBeforeTheRefinement)
{
  Soup soup = Icosphere(0);
  const vtkIdType tip = soup.AddPoint(3.0, 0.0, 0.0);
  soup.Polys.push_back({ soup.Polys[0][0], soup.Polys[0][1], tip }); // a third triangle on an edge
  const auto filter = Filter(soup.ToPolyData(), 0.5);
  filter->RefinementOn();
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  ASSERT_EQ(events.Errors.size(), 1u);
  EXPECT_THAT(events.Errors[0], ::testing::HasSubstr("1 non-manifold edge"));
}

TEST(MaternNoiseFilter, RefinementWorksBlockByBlock)
{
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, Icosphere(3).ToPolyData());
  blocks->SetBlock(2, Icosphere(0).ToPolyData());
  const auto filter = Filter(blocks);
  filter->RefinementOn();
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_EQ(vtkPolyData::SafeDownCast(output->GetBlock(0))->GetNumberOfPoints(), 642);
  EXPECT_EQ(output->GetBlock(1), nullptr);
  EXPECT_GT(vtkPolyData::SafeDownCast(output->GetBlock(2))->GetNumberOfPoints(), 100);
  EXPECT_EQ(vtkPolyData::SafeDownCast(blocks->GetBlock(2))->GetNumberOfPoints(), 12);
}

TEST(MaternNoiseFilter, AnArrayOfTheSameNameIsReplacedInTheOutputOnly)
{
  const auto input = Icosphere(1).ToPolyData();
  vtkNew<vtkDoubleArray> old;
  old->SetName("MaternNoise");
  old->SetNumberOfComponents(3);
  old->SetNumberOfTuples(input->GetNumberOfPoints());
  old->Fill(5.0);
  input->GetPointData()->SetVectors(old);
  const auto filter = Filter(input, 2.0);
  ASSERT_TRUE(Update(filter));
  EXPECT_EQ(NoiseOf(input), old.Get());
  EXPECT_EQ(NoiseOf(filter->GetOutput())->GetNumberOfComponents(), 1);
  EXPECT_EQ(filter->GetPolyDataOutput()->GetPointData()->GetNumberOfArrays(), 1);
}

TEST(MaternNoiseFilter, BlocksDifferAndNullBlocksStayNull)
{
  const auto sphere = Icosphere(2).ToPolyData();
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, sphere);
  blocks->SetBlock(1, nullptr);
  blocks->SetBlock(2, sphere);
  blocks->GetMetaData(2u)->Set(vtkCompositeDataSet::NAME(), "second");
  const auto filter = Filter(blocks);
  ASSERT_TRUE(Update(filter));
  auto* output = vtkMultiBlockDataSet::SafeDownCast(filter->GetOutputDataObject(0));
  ASSERT_TRUE(output);
  ASSERT_EQ(output->GetNumberOfBlocks(), 3u);
  EXPECT_EQ(output->GetBlock(1), nullptr);
  EXPECT_STREQ(output->GetMetaData(2u)->Get(vtkCompositeDataSet::NAME()), "second");
  vtkDataArray* first = NoiseOf(output->GetBlock(0));
  vtkDataArray* second = NoiseOf(output->GetBlock(2));
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(SameBits(first, second));
  double covariance = 0.0;
  double variance = 0.0;
  for (vtkIdType p = 0; p < first->GetNumberOfTuples(); ++p)
  {
    covariance += first->GetComponent(p, 0) * second->GetComponent(p, 0);
    variance += first->GetComponent(p, 0) * first->GetComponent(p, 0);
  }
  EXPECT_LT(std::abs(covariance), 0.8 * variance) << "the blocks' noise is not the same up to rounding";
}

TEST(MaternNoiseFilter, PrintsEveryProperty)
{
  vtkNew<vtkMaternNoiseFilter> filter;
  filter->SetOutputArrayName("Bumps");
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "NoiseModel: 0", "ScaleMode: 0", "CorrelationRange: 0", "StandardDeviation: 1",
         "Screening: 100", "NormalizedScreening: 0.0001", "NumberOfEigenpairs: 256", "Seed: 0", "NumberOfComponents: 1",
         "NumberOfSamples: 1", "FirstSample: 0", "Refinement: 0", "ActiveResult: 0", "OutputArrayName: Bumps",
         "EffectiveScreening: 0", "EffectiveCorrelationRange: 0", "Gamma: 0", "RelativeResidual: 0",
         "NumberOfFactorizations: 0" })
  {
    EXPECT_THAT(text.str(), ::testing::HasSubstr(line));
  }
}

namespace
{
/// R4 for one ranged property: what is set is got, out of range is clamped, the same value again changes nothing.
template <typename Value>
void CheckProperty(vtkMaternNoiseFilter* filter, void (vtkMaternNoiseFilter::*set)(Value),
  Value (vtkMaternNoiseFilter::*get)(), Value value, Value below, Value lowest)
{
  (filter->*set)(value);
  EXPECT_EQ((filter->*get)(), value);
  const vtkMTimeType modified = filter->GetMTime();
  (filter->*set)(value);
  EXPECT_EQ(filter->GetMTime(), modified);
  (filter->*set)(below);
  EXPECT_EQ((filter->*get)(), lowest);
  EXPECT_GT(filter->GetMTime(), modified);
}
} // namespace

TEST(MaternNoiseFilter, PropertiesAreSetGotAndClamped)
{
  using Noise = vtkMaternNoiseFilter;
  vtkNew<Noise> f;
  CheckProperty<int>(f, &Noise::SetNoiseModel, &Noise::GetNoiseModel, Noise::SPECTRAL, -1, Noise::MATERN);
  CheckProperty<int>(f, &Noise::SetScaleMode, &Noise::GetScaleMode, Noise::SCREENING, -1, Noise::CORRELATION_RANGE);
  CheckProperty<double>(f, &Noise::SetCorrelationRange, &Noise::GetCorrelationRange, 2.5, -1.0, 0.0);
  CheckProperty<double>(f, &Noise::SetStandardDeviation, &Noise::GetStandardDeviation, 2.5, -1.0, 0.0);
  CheckProperty<double>(f, &Noise::SetScreening, &Noise::GetScreening, 2.5, 0.0, f->GetScreeningMinValue());
  CheckProperty<double>(
    f, &Noise::SetNormalizedScreening, &Noise::GetNormalizedScreening, 2.5, 0.0, f->GetNormalizedScreeningMinValue());
  CheckProperty<int>(f, &Noise::SetNumberOfEigenpairs, &Noise::GetNumberOfEigenpairs, 12, 0, 1);
  CheckProperty<int>(f, &Noise::SetNumberOfComponents, &Noise::GetNumberOfComponents, 3, 0, 1);
  CheckProperty<int>(f, &Noise::SetNumberOfSamples, &Noise::GetNumberOfSamples, 3, 0, 1);
  CheckProperty<int>(f, &Noise::SetFirstSample, &Noise::GetFirstSample, 3, -1, 0);
  EXPECT_GT(f->GetScreeningMinValue(), 0.0);
  f->SetSeed(-5);
  EXPECT_EQ(f->GetSeed(), -5);
  f->SetOutputArrayName("Bumps");
  EXPECT_STREQ(f->GetOutputArrayName(), "Bumps");
  f->SetNoiseModel(99);
  EXPECT_EQ(f->GetNoiseModel(), static_cast<int>(Noise::SPECTRAL));
  f->SetNoiseModelToWhite();
  EXPECT_EQ(f->GetNoiseModel(), static_cast<int>(Noise::WHITE));
  f->SetScaleModeToNormalizedScreening();
  EXPECT_EQ(f->GetScaleMode(), static_cast<int>(Noise::NORMALIZED_SCREENING));
}

TEST(MaternNoiseFilter, MergesPointsWithTheSameGlobalId)
{
  // Every triangle with points of its own, as pieces that one process has read: the ids say which are the same.
  const auto sphere = Icosphere(3).ToPolyData();
  vtkNew<vtkPolyData> soup;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> triangles;
  vtkNew<vtkIdTypeArray> pointIds;
  vtkNew<vtkIdTypeArray> cellIds;
  pointIds->SetName("PointIds");
  cellIds->SetName("CellIds");
  for (vtkIdType cell = sphere->GetNumberOfCells(); cell-- > 0;)
  {
    vtkNew<vtkIdList> corners;
    sphere->GetCellPoints(cell, corners);
    triangles->InsertNextCell(3);
    for (vtkIdType k = 0; k < 3; ++k)
    {
      triangles->InsertCellPoint(points->InsertNextPoint(sphere->GetPoint(corners->GetId(k))));
      pointIds->InsertNextValue(corners->GetId(k));
    }
    cellIds->InsertNextValue(cell);
  }
  soup->SetPoints(points);
  soup->SetPolys(triangles);
  soup->GetPointData()->SetGlobalIds(pointIds);
  soup->GetCellData()->SetGlobalIds(cellIds);

  const auto whole = Filter(sphere);
  const auto pieces = Filter(soup);
  ASSERT_TRUE(Update(whole));
  ASSERT_TRUE(Update(pieces));
  vtkDataArray* expected = NoiseOf(whole->GetOutput());
  vtkDataArray* found = NoiseOf(pieces->GetOutput());
  ASSERT_TRUE(expected && found);
  ASSERT_EQ(found->GetNumberOfTuples(), soup->GetNumberOfPoints());
  for (vtkIdType k = 0; k < soup->GetNumberOfPoints(); ++k)
  {
    ASSERT_EQ(found->GetTuple1(k), expected->GetTuple1(pointIds->GetValue(k))) << "point " << k;
  }
  EXPECT_TRUE(vtkPolyData::SafeDownCast(pieces->GetOutput())->GetPointData()->GetGlobalIds())
    << "the caller's arrays stay";
}

TEST(MaternNoiseFilter, ComponentsAreIndependentUnlessTheyAreCoupled)
{
  // Two squares at a distance of 0.001.
  Soup sheets = Grid(8);
  const vtkIdType first = sheets.NumberOfPoints();
  for (const auto& polygon : Grid(8).Polys)
  {
    sheets.Polys.push_back({ polygon[0] + first, polygon[1] + first, polygon[2] + first });
  }
  for (vtkIdType p = 0; p < first; ++p)
  {
    const double* point = sheets.Points.data() + 3 * p;
    const double x = point[0], y = point[1];
    sheets.AddPoint(x, y, 0.001);
  }
  const auto filter = Filter(sheets.ToPolyData(), 1.0);
  const auto difference = [&] {
    EXPECT_TRUE(Update(filter));
    double largest = 0.0;
    for (vtkIdType p = 0; p < first; ++p)
    {
      vtkDataArray* noise = NoiseOf(filter->GetOutputDataObject(0));
      largest = std::max(largest, std::abs(noise->GetComponent(p, 0) - noise->GetComponent(p + first, 0)));
    }
    return largest;
  };
  EXPECT_GT(difference(), 0.3);
  filter->ComponentCouplingOn();
  EXPECT_LT(difference(), 1e-3);
  EXPECT_EQ(filter->GetNumberOfFactorizations(), 2);
  filter->SetCouplingDistance(1e-4);
  EXPECT_THAT(ErrorOf(filter), ::testing::HasSubstr("farther than the coupling distance"));
}
