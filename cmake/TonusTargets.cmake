# How every target of the project is made: one standard, one set of warnings, includes from the root.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

# All libraries are the system's, in its own folders: no program names a place to look for them.
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()

# Paths below the sources count as relative, so that one checkout's results serve the next one. What was compiled with a
# precompiled header is kept only when ccache is told that macros in it do not change.
find_program(CCACHE ccache)
if(CCACHE)
  set(launcher ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${launcher})
  set(CMAKE_C_COMPILER_LAUNCHER ${launcher})
endif()

set(TONUS_SANITIZE "" CACHE STRING "Sanitizers of all own targets, e.g. address,undefined or thread")
if(TONUS_SANITIZE)
  add_compile_options(-fsanitize=${TONUS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TONUS_SANITIZE})
endif()

option(TONUS_FUZZ "Build decoder_fuzzer, with what libFuzzer needs in all own targets (clang only)" OFF)
if(TONUS_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# What own code is compiled with, beyond the standard; generated code is not linked to it.
add_library(tonus_options INTERFACE)
target_include_directories(tonus_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(tonus_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion)
# Other compilers, and other levels of optimisation, have other warnings, some of them false.
option(TONUS_WARNINGS_ARE_ERRORS "A warning ends the build; on in the presets" OFF)
if(TONUS_WARNINGS_ARE_ERRORS AND NOT TONUS_FUZZ)
  target_compile_options(tonus_options INTERFACE -Werror)
endif()
# A false positive of g++ 12 on "x" + std::to_string(n).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(tonus_options INTERFACE -Wno-restrict)
endif()

# Tests' own sources are nearly half of a build, and their speed does not matter; neither does that of command lines.
set(TONUS_SHORT_BUILD $<$<CONFIG:RelWithDebInfo>:-O1>)

# Three precompiled headers. CLI11 and nlohmann-json are in that of the command lines alone: a source that includes CLI11
# compiles its validators too, which takes 5 s. Sources still include what they use, so that they build without.
option(TONUS_PRECOMPILED_HEADERS "Read the headers of std, spdlog, Eigen, toml++ once for all sources" OFF)
if(TONUS_PRECOMPILED_HEADERS)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CCACHE)
    target_compile_options(tonus_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>)
  endif()
  # A source may use a precompiled header only with the same macros that it was made with.
  target_link_libraries(tonus_options INTERFACE Eigen3::Eigen spdlog::spdlog tomlplusplus::tomlplusplus)
endif()

function(tonus_make_precompiled_headers)
  if(NOT TONUS_PRECOMPILED_HEADERS)
    return()
  endif()
  set(common
    <algorithm> <array> <atomic> <chrono> <cmath> <condition_variable> <cstdint> <cstring> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <mutex> <numeric> <optional> <set> <span> <sstream> <string> <string_view>
    <thread> <unordered_map> <variant> <vector> <Eigen/Dense> <spdlog/fmt/fmt.h> <spdlog/spdlog.h> <toml++/toml.h>)
  set(source ${PROJECT_BINARY_DIR}/empty.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  foreach(kind library command test)
    add_library(tonus_${kind}_headers OBJECT ${source})
    target_link_libraries(tonus_${kind}_headers PRIVATE tonus_options)
    target_precompile_headers(tonus_${kind}_headers PRIVATE ${common})
  endforeach()
  target_link_libraries(tonus_command_headers PRIVATE CLI11::CLI11 nlohmann_json::nlohmann_json)
  target_compile_options(tonus_command_headers PRIVATE ${TONUS_SHORT_BUILD})
  target_precompile_headers(tonus_command_headers PRIVATE <CLI/CLI.hpp> <nlohmann/json.hpp>)
  target_compile_options(tonus_test_headers PRIVATE ${TONUS_SHORT_BUILD})
  if(TONUS_TESTS)
    target_link_libraries(tonus_test_headers PRIVATE GTest::gmock)
    target_precompile_headers(tonus_test_headers PRIVATE <gmock/gmock.h> <gtest/gtest.h>)
  else()
    set_target_properties(tonus_test_headers PROPERTIES EXCLUDE_FROM_ALL TRUE)
  endif()
endfunction()

# Library, command (short build) or test (short build).
function(tonus_compile_as kind target)
  if(NOT kind STREQUAL "library")
    target_compile_options(${target} PRIVATE ${TONUS_SHORT_BUILD})
  endif()
  if(TONUS_PRECOMPILED_HEADERS)
    if(kind STREQUAL "command")
      target_link_libraries(${target} PRIVATE CLI11::CLI11 nlohmann_json::nlohmann_json)
    endif()
    target_precompile_headers(${target} REUSE_FROM tonus_${kind}_headers)
  endif()
endfunction()

# For what the Python module is made of too: the same objects are in the programs and in the module. Without
# interposition the compiler treats them as it treats a program's own.
function(tonus_share target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
endfunction()

# tonus_library(NAME SOURCES a.cpp ... [DEPENDS target ...] [PRIVATE_DEPENDS target ...] [COMMAND_LINE] [SHARED_CODE])
# COMMAND_LINE: most of its sources read the command line; compiled for a short build.
# SHARED_CODE: also part of the Python module (tonus_share).
function(tonus_library name)
  cmake_parse_arguments(ARG "COMMAND_LINE;SHARED_CODE" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC tonus_options ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
  if(ARG_COMMAND_LINE)
    tonus_compile_as(command ${name})
  else()
    tonus_compile_as(library ${name})
  endif()
  if(ARG_SHARED_CODE)
    tonus_share(${name})
  endif()
endfunction()

# tonus_executable(NAME SOURCES a.cpp ... [DEPENDS target ...] [COMMAND_LINE])
function(tonus_executable name)
  cmake_parse_arguments(ARG "COMMAND_LINE" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE tonus_options ${ARG_DEPENDS})
  if(ARG_COMMAND_LINE)
    tonus_compile_as(command ${name})
  else()
    tonus_compile_as(library ${name})
  endif()
endfunction()

# tonus_test(NAME SOURCES a_test.cpp ... [DEPENDS target ...] [LABELS unit|contract|...] [TIMEOUT seconds] [SERIAL]
#            [WHOLE])
# One GoogleTest program; each of its tests is one ctest, or, with WHOLE, the program is. SERIAL: shares the machine with
# no other test. The target tonus_unit_tests builds all that have the label unit.
function(tonus_test name)
  cmake_parse_arguments(ARG "SERIAL;WHOLE" "TIMEOUT" "SOURCES;DEPENDS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  target_link_libraries(${name} PRIVATE tonus_options ${ARG_DEPENDS} GTest::gmock GTest::gtest_main)
  tonus_compile_as(test ${name})
  set(properties LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT})
  if(ARG_SERIAL)
    list(APPEND properties RUN_SERIAL TRUE)
  endif()
  if("unit" IN_LIST ARG_LABELS)
    add_dependencies(tonus_unit_tests ${name})
  endif()
  if(ARG_WHOLE)
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES ${properties})
    return()
  endif()
  # ctest lists the tests of a new program, rather than the build: a build does not run what it has just linked.
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES ${properties})
endfunction()
