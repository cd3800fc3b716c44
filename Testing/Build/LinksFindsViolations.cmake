# SPDX-License-Identifier: BSD-3-Clause
#
# Links.cmake must find each kind of violation: it is run on a small tree of good documents with one bad line at a time.
cmake_minimum_required(VERSION 3.24)

set(entry "@article{Rue2011,\n  author = {Rue, H.},\n  title  = {Fields},\n  year   = {2011}\n}\n")

# check(<line of Examples/README.md> <BibTeX entry of README.md> <regex of the message, or empty for none>)
function (check line bibtex expected)
  file(REMOVE_RECURSE "${WORK_DIR}")
  file(WRITE "${WORK_DIR}/LICENSE" "text\n")
  file(WRITE "${WORK_DIR}/Examples/picture.png" "")
  file(WRITE "${WORK_DIR}/Examples/references.bib" "% All papers\n\n${entry}")
  file(WRITE "${WORK_DIR}/README.md"
    "# Title\n\n![A picture](Examples/picture.png)\n[Examples](Examples/README.md), [LICENSE](LICENSE),\n"
    "[a section](Examples/README.md#adding-a-filter), [VTK](https://vtk.org)\n\n```bibtex\n${bibtex}```\n")
  file(WRITE "${WORK_DIR}/Examples/README.md" "# Examples\n\n## Adding a filter\n\n${line}\n")
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DSOURCE_DIR=${WORK_DIR}" -P "${CMAKE_CURRENT_LIST_DIR}/Links.cmake"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if (expected STREQUAL "")
    if (NOT result STREQUAL "0")
      message(SEND_ERROR "\"${line}\" is harmless but was reported:\n${output}")
    endif ()
  elseif (result STREQUAL "0" OR NOT output MATCHES "${expected}")
    message(SEND_ERROR "\"${line}\" should have been reported as \"${expected}\", but:\n${output}")
  endif ()
endfunction ()

check("[up](../README.md), [here](#adding-a-filter), ![a picture](picture.png)" "${entry}" "")
check("`array[k](index)` in code" "${entry}" "")
check("[gone](Gone.md)" "${entry}" "the link Gone.md leads nowhere")
check("![gone](Gallery/gone.png)" "${entry}" "the link Gallery/gone.png leads nowhere")
check("[outside](../../elsewhere)" "${entry}" "leads nowhere")
check("[no such section](#removing-a-filter)" "${entry}" "leads to no heading")
check("[no such section](../README.md#removing-a-filter)" "${entry}" "leads to no heading")
string(REPLACE "2011}" "2012}" changed "${entry}")
check("harmless" "${changed}" "the entry @article{Rue2011 differs")
check("harmless" "no entry\n" "0 BibTeX entries")
file(REMOVE_RECURSE "${WORK_DIR}")
