// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/http/files_together.h"

#include <algorithm>
#include <set>

namespace lumatlas {

namespace {

void append(std::uint32_t value, std::vector<std::uint8_t>& bytes) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

std::vector<std::uint8_t> files_together(std::string_view query, const FindSiteFile& find) {
  std::vector<std::uint8_t> all;
  std::size_t left = kMostBytesTogether;
  std::set<std::string_view> named;
  for (std::size_t at = 0; at < query.size();) {
    const std::size_t end = std::min(query.find('&', at), query.size());
    const std::string_view name = query.substr(at, end - at);
    at = end + 1;
    const std::shared_ptr<const SiteFile> file = named.insert(name).second ? find(std::string(name)) : nullptr;
    if (!file || !file->path.empty() || file->bytes.size() > left) {
      append(kNotTogether, all);
      continue;
    }
    left -= file->bytes.size();
    append(static_cast<std::uint32_t>(file->bytes.size()), all);
    all.insert(all.end(), file->bytes.begin(), file->bytes.end());
  }
  return all;
}

}  // namespace lumatlas
