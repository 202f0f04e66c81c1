# SPDX-License-Identifier: GPL-3.0-or-later
# LUMATLAS_PYTHON: whether the Python module is built. It is where pybind11 and Python's headers are found.
#
# Debian's own Python is asked for first, whatever other one PATH has: what is installed into dist-packages is for that. A
# sanitized module could not be loaded by a Python that is not sanitized. Who says OFF needs none of this, and may not have
# it yet.
if(DEFINED LUMATLAS_PYTHON AND NOT LUMATLAS_PYTHON)
  return()
endif()
if(EXISTS /usr/bin/python3 AND NOT DEFINED Python3_EXECUTABLE)
  set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The Python that the module is for")
endif()
find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
if(Python3_Development.Module_FOUND)
  find_package(pybind11 2.10 QUIET)
endif()
set(found_all OFF)
if(pybind11_FOUND AND NOT LUMATLAS_SANITIZE AND PROJECT_IS_TOP_LEVEL)
  set(found_all ON)
endif()
option(LUMATLAS_PYTHON "Build the Python module" ${found_all})
if(LUMATLAS_PYTHON AND NOT pybind11_FOUND)
  message(FATAL_ERROR "LUMATLAS_PYTHON needs pybind11 and Python's headers (pybind11-dev, python3-dev)")
endif()
