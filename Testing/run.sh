#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# All tests: installs what is missing (Debian 12, as root or with sudo), then
#   1. builds with g++ and warnings as errors, and runs every test;
#   2. unpacks ParaView into build/paraview-prefix, builds the plugin, and runs its tests in ParaView;
#   3. compiles the library with clang and warnings as errors;
#   4. builds with AddressSanitizer and UndefinedBehaviorSanitizer, and runs the C++ tests;
#   5. builds with ThreadSanitizer, and runs the C++ tests.
# Goes on after a failure and ends with a summary; its exit status is 0 when everything passed.
#
#   Testing/run.sh [--quick]
#
# --quick: only step 1.
# Tests with the label release are left out, because they take long: ctest --preset release runs them, after a build with
# the preset dev.
# Environment: JOBS (parallel compilations and tests, default the number of processors).
set -uo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
jobs=${JOBS:-$(nproc)}
quick=0
case "$#:${1:-}" in
  0:) ;;
  1:--quick) quick=1 ;;
  *)
    echo "usage: $0 [--quick]" >&2
    exit 2
    ;;
esac

bash "$root/Examples/install-dependencies.sh" --testing || exit 1

cd "$root" || exit 1
export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER:-ccache}
summary=()
failed_tests=()
failures=0

# step <name> <command>...: runs the command, says how long it took, and remembers whether it failed.
step() {
  local name=$1 start=$SECONDS result
  shift
  echo
  echo "=== $name"
  if "$@"; then
    result=passed
  else
    result=FAILED
    failures=$((failures + 1))
  fi
  summary+=("$(printf '%-45s %s (%d s)' "$name" "$result" $((SECONDS - start)))")
  [ $result = passed ]
}

build() {
  local preset=$1
  shift
  cmake --preset "$preset" && cmake --build --preset "$preset" --parallel "$jobs" "$@"
}

run_tests() {
  ctest --preset "$1" --parallel "$jobs" --no-tests=error || remember_failed_tests "$1"
}

# The summary names them: the end of the output may be all that is kept of it.
remember_failed_tests() {
  local log=build/$1/Testing/Temporary/LastTestsFailed.log
  [ ! -f "$log" ] || failed_tests+=("$(sed "s/^[0-9]*:/  $1: /" "$log")")
  return 1
}

# Plots and renderings need an X server.
run_all_tests() {
  xvfb-run -a -s "-screen 0 1280x1024x24" ctest --preset "$1" --parallel "$jobs" --no-tests=error ||
    remember_failed_tests "$1"
}

# ThreadSanitizer of this age cannot start under kernels that randomise addresses further than it knows.
run_tests_at_fixed_addresses() {
  if setarch -R true 2>/dev/null; then
    setarch -R ctest --preset "$1" --parallel "$jobs" --no-tests=error || remember_failed_tests "$1"
  else
    run_tests "$1"
  fi
}

step "Build with g++, warnings as errors" build dev && step "All tests" run_all_tests dev

if [ $quick = 0 ]; then
  step "ParaView" bash Wrapping/ParaView/fetch-paraview.sh &&
    step "Build of the ParaView plugin" build paraview && step "Tests in ParaView" run_tests paraview
  step "Library with clang, warnings as errors" build dev-clang --target surfsynth_libraries
  step "Build with ASan and UBSan" build asan && step "C++ tests with ASan and UBSan" run_tests asan
  step "Build with TSan" build tsan && step "C++ tests with TSan" run_tests_at_fixed_addresses tsan
fi

echo
echo "=== Summary"
printf '%s\n' "${summary[@]}"
if [ $failures -gt 0 ]; then
  [ ${#failed_tests[@]} -eq 0 ] || printf '%s\n' "Tests that failed:" "${failed_tests[@]}"
  echo "$failures of ${#summary[@]} steps FAILED"
  exit 1
fi
echo "All ${#summary[@]} steps passed"
