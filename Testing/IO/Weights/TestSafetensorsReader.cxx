// SPDX-License-Identifier: BSD-3-Clause
// One test for each rule of the reader, named for the rule, which asserts that the message names the file, the byte and
// that rule.
#include "SafetensorsBytes.h"
#include "SparseModels.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>

using namespace surfsynth;
using surfsynth::test::FileOf;
using surfsynth::test::FileWithLength;
using surfsynth::test::OneTensor;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

namespace
{

SafetensorsFile Read(const std::string& bytes, const SafetensorsLimits& limits = {})
{
  return SafetensorsFile(bytes.data(), bytes.size(), "model.safetensors", limits);
}

/// The bytes are refused because of @p rule, at @p offset, with @p text in the message.
void ExpectRefused(
  const std::string& bytes, int rule, const std::string& text, int offset = -1, const SafetensorsLimits& limits = {})
{
  try
  {
    const SafetensorsFile file = Read(bytes, limits);
    for (const auto& entry : file.Tensors())
    {
      file.Bytes(entry.first);
    }
    ADD_FAILURE() << "accepted: " << testing::PrintToString(bytes);
  }
  catch (const FormatError& error)
  {
    const std::string place = "model.safetensors: byte " + (offset < 0 ? "" : std::to_string(offset) + ": ");
    EXPECT_THAT(error.what(),
      AllOf(StartsWith(place), HasSubstr(text), HasSubstr("(safetensors rule " + std::to_string(rule) + ")")));
  }
}

const std::string FourBytes(4, '\0');

} // namespace

// --- What is accepted ----------------------------------------------------------------------------------------------

TEST(SafetensorsReader, ReadsNamesShapesNumbersAndMetadata)
{
  const std::string header = R"({"__metadata__":{"config":"{\"a\": 1}","head":"njf"},)"
                             R"("b":{"dtype":"F32","shape":[2,1],"data_offsets":[0,8]},)"
                             R"("a":{"shape":[],"data_offsets":[8,10],"dtype":"I16"}}   )";
  const SafetensorsFile file = Read(FileOf(header, std::string("\x00\x00\x80\x3f\x00\x00\x00\xc0\xfe\xff", 10)));
  EXPECT_EQ(file.Name(), "model.safetensors");
  EXPECT_EQ(file.Metadata(), (std::map<std::string, std::string>{ { "config", "{\"a\": 1}" }, { "head", "njf" } }));
  ASSERT_EQ(file.Tensors().size(), 2U);
  EXPECT_EQ(file.Entry("b").Shape, (std::vector<std::int64_t>{ 2, 1 }));
  EXPECT_EQ(file.Entry("a").Shape, std::vector<std::int64_t>());
  EXPECT_EQ(file.Float32("b"), (std::vector<float>{ 1.0F, -2.0F }));
  EXPECT_EQ(file.Float64("b"), (std::vector<double>{ 1.0, -2.0 }));
  EXPECT_EQ(file.Integers("a"), std::vector<std::int64_t>{ -2 });
  EXPECT_TRUE(file.Contains("a"));
  EXPECT_FALSE(file.Contains("c"));
}

TEST(SafetensorsReader, AcceptsEmptyFilesAndEmptyTensors)
{
  EXPECT_TRUE(Read(FileOf("{}")).Tensors().empty());
  const SafetensorsFile file = Read(
    FileOf(R"({"a":{"dtype":"F64","shape":[0,9223372036854775807,3],"data_offsets":[4,4]},)"
           R"("b":{"dtype":"U8","shape":[4],"data_offsets":[0,4]}})",
      FourBytes));
  EXPECT_TRUE(file.Float64("a").empty());
  EXPECT_EQ(file.Integers("b").size(), 4U);
}

