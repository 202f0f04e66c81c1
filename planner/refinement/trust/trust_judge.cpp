// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/trust/trust_judge.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>
#include <utility>

#include "mesh/base/median.h"

namespace lumatlas {

namespace {

constexpr double kOverexposed = 0.9;      // linear light of a channel, after averaging: clipped in part
constexpr double kHighlightSlack = 0.03;  // how much darker a highlight may seem in a channel, for noise

glm::dvec3 encoded(const glm::dvec3& linear) {
  return glm::sqrt(glm::clamp(linear, 0.0, 4.0));
}

glm::dvec2 image_of(std::uint32_t width, std::uint32_t height, const TrustGrid& grid, std::uint32_t x,
                    std::uint32_t y) {
  return {(x + 0.5) * width / grid.width, (y + 0.5) * height / grid.height};
}

// Returns the most that the channels of a block may be, square roots of linear light. `shown`: the photograph's linear
// light, `color` its square roots at the common exposure.
glm::dvec3 brightest(const glm::dvec3& shown, const glm::dvec3& color) {
  const auto clipped = glm::greaterThan(shown, glm::dvec3(kOverexposed));
  if (glm::all(clipped)) return color;  // white says nothing of a colour, and gives way to photographs that do
  return glm::mix(color, glm::dvec3(kAnyBrightness), clipped);
}

// Returns by how much a colour is outside a range, in the channel where it is most; below 0 inside.
double distance_from(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& color) {
  const glm::dvec3 off = glm::max(low - color, color - high);
  return std::max({off.r, off.g, off.b});
}

}  // namespace

TrustGrid trust_grid(const Pyramid& pyramid, const glm::dvec3& gain, const VisibilityBuffer& visible) {
  const PhotographSpan& photograph = pyramid.level(0);
  TrustGrid grid{visible.width, visible.height, {}, {}, {}};
  grid.color.resize(grid.size());
  std::vector<glm::dvec3> most(grid.size());
  const std::uint32_t level = pyramid.level_near(std::max(grid.width, grid.height));
  tbb::parallel_for(0u, grid.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      const std::size_t at = std::size_t{y} * grid.width + x;
      const glm::dvec3 color = pyramid.color(level, image_of(photograph.width, photograph.height, grid, x, y));
      grid.color[at] = encoded(gain * color);
      most[at] = brightest(color, grid.color[at]);
    }
  });
  grid.low = grid.color;
  grid.high = most;
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      const std::size_t at = std::size_t{y} * grid.width + x;
      for (std::uint32_t ny = y - (y > 0); ny <= std::min(y + 1, grid.height - 1); ++ny) {
        for (std::uint32_t nx = x - (x > 0); nx <= std::min(x + 1, grid.width - 1); ++nx) {
          const std::size_t neighbour = std::size_t{ny} * grid.width + nx;
          grid.low[at] = glm::min(grid.low[at], grid.color[neighbour]);
          grid.high[at] = glm::max(grid.high[at], most[neighbour]);
        }
      }
    }
  }
  return grid;
}

struct TrustJudge::OtherView {
  glm::dvec3 color;      // square roots of linear light, at the common exposure
  glm::dvec3 direction;  // unit, from the surface to it
  double cosine;         // between that and the judged view's direction
};

// Median by channel, and the largest median deviation from it of any channel.
struct TrustJudge::Consensus {
  glm::dvec3 color{0.0};
  double spread = 0;
};

TrustJudge::Consensus TrustJudge::consensus(const std::vector<OtherView>& others) {
  Consensus result;
  std::vector<double> values(others.size());
  for (int channel = 0; channel < 3; ++channel) {
    for (std::size_t i = 0; i < others.size(); ++i) values[i] = others[i].color[channel];
    const double middle = upper_median(values);
    for (double& value : values) value = std::abs(value - middle);
    result.color[channel] = middle;
    result.spread = std::max(result.spread, upper_median(values));
  }
  return result;
}

// If the mesh is wrong, views from another direction show another part, and agree on it as long as they are close to
// each other. So they must agree over as wide an angle as they are away from the judged view.
bool TrustJudge::is_wide_enough(const std::vector<OtherView>& others) {
  const auto nearest = std::max_element(others.begin(), others.end(),
                                        [](const OtherView& a, const OtherView& b) { return a.cosine < b.cosine; });
  return std::any_of(others.begin(), others.end(), [&](const OtherView& other) {
    return glm::dot(other.direction, nearest->direction) <= std::sqrt((1 + nearest->cosine) / 2);
  });
}

