// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Runs a program that may crash, hang or say nonsense. Private to the module.
#pragma once

#include "Core/Common/Progress.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// Bytes that somebody else owns.
struct Bytes
{
  const void* Data;
  std::size_t Size;
};

/// What to run, and how long.
struct ChildCall
{
  std::string Program;          ///< path
  std::vector<Bytes> Request;   ///< written to its standard input, which then ends
  double Seconds = 0.0;         ///< time limit, 0 for none
  double ExpectedSeconds = 1.0; ///< for progress, which is half done by then

  /// How many bytes the output has in all, told from its first HeaderSize bytes. Throws when it makes no sense of them,
  /// which ends the run.
  std::function<std::int64_t(const char*)> OutputSize;
  std::size_t HeaderSize = 0;
};

/// How a run ended.
struct ChildResult
{
  std::vector<char> Output;
  bool Complete = false; ///< Output has the size that its header tells, and ended there
  bool TimedOut = false; ///< it was stopped by the time limit
  int Signal = 0;        ///< that ended the process, 0 for none
  int ExitStatus = 0;    ///< else; -1 when another part of the process has waited for it
};

/// Runs the program to its end, on this thread, and reports progress about twenty times a second. The program gets nothing
/// of this process but the environment: no file descriptor, no signal mask, no ignored signal; its standard error goes
/// nowhere. Whatever happens, it is gone and waited for when this function returns or throws. Works in several threads
/// at a time.
///
/// @throws Cancelled within a tenth of a second of the request
/// @throws SolverFailure when the program cannot be started
ChildResult RunChild(const ChildCall& call, const Progress& progress);

} // namespace surfsynth
