# SPDX-License-Identifier: GPL-3.0-or-later
# `cpack --config build/release/CPackConfig.cmake` makes Debian packages in the folder it is called from: lumatlas, the
# program with its manual, liblumatlas-dev, the CMake package's libraries and headers, and python3-lumatlas. Which libraries the program
# needs dpkg-shlibdeps finds out; what it loads while it runs, and what the headers include, is named here.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME lumatlas)
set(CPACK_PACKAGE_VENDOR "lumatlas")
set(CPACK_PACKAGE_CONTACT "The lumatlas maintainers <maintainers@lumatlas.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION
  "Turns a triangle mesh and posed photographs, as from COLMAP, into a
view-dependent textured scene, draws it from new viewpoints, and scores it on
photographs that were held out.")
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME lumatlas)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libegl1, libgl1-mesa-dri, libopengl0")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "gnuplot-nox, ffmpeg, colmap")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME liblumatlas-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Static libraries, headers and the CMake package of lumatlas")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libceres-dev, libcgal-dev, libeigen3-dev, libembree-dev, libepoxy-dev, libglm-dev, libjpeg-dev, liblcms2-dev, libmeshoptimizer-dev, libopenimageio-dev, libopenmesh-dev, libpugixml-dev, libtbb-dev, libutf8proc-dev, nlohmann-json3-dev, zlib1g-dev")
# The code for images is a library that programs open when they need it (LumatlasImages.cmake); it comes with the program.
if(LUMATLAS_IMAGES_ON_DEMAND)
  string(PREPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "lumatlas (= ${PROJECT_VERSION}), ")
else()
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libheif-dev, libraw-dev")
endif()

if(LUMATLAS_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-lumatlas)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python module of lumatlas")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  # The compiled part is for one version of Python.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy, libegl1, libgl1-mesa-dri, libopengl0")
  if(LUMATLAS_IMAGES_ON_DEMAND)
    string(APPEND CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS ", lumatlas (= ${PROJECT_VERSION})")
  endif()
endif()
include(CPack)
