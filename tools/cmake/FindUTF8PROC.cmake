# SPDX-License-Identifier: GPL-3.0-or-later
# UTF8PROC::UTF8PROC: utf8proc, which compares names of any script.
include(${CMAKE_CURRENT_LIST_DIR}/LumatlasFindLibrary.cmake)
lumatlas_find_library(UTF8PROC utf8proc.h utf8proc)
