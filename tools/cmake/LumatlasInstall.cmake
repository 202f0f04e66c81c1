# SPDX-License-Identifier: GPL-3.0-or-later
# The installed package: find_package(lumatlas COMPONENTS planner) gives lumatlas::planner and what it is built on, and
# looks for no library that those modules do without.
#
# Each module has an export set of its own and one file, lumatlas-NAME.cmake, that finds its packages and loads it.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(LUMATLAS_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/lumatlas)

# lumatlas_install_module(NAME LINKS ...): called by lumatlas_module.
function(lumatlas_install_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "LINKS")
  install(TARGETS lumatlas_${name} EXPORT lumatlas-${name}-targets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lumatlas COMPONENT development)
  install(EXPORT lumatlas-${name}-targets NAMESPACE lumatlas:: DESTINATION ${LUMATLAS_PACKAGE_DIR} COMPONENT development)

  set(dependencies "")
  foreach(module IN LISTS arg_LINKS)
    if(module MATCHES "^lumatlas::(.+)$")
      string(APPEND dependencies
        "include(\"\${CMAKE_CURRENT_LIST_DIR}/lumatlas-${CMAKE_MATCH_1}.cmake\")\n"
        "if(NOT lumatlas_${CMAKE_MATCH_1}_FOUND)\n  return()\nendif()\n")
    endif()
  endforeach()
  get_property(packages DIRECTORY PROPERTY LUMATLAS_PACKAGES)
  foreach(package IN LISTS packages)
    string(APPEND dependencies "find_dependency(${package})\n")
  endforeach()
  configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/lumatlas-module.cmake.in ${PROJECT_BINARY_DIR}/cmake/lumatlas-${name}.cmake
    @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/cmake/lumatlas-${name}.cmake DESTINATION ${LUMATLAS_PACKAGE_DIR}
    COMPONENT development)
  set_property(GLOBAL APPEND PROPERTY LUMATLAS_INSTALLED_MODULES ${name})
endfunction()

# Called once, after every module.
function(lumatlas_install_package)
  get_property(modules GLOBAL PROPERTY LUMATLAS_INSTALLED_MODULES)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/tools/cmake/lumatlasConfig.cmake.in
    ${PROJECT_BINARY_DIR}/cmake/lumatlasConfig.cmake
    INSTALL_DESTINATION ${LUMATLAS_PACKAGE_DIR} NO_SET_AND_CHECK_MACRO)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/cmake/lumatlasConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES
    ${PROJECT_BINARY_DIR}/cmake/lumatlasConfig.cmake
    ${PROJECT_BINARY_DIR}/cmake/lumatlasConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/tools/cmake/FindLCMS2.cmake
    ${PROJECT_SOURCE_DIR}/tools/cmake/FindUTF8PROC.cmake
    ${PROJECT_SOURCE_DIR}/tools/cmake/FindOpenImageIO.cmake
    ${PROJECT_SOURCE_DIR}/tools/cmake/Findepoxy.cmake
    ${PROJECT_SOURCE_DIR}/tools/cmake/LumatlasFindLibrary.cmake
    DESTINATION ${LUMATLAS_PACKAGE_DIR} COMPONENT development)
  if(NOT LUMATLAS_IMAGES_ON_DEMAND)
    install(FILES
      ${PROJECT_SOURCE_DIR}/tools/cmake/FindHEIF.cmake
      ${PROJECT_SOURCE_DIR}/tools/cmake/FindLIBRAW.cmake
      DESTINATION ${LUMATLAS_PACKAGE_DIR} COMPONENT development)
  endif()
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
endfunction()
