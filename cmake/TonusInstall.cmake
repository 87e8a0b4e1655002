# What `cmake --install` and the packages have, by component: rig, services, dashboard, cli, dev, python.
#   cmake --install build/release --prefix PREFIX [--component NAME]
# Programs find what belongs to them from their own place (services/core/installation.hpp). Where the prefix is /usr,
# configuration and units go to /etc and /lib, otherwise below the prefix.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(packaging ${PROJECT_SOURCE_DIR}/deploy/packaging)
set(made ${PROJECT_BINARY_DIR}/documents)

# --- manual pages, completion, reference: printed by the programs themselves
set(documents "")
function(tonus_document program kind file)
  add_custom_command(OUTPUT ${made}/${file}
    COMMAND ${program} --print-document ${kind} > ${made}/${file}
    DEPENDS ${program} VERBATIM COMMENT "${file}")
  set(documents ${documents} ${made}/${file} PARENT_SCOPE)
endfunction()
function(tonus_install_program program component)
  file(MAKE_DIRECTORY ${made}/man ${made}/bash ${made}/zsh)
  install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
  tonus_document(${program} man man/${program}.1)
  tonus_document(${program} bash bash/${program})
  tonus_document(${program} zsh zsh/_${program})
  tonus_document(${program} reference ${program}.reference)
  tonus_document(${program} toml ${program}.toml)
  add_custom_command(OUTPUT ${made}/man/${program}.1.gz
    COMMAND gzip -9nkf ${made}/man/${program}.1 DEPENDS ${made}/man/${program}.1 VERBATIM)
  install(FILES ${made}/man/${program}.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
  install(FILES ${made}/bash/${program} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
          COMPONENT ${component})
  install(FILES ${made}/zsh/_${program} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions
          COMPONENT ${component})
  set(documents ${documents} ${made}/man/${program}.1.gz PARENT_SCOPE)
endfunction()

tonus_install_program(tonus-rig-agent rig)
install(TARGETS tonus-rig-watchdog RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/tonus COMPONENT rig)
foreach(program tonus-scheduler tonus-identification tonus-archive)
  tonus_install_program(${program} services)
endforeach()
tonus_install_program(tonus-dashboard dashboard)
tonus_install_program(tonus cli)
if(TARGET tonus-driver-contract)
  tonus_install_program(tonus-driver-contract dev)
endif()

# All options of all programs: a page, and a file with every key as a comment.
set(programs tonus-rig-agent tonus-scheduler tonus-identification tonus-archive tonus-dashboard tonus)
list(TRANSFORM programs PREPEND ${made}/ OUTPUT_VARIABLE references)
list(TRANSFORM references APPEND .reference)
list(TRANSFORM programs PREPEND ${made}/ OUTPUT_VARIABLE keys)
list(TRANSFORM keys APPEND .toml)
add_custom_command(OUTPUT ${made}/options.md
  COMMAND cat ${packaging}/options.md ${references} > ${made}/options.md
  DEPENDS ${packaging}/options.md ${references} VERBATIM COMMENT "options.md")
add_custom_command(OUTPUT ${made}/tonus.toml.example
  COMMAND tonus-archive --print-document toml-common > ${made}/tonus.toml.example
  COMMAND cat ${keys} >> ${made}/tonus.toml.example
  DEPENDS tonus-archive ${keys} VERBATIM COMMENT "tonus.toml.example")
add_custom_target(tonus_documents ALL DEPENDS ${documents} ${made}/options.md ${made}/tonus.toml.example)
install(FILES ${made}/options.md ${made}/tonus.toml.example ${PROJECT_SOURCE_DIR}/docs/lab.md
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/tonus-cli COMPONENT cli)

# --- data
install(DIRECTORY ${PROJECT_SOURCE_DIR}/deploy/protocols DESTINATION ${CMAKE_INSTALL_DATADIR}/tonus COMPONENT cli)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/deploy/profiles DESTINATION ${CMAKE_INSTALL_DATADIR}/tonus COMPONENT cli)
if(TARGET tonus_dashboard_pages)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/share/tonus/pages DESTINATION ${CMAKE_INSTALL_DATADIR}/tonus
          COMPONENT dashboard)
endif()

