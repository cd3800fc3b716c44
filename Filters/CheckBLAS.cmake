# SPDX-License-Identifier: BSD-3-Clause
#
# surfsynth_check_blas(<target>...)
#
# Finds out which library serves BLAS in a program that links the targets, and warns when it is not OpenBLAS: the
# factorisation of large meshes is many times slower with the reference BLAS. On Debian the libraries that a program
# loads are chosen by links (update-alternatives) behind the names seen at link time, so a small program is run that
# says where dgemm_ and dpotrf_ came from. Where it cannot be run, the link behind libblas.so.3 is followed instead.
#
# Sets SURFACE_SYNTHESIS_BLAS_IN_USE in the caller's scope: the file, or empty when it is not known.
function (surfsynth_check_blas)
  set(source "${CMAKE_BINARY_DIR}/CMakeFiles/surfsynth_which_blas.cxx")
  file(WRITE "${source}" "
#include <dlfcn.h>
#include <cstdio>
extern \"C\" void dgemm_();
extern \"C\" void dpotrf_();
int main()
{
  Dl_info blas, lapack;
  if (!dladdr(reinterpret_cast<void*>(&dgemm_), &blas) || !dladdr(reinterpret_cast<void*>(&dpotrf_), &lapack))
  {
    return 1;
  }
  std::printf(\"%s;%s\", blas.dli_fname, lapack.dli_fname);
}
")
  # Asked anew by each configure: the alternatives may have been changed since the last one.
  unset(surfsynth_which_blas_run CACHE)
  unset(surfsynth_which_blas_compiled CACHE)
  set(in_use "")
  if (NOT CMAKE_CROSSCOMPILING)
    try_run(surfsynth_which_blas_run surfsynth_which_blas_compiled
      "${CMAKE_BINARY_DIR}/CMakeFiles/surfsynth_which_blas" "${source}"
      LINK_LIBRARIES ${ARGN} ${CMAKE_DL_LIBS}
      RUN_OUTPUT_VARIABLE output)
    if (surfsynth_which_blas_compiled AND surfsynth_which_blas_run STREQUAL "0")
      set(in_use ${output})
    endif ()
  endif ()
  if (NOT in_use)
    find_file(surfsynth_libblas NAMES libblas.so.3 libblas.so NO_CACHE
      PATHS ${CMAKE_LIBRARY_PATH} /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE} /usr/lib64 /usr/lib)
    if (surfsynth_libblas)
      set(in_use "${surfsynth_libblas}")
    endif ()
  endif ()

  surfsynth_judge_blas("BLAS in use" "Factorisations" ${in_use})
  set(SURFACE_SYNTHESIS_BLAS_IN_USE "${resolved_blas}" PARENT_SCOPE)
endfunction ()

# surfsynth_check_torch_blas(<libtorch>)
#
# The same for the products of LibTorch, whose library is loaded and asked where its sgemm_ is. Builds of LibTorch that
# hold a BLAS of their own do not show one.
function (surfsynth_check_torch_blas library)
  set(source "${CMAKE_BINARY_DIR}/CMakeFiles/surfsynth_which_torch_blas.cxx")
  file(WRITE "${source}" "
#include <dlfcn.h>
#include <cstdio>
int main(int count, char** arguments)
{
  void* torch = count > 1 ? dlopen(arguments[1], RTLD_NOW) : nullptr;
  if (!torch)
  {
    return 1;
  }
  Dl_info blas;
  void* product = dlsym(torch, \"sgemm_\");
  std::printf(\"%s\", product && dladdr(product, &blas) ? blas.dli_fname : \"its own\");
}
")
  unset(surfsynth_which_torch_blas_run CACHE)
  unset(surfsynth_which_torch_blas_compiled CACHE)
  set(in_use "")
  if (NOT CMAKE_CROSSCOMPILING)
    try_run(surfsynth_which_torch_blas_run surfsynth_which_torch_blas_compiled
      "${CMAKE_BINARY_DIR}/CMakeFiles/surfsynth_which_torch_blas" "${source}"
      LINK_LIBRARIES ${CMAKE_DL_LIBS}
      RUN_OUTPUT_VARIABLE output
      ARGS "${library}")
    if (surfsynth_which_torch_blas_compiled AND surfsynth_which_torch_blas_run STREQUAL "0")
      set(in_use ${output})
    endif ()
  endif ()
  if (in_use STREQUAL "its own")
    message(STATUS "BLAS of LibTorch: its own")
  else ()
    surfsynth_judge_blas("BLAS of LibTorch" "Networks" ${in_use})
  endif ()
endfunction ()

# Warns when one of the files is not OpenBLAS's. Sets resolved_blas in the caller's scope.
function (surfsynth_judge_blas name victims)
  set(resolved "")
  set(openblas ON)
  foreach (file IN LISTS ARGN)
    file(REAL_PATH "${file}" file)
    list(APPEND resolved "${file}")
    if (NOT file MATCHES "openblas")
      set(openblas OFF)
    endif ()
  endforeach ()
  list(REMOVE_DUPLICATES resolved)
  list(JOIN resolved ", " text)
  if (NOT resolved)
    message(WARNING
      "${name}: could not be found out. ${victims} are many times slower without OpenBLAS.")
  elseif (NOT openblas)
    message(WARNING
      "\n"
      "  ${name}: NOT OpenBLAS but ${text}.\n"
      "  ${victims} will be many times slower than they need to be. On Debian:\n"
      "    apt-get install libopenblas0-pthread libopenblas-dev\n"
      "    update-alternatives --config libblas.so.3-x86_64-linux-gnu\n"
      "    update-alternatives --config liblapack.so.3-x86_64-linux-gnu\n")
  else ()
    message(STATUS "${name}: ${text}")
  endif ()
  set(resolved_blas "${text}" PARENT_SCOPE)
endfunction ()
