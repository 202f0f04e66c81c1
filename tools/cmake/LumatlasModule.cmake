# SPDX-License-Identifier: GPL-3.0-or-later
# What every module of lumatlas has in common: one static library, an alias, warnings, sanitizers, and its place in the
# installed package (LumatlasInstall.cmake).

# Ninja compiles in the build folder: named from there, the file is the same for ccache in every checkout.
set(lumatlas_sanitizer_ignores ${PROJECT_SOURCE_DIR}/tools/cmake/sanitizer-ignores.txt)
if(CMAKE_GENERATOR STREQUAL "Ninja")
  file(RELATIVE_PATH lumatlas_sanitizer_ignores ${CMAKE_BINARY_DIR} ${lumatlas_sanitizer_ignores})
endif()

function(lumatlas_compile_options target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                           -Wnon-virtual-dtor -Wold-style-cast)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC 12 takes "literal" + std::string for an overlapping copy (its bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(LUMATLAS_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(LUMATLAS_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${LUMATLAS_SANITIZE} -fno-omit-frame-pointer
                                            -fno-sanitize-recover=all
      $<$<CXX_COMPILER_ID:Clang>:-fsanitize-ignorelist=${lumatlas_sanitizer_ignores}>)
    target_link_options(${target} PUBLIC -fsanitize=${LUMATLAS_SANITIZE})
    # GCC's documentation warns of false alarms from this one in sanitized code.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  endif()
endfunction()

# lumatlas_compile_together(TARGET)
# Where LUMATLAS_TOGETHER is set, compiles the target's sources together, many at a time, so that headers that they all
# include are read once, and templates that they all use are compiled once. Their unnamed namespaces are then one: a name
# that two of them give to different things is an error there.
# Comes after everything else that is said of the sources: those with options of their own are compiled alone, except
# the quick ones.
option(LUMATLAS_TOGETHER "Compile many sources together: sooner from nothing, later after a change" OFF)
set(lumatlas_quick_options $<$<CONFIG:Release>:-O1>)

function(lumatlas_compile_together target)
  if(NOT LUMATLAS_TOGETHER)
    return()
  endif()
  lumatlas_join_sources(${target} "" "")
  lumatlas_join_sources(${target} _quick "${lumatlas_quick_options}")
  # GCC takes a source that is included in another for a header.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# lumatlas_join_sources(TARGET SUFFIX OPTIONS)
# Puts files that include up to 20 sources each in the place of those sources of the target that lie in this folder or
# below and have these options and no others: TARGET + SUFFIX + _0.cpp, _1.cpp and so on. CMake's own UNITY_BUILD would
# name them by where the checkout lies, and ccache would not know them in the next checkout.
function(lumatlas_join_sources target suffix options)
  get_target_property(sources ${target} SOURCES)
  set(joined "")
  foreach(source IN LISTS sources)
    get_source_file_property(own ${source} COMPILE_OPTIONS)
    get_source_file_property(apart ${source} SKIP_UNITY_BUILD_INCLUSION)
    if(NOT own)
      set(own "")
    endif()
    if(source MATCHES "\\.cpp$" AND NOT IS_ABSOLUTE ${source} AND NOT apart AND own STREQUAL options)
      list(APPEND joined ${source})
    endif()
  endforeach()
  list(REMOVE_ITEM sources ${joined})

  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  set(index 0)
  while(joined)
    list(SUBLIST joined 0 20 some)
    list(REMOVE_ITEM joined ${some})
    list(TRANSFORM some REPLACE "(.+)" "#include \"${folder}/\\1\"\n")
    list(JOIN some "" content)
    set(file ${CMAKE_CURRENT_BINARY_DIR}/${target}${suffix}_${index}.cpp)
    file(CONFIGURE OUTPUT ${file} CONTENT "${content}" @ONLY)
    set_property(SOURCE ${file} PROPERTY COMPILE_OPTIONS ${options})
    list(APPEND sources ${file})
    math(EXPR index "${index} + 1")
  endwhile()
  set_target_properties(${target} PROPERTIES SOURCES "${sources}")
endfunction()

# lumatlas_compile_quickly(TARGET)
# For what runs once or waits for a disk: a release spends no time on optimising it.
function(lumatlas_compile_quickly target)
  target_compile_options(${target} PRIVATE ${lumatlas_quick_options})
  lumatlas_compile_together(${target})
endfunction()

# lumatlas_compile_quickly_sources(SOURCES ...): the same of these sources of the folder.
function(lumatlas_compile_quickly_sources)
  set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS ${lumatlas_quick_options})
endfunction()

# lumatlas_find_package(NAME [VERSION] ...)
# find_package(NAME [VERSION] ... REQUIRED) for the module of this folder. Static libraries hand even their private
# dependencies on to the program that links them, so the installed package repeats each of these calls for a
# project that asks for this module, and for no other one.
macro(lumatlas_find_package)
  find_package(${ARGV} REQUIRED)
  string(REPLACE ";" " " _lumatlas_package "${ARGV}")
  set_property(DIRECTORY APPEND PROPERTY LUMATLAS_PACKAGES "${_lumatlas_package}")
  unset(_lumatlas_package)
endmacro()

# lumatlas_module(NAME [INTERNAL] SOURCES ... HEADERS ... PUBLIC ... PRIVATE ...)
# Makes lumatlas_NAME with the alias lumatlas::NAME; its headers are included as "NAME/header.h".
# It is installed as the package's component NAME unless it is INTERNAL.
function(lumatlas_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "INTERNAL" "" "SOURCES;HEADERS;PUBLIC;PRIVATE")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "lumatlas_module(${name}): cannot place the arguments ${arg_UNPARSED_ARGUMENTS}")
  endif()
  add_library(lumatlas_${name} STATIC ${arg_SOURCES})
  add_library(lumatlas::${name} ALIAS lumatlas_${name})
  set_target_properties(lumatlas_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_sources(lumatlas_${name} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${arg_HEADERS})
  target_link_libraries(lumatlas_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
  lumatlas_compile_options(lumatlas_${name})
  if(LUMATLAS_COMMON_HEADERS)
    target_precompile_headers(lumatlas_${name} REUSE_FROM lumatlas_common_headers)
  endif()
  if(LUMATLAS_INSTALL AND NOT arg_INTERNAL)
    lumatlas_install_module(${name} LINKS ${arg_PUBLIC} ${arg_PRIVATE})
  endif()
endfunction()
