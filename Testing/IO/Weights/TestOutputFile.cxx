// SPDX-License-Identifier: BSD-3-Clause
// Files that appear when they are complete, and the lock on their names.
#include "Core/Common/Errors.h"
#include "IO/Weights/OutputFile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

using namespace surfsynth;
using testing::HasSubstr;

namespace
{
namespace fs = std::filesystem;

class OutputFile : public testing::Test
{
protected:
  void SetUp() override
  {
    fs::remove_all(this->Folder);
    fs::create_directory(this->Folder);
  }
  void TearDown() override { fs::remove_all(this->Folder); }
  std::string File(const std::string& name) const { return (this->Folder / name).string(); }
  std::ptrdiff_t CountFiles() const
  {
    return std::distance(fs::directory_iterator(this->Folder), fs::directory_iterator());
  }
  static std::string Content(const std::string& path)
  {
    std::ifstream file(path, std::ios::binary);
    return { std::istreambuf_iterator<char>(file), {} };
  }

  const fs::path Folder = std::string("OutputFile.") + testing::UnitTest::GetInstance()->current_test_info()->name();
};

/// The text of the InvalidInput that @p call throws; empty when it throws none.
template <typename Call>
std::string Refusal(const Call& call)
{
  try
  {
    call();
  }
  catch (const InvalidInput& error)
  {
    return error.what();
  }
  return "";
}
} // namespace

TEST_F(OutputFile, ReplacesAFileAndALinkButNotWhatTheLinkIsTo)
{
  std::ofstream(this->File("kept")) << "kept";
  fs::create_symlink(fs::absolute(this->File("kept")), this->File("link"));
  WriteOutputFile(this->File("link"), "new", "Test");
  EXPECT_EQ(this->Content(this->File("link")), "new");
  EXPECT_EQ(this->Content(this->File("kept")), "kept");
  EXPECT_EQ(this->CountFiles(), 2);
}

TEST_F(OutputFile, FailuresNameTheFunctionThePathAndTheReason)
{
  const std::string text = Refusal([&] { WriteOutputFile(this->File("absent/file"), "x", "Test"); });
  EXPECT_THAT(text, HasSubstr("Test: cannot write " + this->File("absent/file") + ": No such file"));
  EXPECT_THAT(Refusal([&] { WriteOutputFile(this->Folder.string(), "x", "Test"); }), HasSubstr("it is a folder"));
}

TEST_F(OutputFile, OnlyFilesOfProcessesThatEndedAreRemoved)
{
  const pid_t child = fork();
  if (child == 0)
  {
    _exit(0);
  }
  ASSERT_GT(child, 0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  const std::string target = this->File("model");
  const std::string stale = target + "." + std::to_string(child) + "-0.tmp";
  const std::string own = target + "." + std::to_string(getpid()) + "-3.tmp";
  const std::string others[] = { own, target + ".notes.tmp", target + "." + std::to_string(child) + "-0.tmp.txt",
    target + "x." + std::to_string(child) + "-0.tmp", target + ".-1-0.tmp" };
  std::ofstream(stale) << "half";
  for (const std::string& name : others)
  {
    std::ofstream(name) << "kept";
  }
  RemoveUnfinishedOutput(target);
  EXPECT_FALSE(fs::exists(stale));
  for (const std::string& name : others)
  {
    EXPECT_TRUE(fs::exists(name)) << name;
  }
  RemoveUnfinishedOutput(this->File("absent/model"));
}

TEST_F(OutputFile, ANameIsLockedOnceUntilTheLockEnds)
{
  const std::string path = this->File("model");
  std::optional<OutputLock> lock;
  lock.emplace(path, "Test");
  EXPECT_THAT(Refusal([&] { OutputLock(path, "Test"); }),
    HasSubstr("Test: " + path + " is being written by another training, which holds the lock " + path + ".lock"));
  const OutputLock other(this->File("other"), "Test");
  lock.reset();
  EXPECT_EQ(this->CountFiles(), 1) << "only the lock that is held";
  EXPECT_EQ(Refusal([&] { OutputLock(path, "Test"); }), "");
}

TEST_F(OutputFile, TheLockOfAKilledProcessDoesNotHold)
{
  const std::string path = this->File("model");
  const pid_t child = fork();
  if (child == 0)
  {
    const OutputLock lock(path, "Test");
    _exit(0); // without removing the lock, as when killed
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  ASSERT_TRUE(fs::exists(path + ".lock"));
  EXPECT_EQ(Refusal([&] { OutputLock(path, "Test"); }), "");
  EXPECT_EQ(this->CountFiles(), 0);
}

TEST_F(OutputFile, AFileThatHasTheNameOfTheLockIsKept)
{
  std::ofstream(this->File("model.lock")) << "kept";
  EXPECT_EQ(Refusal([&] { OutputLock(this->File("model"), "Test"); }), "");
  EXPECT_EQ(this->Content(this->File("model.lock")), "kept");
}

TEST_F(OutputFile, FoldersThatCannotBeWrittenToAreNotLocked)
{
  EXPECT_EQ(Refusal([&] { OutputLock(this->File("absent/model"), "Test"); }), "");
}
