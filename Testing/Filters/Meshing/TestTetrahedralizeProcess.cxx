// SPDX-License-Identifier: BSD-3-Clause
//
// Failures of the process of TetGen, with the message of each, R9, R10, and no process left behind.
#include "FilterContract.h"
#include "TetrahedraChecks.h"

#include <vtkDataObject.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dirent.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <thread>

using namespace surfsynthtest;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Tetrahedralize = vtkTetrahedralizeFilter;

namespace
{
const double AbortLimit = IsSanitized() ? 5.0 : 1.0;

/// An environment variable for the time of a test.
class Variable
{
public:
  Variable(const char* name, const std::string& value)
    : Name(name)
  {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { unsetenv(this->Name); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

private:
  const char* Name;
};

bool HasChildren() { return !(waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD); }

int OpenDescriptors()
{
  int count = 0;
  DIR* folder = opendir("/proc/self/fd");
  while (readdir(folder))
  {
    ++count;
  }
  closedir(folder);
  return count;
}

vtkSmartPointer<Tetrahedralize> FilterOn(vtkDataObject* surface)
{
  auto filter = vtkSmartPointer<Tetrahedralize>::New();
  filter->SetInputDataObject(surface);
  filter->SetTimeLimit(20.0);
  return filter;
}

/// The only error of an update, which must fail, leave the output empty and no process behind.
std::string ErrorOf(Tetrahedralize* filter)
{
  const std::string error = surfsynthtest::ErrorOf(filter);
  auto* grid = vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0));
  EXPECT_TRUE(grid && grid->GetNumberOfPoints() == 0 && grid->GetNumberOfCells() == 0);
  EXPECT_FALSE(HasChildren());
  return error;
}

std::string ErrorOf(const Soup& soup) { return ErrorOf(FilterOn(soup.ToPolyData())); }

std::string ErrorWith(const std::function<void(Tetrahedralize*)>& change)
{
  const auto filter = FilterOn(Icosphere(2).ToPolyData());
  change(filter);
  return ErrorOf(filter);
}

/// The error when the program that misbehaves in this way stands in for TetGen.
std::string ErrorOfFake(const std::string& mode, double timeLimit = 20.0)
{
  const Variable program("SURFACE_SYNTHESIS_TETGEN", SURFSYNTH_FAKE_TETGEN);
  const Variable misbehavior("FAKE_TETGEN", mode);
  const auto filter = FilterOn(Icosphere(2).ToPolyData());
  filter->SetTimeLimit(timeLimit);
  return ErrorOf(filter);
}

Soup Crossing() { return Joined({ Shell(2, 1.0), Shell(2, 1.0, 0.5) }); }
} // namespace

// ---- the surface ----------------------------------------------------------------------------------------------------

TEST(TetrahedralizeMessages, SelfIntersection)
{
  const std::string error = ErrorOf(Crossing());
  EXPECT_THAT(error,
    AllOf(HasSubstr("intersects or touches itself"), HasSubstr("first cell"), HasSubstr("vtkSurfaceRepairFilter"),
      HasSubstr("vtkVDBSurfaceFilter")));
}

TEST(TetrahedralizeMessages, TwoSurfacesInOnePlace)
{
  EXPECT_THAT(
    ErrorOf(Joined({ Shell(2, 1.0), Shell(2, 1.0) })), AllOf(HasSubstr("640 triangles"), HasSubstr("first cell 0")));
}

TEST(TetrahedralizeMessages, CellsAreThoseOfTheInput)
{
  Soup soup = Crossing();
  soup.Lines = { { 0, 1 }, { 1, 2 } }; // which come before the polygons
  const std::string with = ErrorOf(soup);
  soup.Lines.clear();
  const std::string without = ErrorOf(soup);
  const auto first = [](const std::string& text) {
    return std::atoi(text.substr(text.find("first cell ") + 11).c_str());
  };
  EXPECT_EQ(first(with), first(without) + 2);
}

