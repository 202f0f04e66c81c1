// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/html_text.h"

#include <cstdio>

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

}  // namespace lumatlas
