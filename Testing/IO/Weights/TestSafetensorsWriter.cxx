// SPDX-License-Identifier: BSD-3-Clause
// Rule 10: what the writer writes.
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

using namespace surfsynth;
using surfsynthtest::MessageOf;
using testing::HasSubstr;

namespace
{

std::map<std::string, TensorData> SomeTensors()
{
  return { { "b.weight", TensorData::FromFloat32({ 2, 2 }, { 1.0F, -2.5F, 3e-40F, 4.0F }) },
    { "a.labels", TensorData::FromInt64({ 2 }, { -7, std::numeric_limits<std::int64_t>::max() }) },
    { "a.bias", TensorData::FromFloat64({}, { 0.1 }) }, { "flags", { TensorType::Bool, { 3 }, { 1, 0, 1 } } },
    { "empty", TensorData::FromFloat32({ 0, 4 }, {}) } };
}

std::string ReadAll(const std::string& path)
{
  std::ifstream stream(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

/// Files of the folder of the tests whose name begins with @p stem.
int CountFiles(const std::string& stem)
{
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("."))
  {
    count += entry.path().filename().string().rfind(stem, 0) == 0 ? 1 : 0;
  }
  return count;
}

} // namespace

TEST(SafetensorsWriter, WhatIsWrittenIsRead)
{
  const std::map<std::string, std::string> metadata = { { "config", "{\"a\": \"\\n\u00e9\"}" }, { "", "\t" } };
  const std::string path = "Written.safetensors";
  WriteSafetensors(path, SomeTensors(), metadata);
  const SafetensorsFile file(path);
  EXPECT_EQ(file.Metadata(), metadata);
  ASSERT_EQ(file.Tensors().size(), 5U);
  EXPECT_EQ(file.Float32("b.weight"), (std::vector<float>{ 1.0F, -2.5F, 3e-40F, 4.0F }));
  EXPECT_EQ(file.Integers("a.labels"), (std::vector<std::int64_t>{ -7, std::numeric_limits<std::int64_t>::max() }));
  EXPECT_EQ(file.Float64("a.bias"), std::vector<double>{ 0.1 });
  EXPECT_EQ(file.Integers("flags"), (std::vector<std::int64_t>{ 1, 0, 1 }));
  EXPECT_EQ(file.Entry("empty").Shape, (std::vector<std::int64_t>{ 0, 4 }));
  std::filesystem::remove(path);
}

TEST(SafetensorsWriter, BytesAreDeterministicAndPaddedToEight)
{
  const std::vector<unsigned char> bytes = SerializeSafetensors(
    { { "w", TensorData::FromFloat32({ 1 }, { 1.0F }) } }, { { "k", "v" } });
  const std::string header = R"({"__metadata__":{"k":"v"},"w":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}})";
  std::string expected(8, '\0');
  expected[0] = static_cast<char>((header.size() + 7) / 8 * 8);
  expected += header + std::string((8 - header.size() % 8) % 8, ' ') + std::string("\x00\x00\x80\x3f", 4);
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), expected);
  for (const std::string name : { "a", "ab", "abc", "abcdefgh" })
  {
    const auto named = SerializeSafetensors({ { name, TensorData::FromFloat32({ 1 }, { 1.0F }) } });
    EXPECT_EQ((named.size() - 4) % 8, 0U) << name;
    EXPECT_EQ(named[8], '{');
  }
}

TEST(SafetensorsWriter, TensorsAreAlignedToTheirElements)
{
  const std::vector<unsigned char> bytes = SerializeSafetensors(SomeTensors());
  const SafetensorsFile file(bytes.data(), bytes.size(), "memory");
  for (const auto& [name, entry] : file.Tensors())
  {
    EXPECT_EQ(entry.Begin % static_cast<std::int64_t>(ElementSize(entry.Type)), 0) << name;
  }
}

