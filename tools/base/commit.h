// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace lumatlas {

// The commit of the sources that the program was built from: "1a2b3c4d5e6f", with "-dirty" where they were changed
// since; empty: unknown. Defined by the build, for the program lumatlas only.
extern const char* const kCommit;

}  // namespace lumatlas
