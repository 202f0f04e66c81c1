// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps as parts of a page in Markdown that people write the rest of.
#pragma once

#include <filesystem>

#include "tools/lab/sweep/shown/page.h"

namespace lumatlas {

// Replaces what stands between the lines "<!-- chart NAME -->" and "<!-- end of chart NAME -->" of each sweep, or
// appends both lines with it, and writes the plots as images/chart-NAME-N.svg beside the file, which is made if it is
// missing. Throws InputError where a file cannot be read or written, or only one of the lines is there.
void update_markdown(const std::filesystem::path& file, const ChartPage& page);

}  // namespace lumatlas
