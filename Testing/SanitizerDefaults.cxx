// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Options and suppressions of the sanitizers, compiled into every test executable of a sanitized build so that they
/// hold however the test is started. Only reports that lie entirely in third-party libraries may be suppressed, each
/// with its reason.

extern "C" {

// detect_stack_use_after_return is on because worker threads receive references to the caller's stack.
const char* __asan_default_options()
{
  return "detect_stack_use_after_return=1:strict_string_checks=1:check_initialization_order=1";
}

const char* __ubsan_default_options() { return "print_stacktrace=1:halt_on_error=1"; }

const char* __tsan_default_options() { return "halt_on_error=0:second_deadlock_stack=1:history_size=4"; }

const char* __lsan_default_suppressions() { return ""; }

const char* __tsan_default_suppressions()
{
  return
    // OpenBLAS is not instrumented: its own locks and spinning queue are invisible to ThreadSanitizer, while the
    // memset() and memcpy() that it calls are not.
    "race:libopenblas\n"
    // As OpenBLAS: TBB's task queue is lock-free code that is not instrumented. VTK's own loops run on it.
    "race:libtbb\n"
    // VTK builds this locator in tasks of TBB, which have ended before the arrays are read again, unseen.
    "race:vtkStaticCellLocator::BuildLocator\n"
    // The same for the locator of volumes, whose tasks ask the grid for the bounds of its cells; what ends the life of
    // the grid or changes it lies in its only user.
    "race:vtkUnstructuredGrid::GetCellBounds\n"
    "race:vtkCellArray::VisitState\n"
    "race:surfsynth::AttachToVolume\n"
    // The same for the locator of points.
    "race:vtkStaticPointLocator::BuildLocator\n"
    // As TBB, on which OpenVDB runs everything: that one task has ended before the next step begins is invisible, so
    // that every step is reported, whether it lies in the library or in OpenVDB's templates.
    "race:libopenvdb\n"
    "race:openvdb::\n";
}
}
