// SPDX-License-Identifier: BSD-3-Clause
//
// Memory and seconds of each rank for a Matérn field on a torus that lies distributed over ranks, of which each makes its
// part only:
//
//   mpiexec -n <ranks> SurfaceSynthesisRankMemory [<points along> <points around>]
//
// Prints one line, with the largest peak of resident memory of a rank above that before the mesh was made.
#include "Core/Common/Errors.h"
#include "Distributed/DistributedMaternField.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

using namespace surfsynth;

namespace
{
/// A line of /proc/self/status, MiB.
double MemoryOf(const std::string& name)
{
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
  {
    if (word == name)
    {
      double kibibytes = 0.0;
      status >> kibibytes;
      return kibibytes / 1024.0;
    }
  }
  return 0.0;
}

double Now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// The rows of quadrilaterals, as two triangles each, that a rank holds of a torus with waves.
MeshPiece PieceOfTorus(std::int64_t along, std::int64_t around, int rank, int count)
{
  const std::int64_t first = along * rank / count;
  const std::int64_t rows = along * (rank + 1) / count - first;
  const double turn = 2.0 * std::acos(-1.0);
  MeshPiece piece;
  piece.Mesh.Points.resize((rows + 1) * around, 3);
  for (std::int64_t i = 0; i <= rows; ++i)
  {
    const std::int64_t row = (first + i) % along;
    const double u = turn * static_cast<double>(row) / static_cast<double>(along);
    for (std::int64_t j = 0; j < around; ++j)
    {
      const double v = turn * static_cast<double>(j) / static_cast<double>(around);
      const double radius = 0.2 + 0.02 * std::cos(5.0 * u) * std::sin(3.0 * v);
      const double distance = 1.0 + radius * std::cos(v);
      piece.Mesh.Points.row(i * around + j) << distance * std::cos(u), distance * std::sin(u), radius * std::sin(v);
      piece.GlobalIds.push_back(row * around + j);
    }
  }
  piece.Mesh.Triangles.resize(2 * rows * around, 3);
  for (std::int64_t i = 0; i < rows; ++i)
  {
    for (std::int64_t j = 0; j < around; ++j)
    {
      const auto a = static_cast<Index>(i * around + j);
      const auto b = static_cast<Index>(i * around + (j + 1) % around);
      const auto c = static_cast<Index>(a + around);
      const auto d = static_cast<Index>(b + around);
      piece.Mesh.Triangles.row(2 * (i * around + j)) << a, c, b;
      piece.Mesh.Triangles.row(2 * (i * around + j) + 1) << b, c, d;
    }
  }
  return piece;
}
} // namespace

int main(int argc, char** argv)
{
  const std::int64_t along = argc > 2 ? std::atoll(argv[1]) : 2450;
  const std::int64_t around = argc > 2 ? std::atoll(argv[2]) : 245;
  try
  {
    const RankGroup ranks = RankGroup::World();
    const double before = MemoryOf("VmRSS:");
    const MeshPiece piece = PieceOfTorus(along, around, ranks.Rank(), ranks.Count());
    const double start = Now();
    DistributedMaternField field(ranks, piece, MaternFieldOptions());
    const double built = Now();
    std::vector<double> values(piece.GlobalIds.size());
    field.SampleInto(SampleRequest(), [&](std::uint32_t) { return values.data(); });
    const double drawn = Now();
    const double peak = ranks.Maximum(MemoryOf("VmHWM:") - before);
    if (ranks.Rank() == 0)
    {
      std::printf("%lld points, %d ranks: %.0f MiB a rank, set up in %.2f s, sample in %.2f s, %d iterations\n",
        static_cast<long long>(field.NumberOfPoints()), ranks.Count(), peak, built - start, drawn - built,
        field.Iterations());
    }
  }
  catch (const Error& error)
  {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
