// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Files that appear when they are complete, and a lock on their names.
#pragma once

#include <string>
#include <string_view>

namespace surfsynth
{

/// Writes a file that appears under its name when it is complete and on the disk: until then, and after a failure, a file
/// that was there before stays as it was. The bytes go to a new file beside it, PATH.PROCESS-NUMBER.tmp, never through a
/// link or into a file that exists.
/// @param function name of the caller, for messages
/// @throws InvalidInput when the path is a folder or a device, the folder cannot be written to or the disk is full.
void WriteOutputFile(const std::string& path, std::string_view bytes, const std::string& function);

/// Removes the temporary files that WriteOutputFile() left beside @p path in processes of this machine that were killed.
void RemoveUnfinishedOutput(const std::string& path);

/// Lock on the name of an output file: while it lives, another one of the same name, in this process or another one, is
/// refused. Makes the file PATH.lock, and removes it at the end if it is empty. A folder that cannot be written to, or a file system
/// without locks, is not locked: what is written there fails or follows the order of the writers.
class OutputLock
{
public:
  /// @param function name of the caller, for messages
  /// @throws InvalidInput when the name is locked.
  OutputLock(const std::string& path, const std::string& function);
  ~OutputLock();
  OutputLock(OutputLock&& other) noexcept;
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;
  OutputLock& operator=(OutputLock&&) = delete;

private:
  std::string Path;
  int Descriptor = -1;
};

} // namespace surfsynth
