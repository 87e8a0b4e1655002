# Debian packages by CPack, one a component: deploy/packages makes them, the same bytes of the same sources.
set(TONUS_PACKAGE_rig tonus-rig-agent)
set(TONUS_PACKAGE_services tonus-services)
set(TONUS_PACKAGE_dashboard tonus-dashboard)
set(TONUS_PACKAGE_cli tonus-cli)
set(TONUS_PACKAGE_dev tonus-dev)
set(TONUS_PACKAGE_python python3-tonus)
set(TONUS_COMPONENTS rig services dashboard cli dev)
if(TARGET tonus_python)
  list(APPEND TONUS_COMPONENTS python)
endif()
set(TONUS_MAINTAINER "tonus maintainers <tonus@example.org>" CACHE STRING "Maintainer that the packages name")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tonus)
set(CPACK_PACKAGE_VERSION ${TONUS_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGE_CONTACT "${TONUS_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "measures how a person's arm resists being moved")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL ${TONUS_COMPONENTS})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${TONUS_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip) # deploy/packages packs them again
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(same "= ${TONUS_VERSION}-1")
set(CPACK_DEBIAN_RIG_PACKAGE_NAME ${TONUS_PACKAGE_rig})
set(CPACK_DEBIAN_RIG_PACKAGE_DEPENDS "tonus-cli (${same})")
set(CPACK_COMPONENT_RIG_DESCRIPTION "tonus: the agent beside the hardware
 Realtime control and acquisition of a manipulandum, with its watchdog process.")
set(CPACK_DEBIAN_SERVICES_PACKAGE_NAME ${TONUS_PACKAGE_services})
set(CPACK_DEBIAN_SERVICES_PACKAGE_DEPENDS "tonus-cli (${same})")
set(CPACK_COMPONENT_SERVICES_DESCRIPTION "tonus: scheduler, identification and archive
 The services that run a session and keep what was measured.")
set(CPACK_DEBIAN_DASHBOARD_PACKAGE_NAME ${TONUS_PACKAGE_dashboard})
set(CPACK_DEBIAN_DASHBOARD_PACKAGE_DEPENDS "tonus-cli (${same})")
set(CPACK_COMPONENT_DASHBOARD_DESCRIPTION "tonus: pages for operator, subject and results
 Gateway from the bus to browsers, and the pages.")
set(CPACK_DEBIAN_CLI_PACKAGE_NAME ${TONUS_PACKAGE_cli})
set(CPACK_DEBIAN_CLI_PACKAGE_DEPENDS "adduser")
set(CPACK_DEBIAN_CLI_PACKAGE_SUGGESTS "gnuplot-nox")
set(CPACK_COMPONENT_CLI_DESCRIPTION "tonus: command line and configuration of a host
 The command tonus, /etc/tonus, the user and the data folder: every host of a lab has it.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME ${TONUS_PACKAGE_dev})
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEV_DESCRIPTION "tonus: for drivers and subscribers
 Header of the driver interface, the contract's IDL, a CMake package, examples, and tonus-driver-contract.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME ${TONUS_PACKAGE_python})
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.11), python3 (<< 3.12), python3-numpy, python3-pandas, python3-websockets")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-matplotlib")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "tonus: archives, datasets and live sessions in Python
 Measured records as NumPy arrays, results as pandas tables, and the identification of the services.")

# CPack finds maintainer scripts by their names.
foreach(component rig services dashboard cli python)
  string(TOUPPER ${component} upper)
  set(scripts "")
  foreach(script postinst prerm postrm)
    if(EXISTS ${PROJECT_SOURCE_DIR}/deploy/packaging/debian/${component}.${script})
      configure_file(${PROJECT_SOURCE_DIR}/deploy/packaging/debian/${component}.${script}
        ${PROJECT_BINARY_DIR}/packaging/${component}/${script} COPYONLY)
      file(CHMOD ${PROJECT_BINARY_DIR}/packaging/${component}/${script}
        PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
      list(APPEND scripts ${PROJECT_BINARY_DIR}/packaging/${component}/${script})
    endif()
  endforeach()
  if(component STREQUAL "cli")
    file(WRITE ${PROJECT_BINARY_DIR}/packaging/cli/conffiles "/etc/tonus/tonus.toml\n")
    list(APPEND scripts ${PROJECT_BINARY_DIR}/packaging/cli/conffiles)
  endif()
  set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA "${scripts}")
endforeach()

# Debian's changelog, with the date of the last commit.
set(date "Thu, 01 Jan 1970 00:00:00 +0000")
find_program(GIT git)
if(GIT AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT} log -1 --format=%cD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE committed OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(committed)
    string(REGEX REPLACE "^([A-Za-z]+, )([0-9] )" "\\10\\2" date "${committed}")
  endif()
endif()
file(WRITE ${PROJECT_BINARY_DIR}/packaging/changelog.Debian
"tonus (${TONUS_VERSION}-1) unstable; urgency=medium

  * See /usr/share/doc/tonus-cli/CHANGELOG.md

 -- ${TONUS_MAINTAINER}  ${date}
")
execute_process(COMMAND gzip -9nkf ${PROJECT_BINARY_DIR}/packaging/changelog.Debian)
include(CPack)