TEST(SafetensorsReader, NumbersOfEveryTypeAreExact)
{
  const struct
  {
    const char* Type;
    std::string Bytes;
    double Value;
  } cases[] = {
    { "F64", std::string("\x18\x2d\x44\x54\xfb\x21\x09\x40", 8), 3.141592653589793 },
    { "F32", std::string("\xdb\x0f\x49\x40", 4), static_cast<double>(3.14159274F) },
    { "F16", std::string("\x48\x42", 2), 3.140625 },           // 1.5703125 x 2
    { "F16", std::string("\x01\x00", 2), std::ldexp(1, -24) }, // the smallest subnormal number
    { "F16", std::string("\xff\xfb", 2), -65504.0 },           // the largest number
    { "F16", std::string("\x00\x7c", 2), std::numeric_limits<double>::infinity() },
    { "BF16", std::string("\x49\x40", 2), 3.140625 },
    { "BF16", std::string("\x80\xff", 2), -std::numeric_limits<double>::infinity() },
  };
  for (const auto& c : cases)
  {
    const std::string size = std::to_string(c.Bytes.size());
    // One byte before, so that the numbers are not aligned.
    const std::string header = R"({"p":{"dtype":"U8","shape":[1],"data_offsets":[0,1]},"w":{"dtype":")" +
      std::string(c.Type) + R"(","shape":[1],"data_offsets":[1,)" + std::to_string(c.Bytes.size() + 1) + "]}}";
    const SafetensorsFile file = Read(FileOf(header, "\x07" + c.Bytes));
    EXPECT_EQ(file.Float64("w")[0], c.Value) << c.Type;
    EXPECT_EQ(file.Float32("w")[0], static_cast<float>(c.Value)) << c.Type;
  }
  EXPECT_TRUE(std::isnan(Read(FileOf(OneTensor("F16", "[1]", "[0,2]"), "\x01\x7c")).Float64("w")[0]));
}

TEST(SafetensorsReader, IntegersOfEveryTypeAreExact)
{
  const std::string minusTwo = "\xfe\xff\xff\xff\xff\xff\xff\xff";
  EXPECT_EQ(Read(FileOf(OneTensor("I64", "[1]", "[0,8]"), minusTwo)).Integers("w")[0], -2);
  EXPECT_EQ(Read(FileOf(OneTensor("I32", "[1]", "[0,4]"), minusTwo.substr(0, 4))).Integers("w")[0], -2);
  EXPECT_EQ(Read(FileOf(OneTensor("I16", "[1]", "[0,2]"), minusTwo.substr(0, 2))).Integers("w")[0], -2);
  EXPECT_EQ(Read(FileOf(OneTensor("I8", "[1]", "[0,1]"), minusTwo.substr(0, 1))).Integers("w")[0], -2);
  EXPECT_EQ(Read(FileOf(OneTensor("U8", "[1]", "[0,1]"), minusTwo.substr(0, 1))).Integers("w")[0], 254);
  EXPECT_EQ(Read(FileOf(OneTensor("BOOL", "[2]", "[0,2]"), std::string("\x00\x01", 2))).Integers("w"),
    (std::vector<std::int64_t>{ 0, 1 }));
}

TEST(SafetensorsReader, TensorsOfAFileAreReadOnlyWhenTheyAreAskedFor)
{
  const char* path = "sparse.safetensors";
  test::WriteSparseModel(path, { { "large", { "F32", { test::SparseBytes / 4 } } }, { "small", { "I64", { 2 } } } });
  const std::uint64_t before = test::PeakMemory();
  {
    const SafetensorsFile file(path);
    EXPECT_EQ(file.DataBytes(), static_cast<std::uint64_t>(test::SparseBytes) + 16);
    EXPECT_EQ(file.Integers("small"), (std::vector<std::int64_t>{ 0, 0 }));
    file.RequireFloatingPoint("large");
    EXPECT_THROW(file.RequireIntegers("large"), ModelMismatch);
    EXPECT_THROW(file.Integers("large"), ModelMismatch);
    file.RequireMemory(1e-9);
    try
    {
      file.RequireMemory(1e9);
      ADD_FAILURE() << "1.7e19 bytes fit into the memory";
    }
    catch (const InvalidInput& error)
    {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("reading sparse.safetensors takes about"), HasSubstr("GB of memory")));
    }
    std::filesystem::resize_file(path, 1000);
    try
    {
      file.Integers("small");
      ADD_FAILURE() << "read from a file that had been truncated";
    }
    catch (const FormatError& error)
    {
      EXPECT_THAT(error.what(), HasSubstr("the file ended while it was read"));
    }
  }
  EXPECT_LT(test::PeakMemory() - before, test::HeaderMemory);
  std::remove(path);
}

