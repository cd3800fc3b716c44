#!/bin/bash
# SPDX-License-Identifier: BSD-3-Clause
#
# All tests: installs what is missing (Debian 12, as root or with sudo), then
#   1. builds with g++ and warnings as errors, and runs every test;
#   2. unpacks ParaView into build/paraview-prefix, builds the plugin, and runs its tests in ParaView;
#   3. builds with clang, warnings as errors, AddressSanitizer and UndefinedBehaviorSanitizer, and runs the C++ tests;
#   4. builds with ThreadSanitizer, and runs the C++ tests.
# Goes on after a failure and ends with a summary; its exit status is 0 when everything passed. Testing/README.md has the
# budget of each step.
#
#   Testing/run.sh [--quick | --release]
#
# --quick: only step 1. --release: the tests with the label release too, which take long and change seldom.
# Environment: JOBS (parallel compilations and tests, default the number of processors), MINUTES (of the whole run, after which
# no sanitizer is compiled for; default: no limit. The summary names what was left out, and the next run goes on from ccache),
# SURFACE_SYNTHESIS_PARITY_DIR (folder with further parity fixtures, see Testing/Parity/README.md).
set -uo pipefail

root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)
jobs=${JOBS:-$(nproc)}
minutes=${MINUTES:-}
quick=0
release=0
case "$#:${1:-}" in
  0:) ;;
  1:--quick) quick=1 ;;
  1:--release) release=1 ;;
  *)
    echo "usage: $0 [--quick | --release]" >&2
    exit 2
    ;;
esac

bash "$root/Examples/install-dependencies.sh" --testing || exit 1

cd "$root" || exit 1
export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER:-ccache}
# The trees share objects of the same text, the nested builds of the tests among them.
export CCACHE_BASEDIR=${CCACHE_BASEDIR:-$root} CCACHE_NOHASHDIR=1
export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros}
summary=()
failed_tests=()
failures=0
left_out=0
out_of_time=0

# step <name> <command>...: runs the command, says how long it took, and remembers whether it failed.
step() {
  local name=$1 start=$SECONDS result
  shift
  echo
  echo "=== $name"
  if "$@"; then
    result=passed
  elif [ $out_of_time = 1 ]; then
    result="LEFT OUT after $minutes minutes"
    left_out=$((left_out + 1))
  else
    result=FAILED
    failures=$((failures + 1))
  fi
  out_of_time=0
  summary+=("$(printf '%-45s %s (%d s)' "$name" "$result" $((SECONDS - start)))")
  [ "$result" = passed ]
}

# Page faults of compilers are a tenth of their time on virtual machines: malloc asks for huge pages (glibc 2.35).
# Groups of sources take half of the time of single ones, and the trees share them (the test Build.SourcesAlone, label
# release, compiles each source alone).
build() {
  cmake --preset "$1" -DSURFACE_SYNTHESIS_UNITY=ON &&
    GLIBC_TUNABLES=glibc.malloc.hugetlb=1 cmake --build --preset "$1" --parallel "$jobs"
}

# As build, until MINUTES of the run are over.
build_in_time() {
  if [ -z "$minutes" ]; then
    build "$1"
    return
  fi
  local left=$((60 * minutes - SECONDS)) status
  if [ $left -le 0 ]; then
    out_of_time=1
    return 1
  fi
  export jobs
  export -f build
  timeout $left bash -c "build $1"
  status=$?
  [ $status -ne 124 ] || out_of_time=1
  return $status
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

# Plots and renderings need an X server, which stays when its last client leaves: a new one may come during a reset.
run_all_tests() {
  xvfb-run -a -s "-screen 0 1280x1024x24 -noreset" ctest --preset "$1" --parallel "$jobs" --no-tests=error ||
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
[ $release = 0 ] || step "Tests before a release" run_all_tests release

if [ $quick = 0 ]; then
  step "ParaView" bash Wrapping/ParaView/fetch-paraview.sh &&
    step "Build of the ParaView plugin" build paraview && step "Tests in ParaView" run_tests paraview
  step "Build with clang, ASan and UBSan" build_in_time asan && step "C++ tests with ASan and UBSan" run_tests asan
  step "Build with TSan" build_in_time tsan && step "C++ tests with TSan" run_tests_at_fixed_addresses tsan
fi

echo
echo "=== Summary"
printf '%s\n' "${summary[@]}"
if [ $failures -gt 0 ]; then
  [ ${#failed_tests[@]} -eq 0 ] || printf '%s\n' "Tests that failed:" "${failed_tests[@]}"
  echo "$failures of ${#summary[@]} steps FAILED"
  exit 1
fi
if [ $left_out -gt 0 ]; then
  echo "$((${#summary[@]} - left_out)) of ${#summary[@]} steps passed, $left_out LEFT OUT for time"
else
  echo "All ${#summary[@]} steps passed"
fi
