# SPDX-License-Identifier: GPL-3.0-or-later
# The headers that most sources include, compiled once for all modules: half a second less for each of their files. Every
# source still includes what it uses; tools/tidy reads each without this and so shows what is missing.
option(LUMATLAS_COMMON_HEADERS "Compile the most common headers once for all modules" ON)

# GCC wants the macros of the precompiled header wherever that is used, and TBB defines one in this configuration alone.
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  set(LUMATLAS_COMMON_HEADERS OFF)
endif()

if(LUMATLAS_COMMON_HEADERS)
  find_package(glm REQUIRED)
  find_package(TBB REQUIRED)
  file(CONFIGURE OUTPUT common_headers.cpp CONTENT "// The headers are all that there is to compile.\n")
  add_library(lumatlas_common_headers OBJECT ${CMAKE_CURRENT_BINARY_DIR}/common_headers.cpp)
  set_target_properties(lumatlas_common_headers PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_link_libraries(lumatlas_common_headers PRIVATE glm::glm TBB::tbb)
  target_precompile_headers(lumatlas_common_headers PRIVATE
    <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream> <functional> <limits> <map> <memory> <numeric>
    <optional> <span> <sstream> <stdexcept> <string> <string_view> <utility> <vector>
    <glm/glm.hpp> <tbb/parallel_for.h>)
  lumatlas_compile_options(lumatlas_common_headers)
  # Clang notes when the headers were written, which each checkout and each configuration does anew: ccache would take
  # them for others.
  target_compile_options(lumatlas_common_headers PRIVATE $<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>)
endif()
