# SPDX-License-Identifier: GPL-3.0-or-later
# Run as a script: writes OUTPUT, a C++ source that holds HTML and STYLE as string constants, and one script made of
# SCRIPTS (a comma-separated list of paths): ES modules that only import each other, joined in this order. Their lines
# `import ... from './other.js';` are left out, the word `export` of all but the last, comments of types, `/** */`, and
# lines of comments but the first of each module, which names its licence.
string(REPLACE "," ";" SCRIPTS "${SCRIPTS}")
list(GET SCRIPTS -1 entry)

set(script "")
foreach(path ${SCRIPTS})
  file(READ ${path} text)
  string(REGEX REPLACE "(^|\n)import [^\n]* from '[^']*';" "" text "${text}")
  string(REGEX REPLACE "\n *[/][*][*]([^*]|[*]+[^*/])*[*]+[/]" "" text "${text}")
  string(REGEX REPLACE "\n *//[^\n]*" "" text "${text}")
  if(NOT path STREQUAL entry)
    string(REGEX REPLACE "\nexport " "\n" text "${text}")
  endif()
  string(APPEND script "${text}")
endforeach()

file(READ ${HTML} html)
file(READ ${STYLE} style)
set(source "// Written by tools/cmake/EmbedPage.cmake.\n#include \"tools/viewer/page_assets.h\"\n\nnamespace lumatlas {\n\n")
foreach(part html style script)
  string(APPEND source "const std::string_view k_page_${part} = R\"lumatlas(${${part}})lumatlas\";\n")
endforeach()
string(APPEND source "\n}  // namespace lumatlas\n")
file(WRITE ${OUTPUT}.new "${source}")
file(RENAME ${OUTPUT}.new ${OUTPUT})
