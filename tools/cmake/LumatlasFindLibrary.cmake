# SPDX-License-Identifier: GPL-3.0-or-later
# For the Find modules beside it, of packages that install a header and a library and no CMake configuration.
include(FindPackageHandleStandardArgs)

# lumatlas_find_library(NAME HEADER LIBRARY)
# Looks for both, sets NAME_FOUND, and makes the target NAME::NAME where they are found.
macro(lumatlas_find_library name header library)
  find_path(${name}_INCLUDE_DIR ${header})
  find_library(${name}_LIBRARY ${library})
  mark_as_advanced(${name}_INCLUDE_DIR ${name}_LIBRARY)
  find_package_handle_standard_args(${name} REQUIRED_VARS ${name}_LIBRARY ${name}_INCLUDE_DIR)
  if(${name}_FOUND AND NOT TARGET ${name}::${name})
    add_library(${name}::${name} UNKNOWN IMPORTED)
    set_target_properties(${name}::${name} PROPERTIES
      IMPORTED_LOCATION "${${name}_LIBRARY}"
      INTERFACE_INCLUDE_DIRECTORIES "${${name}_INCLUDE_DIR}")
  endif()
endmacro()
