// SPDX-License-Identifier: GPL-3.0-or-later
// Decides whether a built model may be saved: only a better model may replace a good one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "tools/pipeline/build_model.h"

namespace lumatlas {

// Counts how many of a scene's photographs a built model uses.
struct PhotographsUsed {
  std::size_t wanted = 0;     // photographs that the scene lists and that are not held out, and `unplaced`
  std::size_t looked_at = 0;  // those whose photograph came, could be read and agrees with the others
  std::size_t stored = 0;
};

// `unplaced`: photographs that were given for the model, but have no pose and are not in the scene for that reason.
[[nodiscard]] PhotographsUsed photographs_used(const BuildResult& result, std::size_t unplaced);

// Throws InputError where the model holds no photograph, whether something stands at `output` or not; and where it
// misses most of the photographs wanted and would take the place of what stands at `output` now.
void require_worth_saving(const BuildResult& result, std::size_t unplaced, const std::filesystem::path& output);

// Throws InputError, naming `model`, where this model holds no photograph.
void require_views(const Snapshot& snapshot, const std::filesystem::path& model);

}  // namespace lumatlas
