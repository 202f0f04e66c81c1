// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/http/byte_range.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace lumatlas {

namespace {

// The number that the digits are, at most that of the type: there is no file whose size tells the two apart. None for
// what is not digits alone.
std::optional<std::uint64_t> number(std::string_view digits) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  if (digits.empty()) return std::nullopt;
  std::uint64_t value = 0;
  for (const char digit : digits) {
    if (digit < '0' || digit > '9') return std::nullopt;
    const auto added = static_cast<std::uint64_t>(digit - '0');
    value = value > (kMost - added) / 10 ? kMost : 10 * value + added;
  }
  return value;
}

std::string_view without_blanks(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool is_bytes(std::string_view unit) {
  constexpr std::string_view kBytes = "bytes";
  return std::equal(unit.begin(), unit.end(), kBytes.begin(), kBytes.end(),
                    [](char a, char b) { return a == b || (a >= 'A' && a <= 'Z' && a + ('a' - 'A') == b); });
}

constexpr ByteRange kUnsatisfiable{ByteRange::Answer::unsatisfiable, 0, 0};

ByteRange part(std::uint64_t first, std::uint64_t end) {
  return {ByteRange::Answer::part, first, end - first};
}

// One range of the list: "first-last", "first-" or "-suffix length". None for what is not.
std::optional<ByteRange> one_range(std::string_view text, std::uint64_t size) {
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(0, dash), after = text.substr(dash + 1);
  if (before.empty()) {
    const std::optional<std::uint64_t> suffix = number(after);
    if (!suffix) return std::nullopt;
    if (*suffix == 0) return kUnsatisfiable;
    if (size == 0) return ByteRange{};  // all of nothing, for which there is no Content-Range
    return part(size - std::min(*suffix, size), size);
  }
  const std::optional<std::uint64_t> first = number(before);
  const std::optional<std::uint64_t> last = after.empty() ? std::numeric_limits<std::uint64_t>::max() : number(after);
  if (!first || !last || *first > *last) return std::nullopt;
  if (*first >= size) return kUnsatisfiable;
  return part(*first, std::min(*last, size - 1) + 1);
}

}  // namespace

ByteRange byte_range(std::string_view header, std::uint64_t size) {
  const std::size_t equals = header.find('=');
  if (equals == std::string_view::npos || !is_bytes(header.substr(0, equals))) return {};
  std::string_view list = header.substr(equals + 1);
  ByteRange result = kUnsatisfiable;
  std::size_t satisfiable = 0, ranges = 0;
  for (bool more = true; more;) {
    const std::size_t comma = list.find(',');
    more = comma != std::string_view::npos;
    const std::string_view text = without_blanks(list.substr(0, comma));
    list.remove_prefix(more ? comma + 1 : list.size());
    if (text.empty()) continue;  // elements of a list may be empty
    const std::optional<ByteRange> range = one_range(text, size);
    if (!range) return kUnsatisfiable;
    ++ranges;
    if (range->answer == ByteRange::Answer::unsatisfiable) continue;
    ++satisfiable;
    result = *range;
  }
  return ranges > 1 && satisfiable > 0 ? ByteRange{} : result;
}

}  // namespace lumatlas
