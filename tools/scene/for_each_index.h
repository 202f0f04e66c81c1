// SPDX-License-Identifier: GPL-3.0-or-later
// Does the same work on each of many files, in parallel.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "mesh/base/errors.h"

namespace lumatlas {

// Runs task(0) ... task(count - 1) in parallel; of the InputErrors, the one of the least index is thrown.
template <typename Task>
void for_each_index(std::size_t count, const Task& task) {
  std::vector<std::string> errors(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    try {
      task(i);
    } catch (const InputError& error) {
      errors[i] = error.what();
    }
  });
  const auto first = std::find_if(errors.begin(), errors.end(), [](const std::string& e) { return !e.empty(); });
  if (first != errors.end()) {
    throw InputError(*first);
  }
}

}  // namespace lumatlas
