# SPDX-License-Identifier: GPL-3.0-or-later
# Configures, builds and runs tests/consumer with one component of an installed lumatlas.
#
#   cmake -D PREFIX=... -D COMPONENT=... -D WORK=... [-D WITHOUT="Ceres,epoxy"] [-D UNLINKED="libGL,libEGL"] -P run.cmake
#
# WITHOUT: packages that must not be needed (any look for them fails). UNLINKED: libraries that the program must not name.
# Further: GENERATOR, COMPILER, READELF.
string(REPLACE "," ";" WITHOUT "${WITHOUT}")
string(REPLACE "," ";" UNLINKED "${UNLINKED}")
list(TRANSFORM WITHOUT REPLACE "^(.+)$" "-DCMAKE_DISABLE_FIND_PACKAGE_\\1=ON")

function(run step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "lumatlas::${COMPONENT}: ${step} failed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run("configuring" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK} -G ${GENERATOR} -DCOMPONENT=${COMPONENT}
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${PREFIX} ${WITHOUT})
run("building" ${CMAKE_COMMAND} --build ${WORK})
run("running" ${WORK}/consumer)
message(STATUS "${output}")

run("reading the libraries it names" ${READELF} --dynamic --wide ${WORK}/consumer)
if(NOT output MATCHES "libstdc")
  message(FATAL_ERROR "lumatlas::${COMPONENT}: no list of libraries in:\n${output}")
endif()
foreach(library IN LISTS UNLINKED)
  if(output MATCHES "${library}\\.so[^]]*")
    message(FATAL_ERROR "lumatlas::${COMPONENT}: the program names ${CMAKE_MATCH_0}, which this component does without")
  endif()
endforeach()
