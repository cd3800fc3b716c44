# SPDX-License-Identifier: BSD-3-Clause
#
# Runs the example on a textured octahedron, with the shipped model where there is one, and checks what it writes.
set(output "${WORK_DIR}/transferred")
file(REMOVE "${output}.vtp" "${output}.png")
file(WRITE "${WORK_DIR}/octahedron.obj" "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
  "vt 0 0\nvt 0.25 0\nvt 0.5 0\nvt 0.75 0\nvt 1 0\nvt 0.5 0.5\nvt 0.5 1\n"
  "f 1/1 2/2 5/6\nf 2/2 3/3 5/6\nf 3/3 4/4 5/6\nf 4/4 1/5 5/6\n"
  "f 2/2 1/1 6/7\nf 3/3 2/2 6/7\nf 4/4 3/3 6/7\nf 1/5 4/4 6/7\n")
execute_process(COMMAND "${PROGRAM}" "no_such_model" "${WORK_DIR}/octahedron.obj" "${PICTURE}" "${output}"
  RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE error)
if (result EQUAL 0 OR NOT error MATCHES "no_such_model")
  message(FATAL_ERROR "a model that does not exist must be an error: ${error}")
endif ()
if (NOT EXISTS "${MODEL}")
  message("There is no ${MODEL}: nothing is decoded")
  return()
endif ()
execute_process(COMMAND "${PROGRAM}" "${MODEL}" "${WORK_DIR}/octahedron.obj" "${PICTURE}" "${output}" "300"
  RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE error)
message("${text}${error}")
if (NOT result EQUAL 0 OR NOT EXISTS "${output}.png")
  message(FATAL_ERROR "the example failed: ${result}")
endif ()
file(STRINGS "${output}.vtp" arrays REGEX "Name=\"Texture\"")
if (NOT arrays)
  message(FATAL_ERROR "${output}.vtp does not hold the colors of the points")
endif ()
