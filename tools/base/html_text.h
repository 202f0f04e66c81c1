// SPDX-License-Identifier: GPL-3.0-or-later
// Names and paths as parts of a web page, whatever characters they hold.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace lumatlas {

// The text, safe as the content of an element and as an attribute value in quotes of either kind.
[[nodiscard]] std::string html_escaped(const std::string& text);

// A relative path with '/' as a URL: whatever could end it, or make a scheme or a query of it, is percent-encoded.
[[nodiscard]] std::string url_of(const std::string& path);

// Returns the template with each place "{{name}}" replaced by the value of that name, as it is. Values are not searched
// for places, so that a text that looks like one stays a text. Throws std::logic_error for a place without a value, a
// value without a place, and "{{" without "}}".
[[nodiscard]] std::string filled_template(std::string_view text, const std::map<std::string, std::string>& values);

}  // namespace lumatlas
