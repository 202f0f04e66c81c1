# SPDX-License-Identifier: GPL-3.0-or-later
# httplib::httplib: an HTTP server. Debian's library was compiled with these definitions, which change its classes.
include(${CMAKE_CURRENT_LIST_DIR}/LumatlasFindLibrary.cmake)
lumatlas_find_library(httplib httplib.h cpp-httplib)
if(httplib_FOUND)
  set_target_properties(httplib::httplib PROPERTIES INTERFACE_COMPILE_DEFINITIONS
    "CPPHTTPLIB_OPENSSL_SUPPORT;CPPHTTPLIB_ZLIB_SUPPORT;CPPHTTPLIB_BROTLI_SUPPORT")
endif()
