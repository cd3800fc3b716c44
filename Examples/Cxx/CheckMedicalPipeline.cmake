# SPDX-License-Identifier: BSD-3-Clause
#
# Runs the example on the brain of mricron-data with coarse voxels, and checks what it prints and writes.
set(output "${WORK_DIR}/brain")
file(REMOVE "${output}.vtp" "${output}.vtu")
execute_process(COMMAND "${PROGRAM}" "${VOLUME}" "${output}" "3000" "4"
  RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE error)
message("${text}${error}")
if (NOT result EQUAL 0)
  message(FATAL_ERROR "the example failed: ${result}")
endif ()
if (NOT text MATCHES "remeshed: ([0-9]+) points" OR CMAKE_MATCH_1 LESS 2900 OR CMAKE_MATCH_1 GREATER 3100)
  message(FATAL_ERROR "the remeshed surface does not have about 3000 points")
endif ()
file(STRINGS "${output}.vtu" arrays REGEX "Name=\"MaternNoise\"")
if (NOT arrays)
  message(FATAL_ERROR "${output}.vtu does not hold the random field")
endif ()
execute_process(COMMAND "${PROGRAM}" "${WORK_DIR}/no-such-file.nii" "${output}"
  RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
if (result EQUAL 0 OR error STREQUAL "")
  message(FATAL_ERROR "a file that does not exist must be an error")
endif ()
