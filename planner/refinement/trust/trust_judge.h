// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: judges the blocks of a photograph by the other views of the same surface, see trust.h.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/pyramid.h"
#include "planner/refinement/trust/trust.h"
#include "planner/refinement/trust/trust_blocks.h"

namespace lumatlas {

// Returns blocks as many as `visible` has pixels. `gain` as in trust_mask().
[[nodiscard]] TrustGrid trust_grid(const Pyramid& pyramid, const glm::dvec3& gain, const VisibilityBuffer& visible);

// Keeps references to all that it is given. The arguments are those of trust_mask().
class TrustJudge {
 public:
  TrustJudge(const TrustGrid& grid, const Camera& camera, const VisibilityBuffer& visible, const Atlas& atlas,
             std::span<const std::optional<ComparedView>> views, std::optional<ViewSlot> self,
             const TrustOptions& options, TrustExtent extent);

  // `block`: below the grid's size(). With TrustExtent::blocks, a block that is doubtful may be called trusted: fewer
  // views are then looked at. May be called by several threads at once.
  [[nodiscard]] Judgement at(std::size_t block) const;

 private:
  struct OtherView;
  struct Consensus;

  [[nodiscard]] bool agrees_with_most(std::size_t block, std::vector<OtherView>& others) const;
  [[nodiscard]] double difference(std::size_t block, const Consensus& others) const;
  [[nodiscard]] bool may_be_highlight(std::size_t block, const Consensus& others) const;
  [[nodiscard]] static Consensus consensus(const std::vector<OtherView>& others);
  [[nodiscard]] static bool is_wide_enough(const std::vector<OtherView>& others);

  const TrustGrid& grid_;
  const Camera& camera_;
  const VisibilityBuffer& visible_;
  const Atlas& atlas_;
  std::span<const std::optional<ComparedView>> views_;
  std::optional<ViewSlot> self_;
  const TrustOptions& options_;
  TrustExtent extent_;
  double comparable_;                // cosine
  std::vector<glm::dvec3> centers_;  // the views' camera centres
};

}  // namespace lumatlas
