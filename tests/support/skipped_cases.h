// SPDX-License-Identifier: GPL-3.0-or-later
// The cases that skip() has recorded, for the main function of the test programs.
#pragma once

#include <string>
#include <vector>

namespace lumatlas {

struct SkippedCase {
  std::string name;    // of the test case
  std::string reason;  // why it could not be checked
};

// In the order in which they were skipped; a case with several sections may stand there more than once.
[[nodiscard]] std::vector<SkippedCase>& skipped_cases();

}  // namespace lumatlas
