// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/http/host_header.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>

namespace lumatlas {

namespace {

bool same_but_for_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char left, unsigned char right) { return std::tolower(left) == std::tolower(right); });
}

// "" or ":8080".
bool is_port(std::string_view text) {
  if (text.empty()) return true;
  if (text.front() != ':' || text.size() > 6) return false;
  text.remove_prefix(1);
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

bool names_this_server(std::string_view header, const std::string& given) {
  boost::system::error_code none;
  if (!header.empty() && header.front() == '[') {
    const std::size_t end = header.find(']');
    if (end == std::string_view::npos || !is_port(header.substr(end + 1))) return false;
    boost::asio::ip::make_address_v6(std::string(header.substr(1, end - 1)), none);
    return !none;
  }
  const std::size_t colon = std::min(header.find(':'), header.size());
  if (!is_port(header.substr(colon))) return false;
  const std::string_view name = header.substr(0, colon);
  boost::asio::ip::make_address_v4(std::string(name), none);
  return !none || same_but_for_case(name, "localhost") || (!name.empty() && same_but_for_case(name, given));
}

}  // namespace lumatlas
