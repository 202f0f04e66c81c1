// SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "tools/scene/scene.h"

namespace lumatlas {

void check(const HoldOut& protocol) {
  if (protocol.hold < 2) {
    throw std::invalid_argument("hold is " + std::to_string(protocol.hold) + ", must be at least 2");
  }
  if (protocol.block < 1) {
    throw std::invalid_argument("block is " + std::to_string(protocol.block) + ", must be at least 1");
  }
}

Split split(std::size_t view_count, const HoldOut& protocol) {
  check(protocol);
  Split result;
  for (std::size_t rank = 0; rank < view_count; ++rank) {
    if ((rank / protocol.block) % protocol.hold != 0) {
      result.input.push_back(rank);
      continue;
    }
    const std::size_t in_block = rank % protocol.block;  // written so that no block is too large for a product
    const std::size_t quarter = protocol.block / 4;
    const std::size_t three_quarters = protocol.block - (protocol.block + 3) / 4;  // floor(3 block / 4)
    if (in_block == quarter || in_block == protocol.block / 2 || in_block == three_quarters) {
      result.scored.push_back(rank);
    }
  }
  return result;
}

Split split(const SceneViews& scene, const std::optional<HoldOut>& protocol) {
  Split result;
  if (protocol) {
    result = split(scene.views.size(), *protocol);
  } else {
    for (std::size_t rank = 0; rank < scene.views.size(); ++rank) {
      (scene.views[rank].held_out ? result.scored : result.input).push_back(rank);
    }
  }
  leave_out_bad(scene, result.input);
  leave_out_bad(scene, result.scored);
  return result;
}

Split split_to_score(const SceneViews& scene, const std::optional<HoldOut>& protocol) {
  Split result = split(scene, protocol);
  if (!result.scored.empty()) return result;
  if (!protocol) throw InputError(scene.root.string() + ": names no photograph that can be scored: give --hold");
  throw InputError(scene.root.string() + ": the protocol scores none of its " + std::to_string(scene.views.size()) +
                   " views: check --hold and --block");
}

}  // namespace lumatlas
