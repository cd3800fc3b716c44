// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Texts of exceptions.
#pragma once

#include "Core/Common/Errors.h"

#include <gtest/gtest.h>

#include <string>

namespace surfsynthtest
{

/// The text of the exception of type Thrown that @p call throws; fails the test when there is none.
template <typename Thrown, typename Call>
std::string TextOf(const Call& call)
{
  try
  {
    call();
  }
  catch (const Thrown& error)
  {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

/// The text of the InvalidInput that @p call throws; "accepted" when there is none.
template <typename Call>
std::string MessageOf(const Call& call)
{
  try
  {
    call();
  }
  catch (const surfsynth::InvalidInput& error)
  {
    return error.what();
  }
  return "accepted";
}

} // namespace surfsynthtest
