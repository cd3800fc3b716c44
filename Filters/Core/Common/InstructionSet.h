// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Instruction set of the library's own inner loops: activations and convolutions of networks, solves with Cholesky
/// factors, normal random numbers, distances of samples.
///
/// Random numbers and distances have the same bits with all of them. The others round differently: results of a
/// PoissonNet, a flow matching or a geometric texture agree to 1e-5 of their size, solutions of linear systems to the
/// rounding errors of double precision. The BLAS and LibTorch choose their own instructions (OPENBLAS_CORETYPE).
#pragma once

namespace surfsynth
{

/// Instruction sets of the inner loops.
enum class InstructionSet
{
  Generic, ///< every processor
  Avx2,    ///< AVX2 and FMA
  Avx512   ///< AVX-512 F, DQ and VL
};

/// True when this build has loops for the instruction set and this processor can run them.
bool HasInstructionSet(InstructionSet set);

/// The instruction set in use: that of SetInstructionSet(), else that which the environment variable
/// SURFACE_SYNTHESIS_INSTRUCTION_SET names ("generic", "avx2", "avx512"), else the widest that HasInstructionSet().
/// @throws InvalidInput when the variable holds another word, or names one that this processor lacks.
InstructionSet CurrentInstructionSet();

/// Sets the instruction set of all loops that begin from now on: for tests and comparisons between machines. Objects
/// that hold a network keep the one that was in use when they were made.
/// @throws InvalidInput when this processor lacks it.
void SetInstructionSet(InstructionSet set);

} // namespace surfsynth
