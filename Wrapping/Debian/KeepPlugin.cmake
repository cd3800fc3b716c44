# SPDX-License-Identifier: BSD-3-Clause
#
# Run by CPack before it packs the plugin: all that is installed goes but the libraries in the plugin's folder, the
# list that names it, and the documents. The rest is in the package of the library.
file(GLOB_RECURSE files LIST_DIRECTORIES OFF "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/*")
foreach (file IN LISTS files)
  if (NOT file MATCHES "/plugins/SurfaceSynthesis/[^/]*\\.so$|/surfacesynthesis\\.plugins\\.xml$|/share/doc/paraview-surfacesynthesis/")
    file(REMOVE "${file}")
  endif ()
endforeach ()
# Folders that are empty now, the innermost first.
file(GLOB_RECURSE entries LIST_DIRECTORIES ON "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/*")
list(SORT entries ORDER DESCENDING)
foreach (entry IN LISTS entries)
  file(GLOB content "${entry}/*")
  if (IS_DIRECTORY "${entry}" AND NOT content)
    file(REMOVE_RECURSE "${entry}")
  endif ()
endforeach ()
