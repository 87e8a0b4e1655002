# Runs `NPM arguments...` in FOLDER, quietly; shows what it said only if it fails.
set(arguments "")
set(is_after FALSE)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(i RANGE 1 ${last})
  if(is_after)
    list(APPEND arguments "${CMAKE_ARGV${i}}")
  elseif("${CMAKE_ARGV${i}}" STREQUAL "--")
    set(is_after TRUE)
  endif()
endforeach()
execute_process(COMMAND ${NPM} ${arguments} WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE code
                OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT code EQUAL 0)
  list(JOIN arguments " " line)
  message(FATAL_ERROR "npm ${line} failed in ${FOLDER}:\n${said}\n"
                      "The dashboard's pages need the npm registry once; -DTONUS_PAGES=OFF builds without them.")
endif()
