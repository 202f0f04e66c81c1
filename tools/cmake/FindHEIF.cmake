# SPDX-License-Identifier: GPL-3.0-or-later
# HEIF::HEIF: libheif, which reads HEIC and AVIF photographs.
include(${CMAKE_CURRENT_LIST_DIR}/LumatlasFindLibrary.cmake)
lumatlas_find_library(HEIF libheif/heif.h heif)
