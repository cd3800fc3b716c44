// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The five errors of the library. Every exception that a plain library (Core, IO, Inference, MeshProcessing, Learning)
/// throws on purpose is one of them. Its text reads "function: found; expected".
#pragma once

#include <stdexcept>
#include <string>

namespace surfsynth
{

/// Base of all errors of the library: catch it to catch all five.
class Error : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// The caller's mesh, array or parameter breaks a documented precondition.
class InvalidInput : public Error
{
public:
  using Error::Error;
};

/// A factorisation, solve or eigenvalue iteration did not reach its stated accuracy.
class SolverFailure : public Error
{
public:
  using Error::Error;
};

/// A file does not follow its format.
class FormatError : public Error
{
public:
  using Error::Error;
};

/// A well-formed model file does not describe the model that was asked for.
class ModelMismatch : public Error
{
public:
  using Error::Error;
};

/// The caller's progress callback asked to stop.
class Cancelled : public Error
{
public:
  using Error::Error;
};

} // namespace surfsynth
