# SPDX-License-Identifier: BSD-3-Clause
#
# Bibliography.cmake must find each kind of violation: it is run on a tree of one bibliography and one header at a time.
cmake_minimum_required(VERSION 3.24)

set(lindgren "@article{Lindgren2011,\n  author = {Lindgren, Finn},\n  title  = {A Link},\n  year   = {2011}\n}\n")
set(crane "@article{Crane2013,\n  author = {Crane, Keenan},\n  title  = {Heat; and more},\n  year   = {2013}\n}\n")

# check(<bibliography> <header> <regex of the message, or empty for none>)
function (check bibliography header expected)
  file(REMOVE_RECURSE "${WORK_DIR}")
  file(WRITE "${WORK_DIR}/Examples/references.bib" "% Some papers.\n\n${bibliography}")
  file(WRITE "${WORK_DIR}/Filters/Core/A.h" "${header}")
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DSOURCE_DIR=${WORK_DIR}" -P "${CMAKE_CURRENT_LIST_DIR}/Bibliography.cmake"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if (expected STREQUAL "")
    if (NOT result STREQUAL "0")
      message(SEND_ERROR "\"${header}\" is harmless but was reported:\n${output}")
    endif ()
  elseif (result STREQUAL "0" OR NOT output MATCHES "${expected}")
    message(SEND_ERROR "\"${header}\" should have been reported as \"${expected}\", but:\n${output}")
  endif ()
endfunction ()

set(both "/// A field [Lindgren2011]; see [Crane2013], [1] and rows[Index].\n")
check("${crane}\n${lindgren}" "${both}" "")
check("${crane}\n${lindgren}" "${both}/// [Lindgren2012]\n" "A\\.h: \\[Lindgren2012\\] has no entry")
check("${crane}\n${lindgren}" "/// [Crane2013]\n" "Lindgren2011: is cited nowhere")
check("${crane}\n${lindgren}" "${both}/// [Lindgren2011, Crane2013]\n" "must give each key brackets of its own")
check("${crane}\n${lindgren}${lindgren}" "${both}" "Lindgren2011: has two entries")
check("${lindgren}${crane}" "${both}" "Crane2013: stands behind Lindgren2011")
check("${crane}@article{Lindgren2011,\n  author = {Lindgren, Finn},\n  title  = {A Link},\n  year   = {2010}\n}\n"
  "${both}" "Lindgren2011: lacks the field year")
check("${crane}@article{Lindgren2011,\n  title  = {A Link},\n  year   = {2011}\n}\n" "${both}"
  "Lindgren2011: lacks the field author")
check("${crane}${lindgren}@book{geometry,\n  title  = {Shapes}\n}\n" "${both}" "is not an entry whose key")
check("" "/// No citation.\n" "0 entries and 0 citations")
