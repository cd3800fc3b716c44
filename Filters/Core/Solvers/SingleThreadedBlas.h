// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Keeps the BLAS on the calling thread. Private to the library.
#pragma once

namespace surfsynth
{

/// While at least one of these lives, OpenBLAS uses one thread for each call: the library distributes work itself, and
/// results must not depend on how many threads the BLAS would have split a product over. No effect on other BLAS.
class SingleThreadedBlas
{
public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

} // namespace surfsynth
