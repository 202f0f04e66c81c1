// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the page's shaders, and how it blends, to the standard output, for pages that do not get them from a site.
// `npm pack` takes them into the package (package/pack.mjs).
#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "tools/viewer/site.h"

int main() {
  const std::vector<lumatlas::SiteFile> files = lumatlas::page_files("");
  const auto shaders = std::find_if(files.begin(), files.end(),
                                    [](const lumatlas::SiteFile& file) { return file.name == "shaders.json"; });
  if (shaders == files.end()) return 1;
  std::cout << std::string(shaders->bytes.begin(), shaders->bytes.end()) << '\n';
  return std::cout.flush() ? 0 : 1;
}