TEST(SafetensorsWriter, EmptyFilesCanBeWritten)
{
  const std::vector<unsigned char> bytes = SerializeSafetensors({});
  EXPECT_EQ(std::string(bytes.begin() + 8, bytes.end()), "{}      ");
  EXPECT_TRUE(SafetensorsFile(bytes.data(), bytes.size(), "memory").Tensors().empty());
}

TEST(SafetensorsWriter, AnExistingFileIsReplacedAndNothingIsLeftBeside)
{
  const std::string path = "Replaced.safetensors";
  std::ofstream(path) << "old";
  WriteSafetensors(path, SomeTensors());
  const std::vector<unsigned char> bytes = SerializeSafetensors(SomeTensors());
  EXPECT_EQ(ReadAll(path), std::string(bytes.begin(), bytes.end()));
  EXPECT_EQ(CountFiles(path), 1);
  std::filesystem::remove(path);
}

TEST(SafetensorsWriter, AFailureKeepsTheOldFileAndNamesThePath)
{
  EXPECT_THAT(MessageOf([] { WriteSafetensors("no/such/folder/m.safetensors", {}); }),
    testing::AllOf(HasSubstr("no/such/folder/m.safetensors"), HasSubstr("No such file")));
  // A folder cannot be replaced by a file: the last step fails, and the temporary file goes.
  std::filesystem::create_directory("Folder.safetensors");
  std::ofstream("Folder.safetensors/inside") << "kept";
  EXPECT_THAT(MessageOf([] { WriteSafetensors("Folder.safetensors", SomeTensors()); }), HasSubstr("cannot write"));
  EXPECT_EQ(ReadAll("Folder.safetensors/inside"), "kept");
  EXPECT_EQ(CountFiles("Folder.safetensors"), 1);
  std::filesystem::remove_all("Folder.safetensors");
  ASSERT_EQ(mkfifo("Pipe.safetensors", 0600), 0);
  EXPECT_THAT(
    MessageOf([] { WriteSafetensors("Pipe.safetensors", SomeTensors()); }), HasSubstr("a folder or a device"));
  EXPECT_TRUE(std::filesystem::is_fifo("Pipe.safetensors"));
  std::filesystem::remove("Pipe.safetensors");
  if (std::filesystem::exists("/dev/full"))
  {
    std::filesystem::create_symlink("/dev", "Device");
    EXPECT_NE(MessageOf([] { WriteSafetensors("Device/no/full", SomeTensors()); }), "accepted");
    std::filesystem::remove("Device");
  }
}

TEST(SafetensorsWriter, RefusesWhatCannotBeRead)
{
  const TensorData number = TensorData::FromFloat32({}, { 1.0F });
  EXPECT_THAT(MessageOf([&] { SerializeSafetensors({ { "", number } }); }), HasSubstr("empty name"));
  EXPECT_THAT(MessageOf([&] { SerializeSafetensors({ { "a\n", number } }); }), HasSubstr("control character"));
  EXPECT_THAT(MessageOf([&] { SerializeSafetensors({ { "__metadata__", number } }); }), HasSubstr("__metadata__"));
  EXPECT_THAT(MessageOf([&] { SerializeSafetensors({ { "\xff", number } }); }), HasSubstr("not UTF-8"));
  EXPECT_THAT(MessageOf([&] { SerializeSafetensors({}, { { "k", "\xc3" } }); }), HasSubstr("not UTF-8"));
  EXPECT_THAT(MessageOf([&] {
    SerializeSafetensors({ { "w", { TensorType::Float32, { 2 }, { 0, 0, 0, 0 } } } });
  }),
    HasSubstr("has 4 bytes; expected 8"));
  EXPECT_THAT(MessageOf([&] {
    SerializeSafetensors({ { "w", { TensorType::Float32, { -1 }, {} } } });
  }),
    HasSubstr("shape"));
  EXPECT_THAT(MessageOf([&] {
    SerializeSafetensors({ { "w", { TensorType::Float32, std::vector<std::int64_t>(9, 0), {} } } });
  }),
    HasSubstr("shape"));
}
