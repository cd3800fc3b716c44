// SPDX-License-Identifier: BSD-3-Clause
#include "Distributed/DistributedSystem.h"

#include "Core/Common/Errors.h"

#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <string>
#include <utility>

namespace surfsynth
{

namespace
{
constexpr double Tolerance = 1e-12;
constexpr int MaximumIterations = 500;
constexpr const char* Prefix = "surfacesynthesis_";

/// PETSc's errors as return values while it lives, instead of lines on the error stream.
class QuietErrors
{
public:
  QuietErrors() { PetscPushErrorHandler(PetscReturnErrorHandler, nullptr); }
  ~QuietErrors() { PetscPopErrorHandler(); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;
};

void Require(PetscErrorCode code)
{
  if (code != 0)
  {
    const char* text = nullptr;
    PetscErrorMessage(code, &text, nullptr);
    throw SolverFailure("DistributedSystem: PETSc reports error " + std::to_string(code) + " (" +
      (text ? text : "without a text") + "); expected none.");
  }
}

/// Initializes PETSc once for the process. It belongs to this process alone, so that ranks need not do so together.
void InitializePetsc()
{
  PetscBool initialized = PETSC_FALSE;
  Require(PetscInitialized(&initialized));
  if (!initialized)
  {
    PETSC_COMM_WORLD = MPI_COMM_SELF;
    Require(PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"));
    Require(PetscOptionsSetValue(nullptr, "-skip_petscrc", "true"));
    Require(PetscInitializeNoArguments());
  }
  // Coarsening and interpolation of low complexity: two thirds of the memory of the default ones [DeSterck2006].
  const std::pair<const char*, const char*> options[] = { { "coarsen_type", "HMIS" }, { "interp_type", "ext+i" },
    { "P_max", "4" }, { "strong_threshold", "0.25" } };
  for (const auto& option : options)
  {
    const std::string name = std::string("-") + Prefix + "pc_hypre_boomeramg_" + option.first;
    Require(PetscOptionsSetValue(nullptr, name.c_str(), option.second));
  }
}

/// What the test of convergence needs to know.
struct SolveState
{
  MPI_Comm Communicator;
  const Progress* Report;
  double First = 0.0;
  bool Stopped = false;      ///< on some rank
  std::exception_ptr Thrown; ///< by the report of this rank
};

/// Reports the digits gained, and returns whether to go on.
bool ReportDigits(SolveState& state, double norm)
{
  const double digits = norm > 0.0 && state.First > 0.0 ? std::log(state.First / norm) / -std::log(Tolerance) : 1.0;
  try
  {
    return !*state.Report || (*state.Report)(std::clamp(digits, 0.0, 1.0));
  }
  catch (...)
  {
    state.Thrown = std::current_exception();
    return false;
  }
}

PetscErrorCode TestConvergence(KSP, PetscInt iteration, PetscReal norm, KSPConvergedReason* reason, void* context)
{
  auto& state = *static_cast<SolveState*>(context);
  state.First = iteration == 0 ? norm : state.First;
  int stops = ReportDigits(state, norm) ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &stops, 1, MPI_INT, MPI_MAX, state.Communicator);
  state.Stopped = stops != 0;
  *reason = KSP_CONVERGED_ITERATING;
  if (state.Stopped)
  {
    *reason = KSP_DIVERGED_BREAKDOWN;
  }
  else if (!std::isfinite(norm))
  {
    *reason = KSP_DIVERGED_NANORINF;
  }
  else if (norm <= Tolerance * state.First)
  {
    *reason = KSP_CONVERGED_RTOL;
  }
  return 0;
}
} // namespace

class DistributedSystem::Internals
{
public:
  explicit Internals(const RankGroup& ranks)
    : Ranks(ranks)
    , Communicator(*static_cast<const MPI_Comm*>(ranks.Communicator()))
  {}

  ~Internals()
  {
    PetscBool finalized = PETSC_FALSE;
    int ended = 0;
    PetscFinalized(&finalized);
    MPI_Finalized(&ended);
    if (!finalized && !ended)
    {
      KSPDestroy(&this->Solver);
      VecDestroy(&this->RightHandSide);
      VecDestroy(&this->Solution);
      MatDestroy(&this->Matrix);
    }
  }

