// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Program without tests, for the headers that it precompiles.
