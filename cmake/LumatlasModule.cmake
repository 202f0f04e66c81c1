# SPDX-License-Identifier: GPL-3.0-or-later
# What every module of lumatlas has in common: one static library, an alias, warnings, sanitizers.
include(GNUInstallDirs)

function(lumatlas_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                           -Wnon-virtual-dtor -Wold-style-cast)
  if(LUMATLAS_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(LUMATLAS_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${LUMATLAS_SANITIZE} -fno-omit-frame-pointer
                                            -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${LUMATLAS_SANITIZE})
  endif()
endfunction()

# lumatlas_module(NAME SOURCES ... HEADERS ... PUBLIC ... PRIVATE ...)
# Makes lumatlas_NAME with the alias lumatlas::NAME; its headers are included as "NAME/header.h".
function(lumatlas_module name)
  cmake_parse_arguments(arg "" "" "SOURCES;HEADERS;PUBLIC;PRIVATE" ${ARGN})
  add_library(lumatlas_${name} STATIC ${arg_SOURCES})
  add_library(lumatlas::${name} ALIAS lumatlas_${name})
  set_target_properties(lumatlas_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_sources(lumatlas_${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${arg_HEADERS})
  target_link_libraries(lumatlas_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
  lumatlas_compile_options(lumatlas_${name})
endfunction()
