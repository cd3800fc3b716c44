# SPDX-License-Identifier: BSD-3-Clause
#
# Commands of the nested builds (cmake -P). Each stops the script with a message when it fails.

cmake_minimum_required(VERSION 3.24)

# Runs a command and prints its output only when it fails. The output is left in the variable OUTPUT.
function (run_command)
  list(JOIN ARGN " " text)
  message(STATUS "${text}")
  execute_process(COMMAND ${ARGN}
    RESULT_VARIABLE result
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if (NOT result STREQUAL "0")
    message(FATAL_ERROR "The command\n  ${text}\nended with ${result} and printed\n${output}")
  endif ()
  set(OUTPUT "${output}" PARENT_SCOPE)
endfunction ()

# configure_and_build(<source> <build> <-Dvariable=value>...)
function (configure_and_build source build)
  set(arguments)
  foreach (pair IN ITEMS
      "CMAKE_CXX_COMPILER=${COMPILER}" "CMAKE_CXX_FLAGS=${COMPILER_FLAGS}"
      "CMAKE_BUILD_TYPE=${BUILD_TYPE}" "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
    if (NOT pair MATCHES "=$")
      list(APPEND arguments "-D${pair}")
    endif ()
  endforeach ()
  run_command("${CMAKE_COMMAND}" -S "${source}" -B "${build}" -G "${GENERATOR}" ${arguments} ${ARGN})
  cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
  run_command("${CMAKE_COMMAND}" --build "${build}" --parallel ${processors})
endfunction ()
