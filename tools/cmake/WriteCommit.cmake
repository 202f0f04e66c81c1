# SPDX-License-Identifier: GPL-3.0-or-later
# Writes OUTPUT, which defines lumatlas::kCommit (tools/base/commit.h), from the git repository that SOURCE is in; empty where
# there is none. A file that is right already is left alone.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
// Made by the build from tools/cmake/WriteCommit.cmake.
#include "tools/base/commit.h"

namespace lumatlas {

const char* const kCommit = "@commit@";

}  // namespace lumatlas
]])