TEST(TetrahedralizeMessages, TheGateNamesWhatIsMissing)
{
  EXPECT_THAT(ErrorOf(Grid(3)), AllOf(HasSubstr("12 boundary edge"), HasSubstr("closed surface")));
  Soup fin = Icosphere(1);
  fin.Polys.push_back({ fin.Polys[0][0], fin.Polys[0][1], fin.AddPoint(3, 3, 3) });
  EXPECT_THAT(ErrorOf(fin), HasSubstr("non-manifold edge"));
  Soup flat = Icosphere(2);
  for (std::size_t k = 2; k < flat.Points.size(); k += 3)
  {
    flat.Points[k] = 0.0;
  }
  EXPECT_THAT(ErrorOf(flat), HasSubstr("degenerate"));
}

TEST(TetrahedralizeMessages, WrongParameters)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorWith([](auto* f) { f->SetQualityRatio(0.7); }), HasSubstr("QualityRatio is 0.7"));
  EXPECT_THAT(ErrorWith([&](auto* f) { f->SetQualityRatio(nan); }), HasSubstr("QualityRatio is nan"));
  EXPECT_THAT(ErrorWith([&](auto* f) { f->SetMinimumDihedralAngle(nan); }), HasSubstr("MinimumDihedralAngle is nan"));
  EXPECT_THAT(ErrorWith([&](auto* f) { f->SetMaximumVolume(nan); }), HasSubstr("MaximumVolume is nan"));
  EXPECT_THAT(ErrorWith([&](auto* f) { f->SetTimeLimit(nan); }), HasSubstr("TimeLimit is nan"));
  EXPECT_THAT(ErrorWith([](auto* f) { f->SetRegionArrayName(""); }), HasSubstr("RegionArrayName"));
  EXPECT_THAT(ErrorWith([](auto* f) { f->SetSurfaceArrayName(nullptr); }), HasSubstr("SurfaceArrayName"));
}

TEST(TetrahedralizeMessages, NoInput)
{
  vtkNew<Tetrahedralize> filter;
  EventRecorder events(filter);
  EXPECT_FALSE(Update(filter));
  EXPECT_FALSE(events.Errors.empty());
}

// ---- TetGen itself --------------------------------------------------------------------------------------------------

TEST(TetrahedralizeProcess, ABoundThatCannotBeMetEndsAtTheTimeLimit)
{
  const double start = Now();
  const std::string error = ErrorWith([](auto* f) {
    f->SetMaximumVolume(1e-8);
    f->SetMaximumNumberOfTetrahedra(VTK_INT_MAX); // so that TetGen is asked
    f->SetTimeLimit(0.5);
  });
  EXPECT_THAT(error, AllOf(HasSubstr("TimeLimit of 0.5 s"), HasSubstr("MaximumVolume")));
  EXPECT_LT(Now() - start, 0.5 + AbortLimit);
}

TEST(TetrahedralizeProcess, TheMemoryLimitIsAnErrorAndNotTheEnd)
{
  const std::string error = ErrorWith([](auto* f) {
    f->SetMaximumVolume(1e-8);
    f->SetMaximumNumberOfTetrahedra(VTK_INT_MAX); // so that TetGen is asked
    f->SetMemoryLimit(64);
    f->SetTimeLimit(10.0);
  });
  if (IsSanitized()) // which needs all addresses, so that the limit of time is what ends it
  {
    EXPECT_THAT(error, HasSubstr("TimeLimit"));
  }
  else
  {
    EXPECT_THAT(error, AllOf(HasSubstr("out of memory"), HasSubstr("64 MiB")));
  }
}

TEST(TetrahedralizeProcess, AbortEndsItWithinASecondAndTheNextUpdateIsComplete)
{
  const auto filter = FilterOn(Icosphere(IsSanitized() ? 4 : 5).ToPolyData());
  {
    EventRecorder events(filter);
    events.AbortAt = 0.1;
    EXPECT_TRUE(Update(filter)) << "an abort is no failure";
    EXPECT_THAT(events.Errors, IsEmpty());
    ASSERT_GE(events.SecondsAfterAbort, 0.0);
    EXPECT_LT(events.SecondsAfterAbort, AbortLimit) << "R9";
    EXPECT_FALSE(HasChildren());
  }
  EXPECT_EQ(vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfCells(), 0);
  filter->SetTimeLimit(0.0);
  EventRecorder events(filter);
  EXPECT_TRUE(Update(filter));
  EXPECT_EQ(events.Executions, 1);
  EXPECT_GT(vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfCells(), 1000);
  EXPECT_TRUE(std::is_sorted(events.Progress.begin(), events.Progress.end())) << "R10";
  EXPECT_GE(events.Progress.size(), 4u);
  EXPECT_EQ(events.Progress.back(), 1.0);
  EXPECT_FALSE(events.ForeignThread);
  EXPECT_LT(events.LongestSilence, AbortLimit);
}

