# SPDX-License-Identifier: GPL-3.0-or-later
# Run as a script: writes OUTPUT, a C++ source that holds every file of SHADERS (a comma-separated list of paths) as a
# string constant named after it (blend.frag: k_blend_frag), with the lines `#include "file"` replaced by that file's text.
# HEADER, of which "blend/shaders.h" is the default, declares them.
if(NOT HEADER)
  set(HEADER blend/shaders.h)
endif()
string(REPLACE "," ";" SHADERS "${SHADERS}")

function(read_shader path result)
  if(NOT EXISTS ${path})
    message(FATAL_ERROR "shader ${path} does not exist")
  endif()
  get_filename_component(folder ${path} DIRECTORY)
  file(READ ${path} text)
  while(text MATCHES "#include \"([^\"]+)\"\n")
    set(line "${CMAKE_MATCH_0}")
    read_shader(${folder}/${CMAKE_MATCH_1} included)
    string(REPLACE "${line}" "${included}" text "${text}")
  endwhile()
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

set(source "// Written by tools/cmake/EmbedShaders.cmake .\n#include \"${HEADER}\"\n\nnamespace lumatlas {\n\n")
foreach(path ${SHADERS})
  get_filename_component(name ${path} NAME)
  string(MAKE_C_IDENTIFIER "k_${name}" identifier)
  read_shader(${path} text)
  string(APPEND source "const std::string_view ${identifier} = R\"glsl(${text})glsl\";\n")
endforeach()
string(APPEND source "\n}  // namespace lumatlas\n")
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "${source}" @ONLY)
