// SPDX-License-Identifier: BSD-3-Clause
// The same work done plainly with well-kept libraries, and what the machine can do, so that ratios can be reported.
#include "BenchmarkMeshes.h"

#include <Eigen/Geometry>

#ifdef SURFACE_SYNTHESIS_CHOLMOD
#include <cholmod.h>

extern "C" void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
  const double* alpha, const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c,
  const int* ldc);
#endif

namespace surfsynth::bench
{
namespace
{

/// Mass and stiffness through a list of triplets, as most programs assemble them with Eigen.
void ReferenceEigenTriplets(benchmark::State& state, const TriangleMesh& mesh)
{
  for ([[maybe_unused]] auto step : state)
  {
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.NumberOfPoints());
    std::vector<Eigen::Triplet<double, Index>> triplets;
    triplets.reserve(static_cast<std::size_t>(mesh.NumberOfTriangles()) * 12);
    for (Index f = 0; f < mesh.NumberOfTriangles(); ++f)
    {
      for (int c = 0; c < 3; ++c)
      {
        const Index at = mesh.Triangles(f, c);
        const Index i = mesh.Triangles(f, (c + 1) % 3);
        const Index j = mesh.Triangles(f, (c + 2) % 3);
        const Eigen::Vector3d a = mesh.Points.row(i) - mesh.Points.row(at);
        const Eigen::Vector3d b = mesh.Points.row(j) - mesh.Points.row(at);
        const double doubleArea = a.cross(b).norm();
        const double weight = 0.5 * a.dot(b) / doubleArea;
        mass[at] += doubleArea / 6.0;
        triplets.emplace_back(i, j, -weight);
        triplets.emplace_back(j, i, -weight);
        triplets.emplace_back(i, i, weight);
        triplets.emplace_back(j, j, weight);
      }
    }
    SparseMatrix stiffness(mesh.NumberOfPoints(), mesh.NumberOfPoints());
    stiffness.setFromTriplets(triplets.begin(), triplets.end());
    benchmark::DoNotOptimize(mass.data());
    benchmark::DoNotOptimize(stiffness.valuePtr());
  }
}

#ifdef SURFACE_SYNTHESIS_CHOLMOD
/// CHOLMOD with its own defaults.
class Cholmod
{
public:
  explicit Cholmod(SparseMatrix matrix)
    : Matrix(std::move(matrix))
  {
    cholmod_start(&this->Common);
    this->View.nrow = this->View.ncol = static_cast<std::size_t>(this->Matrix.rows());
    this->View.nzmax = static_cast<std::size_t>(this->Matrix.nonZeros());
    this->View.p = this->Matrix.outerIndexPtr();
    this->View.i = this->Matrix.innerIndexPtr();
    this->View.x = this->Matrix.valuePtr();
    this->View.stype = -1;
    this->View.itype = CHOLMOD_INT;
    this->View.xtype = CHOLMOD_REAL;
    this->View.dtype = CHOLMOD_DOUBLE;
    this->View.sorted = this->View.packed = 1;
  }
  ~Cholmod()
  {
    cholmod_free_factor(&this->Factor, &this->Common);
    cholmod_finish(&this->Common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  bool Factorize()
  {
    cholmod_free_factor(&this->Factor, &this->Common);
    this->Factor = cholmod_analyze(&this->View, &this->Common);
    return cholmod_factorize(&this->View, this->Factor, &this->Common) != 0;
  }
  void Solve(std::size_t columns)
  {
    cholmod_dense* sides = cholmod_ones(this->View.nrow, columns, CHOLMOD_REAL, &this->Common);
    cholmod_dense* solutions = cholmod_solve(CHOLMOD_A, this->Factor, sides, &this->Common);
    benchmark::DoNotOptimize(solutions->x);
    cholmod_free_dense(&solutions, &this->Common);
    cholmod_free_dense(&sides, &this->Common);
  }

private:
  SparseMatrix Matrix;
  cholmod_common Common{};
  cholmod_sparse View{};
  cholmod_factor* Factor = nullptr;
};

void CholmodFactorization(benchmark::State& state, const SparseMatrix& matrix)
{
  Cholmod solver(matrix);
  for ([[maybe_unused]] auto step : state)
  {
    if (!solver.Factorize())
    {
      state.SkipWithError("CHOLMOD failed");
    }
  }
}

template <std::size_t Columns>
void CholmodSolve(benchmark::State& state, const SparseMatrix& matrix)
{
  Cholmod solver(matrix);
  if (!solver.Factorize())
  {
    state.SkipWithError("CHOLMOD failed");
  }
  for ([[maybe_unused]] auto step : state)
  {
    solver.Solve(Columns);
  }
}

/// The benchmark of a matrix for that of a surface.
Body OnSurface(const MatrixBody& body)
{
  return [body](benchmark::State& state, const TriangleMesh& mesh) { body(state, ScreenedLaplacian(mesh)); };
}
#endif

void MachineMatrixProduct(benchmark::State& state, int threads)
{
  const Threads limit(threads);
  const int n = 1536;
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(n, n);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(n, n);
  Eigen::MatrixXd c(n, n);
  for ([[maybe_unused]] auto step : state)
  {
#ifdef SURFACE_SYNTHESIS_CHOLMOD
    const double one = 1.0;
    const double zero = 0.0;
    dgemm_("N", "N", &n, &n, &n, &one, a.data(), &n, b.data(), &n, &zero, c.data(), &n);
#else
    c.noalias() = a * b;
#endif
    benchmark::DoNotOptimize(c.data());
  }
  state.counters["FLOP"] = benchmark::Counter(
    2.0 * n * n * n, benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
}

/// a = b + s c over arrays that no cache holds; counts the three streams.
void MachineTriad(benchmark::State& state, int threads)
{
  const Threads limit(threads);
  const std::int64_t count = std::int64_t(16) << 20;
  std::vector<double> a(static_cast<std::size_t>(count), 1.0);
  const std::vector<double> b(a.size(), 2.0);
  const std::vector<double> c(a.size(), 3.0);
  for ([[maybe_unused]] auto step : state)
  {
    ParallelFor(count, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
      double* to = a.data();
      const double* from = b.data();
      const double* other = c.data();
      for (std::int64_t i = begin; i < end; ++i)
      {
        to[i] = from[i] + 0.5 * other[i];
      }
    });
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * count * 24);
}

} // namespace

void RegisterReferences()
{
  Register("ReferenceEigenTriplets", ReferenceEigenTriplets);
#ifdef SURFACE_SYNTHESIS_CHOLMOD
  Register("ReferenceCholmodFactorization", OnSurface(CholmodFactorization));
  Register("ReferenceCholmodSolve1", OnSurface(CholmodSolve<1>));
  Register("ReferenceCholmodSolve100", OnSurface(CholmodSolve<100>));
  Register("ReferenceCholmodSolve128", OnSurface(CholmodSolve<128>));
  RegisterVolume("ReferenceCholmodVolumeFactorization", CholmodFactorization);
  RegisterVolume("ReferenceCholmodVolumeSolve100", CholmodSolve<100>);
#endif
  for (const int threads : { 1, 2 })
  {
    const std::string suffix = "/threads:" + std::to_string(threads);
    benchmark::RegisterBenchmark(("MachineMatrixProduct" + suffix).c_str(),
      [threads](benchmark::State& state) { MachineMatrixProduct(state, threads); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
    benchmark::RegisterBenchmark(
      ("MachineTriad" + suffix).c_str(), [threads](benchmark::State& state) { MachineTriad(state, threads); })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  }
}

} // namespace surfsynth::bench