TEST(TetrahedralizeProcess, WorksInAHostWithClosedStandardStreams)
{
  const auto sphere = Icosphere(2).ToPolyData();
  const auto reference = TetrahedraOf(sphere);
  int saved[3];
  for (int k = 0; k < 3; ++k)
  {
    saved[k] = fcntl(k, F_DUPFD_CLOEXEC, 100);
    close(k);
  }
  const auto filter = FilterOn(sphere);
  const bool updated = Update(filter);
  for (int k = 0; k < 3; ++k)
  {
    dup2(saved[k], k);
    close(saved[k]);
  }
  ASSERT_TRUE(updated);
  ExpectSameGrid(vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0)), reference);
}

TEST(TetrahedralizeProcess, WorksWhereSignalsAreBlockedAndIgnored)
{
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  auto* pipeHandler = signal(SIGPIPE, SIG_DFL);
  auto* childHandler = signal(SIGCHLD, SIG_IGN); // the system then waits for children itself
  const auto grid = TetrahedraOf(Icosphere(2).ToPolyData());
  EXPECT_GT(grid->GetNumberOfCells(), 100);
  signal(SIGCHLD, childHandler);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_THAT(ErrorOfFake("deaf"), HasSubstr("TetGen ended the process with exit status 3")) << "and no SIGPIPE here";
  signal(SIGPIPE, pipeHandler);
}

TEST(TetrahedralizeProcess, LeavesNoDescriptorBehind)
{
  TetrahedraOf(Icosphere(1).ToPolyData());
  const int before = OpenDescriptors();
  for (int k = 0; k < 5; ++k)
  {
    TetrahedraOf(Icosphere(1).ToPolyData());
    ErrorOfFake("crash");
    ErrorOfFake("hang", 0.1);
  }
  EXPECT_EQ(OpenDescriptors(), before);
}

TEST(TetrahedralizeProcess, TwoFiltersOnTwoThreadsOneOfWhichFails)
{
  const auto good = [] {
    for (int k = 0; k < 4; ++k)
    {
      EXPECT_GT(TetrahedraOf(Icosphere(2).ToPolyData())->GetNumberOfCells(), 100);
    }
  };
  const auto bad = [] {
    for (int k = 0; k < 4; ++k)
    {
      const auto filter = FilterOn(Crossing().ToPolyData());
      EventRecorder events(filter);
      EXPECT_FALSE(Update(filter));
      EXPECT_THAT(events.AllErrors(), HasSubstr("intersects or touches itself"));
    }
  };
  std::thread first(good);
  std::thread second(bad);
  first.join();
  second.join();
  EXPECT_FALSE(HasChildren());
}

// ---- programs that misbehave ----------------------------------------------------------------------------------------

TEST(TetrahedralizeProcess, Crash)
{
  EXPECT_THAT(ErrorOfFake("crash"), AllOf(HasSubstr("TetGen crashed (signal 11"), HasSubstr("vtkVDBSurfaceFilter")));
  EXPECT_THAT(ErrorOfFake("abort"), HasSubstr("TetGen crashed (signal 6"));
  EXPECT_THAT(ErrorOfFake("killed"), HasSubstr("killed from outside"));
}

TEST(TetrahedralizeProcess, Exit)
{
  EXPECT_THAT(ErrorOfFake("exit"), HasSubstr("exit status 7"));
  EXPECT_THAT(ErrorOfFake("nothing"), HasSubstr("exit status 0 and without a complete mesh"));
}

TEST(TetrahedralizeProcess, Hang)
{
  for (const char* mode : { "hang", "hang-after-reply", "close-and-hang" })
  {
    const double start = Now();
    EXPECT_THAT(ErrorOfFake(mode, 0.3), HasSubstr("TimeLimit of 0.3 s")) << mode;
    EXPECT_LT(Now() - start, 0.3 + AbortLimit) << mode;
  }
}