  void Build(DistributedRows rows)
  {
    const QuietErrors quiet;
    const auto own = static_cast<PetscInt>(rows.Starts.size()) - 1;
    const auto total = static_cast<PetscInt>(rows.NumberOfRows);
    Require(MatCreateMPIAIJWithArrays(this->Communicator, own, own, total, total, rows.Starts.data(),
      rows.Columns.data(), rows.Values.data(), &this->Matrix));
    rows = {}; // PETSc has copied them
    Require(MatSetOption(this->Matrix, MAT_SPD, PETSC_TRUE));
    Require(MatCreateVecs(this->Matrix, &this->Solution, &this->RightHandSide));
    Require(KSPCreate(this->Communicator, &this->Solver));
    Require(KSPSetOptionsPrefix(this->Solver, Prefix));
    Require(KSPSetOperators(this->Solver, this->Matrix, this->Matrix));
    Require(KSPSetType(this->Solver, KSPCG));
    Require(KSPSetNormType(this->Solver, KSP_NORM_UNPRECONDITIONED));
    Require(KSPSetTolerances(this->Solver, Tolerance, 0.0, std::numeric_limits<double>::max(), MaximumIterations));
    PC multigrid = nullptr;
    Require(KSPGetPC(this->Solver, &multigrid));
    Require(PCSetType(multigrid, PCHYPRE));
    Require(PCHYPRESetType(multigrid, "boomeramg"));
    Require(KSPSetFromOptions(this->Solver));
    Require(KSPSetUp(this->Solver));
  }

  double Solve(Eigen::VectorXd& values, const Progress& progress)
  {
    const QuietErrors quiet;
    SolveState state{ this->Communicator, &progress, 0.0, false, nullptr };
    Require(KSPSetConvergenceTest(this->Solver, TestConvergence, &state, nullptr));
    this->Write(values);
    Require(KSPSolve(this->Solver, this->RightHandSide, this->Solution));
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    PetscInt iterations = 0;
    Require(KSPGetConvergedReason(this->Solver, &reason));
    Require(KSPGetIterationNumber(this->Solver, &iterations));
    if (state.Thrown)
    {
      std::rethrow_exception(state.Thrown);
    }
    if (state.Stopped)
    {
      throw Cancelled("Stopped on request.");
    }
    if (reason < 0)
    {
      throw SolverFailure("DistributedSystem: conjugate gradients end after " + std::to_string(iterations) +
        " iterations without a solution (PETSc's reason " + std::to_string(reason) +
        "); expected a relative residual of 1e-12. Needle triangles, or a screening term that is tiny for the size of "
        "the "
        "mesh, make the equations ill-conditioned: remesh, or use a smaller correlation range.");
    }
    this->MostIterations = std::max(this->MostIterations, static_cast<int>(iterations));
    return this->Read(values);
  }

  RankGroup Ranks; ///< keeps the communicator
  int MostIterations = 0;

private:
  void Write(const Eigen::VectorXd& values)
  {
    double* entries = nullptr;
    Require(VecGetArray(this->RightHandSide, &entries));
    std::copy(values.begin(), values.end(), entries);
    Require(VecRestoreArray(this->RightHandSide, &entries));
  }

  /// Takes the solution, and returns its relative residual.
  double Read(Eigen::VectorXd& values)
  {
    const double* entries = nullptr;
    Require(VecGetArrayRead(this->Solution, &entries));
    std::copy(entries, entries + values.size(), values.begin());
    Require(VecRestoreArrayRead(this->Solution, &entries));
    double size = 0.0;
    double rest = 0.0;
    Require(VecNorm(this->RightHandSide, NORM_2, &size));
    Vec residual = nullptr;
    Require(VecDuplicate(this->RightHandSide, &residual));
    Require(MatMult(this->Matrix, this->Solution, residual));
    Require(VecAXPY(residual, -1.0, this->RightHandSide));
    Require(VecNorm(residual, NORM_2, &rest));
    Require(VecDestroy(&residual));
    return size > 0.0 ? rest / size : 0.0;
  }

  MPI_Comm Communicator;
  Mat Matrix = nullptr;
  Vec RightHandSide = nullptr;
  Vec Solution = nullptr;
  KSP Solver = nullptr;
};

DistributedSystem::DistributedSystem(const RankGroup& ranks, DistributedRows rows)
  : Impl(std::make_unique<Internals>(ranks))
{
  if (rows.NumberOfRows > std::numeric_limits<PetscInt>::max())
  {
    throw InvalidInput("DistributedSystem: there are " + std::to_string(rows.NumberOfRows) +
      " rows; expected at most " + std::to_string(std::numeric_limits<PetscInt>::max()) + ", which this PETSc counts.");
  }
  InitializePetsc();
  this->Impl->Build(std::move(rows));
}

DistributedSystem::~DistributedSystem() = default;

double DistributedSystem::SolveInPlace(Eigen::VectorXd& values, const Progress& progress)
{
  return this->Impl->Solve(values, progress);
}

int DistributedSystem::Iterations() const { return this->Impl->MostIterations; }

} // namespace surfsynth
