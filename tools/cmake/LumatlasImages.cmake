# SPDX-License-Identifier: GPL-3.0-or-later
# LUMATLAS_IMAGES_ON_DEMAND: the code that reads and writes images is the shared library lumatlas-images, which a program
# opens when it meets the first image. Without that, each start of a program waits for the 260 libraries that
# OpenImageIO brings along.
#
# Programs find it by their run path: where it is built, or from where they are installed, in lib/lumatlas beside bin.
set(on_demand ${PROJECT_IS_TOP_LEVEL})
if(LUMATLAS_SANITIZE)
  set(on_demand OFF)
endif()
option(LUMATLAS_IMAGES_ON_DEMAND "Open the libraries for images when the first image is met" ${on_demand})

set(LUMATLAS_IMAGES_DIR lib/lumatlas)  # below the prefix
if(LUMATLAS_IMAGES_ON_DEMAND)
  set(CMAKE_BUILD_RPATH ${PROJECT_BINARY_DIR}/atlas)
  set(CMAKE_INSTALL_RPATH $ORIGIN/../lib/lumatlas)
endif()

# lumatlas_image_library(SOURCES ... PRIVATE ...): lumatlas_images, which exports one function.
function(lumatlas_image_library)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "SOURCES;PRIVATE")
  add_library(lumatlas_images MODULE ${arg_SOURCES})
  set_target_properties(lumatlas_images PROPERTIES
    OUTPUT_NAME lumatlas-images
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    BUILD_RPATH ""
    INSTALL_RPATH "")
  target_link_libraries(lumatlas_images PRIVATE ${arg_PRIVATE})
  target_link_options(lumatlas_images PRIVATE LINKER:--exclude-libs,ALL LINKER:--no-undefined)
  target_compile_definitions(lumatlas_images PRIVATE LUMATLAS_VERSION="${PROJECT_VERSION}")
  lumatlas_compile_options(lumatlas_images)
  if(LUMATLAS_COMMON_HEADERS)
    target_precompile_headers(lumatlas_images REUSE_FROM lumatlas_common_headers)
  endif()
  lumatlas_compile_together(lumatlas_images)
  if(LUMATLAS_INSTALL)
    install(TARGETS lumatlas_images LIBRARY DESTINATION ${LUMATLAS_IMAGES_DIR} COMPONENT program)
  endif()
endfunction()

# lumatlas_open_images_on_demand(TARGET): TARGET opens lumatlas_images; what links the installed TARGET looks for it where
# it was installed.
function(lumatlas_open_images_on_demand target)
  target_compile_definitions(${target} PRIVATE
    LUMATLAS_VERSION="${PROJECT_VERSION}" LUMATLAS_IMAGES_FILE="$<TARGET_FILE_NAME:lumatlas_images>")
  add_dependencies(${target} lumatlas_images)
  target_link_options(${target} INTERFACE
    $<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${LUMATLAS_IMAGES_DIR}>)
endfunction()
