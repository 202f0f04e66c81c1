# SPDX-License-Identifier: GPL-3.0-or-later
# epoxy::epoxy: GL and EGL entry points, loaded when they are first called.
include(${CMAKE_CURRENT_LIST_DIR}/LumatlasFindLibrary.cmake)
lumatlas_find_library(epoxy epoxy/egl.h epoxy)
