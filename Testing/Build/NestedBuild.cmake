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

# configure_and_build(<source> <build> <-Dvariable=value>... [TARGETS <target>...])
function (configure_and_build source build)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "TARGETS")
  set(arguments)
  foreach (pair IN ITEMS
      "CMAKE_CXX_COMPILER=${COMPILER}" "CMAKE_CXX_FLAGS=${COMPILER_FLAGS}"
      "CMAKE_BUILD_TYPE=${BUILD_TYPE}" "CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}"
      "SURFACE_SYNTHESIS_UNITY=${UNITY}")
    if (NOT pair MATCHES "=$")
      list(APPEND arguments "-D${pair}")
    endif ()
  endforeach ()
  run_command("${CMAKE_COMMAND}" -S "${source}" -B "${build}" -G "${GENERATOR}" ${arguments} ${arg_UNPARSED_ARGUMENTS})
  cmake_host_system_information(RESULT processors QUERY NUMBER_OF_LOGICAL_CORES)
  set(targets)
  if (arg_TARGETS)
    set(targets --target ${arg_TARGETS})
  endif ()
  run_command("${CMAKE_COMMAND}" --build "${build}" --parallel ${processors} ${targets})
endfunction ()

# copy_sources(<destination> <entry of the root>...)
#
# A copy as another tree would have it. Time stamps are kept, so that what has not changed is not compiled again.
function (copy_sources destination)
  file(REMOVE_RECURSE "${destination}")
  foreach (entry IN LISTS ARGN)
    cmake_path(GET entry PARENT_PATH folder)
    file(COPY "${SOURCE_DIR}/${entry}" DESTINATION "${destination}/${folder}")
  endforeach ()
endfunction ()

# Objects that the outer tree has compiled from the same text come from ccache, where paths are relative to the folder of
# the build: each nested build lies two folders below its copy of the sources, as the presets' do.
set(ENV{CCACHE_BASEDIR} "${SOURCE_DIR}")
set(ENV{CCACHE_NOHASHDIR} 1)

# forbid_libraries(<folder> <regex of a file name>...): no library in the folder may need one of these.
function (forbid_libraries folder)
  list(JOIN ARGN "|" forbidden)
  find_program(READELF readelf REQUIRED)
  file(GLOB_RECURSE libraries "${folder}/*.so")
  if (NOT libraries)
    message(FATAL_ERROR "No library was built in ${folder}")
  endif ()
  foreach (library IN LISTS libraries)
    run_command("${READELF}" -d "${library}")
    if (OUTPUT MATCHES "NEEDED[^\n]*(${forbidden})[^\n]*")
      message(FATAL_ERROR "${library} needs ${CMAKE_MATCH_1}")
    endif ()
  endforeach ()
endfunction ()
