# SPDX-License-Identifier: GPL-3.0-or-later
# The installed package, as another project sees it: each component is found, linked alone and run.
set(consumer_prefix ${CMAKE_CURRENT_BINARY_DIR}/consumer/prefix)
add_test(NAME "package: installs" COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${consumer_prefix})
set_tests_properties("package: installs" PROPERTIES FIXTURES_SETUP lumatlas_installed)

# lumatlas_consumer_test(COMPONENT WITHOUT packages... UNLINKED libraries...)
# Runs tests/consumer/COMPONENT.cpp, with the packages impossible to find and none of the libraries linked.
function(lumatlas_consumer_test component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "WITHOUT;UNLINKED")
  list(JOIN arg_WITHOUT "," without)
  list(JOIN arg_UNLINKED "," unlinked)
  set(name "package: ${component} alone")
  add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} -D COMPONENT=${component} -D PREFIX=${consumer_prefix}
    -D WORK=${CMAKE_CURRENT_BINARY_DIR}/consumer/${component} -D WITHOUT=${without} -D UNLINKED=${unlinked}
    -D GENERATOR=${CMAKE_GENERATOR} -D COMPILER=${CMAKE_CXX_COMPILER} -D READELF=${CMAKE_READELF}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/run.cmake)
  set_tests_properties(${name} PROPERTIES FIXTURES_REQUIRED lumatlas_installed TIMEOUT 600)
endfunction()

set(gl_libraries libGL libOpenGL libGLX libEGL libepoxy)
lumatlas_consumer_test(mesh WITHOUT epoxy OpenImageIO TinyGLTF Ceres UNLINKED ${gl_libraries} libOpenImageIO libceres)
lumatlas_consumer_test(planner WITHOUT epoxy UNLINKED ${gl_libraries})
lumatlas_consumer_test(blend WITHOUT Ceres UNLINKED libceres)
