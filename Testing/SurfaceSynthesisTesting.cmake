# SPDX-License-Identifier: BSD-3-Clause
#
# surfsynth_add_gtest(<target>
#   SOURCES <file>...
#   [LIBRARIES <target>...]
#   LABELS <label>...
#   [ENVIRONMENT <VAR=value>...]
#   [TIMEOUT <seconds>]
#   [AS_ONE]
#   [LONG <filter>]
#   [OPTIMIZED]
#   [SINGLE_THREADED]
#   [UNSANITIZED])
#
# Builds a GoogleTest executable (its main() is GoogleTest's, unless a source defines one: the linker prefers it) and
# registers each of its tests with CTest as <target>.<suite>.<test>.
#
#   LABELS       at least one of core, inference, meshing, learning, io, filters, python, paraview, parity, benchmark, gpu, build;
#                "slow" for tests that take more than a few seconds; and "release" for those that take so long that
#                they run before a release only, by ctest --preset release: the other presets leave them out
#   ENVIRONMENT  for each test
#   TIMEOUT      of each test, default 120; sanitizers multiply it by four
#   AS_ONE       registers all as one test named <target>: for many quick tests, which take less time than a process for
#                each. Not for tests that may skip: CTest would not say so.
#   LONG         with AS_ONE, a --gtest_filter of tests that take long: they are another test, <target>Long, with the label
#                release. The presets of sanitizers leave out what they need not run by themselves.
#   OPTIMIZED    compiles the tests with -O1 under sanitizers too: for tests that compute for long themselves
#   SINGLE_THREADED  leaves the program out of trees with ThreadSanitizer: the library has no threads in what it tests
#   UNSANITIZED  leaves the program out of all trees with sanitizers: it measures what other programs run
#
# Trees with sanitizers run the tests that SanitizedTests.cmake names, and do not build programs without any.
#
# Tests may write files in the folder that they run in: that of the calling CMakeLists.txt in the build tree, and with
# AS_ONE <target>_files in it, since tests of several programs run at a time and may use the same names.
include_guard(GLOBAL)

if (SURFACE_SYNTHESIS_TESTING)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif ()

set(surfsynth_testing_folder "${CMAKE_CURRENT_LIST_DIR}")
include("${CMAKE_CURRENT_LIST_DIR}/SanitizedTests.cmake")

# surfsynth_precompile_test_headers(<target> <header>...)
#
# Adds a program that does nothing, compiled as the tests are, whose precompiled headers they reuse: GoogleTest's and VTK's
# headers cost more than half of the time in which a test is compiled.
function (surfsynth_precompile_test_headers target)
  add_executable(${target} "${surfsynth_testing_folder}/PrecompiledHeaders.cxx")
  surfsynth_set_warnings(${target})
  surfsynth_set_test_options(${target})
  target_precompile_headers(${target} PRIVATE ${ARGN})
endfunction ()

if (CMAKE_CXX_FLAGS MATCHES "-fsanitize=")
  set(surfsynth_sanitized ON)
  # Options and suppressions of the sanitizers, which each program has.
  add_library(surfsynthSanitizerDefaults OBJECT "${surfsynth_testing_folder}/SanitizerDefaults.cxx")
else ()
  set(surfsynth_sanitized OFF)
endif ()

# What is tested is in libraries: optimising the tests themselves would take half of the time of a build. Inline functions
# are hidden, so that the libraries keep to their own, optimised ones.
function (surfsynth_set_test_options target)
  target_compile_options(${target}
    PRIVATE
      $<IF:$<BOOL:${surfsynth_sanitized}>,-O0,-O1>
      -fvisibility=hidden
      # ccache keeps what is compiled with precompiled headers only with these.
      $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>
      $<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>)
  target_link_libraries(${target} PRIVATE GTest::gmock GTest::gtest GTest::gtest_main)
endfunction ()

