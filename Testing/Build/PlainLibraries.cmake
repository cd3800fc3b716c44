# SPDX-License-Identifier: BSD-3-Clause
#
# The plain libraries without VTK, CHOLMOD and LibTorch, and their tests.
include("${CMAKE_CURRENT_LIST_DIR}/NestedBuild.cmake")

configure_and_build("${SOURCE_DIR}" "${WORK_DIR}"
  -DSURFACE_SYNTHESIS_VTK=OFF -DSURFACE_SYNTHESIS_CHOLMOD=OFF -DSURFACE_SYNTHESIS_LEARNING=OFF
  -DSURFACE_SYNTHESIS_BENCHMARKS=OFF "-DSURFACE_SYNTHESIS_WERROR=${WERROR}")

# None of them may have slipped in.
file(GLOB libraries "${WORK_DIR}/lib/*.so")
if (NOT libraries)
  message(FATAL_ERROR "No library was built in ${WORK_DIR}/lib")
endif ()
find_program(READELF readelf REQUIRED)
foreach (library IN LISTS libraries)
  run_command("${READELF}" -d "${library}")
  if (OUTPUT MATCHES "NEEDED[^\n]*(libvtk[^\n]*|libcholmod[^\n]*|libtorch[^\n]*)")
    message(FATAL_ERROR "${library} needs ${CMAKE_MATCH_1}")
  endif ()
endforeach ()

cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
run_command("${CMAKE_CTEST_COMMAND}" --test-dir "${WORK_DIR}" --output-on-failure --no-tests=error
  --label-regex "core|io|meshing" --label-exclude "slow|benchmark|release" --parallel ${processors})
string(REGEX MATCH "[0-9]+% tests passed[^\n]*" summary "${OUTPUT}")
message(STATUS "${summary}")
