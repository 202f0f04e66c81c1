// SPDX-License-Identifier: GPL-3.0-or-later
// Finds in COLMAP's own output why it placed no photograph.
#pragma once

#include <cstddef>
#include <string>

namespace lumatlas {

// The counts in a log of `colmap feature_extractor`: photographs that it searched for features, and those without any.
struct FeatureCounts {
  std::size_t photographs = 0, without_features = 0;
};
[[nodiscard]] FeatureCounts feature_counts(const std::string& log);

// Why the log of `colmap mapper` has no reconstruction, and what to do, as the end of a sentence; empty: it does not
// say. `exhaustive`: each photograph was compared with each.
[[nodiscard]] std::string why_no_reconstruction(const std::string& log, bool exhaustive);

// The last line that says something: neither blank, nor a rule, nor part of a stack trace. Empty: there is none.
[[nodiscard]] std::string last_told(const std::string& log);

}  // namespace lumatlas
