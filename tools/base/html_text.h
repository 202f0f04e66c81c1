// SPDX-License-Identifier: GPL-3.0-or-later
// Names and paths as parts of a web page, whatever characters they hold.
#pragma once

#include <string>

namespace lumatlas {

// The text, safe as the content of an element and as an attribute value in quotes of either kind.
[[nodiscard]] std::string html_escaped(const std::string& text);

// A relative path with '/' as a URL: whatever could end it, or make a scheme or a query of it, is percent-encoded.
[[nodiscard]] std::string url_of(const std::string& path);

}  // namespace lumatlas
