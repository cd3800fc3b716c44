# SPDX-License-Identifier: BSD-3-Clause
#
# Each source of the libraries compiled by itself, without optimization: it includes what it uses. Those that
# MeshProcessing and Learning always compile in groups stay in them.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

set(build "${WORK_DIR}/Source/build/dev")
copy_sources("${WORK_DIR}/Source" CMakeLists.txt Filters IO Wrapping LICENSE)
set(UNITY OFF)
set(BUILD_TYPE Debug)
set(COMPILER_FLAGS "${COMPILER_FLAGS} -O0 -g0")
configure_and_build("${WORK_DIR}/Source" "${build}"
  -DSURFACE_SYNTHESIS_TESTING=OFF -DSURFACE_SYNTHESIS_BENCHMARKS=OFF -DSURFACE_SYNTHESIS_EXAMPLES=OFF
  -DSURFACE_SYNTHESIS_PYTHON=OFF "-DSURFACE_SYNTHESIS_WERROR=${WERROR}")
