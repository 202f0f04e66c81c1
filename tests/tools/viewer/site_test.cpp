// SPDX-License-Identifier: GPL-3.0-or-later
// What a site is written as.
#include "tools/viewer/site.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/small_scenes.h"

namespace lumatlas {
namespace {

Snapshot small_room() { return room_snapshot(3, {}, {16, 2, 0}); }

TEST_CASE(
    "a title that looks like a place in the page's template stays a title") {
  SiteOptions options;
  options.title = "a{{data}}b{{script}}{{style}}{{title}}{{x";
  std::ostringstream page;
  write_one_page(page, small_room(), options);
  const std::string html = page.str();
  CHECK(html.find("<title>" + options.title + "</title>") != std::string::npos);
  // The data stands in the body, where the page looks for it, and the page's
  // script after it.
  const std::size_t first =
      html.find("<script type=\"application/octet-stream\"");
  REQUIRE(first != std::string::npos);
  CHECK(first > html.find("<main>"));
  CHECK(html.find("<script type=\"module\">") >
        html.rfind("<script type=\"application/octet-stream\""));
  const std::vector<std::uint8_t> index = page_files(options).front().bytes;
  CHECK(std::string(index.begin(), index.end())
            .find("<title>" + options.title + "</title>") != std::string::npos);
}

} // namespace
} // namespace lumatlas
