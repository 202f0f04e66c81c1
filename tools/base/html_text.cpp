// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/html_text.h"

#include <cstdio>
#include <set>
#include <stdexcept>

namespace lumatlas {

namespace {

bool is_plain_in_url(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
         c == '_' || c == '~' || c == '/';
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string url_of(const std::string& path) {
  std::string result;
  for (const char c : path) {
    if (is_plain_in_url(c)) {
      result += c;
    } else {
      char code[4];
      std::snprintf(code, sizeof(code), "%%%02X", unsigned{static_cast<unsigned char>(c)});
      result += code;
    }
  }
  return result;
}

std::string filled_template(std::string_view text, const std::map<std::string, std::string>& values) {
  std::string result;
  std::set<std::string> used;
  for (std::size_t at = 0;;) {
    const std::size_t place = text.find("{{", at);
    result += text.substr(at, place == std::string_view::npos ? place : place - at);
    if (place == std::string_view::npos) break;
    const std::size_t end = text.find("}}", place);
    if (end == std::string_view::npos) throw std::logic_error("a template has \"{{\" without \"}}\"");
    const std::string name(text.substr(place + 2, end - place - 2));
    const auto value = values.find(name);
    if (value == values.end()) throw std::logic_error("a template has a place for " + name + ", which has no value");
    result += value->second;
    used.insert(name);
    at = end + 2;
  }
  for (const auto& [name, value] : values) {
    if (!used.contains(name)) throw std::logic_error("a template has no place for " + name);
  }
  return result;
}

}  // namespace lumatlas
