// SPDX-License-Identifier: BSD-3-Clause
// Figure 4 of "Matérn Noise for Triangulation-Agnostic Flow Matching on Meshes" as a table: standard deviations of
// three spectral coefficients over many samples, on three triangulations of one surface, for the library's noise and
// for iid numbers per vertex, beside the expected values 1 / (lambda + tau) and sqrt(phi^T M^2 phi).
//
//   MaternSpectrumTable [samples [file.csv]]
//
// Fails when a sampled value lies more than 5 standard errors from the expected one, when our noise differs by more
// than 15 per cent between triangulations at coefficients 2 and 50, or when iid noise does not differ by at least a
// factor 2.
#include "ExampleMeshes.h"
#include "SpectralSamples.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <vector>

using namespace surfsynth;

namespace
{

constexpr double Tau = 100.0;
/// Counted from 1, so that coefficient 1 is that of the constant.
const std::vector<Index> Numbers = { 2, 50, 500 };

struct Row
{
  Index Points;
  Index Coefficient;
  double Lambda;
  double Matern;
  double MaternExpected;
  double Iid;
  double IidExpected;
};

std::vector<Row> Measure(const test::SpectralSurface& surface, std::uint32_t samples)
{
  SampleRequest request;
  request.Seed = 4;
  request.NumberOfSamples = samples;
  MaternFieldOptions options;
  options.Mode = ScaleMode::Screening;
  options.Screening = Tau;
  const Eigen::MatrixXd matern = test::SpectralCoefficients(MaternField(surface.Mesh, options), surface, request);
  options.Model = NoiseModel::PerVertex;
  const Eigen::MatrixXd iid = test::SpectralCoefficients(MaternField(surface.Mesh, options), surface, request);
  std::vector<Row> rows;
  for (const Index number : Numbers)
  {
    const Index i = number - 1;
    const double root = std::sqrt(static_cast<double>(samples));
    rows.push_back({ surface.Mesh.NumberOfPoints(), number, surface.Pairs.Values[i], matern.row(i).norm() / root,
      1.0 / (surface.Pairs.Values[i] + Tau), iid.row(i).norm() / root,
      (surface.Mass.asDiagonal() * surface.Pairs.Vectors.col(i)).norm() });
  }
  return rows;
}

bool Within(double value, double expected, double relative) { return std::abs(value / expected - 1.0) <= relative; }

/// Prints a line for each broken expectation; returns how many.
int Check(const std::vector<std::vector<Row>>& table, std::uint32_t samples)
{
  int broken = 0;
  const auto require = [&](bool holds, const Row& row, const char* what) {
    if (!holds)
    {
      std::printf("FAILED: coefficient %d on %d vertices: %s\n", row.Coefficient, row.Points, what);
      ++broken;
    }
  };
  // The standard error of a standard deviation over n normal numbers is 1 / sqrt(2 n) of it.
  const double bound = 5.0 / std::sqrt(2.0 * samples);
  for (std::size_t i = 0; i < Numbers.size(); ++i)
  {
    for (const std::vector<Row>& rows : table)
    {
      require(Within(rows[i].Matern, rows[i].MaternExpected, bound), rows[i], "our noise is not as expected");
      require(Within(rows[i].Iid, rows[i].IidExpected, bound), rows[i], "iid noise is not as expected");
    }
    const Row& coarse = table.front()[i];
    const Row& fine = table.back()[i];
    require(
      Numbers[i] > 50 || Within(coarse.Matern, fine.Matern, 0.15), fine, "our noise depends on the triangulation");
    require(coarse.Iid > 2.0 * fine.Iid, fine, "iid noise does not depend on the triangulation");
  }
  return broken;
}

} // namespace

int main(int argc, char* argv[])
try
{
  const auto samples = static_cast<std::uint32_t>(argc > 1 ? std::atoi(argv[1]) : 1000);
  if (samples < 100)
  {
    std::fprintf(stderr, "usage: MaternSpectrumTable [samples, at least 100 [file.csv]]\n");
    return EXIT_FAILURE;
  }
  std::vector<TriangleMesh> meshes = { test::Triangulation(0) };
  const char* full = std::getenv("SURFACE_SYNTHESIS_FULL");
  if (full != nullptr && full[0] == '1')
  {
    meshes.push_back(test::Triangulation(1));
    meshes.push_back(test::Triangulation(2));
  }
  else
  {
    // 500 eigenpairs of the original take minutes; those of these a few seconds.
    meshes.push_back(test::Decimate(test::ScannedSurface(), 5000));
    meshes.push_back(test::Decimate(test::ScannedSurface(), 12000));
  }
  std::vector<std::vector<Row>> table;
  for (const TriangleMesh& mesh : meshes)
  {
    table.push_back(Measure(test::WithEigenpairs("", mesh, Numbers.back()), samples));
  }
  std::printf("Standard deviation of spectral coefficients over %u samples, tau = %g\n", samples, Tau);
  std::printf("%-12s %9s %10s | %11s %11s | %11s %11s\n", "coefficient", "vertices", "lambda", "Matern", "expected",
    "iid", "expected");
  for (std::size_t i = 0; i < Numbers.size(); ++i)
  {
    for (const std::vector<Row>& rows : table)
    {
      const Row& row = rows[i];
      std::printf("%-12d %9d %10.2f | %11.4e %11.4e | %11.4e %11.4e\n", row.Coefficient, row.Points, row.Lambda,
        row.Matern, row.MaternExpected, row.Iid, row.IidExpected);
    }
  }
  if (argc > 2)
  {
    std::ofstream file(argv[2]);
    file.precision(9);
    file << "coefficient,vertices,lambda,matern,matern_expected,iid,iid_expected\n";
    for (const std::vector<Row>& rows : table)
    {
      for (const Row& row : rows)
      {
        file << row.Coefficient << ',' << row.Points << ',' << row.Lambda << ',' << row.Matern << ','
             << row.MaternExpected << ',' << row.Iid << ',' << row.IidExpected << '\n';
      }
    }
    if (!file.flush())
    {
      std::fprintf(stderr, "cannot write %s\n", argv[2]);
      return EXIT_FAILURE;
    }
  }
  return Check(table, samples) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
catch (const std::exception& error)
{
  std::fprintf(stderr, "MaternSpectrumTable: %s\n", error.what());
  return EXIT_FAILURE;
}
