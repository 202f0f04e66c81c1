# SPDX-License-Identifier: GPL-3.0-or-later
# OpenImageIO::OpenImageIO from the library and its headers alone. The configuration file that Debian 12 ships cannot be
# used: it insists on every OpenImageIO program and on OpenCV's headers, which libopenimageio-dev does not bring.
include(FindPackageHandleStandardArgs)
find_package(Imath CONFIG QUIET)
find_path(OpenImageIO_INCLUDE_DIR OpenImageIO/imageio.h)
find_library(OpenImageIO_LIBRARY OpenImageIO)
find_library(OpenImageIO_Util_LIBRARY OpenImageIO_Util)
mark_as_advanced(OpenImageIO_INCLUDE_DIR OpenImageIO_LIBRARY OpenImageIO_Util_LIBRARY)

set(OpenImageIO_VERSION "")
if(OpenImageIO_INCLUDE_DIR)
  file(STRINGS ${OpenImageIO_INCLUDE_DIR}/OpenImageIO/oiioversion.h _numbers
    REGEX "^#define OIIO_VERSION_(MAJOR|MINOR|PATCH) +[0-9]+")
  foreach(_number IN LISTS _numbers)
    string(REGEX REPLACE "^.* " "" _number "${_number}")
    list(APPEND OpenImageIO_VERSION ${_number})
  endforeach()
  list(JOIN OpenImageIO_VERSION . OpenImageIO_VERSION)
  unset(_numbers)
  unset(_number)
endif()

find_package_handle_standard_args(OpenImageIO
  REQUIRED_VARS OpenImageIO_LIBRARY OpenImageIO_Util_LIBRARY OpenImageIO_INCLUDE_DIR Imath_FOUND
  VERSION_VAR OpenImageIO_VERSION)

if(OpenImageIO_FOUND AND NOT TARGET OpenImageIO::OpenImageIO)
  add_library(OpenImageIO::OpenImageIO_Util UNKNOWN IMPORTED)
  set_target_properties(OpenImageIO::OpenImageIO_Util PROPERTIES
    IMPORTED_LOCATION "${OpenImageIO_Util_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES Imath::Imath)
  add_library(OpenImageIO::OpenImageIO UNKNOWN IMPORTED)
  set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
    IMPORTED_LOCATION "${OpenImageIO_LIBRARY}"
    INTERFACE_LINK_LIBRARIES OpenImageIO::OpenImageIO_Util)
endif()
