# SPDX-License-Identifier: GPL-3.0-or-later
# OpenCVVideo::OpenCVVideo: the modules of OpenCV that follow points through a video. Debian's packages of single modules
# bring no CMake configuration; that of all of OpenCV does, and many other packages.
include(FindPackageHandleStandardArgs)

find_path(OpenCVVideo_INCLUDE_DIR opencv2/video/tracking.hpp PATH_SUFFIXES opencv4)
set(OpenCVVideo_required OpenCVVideo_INCLUDE_DIR)
set(OpenCVVideo_libraries "")
foreach(module IN ITEMS video imgproc core)
  find_library(OpenCVVideo_${module}_LIBRARY opencv_${module})
  list(APPEND OpenCVVideo_required OpenCVVideo_${module}_LIBRARY)
  list(APPEND OpenCVVideo_libraries ${OpenCVVideo_${module}_LIBRARY})
endforeach()
mark_as_advanced(${OpenCVVideo_required})
find_package_handle_standard_args(OpenCVVideo REQUIRED_VARS ${OpenCVVideo_required})
if(OpenCVVideo_FOUND AND NOT TARGET OpenCVVideo::OpenCVVideo)
  add_library(OpenCVVideo::OpenCVVideo INTERFACE IMPORTED)
  target_include_directories(OpenCVVideo::OpenCVVideo INTERFACE "${OpenCVVideo_INCLUDE_DIR}")
  target_link_libraries(OpenCVVideo::OpenCVVideo INTERFACE ${OpenCVVideo_libraries})
endif()