TEST(TetrahedralizeProcess, Codes)
{
  EXPECT_THAT(ErrorOfFake("code2"), HasSubstr("internal error (code 2)"));
  EXPECT_THAT(ErrorOfFake("code3"), HasSubstr("intersects itself"));
  EXPECT_THAT(ErrorOfFake("code4"), HasSubstr("too small"));
  EXPECT_THAT(ErrorOfFake("code5"), HasSubstr("PreserveSurface"));
  EXPECT_THAT(ErrorOfFake("code10"), HasSubstr("did not accept"));
  EXPECT_THAT(ErrorOfFake("memory"), HasSubstr("out of memory"));
}

TEST(TetrahedralizeProcess, Nonsense)
{
  for (const char* mode : { "chatter", "flood", "negative", "huge", "id", "negative-id", "nan", "unknown-status" })
  {
    EXPECT_THAT(ErrorOfFake(mode), AnyOf(HasSubstr(" answered "), HasSubstr("complete mesh"), HasSubstr("crashed")))
      << mode;
  }
  EXPECT_THAT(ErrorOfFake("half"), HasSubstr("without a complete mesh"));
  EXPECT_THAT(ErrorOfFake("longer"), HasSubstr("answered with more than its header announces"));
}

TEST(TetrahedralizeProcess, GarbledRepliesAreErrorsOrValidMeshes)
{
  const Variable program("SURFACE_SYNTHESIS_TETGEN", SURFSYNTH_FAKE_TETGEN);
  const auto sphere = Icosphere(1).ToPolyData();
  int errors = 0;
  for (int seed = 0; seed < 150; ++seed)
  {
    const Variable misbehavior("FAKE_TETGEN", "garbled" + std::to_string(seed));
    const auto filter = FilterOn(sphere);
    EventRecorder events(filter);
    const bool updated = Update(filter);
    EXPECT_EQ(updated, events.Errors.empty()) << seed;
    errors += updated ? 0 : 1;
    auto* grid = vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0));
    EXPECT_EQ(updated, grid->GetNumberOfCells() > 0) << seed;
    for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p)
    {
      EXPECT_TRUE(std::isfinite(grid->GetPoint(p)[0])) << seed;
    }
  }
  EXPECT_GT(errors, 50);
  EXPECT_FALSE(HasChildren());
}

TEST(TetrahedralizeProcess, AMissingProgramIsNamed)
{
  const Variable program("SURFACE_SYNTHESIS_TETGEN", "/nonexistent/tetgen");
  EXPECT_THAT(ErrorOf(Icosphere(1)),
    AllOf(
      HasSubstr("SURFACE_SYNTHESIS_TETGEN"), HasSubstr("/nonexistent/tetgen"), HasSubstr("surfacesynthesis-tetgen")));
}

TEST(TetrahedralizeProcess, SomethingThatIsNoProgramIsNamed)
{
  const std::string text = "no-program.txt";
  FILE* file = std::fopen(text.c_str(), "w");
  std::fputs("This is no program.\n", file);
  std::fclose(file);
  chmod(text.c_str(), 0755);
  const Variable program("SURFACE_SYNTHESIS_TETGEN", "./" + text);
  EXPECT_THAT(ErrorOf(Icosphere(1)), AllOf(HasSubstr("could not be started"), HasSubstr(text)));
  unlink(text.c_str());
}

TEST(TetrahedralizeProcess, AFailureIsForgottenByTheNextUpdate)
{
  const auto filter = FilterOn(Icosphere(1).ToPolyData());
  {
    const Variable program("SURFACE_SYNTHESIS_TETGEN", SURFSYNTH_FAKE_TETGEN);
    const Variable misbehavior("FAKE_TETGEN", "crash");
    ErrorOf(filter);
  }
  filter->Modified();
  EXPECT_TRUE(Update(filter));
  EXPECT_GT(vtkUnstructuredGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfCells(), 0);
}

TEST(TetrahedralizeProcess, MemoryDoesNotGrow)
{
  const auto sphere = Icosphere(2).ToPolyData();
  for (int k = 0; k < 5; ++k)
  {
    TetrahedraOf(sphere);
  }
  const auto before = ResidentMemory();
  for (int k = 0; k < 20; ++k)
  {
    TetrahedraOf(sphere);
  }
  const auto after = ResidentMemory();
  if (!IsSanitized())
  {
    EXPECT_LT(after, before + before / 50) << "R11";
  }
}
