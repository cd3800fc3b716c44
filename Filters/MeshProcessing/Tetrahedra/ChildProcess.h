// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Safe run of a program that may crash, hang or write an invalid output. Private to the mesh processing.
#pragma once

#include "Core/Common/Progress.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace surfsynth
{

/// A view of bytes of the caller.
struct Bytes
{
  const void* Data; ///< first byte
  std::size_t Size; ///< number of bytes
};

/// Program to run, its input and its limits.
struct ChildCall
{
  std::string Program;          ///< path
  std::vector<Bytes> Request;   ///< written to its standard input, which then ends
  double Seconds = 0.0;         ///< time limit, 0 for none
  double ExpectedSeconds = 1.0; ///< for progress, which is half done by then

  /// Returns the number of bytes of the whole output, from its first HeaderSize bytes. Throws for an invalid header,
  /// which ends the run.
  std::function<std::int64_t(const char*)> OutputSize;
  std::size_t HeaderSize = 0; ///< bytes of the header of the output
};

/// Result of a run.
struct ChildResult
{
  std::vector<char> Output; ///< bytes from its standard output
  bool Complete = false;    ///< Output has the size of its header, and ended there
  bool TimedOut = false;    ///< the time limit ended the run
  int Signal = 0;           ///< signal that ended the process, 0 for none
  int ExitStatus = 0;       ///< exit status without a signal; -1 when another part of the process has waited for it
};

/// Runs the program to its end, on this thread, and reports progress about twenty times a second. The program gets
/// nothing of this process but the environment: no file descriptor, no signal mask, no ignored signal; its standard
/// error is discarded. In every case the process has ended, and was waited for, when this function returns or throws.
/// Works in several threads at a time.
///
/// @throws Cancelled within a tenth of a second of the request
/// @throws SolverFailure when the program cannot be started
ChildResult RunChild(const ChildCall& call, const Progress& progress);

} // namespace surfsynth
