# SPDX-License-Identifier: GPL-3.0-or-later
# LCMS2::LCMS2: Little CMS, which converts the colours of ICC profiles.
include(${CMAKE_CURRENT_LIST_DIR}/LumatlasFindLibrary.cmake)
lumatlas_find_library(LCMS2 lcms2.h lcms2)
