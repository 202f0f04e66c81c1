// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/colmap_log.h"

#include <regex>
#include <sstream>

namespace lumatlas {

namespace {

bool says(const std::string& log, const char* words) {
  return log.find(words) != std::string::npos;
}

}  // namespace

FeatureCounts feature_counts(const std::string& log) {
  static const std::regex kFeatures(R"(Features:\s+(\d+))");
  FeatureCounts counts;
  for (auto at = std::sregex_iterator(log.begin(), log.end(), kFeatures); at != std::sregex_iterator(); ++at) {
    ++counts.photographs;
    if ((*at)[1].str().find_first_not_of('0') == std::string::npos) ++counts.without_features;
  }
  return counts;
}

std::string why_no_reconstruction(const std::string& log, bool exhaustive) {
  if (says(log, "No images with matches") || says(log, "(connected 0)")) {
    return std::string(
               "no two photographs were found to show the same: take more of them, in smaller steps, of what "
               "has texture") +
           (exhaustive ? "" : ", or compare each with each (--matching exhaustive)");
  }
  if (says(log, "No good initial image pair")) {
    return "photographs show the same, but no two of them from places far enough apart to start from: walk between "
           "photographs rather than turn on the spot, and let neighbours overlap by two thirds";
  }
  if (says(log, "Could not register") || says(log, "could not register") || says(log, "Discarding reconstruction")) {
    return "a start was found, but too few others could be added to it: take more photographs, in smaller steps";
  }
  return "";
}

std::string last_told(const std::string& log) {
  std::istringstream lines(log);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(" \t\r=*");
    if (begin == std::string::npos || line.compare(begin, 2, "@ ") == 0) continue;
    if (line.find("Check failure stack trace") != std::string::npos) continue;
    last = line;
  }
  return last;
}

}  // namespace lumatlas
