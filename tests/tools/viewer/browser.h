// SPDX-License-Identifier: GPL-3.0-or-later
// A site, and a page that tries it, in headless Chromium with its software WebGL 2.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/viewer/site.h"

namespace lumatlas {

// The messages of pages, by the last part of the address that they posted to: "/said/NAME".
using Said = std::map<std::string, std::string>;

// The fault that a test server adds to one request for a file.
struct Trouble {
  enum class Kind {
    none,
    refused,    // status 503
    missing,    // status 404
    cut,        // half of the bytes that the header promises
    shortened,  // half of the bytes, in an answer that is complete by its header
  };
  Kind kind = Kind::none;
  std::chrono::milliseconds delay{0};
};

// Says what happens to the request for a file of that name; may be called from several threads at once.
using Network = std::function<Trouble(const std::string& name)>;

// Serves the files, opens `start` (a path on that server, or a whole URL in which {{server}} is its address) in a new
// tab, waits until something is posted to /said/done, or the time is over, and closes the tab. All calls of a program
// share one browser, whose window has 640 x 480 pixels; each call has a server of its own, and so an origin with its
// own cache and storage. Skips the test case, and says nothing, where there is no Chromium.
[[nodiscard]] Said said_in_browser(const std::vector<SiteFile>& files, const std::string& start,
                                   const Network& network = {});

// All errors and warnings that pages said; empty: none.
[[nodiscard]] std::string problem_of(const Said& said);

}  // namespace lumatlas