# Sets <result> to whether this tree runs any test of the sources: all but trees with ThreadSanitizer run some.
function (surfsynth_have_tests_to_run result)
  if (NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread")
    set(${result} ON PARENT_SCOPE)
    return()
  endif ()
  list(JOIN surfsynth_thread_words "|" words)
  set(${result} OFF PARENT_SCOPE)
  foreach (source IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH source)
    file(STRINGS "${source}" found REGEX "^(TEST|TEST_F|TEST_P|TYPED_TEST)\\([^)]*(${words})" LIMIT_COUNT 1)
    if (found)
      set(${result} ON PARENT_SCOPE)
    endif ()
  endforeach ()
endfunction ()

# All tests of a program, or those of its arguments, as one; called by surfsynth_add_gtest(), whose variables it reads.
function (surfsynth_add_program_test name target)
  # A test that skips must not pass unseen, nor an executable without tests. What ThreadSanitizer runs is chosen by names, some
  # of which this tree may not have compiled.
  set(failures "\\[  SKIPPED \\]")
  if (NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread")
    list(APPEND failures "Running 0 tests")
  endif ()
  add_test(NAME ${name} COMMAND ${target} ${ARGN} WORKING_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/${target}_files")
  set_tests_properties(${name} PROPERTIES
    TIMEOUT ${arg_TIMEOUT}
    LABELS "${arg_LABELS}"
    ENVIRONMENT "${arg_ENVIRONMENT}"
    FAIL_REGULAR_EXPRESSION "${failures}")
endfunction ()

function (surfsynth_add_gtest target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "AS_ONE;OPTIMIZED;SINGLE_THREADED;UNSANITIZED" "TIMEOUT;LONG" "SOURCES;LIBRARIES;LABELS;ENVIRONMENT")
  if (arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "surfsynth_add_gtest(${target}): unexpected arguments ${arg_UNPARSED_ARGUMENTS}")
  endif ()
  foreach (required IN ITEMS SOURCES LABELS)
    if (NOT arg_${required})
      message(FATAL_ERROR "surfsynth_add_gtest(${target}): ${required} is missing")
    endif ()
  endforeach ()
  if ((arg_UNSANITIZED AND surfsynth_sanitized) OR (arg_SINGLE_THREADED AND CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread"))
    return()
  endif ()
  if (NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif ()
  if (surfsynth_sanitized)
    math(EXPR arg_TIMEOUT "4 * ${arg_TIMEOUT}")
  endif ()

  add_executable(${target} ${arg_SOURCES})
  surfsynth_have_tests_to_run(has_tests ${arg_SOURCES})
  if (NOT has_tests)
    set_target_properties(${target} PROPERTIES EXCLUDE_FROM_ALL ON)
    return()
  endif ()
  surfsynth_set_warnings(${target})
  target_link_libraries(${target} PRIVATE ${arg_LIBRARIES})
  surfsynth_set_test_options(${target})
  if (arg_OPTIMIZED)
    target_compile_options(${target} PRIVATE -O1)
  endif ()
  if (arg_LIBRARIES MATCHES "Learning|TrainingData" OR (arg_OPTIMIZED AND surfsynth_sanitized))
    # LibTorch brings definitions of its own; precompiled headers are those of one level of optimisation.
  elseif (arg_LABELS MATCHES "filters")
    target_precompile_headers(${target} REUSE_FROM surfsynthVtkTestHeaders)
  else ()
    target_precompile_headers(${target} REUSE_FROM surfsynthTestHeaders)
  endif ()
  if (surfsynth_sanitized)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:surfsynthSanitizerDefaults>)
  endif ()

  if (arg_AS_ONE)
    file(MAKE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/${target}_files")
    if (surfsynth_sanitized)
      surfsynth_add_program_test(${target} ${target} "--gtest_filter=${surfsynth_test_filter}")
    elseif (arg_LONG)
      surfsynth_add_program_test(${target} ${target} "--gtest_filter=-${arg_LONG}")
      surfsynth_add_program_test(${target}Long ${target} "--gtest_filter=${arg_LONG}")
      set_tests_properties(${target}Long PROPERTIES LABELS "${arg_LABELS};release")
    else ()
      surfsynth_add_program_test(${target} ${target})
    endif ()
    return()
  endif ()

  # Tests are listed when CTest starts, not when they are built, so that a crash is a failed test.
  gtest_discover_tests(${target}
    TEST_PREFIX "${target}."
    TEST_LIST ${target}_tests
    TEST_FILTER "${surfsynth_test_filter}"
    NO_PRETTY_VALUES
    DISCOVERY_MODE PRE_TEST
    DISCOVERY_TIMEOUT 120
    PROPERTIES TIMEOUT ${arg_TIMEOUT})

  # gtest_discover_tests() cannot pass properties that are lists: they are set by a file that CTest reads after its own.
  set(properties "${CMAKE_CURRENT_BINARY_DIR}/${target}_properties.cmake")
  file(CONFIGURE OUTPUT "${properties}" @ONLY CONTENT [[
if (@target@_tests)
  set_tests_properties(${@target@_tests} PROPERTIES
    LABELS "@arg_LABELS@"
    ENVIRONMENT "@arg_ENVIRONMENT@")
else ()
  # An executable without tests must not pass unseen.
  add_test(@target@.holds_no_tests "@CMAKE_COMMAND@" -E false)
  set_tests_properties(@target@.holds_no_tests PROPERTIES LABELS "@arg_LABELS@")
endif ()
]])
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES "${properties}")
endfunction ()

# surfsynth_add_table(<target> LABEL <label> TIMEOUT <seconds> SOURCES <file>... LIBRARIES <target>...)
#
# A program that prints a table and fails when a number is not what it must be, as a test with the labels <label> and release.
# Trees with sanitizers have no such target.
function (surfsynth_add_table target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL;TIMEOUT" "SOURCES;LIBRARIES")
  if (surfsynth_sanitized)
    return()
  endif ()
  add_executable(${target} ${arg_SOURCES})
  surfsynth_set_warnings(${target})
  target_link_libraries(${target} PRIVATE ${arg_LIBRARIES})
  add_test(NAME ${target} COMMAND ${target})
  set_tests_properties(${target} PROPERTIES LABELS "${arg_LABEL};release" TIMEOUT ${arg_TIMEOUT})
endfunction ()

# surfsynth_compile_torch_tests(<target>)
#
# Compiles the sources of a target as one: torch's headers cost half a minute in each source that includes them.
function (surfsynth_compile_torch_tests target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  target_compile_options(${target}
    PRIVATE
      # Fixtures of tests lie in anonymous namespaces, which g++ takes for those of a header here.
      $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction ()
