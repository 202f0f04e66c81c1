// SPDX-License-Identifier: GPL-3.0-or-later
// Lines, fields and numbers of text files, and how a message quotes them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace lumatlas {

// Cuts the first line off `text`, without its line feed; the last line may lack one.
[[nodiscard]] std::string_view take_line(std::string_view& text, char line_feed = '\n');

// Cuts the first field off `line`; fields are separated by any of `separators`. Empty when there is none left.
[[nodiscard]] std::string_view take_field(std::string_view& line, std::string_view separators = " \t\r\v\f");

// The whole field as a number, correctly rounded, in any locale; also "nan", "inf" and a leading plus.
// Beyond the range of double: infinity or 0.
[[nodiscard]] std::optional<double> parse_number(std::string_view field);

// The whole field as a decimal number without a fraction; none if it is anything else or does not fit.
[[nodiscard]] std::optional<long long> parse_integer(std::string_view field);

// The field in single quotes, shortened, without characters that would break a one-line message.
[[nodiscard]] std::string in_quotes(std::string_view field);

// Another library's reason as a part of a one-line message: blanks for control characters, none at its end, and "..."
// after 200 bytes or a few less, so that no character is cut. Such reasons may quote all of a file.
[[nodiscard]] std::string short_reason(std::string_view reason);

}  // namespace lumatlas