// Returns how far the others' consensus is off the block, as a share of what a contradiction takes.
double TrustJudge::difference(std::size_t block, const Consensus& others) const {
  const double most = distance_from(grid_.low[block], grid_.high[block], others.color);
  if (!(most > 0)) return 0;
  return most / std::max(options_.least_difference, options_.least_to_spread * others.spread);
}

bool TrustJudge::may_be_highlight(std::size_t block, const Consensus& others) const {
  for (int channel = 0; channel < 3; ++channel) {
    const bool is_darker = grid_.low[block][channel] <= others.color[channel] - kHighlightSlack;
    if (is_darker && grid_.high[block][channel] < kAnyBrightness) return false;
  }
  return true;
}

TrustJudge::TrustJudge(const TrustGrid& grid, const Camera& camera, const VisibilityBuffer& visible, const Atlas& atlas,
                       std::span<const std::optional<ComparedView>> views, std::optional<ViewSlot> self,
                       const TrustOptions& options, TrustExtent extent)
    : grid_(grid),
      camera_(camera),
      visible_(visible),
      atlas_(atlas),
      views_(views),
      self_(self),
      options_(options),
      extent_(extent),
      comparable_(std::cos(glm::radians(options.comparable_deg))),
      centers_(views.size()) {
  for (std::size_t slot = 0; slot < views.size(); ++slot) {
    if (views[slot]) centers_[slot] = views[slot]->camera.center();
  }
}

// Looks at the views that are evidence for or against the block until more than half of all that can be are near enough
// to its colours: then so is their median, whatever the others show.
bool TrustJudge::agrees_with_most(std::size_t block, std::vector<OtherView>& others) const {
  const auto x = static_cast<std::uint32_t>(block % grid_.width), y = static_cast<std::uint32_t>(block / grid_.width);
  const double z = static_cast<double>(visible_.depth[block]);
  const glm::dvec3 center = camera_.center();
  const glm::dvec3 position = center + z * camera_.ray(image_of(camera_.width, camera_.height, grid_, x, y));
  const glm::dvec3 direction = glm::normalize(center - position);
  const double block_size = z / camera_.fx * camera_.width / grid_.width;
  const auto& references = atlas_.references(atlas_.surface()->cells.cell_of_face[visible_.face[block]]);
  const double near_enough = (extent_ == TrustExtent::blocks ? 1 : kDoubtful) * options_.least_difference;
  std::size_t unseen = references.size(), near = 0;
  for (const ViewSlot slot : references) {
    --unseen;
    if (slot == self_ || !views_[slot]) continue;
    const glm::dvec3 towards = glm::normalize(centers_[slot] - position);
    const double cosine = glm::dot(direction, towards);
    if (cosine < comparable_) continue;
    const std::optional<glm::dvec3> color = color_in_view(*views_[slot], position, block_size);
    if (!color) continue;
    const auto clipped = glm::greaterThan(*color, glm::dvec3(kOverexposed));
    if (extent_ == TrustExtent::blocks && glm::any(clipped)) continue;
    // A channel that is overexposed is at least as bright as it seems, and so agrees with all that is brighter.
    const glm::dvec3 seen = encoded(views_[slot]->gain * *color);
    others.push_back({glm::mix(seen, glm::max(seen, grid_.low[block]), clipped), towards, cosine});
    near += distance_from(grid_.low[block], grid_.high[block], others.back().color) <= near_enough;
    if (2 * near > others.size() + unseen) return true;
  }
  return false;
}

Judgement TrustJudge::at(std::size_t block) const {
  if (visible_.face[block] == FaceId::none) return Judgement::unknown;
  std::vector<OtherView> others;
  if (agrees_with_most(block, others)) return Judgement::trusted;
  if (others.size() < options_.least_views || !is_wide_enough(others)) return Judgement::unknown;
  const Consensus all = consensus(others);
  double off = difference(block, all);
  if (off > kDoubtful && may_be_highlight(block, all)) {
    const double near = std::cos(glm::radians(options_.highlight_deg));
    std::erase_if(others, [near](const OtherView& other) { return other.cosine < near; });
    if (others.size() < options_.least_views) return Judgement::trusted;
    off = std::min(off, difference(block, consensus(others)));
  }
  if (off > 1) return Judgement::contradicted;
  return off > kDoubtful ? Judgement::doubtful : Judgement::trusted;
}

}  // namespace lumatlas
