# SPDX-License-Identifier: BSD-3-Clause
#
# Runs the example with its own sphere and checks what it prints and writes, then with a file that does not exist.
set(output "${WORK_DIR}/sphere.vtp")
file(REMOVE "${output}")
execute_process(COMMAND "${PROGRAM}" "--range" "0.5" "--samples" "200" "${output}"
  RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE error)
message("${text}${error}")
if (NOT result EQUAL 0)
  message(FATAL_ERROR "the example failed: ${result}")
endif ()
if (NOT EXISTS "${output}")
  message(FATAL_ERROR "the example wrote no ${output}")
endif ()
file(STRINGS "${output}" arrays REGEX "Name=\"MaternNoise_199\"")
if (NOT arrays)
  message(FATAL_ERROR "${output} does not hold the last of the 200 samples")
endif ()
# on a closed surface the deviation is the one asked for; 5 per cent is the library's own tolerance for 200 samples
if (NOT text MATCHES "standard deviation ([0-9.]+)")
  message(FATAL_ERROR "the example prints no standard deviation")
endif ()
if (CMAKE_MATCH_1 LESS 0.95 OR CMAKE_MATCH_1 GREATER 1.05)
  message(FATAL_ERROR "the standard deviation is ${CMAKE_MATCH_1}, not within 5 per cent of 1")
endif ()

execute_process(COMMAND "${PROGRAM}" "${WORK_DIR}/no-such-file.stl" "${output}"
  RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
if (result EQUAL 0 OR error STREQUAL "")
  message(FATAL_ERROR "a file that does not exist must be an error")
endif ()