TEST(SafetensorsReader, LargeTensorsAreReadInPieces)
{
  const char* path = "pieces.safetensors";
  const std::int64_t count = (std::int64_t(1) << 19) + 3;
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), -7);
  WriteSafetensors(path, { { "w", TensorData::FromInt64({ count }, numbers) } }, {});
  EXPECT_EQ(SafetensorsFile(path).Integers("w"), numbers);
  std::remove(path);
}

// --- Rule 1 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule1HeaderLength)
{
  ExpectRefused("", 1, "the file has 0 bytes", 0);
  ExpectRefused("1234567", 1, "the file has 7 bytes", 0);
  ExpectRefused(FileWithLength(0, "{}"), 1, "the length of the header is 0; expected at least 2", 0);
  ExpectRefused(FileWithLength(1, "{}"), 1, "the length of the header is 1", 0);
  ExpectRefused(std::string("PK\x03\x04") + std::string(60, 'x'), 1, "the file is a ZIP archive, as PyTorch", 0);
  ExpectRefused("\x80\x02}q" + std::string(60, 'x'), 1, "the file is a pickle, as PyTorch", 0);
  ExpectRefused(FileWithLength(3, "{}"), 1, "expected at most the 2 bytes that follow", 0);
  ExpectRefused(FileWithLength(~std::uint64_t(0), "{}"), 1, "expected at most 16777216 bytes", 0);
  ExpectRefused(FileWithLength(~std::uint64_t(0) - 7, "{}"), 1, "expected at most 16777216 bytes", 0);
  ExpectRefused(FileWithLength((16U << 20) + 1, "{}"), 1, "expected at most 16777216 bytes", 0);
}

TEST(SafetensorsReader, Rule1LimitCanBeSetUpTo100MB)
{
  SafetensorsLimits limits;
  limits.HeaderBytes = 10;
  EXPECT_TRUE(Read(FileOf("{}        "), limits).Tensors().empty());
  ExpectRefused(FileOf("{}         "), 1, "expected at most 10 bytes", 0, limits);
  limits.HeaderBytes = ~std::uint64_t(0);
  ExpectRefused(FileWithLength(100000001, "{}"), 1, "expected at most 100000000 bytes", 0, limits);
  const std::string long17MiB = "{}" + std::string(std::size_t(17) << 20, ' ');
  EXPECT_TRUE(Read(FileOf(long17MiB), limits).Tensors().empty());
  ExpectRefused(FileOf(long17MiB), 1, "expected at most 16777216 bytes", 0);
}

// --- Rule 2 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule2HeaderText)
{
  ExpectRefused(FileOf("\xEF\xBB\xBF{}"), 2, "does not begin with {", 8);
  ExpectRefused(FileOf(" {}"), 2, "does not begin with {", 8);
  ExpectRefused(FileOf("[]"), 2, "does not begin with {", 8);
  ExpectRefused(FileOf("{}\n"), 2, "does not end with }", 10);
  ExpectRefused(FileOf(std::string("{}\0", 3)), 2, "does not end with }", 10);
  ExpectRefused(FileOf("{}  x"), 2, "does not end with }", 12);
  for (const std::string bad : { "\xff", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80",
         "\xf0\x80\x80\x80", "\x80", "\xc3", "\xe2\x82", "\xf5\x80\x80\x80" })
  {
    ExpectRefused(FileOf(R"({"__metadata__":{"k":")" + bad + R"("}})"), 2, "the header is not UTF-8", 30);
  }
  const std::string good = u8"\u00e9\u20ac\U0001F600";
  EXPECT_EQ(Read(FileOf(R"({"__metadata__":{"k":")" + good + R"("}})")).Metadata().at("k"), good);
}

// --- Rule 3 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule3StrictJson)
{
  ExpectRefused(FileOf("{} {}"), 3, "not JSON");
  ExpectRefused(FileOf("{}\n}"), 3, "not JSON");
  ExpectRefused(FileOf(R"({"a"}})"), 3, "not JSON");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":"b",}})"), 3, "not JSON");
  ExpectRefused(FileOf(R"({/* no */"__metadata__":{}})"), 3, "not JSON");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":NaN}})"), 3, "not JSON");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":Infinity}})"), 3, "not JSON");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":"\ud800"}})"), 3, "not JSON");
  ExpectRefused(FileOf(R"({"w":{"dtype":"F32")" + std::string("}}")), 3, "lacks dtype, shape or data_offsets");
}