# --- tonus-dev
install(FILES rig_agent/drivers/tonus_driver.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tonus COMPONENT dev)
file(GLOB idl_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/idl/*.idl)
install(FILES ${idl_files} idl/README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/tonus/idl COMPONENT dev)
install(DIRECTORY examples/driver examples/fastdds examples/cyclonedds examples/typescript
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/tonus-dev/examples COMPONENT dev)
configure_package_config_file(cmake/tonusConfig.cmake.in ${PROJECT_BINARY_DIR}/tonusConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_DATADIR}/cmake/tonus
  PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_DATADIR CMAKE_INSTALL_BINDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tonusConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${PROJECT_BINARY_DIR}/tonusConfig.cmake ${PROJECT_BINARY_DIR}/tonusConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_DATADIR}/cmake/tonus COMPONENT dev)

# --- python3-tonus: the package as Debian's Python finds it
if(TARGET tonus_python)
  set(python_folder lib/python3/dist-packages)
  install(TARGETS tonus_python LIBRARY DESTINATION ${python_folder}/tonus COMPONENT python)
  install(DIRECTORY services/python/tonus/ DESTINATION ${python_folder}/tonus COMPONENT python
          FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
  install(FILES ${TONUS_PYTHON_METADATA} DESTINATION ${python_folder}/tonus-${TONUS_VERSION}.dist-info COMPONENT python)
  install(DIRECTORY examples/python/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-tonus/examples COMPONENT python
          FILES_MATCHING PATTERN "*.ipynb")
endif()

# --- configuration and units, whose places depend on the prefix of the installation
function(tonus_install_outside_prefix component folder)
  foreach(file ${ARGN})
    install(CODE "
      set(root \"\${CMAKE_INSTALL_PREFIX}/\")
      if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
        set(root \"/\")
      endif()
      get_filename_component(extension \"${file}\" LAST_EXT)
      if(extension STREQUAL \".in\")
        set(BIN \"\${CMAKE_INSTALL_PREFIX}/bin\")
        get_filename_component(name \"${file}\" NAME_WLE)
        configure_file(\"${file}\" \"${made}/installed/\${name}\" @ONLY)
        set(source \"${made}/installed/\${name}\")
      else()
        set(source \"${file}\")
      endif()
      file(INSTALL \"\${source}\" DESTINATION \"\${root}${folder}\")"
      COMPONENT ${component})
  endforeach()
endfunction()
function(tonus_install_service component name what)
  set(PROGRAM ${name})
  set(WHAT ${what})
  set(BIN @BIN@)
  set(unit ${made}/units/${name}.service.in)
  configure_file(${packaging}/systemd/service.in ${unit} @ONLY)
  tonus_install_outside_prefix(${component} lib/systemd/system ${unit})
  tonus_want(${component} tonus-lab.target ${name}.service)
endfunction()
# The target starts the unit; whether the target itself is started, the engineer says.
function(tonus_want component target unit)
  install(CODE "
    set(root \"\${CMAKE_INSTALL_PREFIX}\")
    if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
      set(root \"\")
    endif()
    set(folder \"\$ENV{DESTDIR}\${root}/lib/systemd/system/${target}.wants\")
    file(MAKE_DIRECTORY \"\${folder}\")
    file(CREATE_LINK ../${unit} \"\${folder}/${unit}\" SYMBOLIC)" COMPONENT ${component})
endfunction()
tonus_install_service(services tonus-scheduler scheduler)
tonus_install_service(services tonus-identification identification)
tonus_install_service(services tonus-archive archive)
tonus_install_service(dashboard tonus-dashboard dashboard)
tonus_install_outside_prefix(rig lib/systemd/system ${packaging}/systemd/tonus-rig-agent.service.in)
tonus_want(rig tonus-rig.target tonus-rig-agent.service)
tonus_install_outside_prefix(cli lib/systemd/system
  ${packaging}/systemd/tonus-lab.target ${packaging}/systemd/tonus-rig.target)
tonus_install_outside_prefix(cli etc/tonus ${packaging}/tonus.toml)

# --- licences: of tonus, of the libraries whose code is in the programs, of the npm packages in the pages
set(licences ${PROJECT_BINARY_DIR}/licences)
set(in_programs libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libeigen3-dev libspdlog-dev libfmt-dev libfastcdr-dev
    libboost1.74-dev pybind11-dev)
set(files "")
foreach(package ${in_programs})
  if(EXISTS /usr/share/doc/${package}/copyright)
    add_custom_command(OUTPUT ${licences}/${package}.gz
      COMMAND ${CMAKE_COMMAND} -E make_directory ${licences}
      COMMAND gzip -9nc /usr/share/doc/${package}/copyright > ${licences}/${package}.gz
      DEPENDS /usr/share/doc/${package}/copyright VERBATIM)
    list(APPEND files ${licences}/${package}.gz)
  endif()
endforeach()
set(pages_licences "")
if(TARGET tonus_dashboard_packages)
  find_program(NODE NAMES node nodejs REQUIRED)
  add_custom_command(OUTPUT ${licences}/pages.gz
    COMMAND ${CMAKE_COMMAND} -E make_directory ${licences}
    COMMAND ${NODE} ${PROJECT_SOURCE_DIR}/services/dashboard/web/licences.mjs ${TONUS_WEB_FOLDER} > ${licences}/pages
    COMMAND gzip -9nf ${licences}/pages
    DEPENDS services/dashboard/web/licences.mjs tonus_dashboard_packages VERBATIM COMMENT "licences of the pages")
  set(pages_licences ${licences}/pages.gz)
endif()
add_custom_target(tonus_licences ALL DEPENDS ${files} ${pages_licences})

include(TonusPackages)
foreach(component ${TONUS_COMPONENTS})
  set(folder ${CMAKE_INSTALL_DATADIR}/doc/${TONUS_PACKAGE_${component}})
  install(FILES ${packaging}/copyright DESTINATION ${folder} COMPONENT ${component})
  install(FILES ${PROJECT_BINARY_DIR}/packaging/changelog.Debian.gz DESTINATION ${folder} COMPONENT ${component})
  install(FILES ${files} DESTINATION ${folder}/licences COMPONENT ${component})
endforeach()
install(FILES CHANGELOG.md SECURITY.md docs/support.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/tonus-cli
        COMPONENT cli)
if(pages_licences)
  install(FILES ${pages_licences} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${TONUS_PACKAGE_dashboard}/licences
          COMPONENT dashboard)
endif()

# Everything that is installed; deploy/packages builds this alone.
add_custom_target(tonus_packaged)
add_dependencies(tonus_packaged tonus_documents tonus_licences tonus-rig-watchdog)
if(TARGET tonus_python)
  add_dependencies(tonus_packaged tonus_python_package)
endif()
if(TARGET tonus_dashboard_pages)
  add_dependencies(tonus_packaged tonus_dashboard_pages)
endif()
