// SPDX-License-Identifier: GPL-3.0-or-later
// A site, and a page that tries it, in headless Chromium with its software WebGL 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tools/viewer/site.h"

namespace lumatlas {

// What pages said, by the last part of the address that they posted it to: "/said/NAME".
using Said = std::map<std::string, std::string>;

// Serves the files, opens `start` (a path on that server, or a whole URL in which {{server}} is its address), and waits
// until something is posted to /said/done, or the time is over. Skips the test case, and says nothing, where there is
// no Chromium.
[[nodiscard]] Said said_in_browser(const std::vector<SiteFile>& files, const std::string& start, int width = 640,
                                   int height = 480);

[[nodiscard]] SiteFile html_file(const std::string& name, const std::string& text);

}  // namespace lumatlas
