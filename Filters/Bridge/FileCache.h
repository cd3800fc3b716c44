// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Cache of what a filter has read from a file, which is read again only when the file has changed.
#pragma once

#include "Core/Common/Errors.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

namespace surfsynth
{

/// Holds the content of the last file that was asked for.
template <typename Content>
class FileCache
{
public:
  /// Reads a file; throws what Get() is to throw.
  using Reader = std::function<Content(const std::string& path)>;

  /// @param advice ends the error of a missing file: a sentence on what is needed, and where it comes from.
  /// @param kind of files, for that error
  FileCache(Reader reader, std::string advice, std::string kind = "model")
    : Read(std::move(reader))
    , Advice(std::move(advice))
    , Kind(std::move(kind))
  {}

  /// Returns the content of the file: what was read last when path, size and modification time of the file are the
  /// same.
  /// @throws InvalidInput when there is no such file; what the reader throws. Then nothing is held.
  std::shared_ptr<const Content> Get(const std::string& path)
  {
    std::error_code error;
    const auto time = std::filesystem::last_write_time(path, error);
    if (error)
    {
      this->Held.reset();
      throw InvalidInput(
        "The " + this->Kind + " file \"" + path + "\" cannot be read: " + error.message() + ". " + this->Advice);
    }
    const auto size = std::filesystem::file_size(path, error); // of what is no file: the reader says so
    if (!this->Held || path != this->Path || time != this->Time || size != this->Size)
    {
      this->Held.reset(); // first, so that two are never held, and none after an error
      this->Held = std::make_shared<const Content>(this->Read(path));
      this->Path = path;
      this->Time = time;
      this->Size = size;
      ++this->Loads;
    }
    return this->Held;
  }

  /// Number of files read since this object was made.
  std::int64_t NumberOfLoads() const { return this->Loads; }

private:
  Reader Read;
  std::string Advice;
  std::string Kind;
  std::shared_ptr<const Content> Held;
  std::string Path;
  std::filesystem::file_time_type Time;
  std::uintmax_t Size = 0;
  std::int64_t Loads = 0;
};

} // namespace surfsynth
