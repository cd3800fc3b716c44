// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Builds with sanitizers.
#pragma once

namespace surfsynth
{

/// True in builds with AddressSanitizer or ThreadSanitizer, which reserve terabytes of address space and multiply times
/// and memory.
constexpr bool HasSanitizer()
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  return true;
#else
  return false;
#endif
#else
  return false;
#endif
}

} // namespace surfsynth
