# TONUS_VERSION: what every program, archive and package states.
#   at a tag v1.2.3                     1.2.3
#   12 commits behind it                1.2.3+12.gabc1234
#   without any tag, or without git     the version of project(), and +dev
# -DTONUS_VERSION=... sets it, e.g. for sources that were unpacked from an archive. It is found when the build folder is
# configured; packages are always made from a folder that has just been configured (deploy/packages).
set(TONUS_VERSION "" CACHE STRING "Version that the programs state; empty: from the git tag")
function(tonus_find_version)
  if(TONUS_VERSION)
    return()
  endif()
  find_program(GIT git)
  if(GIT AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
    execute_process(COMMAND ${GIT} describe --tags --match "v[0-9]*" WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                    OUTPUT_VARIABLE tag OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
    if(NOT failed)
      string(REGEX REPLACE "^v" "" version "${tag}")
      string(REGEX REPLACE "-([0-9]+)-(g[0-9a-f]+)$" "+\\1.\\2" version "${version}")
    endif()
  endif()
  if(NOT version)
    set(version "${PROJECT_VERSION}+dev")
  endif()
  set(TONUS_VERSION ${version} PARENT_SCOPE)
endfunction()
tonus_find_version()