TEST(SafetensorsReader, Rule3Depth)
{
  ExpectRefused(FileOf(OneTensor("F32", "[[1]]", "[0,4]"), FourBytes), 4, "an array in its shape");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":{"b":"c"}}})"), 3, "__metadata__ holds an object");
  ExpectRefused(FileOf("{\"a\":" + std::string(1 << 20, '[') + "}"), 3, "an array stands where it may not");
  ExpectRefused(FileOf(std::string(1 << 20, '{') + "}"), 3, "not JSON");
}

TEST(SafetensorsReader, Rule3NoKeyTwice)
{
  ExpectRefused(FileOf(R"({"__metadata__":{},"__metadata__":{}})"), 3, "\"__metadata__\" occurs twice");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":"1","a":"1"}})"), 3, "\"a\" occurs twice");
  const std::string tensor = R"("w":{"dtype":"F32","shape":[0],"data_offsets":[0,0]})";
  ExpectRefused(FileOf("{" + tensor + "," + tensor + "}"), 3, "\"w\" occurs twice");
  ExpectRefused(
    FileOf(R"({"w":{"dtype":"F32","dtype":"F32","shape":[0],"data_offsets":[0,0]}})"), 3, "\"dtype\" occurs twice");
  // The same key spelled with an escape.
  ExpectRefused(
    FileOf("{" + tensor + R"(,"\u0077":{"dtype":"F32","shape":[0],"data_offsets":[0,0]}})"), 3, "\"w\" occurs twice");
}

TEST(SafetensorsReader, Rule3TensorsHaveExactlyThreeKeys)
{
  ExpectRefused(FileOf(R"({"w":{"dtype":"F32","shape":[0]}})"), 3, "tensor \"w\" lacks");
  ExpectRefused(FileOf(R"({"w":{"shape":[0],"data_offsets":[0,0]}})"), 3, "tensor \"w\" lacks");
  ExpectRefused(FileOf(R"({"w":{"dtype":"F32","shape":[0],"data_offsets":[0,0],"x":1}})"), 3, "has the key \"x\"");
  ExpectRefused(FileOf(R"({"w":[]})"), 3, "an array stands where it may not");
  ExpectRefused(FileOf(R"({"w":null})"), 3, "null stands where it may not");
  ExpectRefused(FileOf(R"({"w":{"dtype":4,"shape":[0],"data_offsets":[0,0]}})"), 3, "a number stands where it may not");
  ExpectRefused(
    FileOf(R"({"w":{"dtype":"F32","shape":0,"data_offsets":[0,0]}})"), 3, "a number stands where it may not");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0]")), 3, "one data offset or none");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,0,0]")), 3, "two of them in data_offsets");
}

TEST(SafetensorsReader, Rule3MetadataMapsStringsToStrings)
{
  ExpectRefused(FileOf(R"({"__metadata__":{"a":1}})"), 3, "__metadata__ holds a number");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":true}})"), 3, "__metadata__ holds a boolean");
  ExpectRefused(FileOf(R"({"__metadata__":{"a":null}})"), 3, "__metadata__ holds null");
  ExpectRefused(FileOf(R"({"__metadata__":[]})"), 3, "__metadata__ holds an array");
  ExpectRefused(FileOf(R"({"__metadata__":"a"})"), 3, "__metadata__ holds a string");
}

// --- Rule 4 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule4Integers)
{
  for (const char* number : { "-1", "-0", "1.0", "1e0", "9223372036854775808", "18446744073709551615",
         "18446744073709551616", "99999999999999999999999999" })
  {
    ExpectRefused(FileOf(OneTensor("F32", "[" + std::string(number) + "]", "[0,4]"), FourBytes), 4, "has the number");
    ExpectRefused(FileOf(OneTensor("F32", "[1]", "[0," + std::string(number) + "]"), FourBytes), 4, "has the number");
  }
  for (const char* number : { "01", "+1", "0x1", "1_", ".5" })
  {
    ExpectRefused(FileOf(OneTensor("F32", "[" + std::string(number) + "]", "[0,4]"), FourBytes), 4, "not JSON");
  }
  ExpectRefused(FileOf(OneTensor("F32", "[\"1\"]", "[0,4]"), FourBytes), 4, "a string in its shape");
  ExpectRefused(FileOf(OneTensor("F32", "[true]", "[0,4]"), FourBytes), 4, "a boolean in its shape");
}

