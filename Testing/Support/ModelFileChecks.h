// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Changed model files, and what reading them says: the same for each kind whose metadata have an architecture, a format
/// version and a description in JSON.
#pragma once

#include "Core/Common/Errors.h"
#include "IO/Weights/SafetensorsFile.h"
#include "IO/Weights/SafetensorsWriter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace surfsynth::test
{

using Tensors = std::map<std::string, TensorData>;
using Metadata = std::map<std::string, std::string>;

/// A kind of model files.
struct ModelFileKind
{
  std::string Path;                                   ///< file that is written and read
  std::string Architecture;                           ///< metadata "architecture", and the key of the description
  std::function<void(const std::string& path)> Write; ///< writes a small model
  std::function<void(const std::string& path)> Read;  ///< reads a model
};

/// Message of reading the file of a small model after @p change, behind the name of its exception; "accepted" without one.
inline std::string MessageAfter(const ModelFileKind& kind, const std::function<void(Tensors&, Metadata&)>& change)
{
  kind.Write(kind.Path);
  Tensors tensors;
  Metadata metadata;
  {
    const SafetensorsFile file(kind.Path);
    metadata = file.Metadata();
    for (const auto& [name, entry] : file.Tensors())
    {
      tensors[name] = { entry.Type, entry.Shape, file.Bytes(name) };
    }
  }
  change(tensors, metadata);
  WriteSafetensors(kind.Path, tensors, metadata);
  try
  {
    kind.Read(kind.Path);
  }
  catch (const ModelMismatch& error)
  {
    return std::string("ModelMismatch ") + error.what();
  }
  catch (const FormatError& error)
  {
    return std::string("FormatError ") + error.what();
  }
  return "accepted";
}

/// The same after the text @p from in the description has become @p to.
inline std::string MessageWith(const ModelFileKind& kind, const std::string& from, const std::string& to)
{
  return MessageAfter(kind, [&](Tensors&, Metadata& metadata) {
    std::string& text = metadata[kind.Architecture];
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << text;
    text.replace(place, from.size(), to);
  });
}

/// Expects that a file that was not changed is accepted, and that another architecture or version, and a missing or broken
/// description, are named.
inline void ExpectMetadataAreChecked(const ModelFileKind& kind)
{
  using testing::AllOf;
  using testing::HasSubstr;
  const auto messageWithout = [&kind](const std::string& key) {
    return MessageAfter(kind, [&](Tensors&, Metadata& metadata) { metadata.erase(key); });
  };
  const auto messageOf = [&kind](const std::string& key, const std::string& value) {
    return MessageAfter(kind, [&](Tensors&, Metadata& metadata) { metadata[key] = value; });
  };
  const std::string& name = kind.Architecture;
  EXPECT_EQ(MessageAfter(kind, [](Tensors&, Metadata&) {}), "accepted");
  EXPECT_THAT(messageOf("architecture", "poissonnet"),
    AllOf(HasSubstr("\"architecture\" is \"poissonnet\""), HasSubstr(name), HasSubstr(kind.Path)));
  EXPECT_THAT(messageWithout("architecture"), HasSubstr("\"architecture\" is missing"));
  EXPECT_THAT(
    messageOf("format_version", "3"), AllOf(HasSubstr("\"format_version\" is \"3\""), HasSubstr("expected \"1\"")));
  EXPECT_THAT(messageWithout(name), HasSubstr("\"" + name + "\" is missing"));
  EXPECT_THAT(messageOf(name, "{"), HasSubstr("no JSON object"));
  EXPECT_THAT(messageOf(name, "[]"), HasSubstr("no JSON object"));
}

/// Expects that each of @p keys is needed in the description.
inline void ExpectKeysAreNeeded(const ModelFileKind& kind, const std::vector<std::string>& keys)
{
  for (const std::string& key : keys)
  {
    EXPECT_THAT(MessageWith(kind, "\"" + key + "\"", "\"another\""),
      testing::AllOf(testing::HasSubstr("ModelMismatch"), testing::HasSubstr("\"" + key + "\""),
        testing::HasSubstr("is missing; expected")));
  }
}

} // namespace surfsynth::test
