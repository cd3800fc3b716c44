// SPDX-License-Identifier: BSD-3-Clause
//
// RunChild(): request and output, how a run ended, and that no process is left behind.
#include "Core/Common/Errors.h"
#include "MeshProcessing/Tetrahedra/ChildProcess.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

using namespace surfsynth;
using ::testing::AllOf;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

namespace
{
bool HasChildren() { return !(waitpid(-1, nullptr, WNOHANG) < 0 && errno == ECHILD); }

/// A shell script that is removed at the end.
class Script
{
public:
  explicit Script(const std::string& commands)
    : Path(std::filesystem::absolute(
        std::string("ChildProcess.") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".sh")
             .string())
  {
    std::ofstream(this->Path) << "#!/bin/sh\n" << commands << "\n";
    std::filesystem::permissions(this->Path, std::filesystem::perms::owner_all);
  }
  ~Script() { std::filesystem::remove(this->Path); }
  Script(const Script&) = delete;
  Script& operator=(const Script&) = delete;

  std::string Path;
};

/// A call whose output has @p size bytes.
ChildCall CallOf(const std::string& program, std::int64_t size)
{
  ChildCall call;
  call.Program = program;
  call.Seconds = 60.0; // so that no test hangs
  call.HeaderSize = 1;
  call.OutputSize = [size](const char*) { return size; };
  return call;
}

std::string TextOf(const ChildResult& result) { return { result.Output.begin(), result.Output.end() }; }

class ChildProcess : public ::testing::Test
{
protected:
  void TearDown() override { EXPECT_FALSE(HasChildren()); }
};
} // namespace

TEST_F(ChildProcess, OutputIsWhatTheProgramMakesOfTheRequest)
{
  // More than the buffers of a stream hold, in parts, of which one is empty.
  std::vector<char> first(300000);
  for (std::size_t k = 0; k < first.size(); ++k)
  {
    first[k] = static_cast<char>(k * k % 251);
  }
  const std::string second = "the end";
  const Script cat("exec cat");
  ChildCall call = CallOf(cat.Path, static_cast<std::int64_t>(first.size() + second.size()));
  call.Request = { { first.data(), first.size() }, { nullptr, 0 }, { second.data(), second.size() } };
  const ChildResult result = RunChild(call, {});
  EXPECT_TRUE(result.Complete);
  EXPECT_FALSE(result.TimedOut);
  EXPECT_EQ(result.Signal, 0);
  EXPECT_EQ(result.ExitStatus, 0);
  first.insert(first.end(), second.begin(), second.end());
  EXPECT_EQ(result.Output, first);
}

TEST_F(ChildProcess, HeaderTellsTheSize)
{
  const Script script("cat >/dev/null; printf '5 bytes follow'");
  ChildCall call = CallOf(script.Path, 0);
  call.HeaderSize = 3;
  std::string header;
  call.OutputSize = [&header](const char* bytes) {
    header.assign(bytes, 3);
    return 14;
  };
  const ChildResult result = RunChild(call, {});
  EXPECT_EQ(header, "5 b");
  EXPECT_TRUE(result.Complete);
  EXPECT_EQ(TextOf(result), "5 bytes follow");
}

TEST_F(ChildProcess, ExitStatusIsReported)
{
  for (const int status : { 0, 1, 7, 255 })
  {
    const Script script("exit " + std::to_string(status));
    const ChildResult result = RunChild(CallOf(script.Path, 3), {});
    EXPECT_EQ(result.ExitStatus, status);
    EXPECT_EQ(result.Signal, 0);
    EXPECT_FALSE(result.Complete);
    EXPECT_THAT(result.Output, IsEmpty());
  }
}

TEST_F(ChildProcess, SignalIsReported)
{
  for (const int signal : { SIGKILL, SIGTERM })
  {
    const Script script("printf abc; kill -" + std::to_string(signal) + " $$");
    const ChildResult result = RunChild(CallOf(script.Path, 9), {});
    EXPECT_EQ(result.Signal, signal);
    EXPECT_FALSE(result.Complete);
    EXPECT_EQ(TextOf(result), "abc");
  }
}

TEST_F(ChildProcess, ShorterAndLongerOutputIsNotComplete)
{
  const Script script("printf abc");
  EXPECT_TRUE(RunChild(CallOf(script.Path, 3), {}).Complete);
  EXPECT_FALSE(RunChild(CallOf(script.Path, 2), {}).Complete);
  EXPECT_FALSE(RunChild(CallOf(script.Path, 4), {}).Complete);
}

TEST_F(ChildProcess, EndlessOutputIsStopped)
{
  const Script script("exec yes");
  const ChildResult result = RunChild(CallOf(script.Path, 1000), {});
  EXPECT_FALSE(result.Complete);
  EXPECT_FALSE(result.TimedOut);
  EXPECT_LT(result.Output.size(), 1000000U);
}

TEST_F(ChildProcess, StandardErrorIsNotPartOfTheOutput)
{
  const Script script("echo mistake >&2; printf abc");
  EXPECT_EQ(TextOf(RunChild(CallOf(script.Path, 3), {})), "abc");
}

TEST_F(ChildProcess, TimeLimitEndsIt)
{
  const Script script("exec sleep 100");
  ChildCall call = CallOf(script.Path, 3);
  call.Seconds = 0.2;
  const auto start = std::chrono::steady_clock::now();
  const ChildResult result = RunChild(call, {});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  EXPECT_TRUE(result.TimedOut);
  EXPECT_FALSE(result.Complete);
  EXPECT_EQ(result.Signal, SIGKILL);
}

TEST_F(ChildProcess, ProgressIsMonotoneAndCanCancel)
{
  const Script script("exec sleep 100");
  std::vector<double> fractions;
  EXPECT_THROW(RunChild(CallOf(script.Path, 3),
                 [&](double fraction) {
                   fractions.push_back(fraction);
                   return fractions.size() < 5;
                 }),
    Cancelled);
  EXPECT_EQ(fractions.size(), 5U);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_GE(fractions.front(), 0.0);
  EXPECT_LT(fractions.back(), 1.0);
}

TEST_F(ChildProcess, ErrorOfTheHeaderEndsIt)
{
  const Script script("printf abc; exec sleep 100");
  ChildCall call = CallOf(script.Path, 0);
  call.OutputSize = [](const char*) -> std::int64_t { throw FormatError("no header"); };
  EXPECT_THAT([&] { RunChild(call, {}); }, ThrowsMessage<FormatError>("no header"));
}

TEST_F(ChildProcess, ProgramsThatCannotStartAreNamed)
{
  EXPECT_THAT([] { RunChild(CallOf("/nonexistent/program", 3), {}); },
    ThrowsMessage<SolverFailure>(
      "The program /nonexistent/program could not be started: " + std::string(std::strerror(ENOENT)) + "."));
}