// --- Rule 5 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule5Names)
{
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,0]", "")), 5, "an empty name");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,0]", std::string(1025, 'a'))), 5, "has 1025 bytes");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,0]", R"(a\u0000)")), 5, "a control character");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,0]", R"(a\n)")), 5, "a control character");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,0]", "a\x7f")), 5, "a control character");
  EXPECT_TRUE(Read(FileOf(OneTensor("F32", "[0]", "[0,0]", std::string(1024, 'a')))).Contains(std::string(1024, 'a')));
  EXPECT_TRUE(Read(FileOf(OneTensor("F32", "[0]", "[0,0]", "../../etc/passwd"))).Contains("../../etc/passwd"));
}

TEST(SafetensorsReader, Rule5NumberOfTensorsAndRank)
{
  std::string header = "{";
  for (int k = 0; k < 100001; ++k)
  {
    header += (k > 0 ? ",\"" : "\"") + std::to_string(k) + R"(":{"dtype":"U8","shape":[0],"data_offsets":[0,0]})";
    if (k == 99999)
    {
      EXPECT_EQ(Read(FileOf(header + "}")).Tensors().size(), 100000U);
    }
  }
  ExpectRefused(FileOf(header + "}"), 5, "more than 100000 tensors");
  EXPECT_TRUE(Read(FileOf(OneTensor("U8", "[1,1,1,1,1,1,1,0]", "[0,0]"))).Contains("w"));
  ExpectRefused(FileOf(OneTensor("U8", "[1,1,1,1,1,1,1,1,0]", "[0,0]")), 5, "more than 8 dimensions");
}

// --- Rule 6 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule6Types)
{
  for (const char* type : { "U16", "U32", "U64", "F8_E4M3", "C64", "f32", "", "F32 " })
  {
    ExpectRefused(FileOf(OneTensor(type, "[0]", "[0,0]")), 6, "unsupported dtype \"" + std::string(type) + "\"");
  }
  const std::string header = OneTensor("BOOL", "[3]", "[0,3]");
  ExpectRefused(
    FileOf(header, std::string("\x01\x00\x02", 3)), 6, "holds the byte 2", static_cast<int>(header.size()) + 10);
}

// --- Rule 7 --------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule7Layout)
{
  ExpectRefused(FileOf(OneTensor("F32", "[2]", "[0,4]"), FourBytes), 7, "expected 8 bytes for F32 [2]");
  ExpectRefused(FileOf(OneTensor("F32", "[1]", "[4,0]"), FourBytes), 7, "begins at offset 4");
  ExpectRefused(FileOf(OneTensor("F32", "[0]", "[0,4]"), FourBytes), 7, "expected 0 bytes");
  ExpectRefused(FileOf(OneTensor("U8", "[3]", "[1,4]"), FourBytes), 7, "begins at offset 1");
  ExpectRefused(FileOf(OneTensor("F32", "[1]", "[0,4]"), FourBytes + "x"), 7, "the file holds 5");
  ExpectRefused(FileOf(OneTensor("F32", "[1]", "[0,4]"), "abc"), 7, "the file holds 3");
  ExpectRefused(FileOf("{}", "x"), 7, "the file holds 1");
  const auto two = [](const std::string& first, const std::string& second) {
    return FileOf(R"({"a":{"dtype":"U8","shape":[2],"data_offsets":)" + first +
        R"(},"b":{"dtype":"U8","shape":[2],"data_offsets":)" + second + "}}",
      "1234");
  };
  EXPECT_EQ(Read(two("[2,4]", "[0,2]")).Tensors().size(), 2U);
  ExpectRefused(two("[0,2]", "[1,3]"), 7, "tensor \"b\" begins at offset 1; expected offset 2");
  ExpectRefused(two("[0,2]", "[0,2]"), 7, "tensor \"b\" begins at offset 0; expected offset 2");
  ExpectRefused(two("[0,2]", "[3,5]"), 7, "tensor \"b\" begins at offset 3; expected offset 2");
}

