# SPDX-License-Identifier: GPL-3.0-or-later
# The installed package, as another project sees it: each component is found, linked alone and run.
set(consumer_prefix ${CMAKE_CURRENT_BINARY_DIR}/consumer/prefix)
add_test(NAME "package: installs" COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${consumer_prefix})
set_tests_properties("package: installs" PROPERTIES FIXTURES_SETUP lumatlas_installed)

# Some of them are given a scene.
set(consumer_scene ${CMAKE_CURRENT_BINARY_DIR}/consumer/apartment)
add_test(NAME "package: makes a scene" COMMAND ${consumer_prefix}/${CMAKE_INSTALL_BINDIR}/lumatlas
  synth apartment -o ${consumer_scene} --photographs 24 --width 96 --height 72 --samples 1 --triangles 3000 --quiet)
set_tests_properties("package: makes a scene" PROPERTIES
  FIXTURES_REQUIRED lumatlas_installed FIXTURES_SETUP lumatlas_scene)

# lumatlas_consumer_test(COMPONENT [WITH components...] [ARGUMENTS ...] [WITHOUT packages...] [UNLINKED libraries...])
# Runs tests/consumer/COMPONENT.cpp, linked with that component and those of WITH, with the packages impossible to find
# and none of the libraries linked.
function(lumatlas_consumer_test component)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "WITH;ARGUMENTS;WITHOUT;UNLINKED")
  list(JOIN arg_ARGUMENTS "," arguments)
  list(JOIN arg_WITH "," components)
  string(REGEX REPLACE ",$" "" components "${component},${components}")
  list(JOIN arg_WITHOUT "," without)
  list(JOIN arg_UNLINKED "," unlinked)
  set(name "package: ${component}")
  add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} -D COMPONENTS=${components} -D PREFIX=${consumer_prefix}
    -D WORK=${CMAKE_CURRENT_BINARY_DIR}/consumer/build-${component} -D ARGUMENTS=${arguments}
    -D WITHOUT=${without} -D UNLINKED=${unlinked}
    -D GENERATOR=${CMAKE_GENERATOR} -D COMPILER=${CMAKE_CXX_COMPILER} -D LAUNCHER=${LUMATLAS_CCACHE}
    -D READELF=${CMAKE_READELF}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/run.cmake)
  set_tests_properties(${name} PROPERTIES FIXTURES_REQUIRED "lumatlas_installed;lumatlas_scene" TIMEOUT 600)
endfunction()

set(gl_libraries libGL libOpenGL libGLX libEGL libepoxy)
lumatlas_consumer_test(mesh WITHOUT epoxy OpenImageIO TinyGLTF Ceres UNLINKED ${gl_libraries} libOpenImageIO libceres)
lumatlas_consumer_test(planner WITHOUT epoxy UNLINKED ${gl_libraries})
lumatlas_consumer_test(live WITHOUT CLI11 epoxy UNLINKED ${gl_libraries})
lumatlas_consumer_test(blend WITHOUT Ceres UNLINKED libceres)
lumatlas_consumer_test(scene WITH surface ARGUMENTS ${consumer_scene} WITHOUT CLI11 epoxy Ceres UNLINKED ${gl_libraries} libceres)
lumatlas_consumer_test(pipeline WITH score ARGUMENTS ${consumer_scene} ${CMAKE_CURRENT_BINARY_DIR}/consumer/model
  WITHOUT CLI11)
lumatlas_consumer_test(score WITHOUT CLI11)

# The Python module, from where Debian's package puts it.
if(LUMATLAS_PYTHON)
  add_test(NAME "package: python" COMMAND ${CMAKE_COMMAND} -E env
    PYTHONPATH=${consumer_prefix}/${LUMATLAS_PYTHON_DIR} ${Python3_EXECUTABLE} -c
    "import lumatlas, os; scene = lumatlas.load_scene('${consumer_scene}'); assert len(scene) == 24; folder = os.path.dirname(lumatlas.__file__); assert folder.startswith('${consumer_prefix}'); assert {'py.typed', '__init__.pyi'} <= set(os.listdir(folder))")
  set_tests_properties("package: python" PROPERTIES FIXTURES_REQUIRED "lumatlas_installed;lumatlas_scene")
endif()
