# SPDX-License-Identifier: GPL-3.0-or-later
# Configures, builds and runs tests/consumer with components of an installed lumatlas.
#
#   cmake -D PREFIX=... -D COMPONENTS="pipeline,score" -D WORK=... [-D ARGUMENTS="scene,model"]
#         [-D WITHOUT="Ceres,epoxy"] [-D UNLINKED="libGL,libEGL"] -P run.cmake
#
# ARGUMENTS: of the program. WITHOUT: packages that must not be needed (any look for them fails). UNLINKED: libraries that
# the program must not name.
# Further: GENERATOR, COMPILER, READELF. LAUNCHER: of the compiler, a cache for instance; may be left out.
string(REPLACE "," ";" ARGUMENTS "${ARGUMENTS}")
string(REPLACE "," ";" WITHOUT "${WITHOUT}")
string(REPLACE "," ";" UNLINKED "${UNLINKED}")
list(TRANSFORM WITHOUT REPLACE "^(.+)$" "-DCMAKE_DISABLE_FIND_PACKAGE_\\1=ON")
if(LAUNCHER)
  set(LAUNCHER -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
endif()

function(run step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "component ${COMPONENTS}: ${step} failed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run("configuring" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK} -G ${GENERATOR} -DCOMPONENTS=${COMPONENTS}
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${PREFIX}
  ${LAUNCHER} ${WITHOUT})
run("building" ${CMAKE_COMMAND} --build ${WORK})
run("running" ${WORK}/consumer ${ARGUMENTS})
message(STATUS "${output}")

run("reading the libraries it names" ${READELF} --dynamic --wide ${WORK}/consumer)
if(NOT output MATCHES "libstdc")
  message(FATAL_ERROR "component ${COMPONENTS}: no list of libraries in:\n${output}")
endif()
foreach(library IN LISTS UNLINKED)
  if(output MATCHES "${library}\\.so[^]]*")
    message(FATAL_ERROR "component ${COMPONENTS}: the program names ${CMAKE_MATCH_0}, which this component does without")
  endif()
endforeach()