TEST(SafetensorsReader, Rule7ProductsDoNotOverflow)
{
  for (const char* shape : { "[9223372036854775807]", "[4611686018427387904,4]", "[4294967296,4294967296]",
         "[65536,65536,65536,65536]", "[3,6148914691236517206]" })
  {
    ExpectRefused(FileOf(OneTensor("F32", shape, "[0,4]"), FourBytes), 7, "exceeds 2^63 - 1 bytes");
  }
  ExpectRefused(
    FileOf(OneTensor("U8", "[9223372036854775807]", "[0,9223372036854775807]"), FourBytes), 7, "the file holds 4");
}

// --- Rules 8 and 9 -------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, Rule9NonFiniteNumbersAreNamed)
{
  const std::string header = OneTensor("F32", "[3]", "[0,12]");
  const SafetensorsFile file = Read(
    FileOf(header, std::string("\x00\x00\x80\x3f\x00\x00\xc0\x7f\x00\x00\x80\xff", 12)));
  try
  {
    file.RequireFinite("w");
    FAIL() << "accepted";
  }
  catch (const FormatError& error)
  {
    EXPECT_THAT(error.what(),
      AllOf(StartsWith("model.safetensors: byte " + std::to_string(8 + header.size() + 4) + ": "),
        HasSubstr("element 1 of tensor \"w\" is not finite"), HasSubstr("(safetensors rule 9)")));
  }
}

TEST(SafetensorsReader, Rule9NumbersTooLargeForFloat32AreNotMadeInfinite)
{
  const SafetensorsFile file = Read(
    FileOf(OneTensor("F64", "[1]", "[0,8]"), std::string("\0\0\0\0\0\0\xf0\x7f", 8).replace(6, 1, "\xe0")));
  EXPECT_EQ(file.Float64("w")[0], std::ldexp(1.0, 1023));
  EXPECT_NO_THROW(file.RequireFinite("w"));
  EXPECT_THROW(file.Float32("w"), FormatError);
}

TEST(SafetensorsReader, TensorsThatAreNotThereOrOfAnotherTypeAreMismatches)
{
  const SafetensorsFile file = Read(FileOf(R"({"i":{"dtype":"I64","shape":[0],"data_offsets":[0,0]},)"
                                           R"("f":{"dtype":"F32","shape":[0],"data_offsets":[0,0]}})"));
  EXPECT_THROW(file.Entry("g"), ModelMismatch);
  EXPECT_THROW(file.Float32("g"), ModelMismatch);
  EXPECT_THROW(file.Float32("i"), ModelMismatch);
  EXPECT_THROW(file.Float64("i"), ModelMismatch);
  EXPECT_THROW(file.RequireFinite("i"), ModelMismatch);
  EXPECT_THROW(file.Integers("f"), ModelMismatch);
}

// --- Files ---------------------------------------------------------------------------------------------------------

TEST(SafetensorsReader, EveryTruncationOfAFileIsRefused)
{
  const std::string bytes = FileOf(
    R"({"__metadata__":{"a":"b"},"w":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}} )", FourBytes);
  EXPECT_NO_THROW(Read(bytes));
  for (std::size_t length = 0; length < bytes.size(); ++length)
  {
    EXPECT_THROW(Read(bytes.substr(0, length)), FormatError) << length;
    const std::string path = "Truncated.safetensors";
    std::ofstream(path, std::ios::binary) << bytes.substr(0, length);
    EXPECT_THROW(SafetensorsFile{ path }, FormatError) << length;
  }
  std::remove("Truncated.safetensors");
}

TEST(SafetensorsReader, PathsThatAreNoFilesAreInvalidInput)
{
  const auto message = [](const std::string& path) {
    try
    {
      SafetensorsFile file(path);
    }
    catch (const InvalidInput& error)
    {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message("no/such.safetensors"), AllOf(HasSubstr("no/such.safetensors"), HasSubstr("No such file")));
  EXPECT_THAT(message(""), HasSubstr("No such file"));
  EXPECT_THAT(message("."), HasSubstr("is not a file"));
  EXPECT_THAT(message("/dev/zero"), HasSubstr("is not a file"));
}
