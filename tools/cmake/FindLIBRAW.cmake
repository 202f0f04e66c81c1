# SPDX-License-Identifier: GPL-3.0-or-later
# LIBRAW::LIBRAW: LibRaw, as several threads may use it, which develops the raw photographs of cameras.
include(${CMAKE_CURRENT_LIST_DIR}/LumatlasFindLibrary.cmake)
lumatlas_find_library(LIBRAW libraw/libraw.h raw_r)
