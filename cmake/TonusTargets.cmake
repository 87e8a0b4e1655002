# How every target of the project is made: one standard, one set of warnings, includes from the root.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()

set(TONUS_SANITIZE "" CACHE STRING "Sanitizers of all own targets, e.g. address,undefined or thread")
if(TONUS_SANITIZE)
  add_compile_options(-fsanitize=${TONUS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TONUS_SANITIZE})
endif()

# What own code is compiled with, beyond the standard; generated code is not linked to it.
add_library(tonus_options INTERFACE)
target_include_directories(tonus_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(tonus_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror)
# A false positive of g++ 12 on "x" + std::to_string(n).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(tonus_options INTERFACE -Wno-restrict)
endif()

# tonus_library(NAME SOURCES a.cpp ... [DEPENDS target ...] [PRIVATE_DEPENDS target ...])
function(tonus_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC tonus_options ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
endfunction()

# tonus_executable(NAME SOURCES a.cpp ... [DEPENDS target ...])
function(tonus_executable name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE tonus_options ${ARG_DEPENDS})
endfunction()

# tonus_test(NAME SOURCES a_test.cpp ... [DEPENDS target ...] [LABELS unit|contract|...] [TIMEOUT seconds] [SERIAL])
# One GoogleTest program; each of its tests is one ctest. SERIAL: shares the machine with no other test.
function(tonus_test name)
  cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "SOURCES;DEPENDS;LABELS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  target_link_libraries(${name} PRIVATE tonus_options ${ARG_DEPENDS} GTest::gmock GTest::gtest_main)
  # Nearly half of a build are the tests' own sources, and nobody measures how fast those run.
  target_compile_options(${name} PRIVATE $<$<CONFIG:RelWithDebInfo>:-O1>)
  set(properties LABELS "${ARG_LABELS}" TIMEOUT ${ARG_TIMEOUT})
  if(ARG_SERIAL)
    list(APPEND properties RUN_SERIAL TRUE)
  endif()
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 PROPERTIES ${properties})
endfunction()
