// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/trust.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kOverexposed = 0.9;      // linear light of a channel, after averaging: clipped in part
constexpr double kAnyBrightness = 1e3;    // above every square root of linear light
constexpr double kHighlightSlack = 0.03;  // how much darker a highlight may seem in a channel, for noise
constexpr int kNeighboursAgreeing = 5;    // among the 3x3 blocks around one, itself included: no lone errors

// Blocks of pixels of the photograph, each with the surface point at its middle.
struct TrustGrid {
  std::uint32_t width, height;
  // Square roots of linear light: range over the 3x3 blocks around. Where one of them is overexposed in a channel, and
  // not in all, the photograph does not say how bright that channel is, and `high` is kAnyBrightness.
  std::vector<glm::dvec3> low, high;
  [[nodiscard]] std::size_t size() const { return std::size_t{width} * height; }
};

enum class Judgement : std::uint8_t { trusted, contradicted };

struct OtherView {
  glm::dvec3 color;      // square roots of linear light, at the common exposure
  glm::dvec3 direction;  // unit, from the surface to it
  double cosine;         // between that and the judged view's direction
};

glm::dvec3 encoded(const glm::dvec3& linear) {
  return glm::sqrt(glm::clamp(linear, 0.0, 4.0));
}

glm::dvec2 image_of(const PhotographSpan& photograph, const TrustGrid& grid, std::uint32_t x, std::uint32_t y) {
  return {(x + 0.5) * photograph.width / grid.width, (y + 0.5) * photograph.height / grid.height};
}

// Returns the most that the channels of a block may be, square roots of linear light. `shown`: the photograph's linear
// light, `color` its square roots at the common exposure.
glm::dvec3 brightest(const glm::dvec3& shown, const glm::dvec3& color) {
  const auto clipped = glm::greaterThan(shown, glm::dvec3(kOverexposed));
  if (glm::all(clipped)) return color;  // white says nothing of a colour, and gives way to photographs that do
  return glm::mix(color, glm::dvec3(kAnyBrightness), clipped);
}

TrustGrid make_grid(const Pyramid& pyramid, const glm::dvec3& gain, const VisibilityBuffer& visible) {
  const PhotographSpan& photograph = pyramid.level(0);
  TrustGrid grid{visible.width, visible.height, {}, {}};
  std::vector<glm::dvec3> middle(grid.size()), most(grid.size());
  const std::uint32_t level = pyramid.level_near(std::max(grid.width, grid.height));
  tbb::parallel_for(0u, grid.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      const std::size_t at = std::size_t{y} * grid.width + x;
      const glm::dvec3 color = pyramid.color(level, image_of(photograph, grid, x, y));
      middle[at] = encoded(gain * color);
      most[at] = brightest(color, middle[at]);
    }
  });
  grid.low = middle;
  grid.high = most;
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      const std::size_t at = std::size_t{y} * grid.width + x;
      for (std::uint32_t ny = y - (y > 0); ny <= std::min(y + 1, grid.height - 1); ++ny) {
        for (std::uint32_t nx = x - (x > 0); nx <= std::min(x + 1, grid.width - 1); ++nx) {
          const std::size_t neighbour = std::size_t{ny} * grid.width + nx;
          grid.low[at] = glm::min(grid.low[at], middle[neighbour]);
          grid.high[at] = glm::max(grid.high[at], most[neighbour]);
        }
      }
    }
  }
  return grid;
}

// Median by channel, and the largest median deviation from it of any channel.
struct Consensus {
  glm::dvec3 color{0.0};
  double spread = 0;
};
Consensus consensus(const std::vector<OtherView>& others) {
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

// Returns by how much a colour is outside a range, in the channel where it is most; below 0 inside.
double distance_from(const glm::dvec3& low, const glm::dvec3& high, const glm::dvec3& color) {
  const glm::dvec3 off = glm::max(low - color, color - high);
  return std::max({off.r, off.g, off.b});
}

bool differs(const glm::dvec3& low, const glm::dvec3& high, const Consensus& others, const TrustOptions& options) {
  const double most = distance_from(low, high, others.color);
  return most > options.least_difference && most > options.least_to_spread * others.spread;
}

bool may_be_highlight(const glm::dvec3& low, const glm::dvec3& high, const Consensus& others) {
  for (int channel = 0; channel < 3; ++channel) {
    const bool is_darker = low[channel] <= others.color[channel] - kHighlightSlack;
    if (is_darker && high[channel] < kAnyBrightness) return false;
  }
  return true;
}

// If the mesh is wrong, views from another direction show another part, and agree on it as long as they are close to
// each other. So they must agree over as wide an angle as they are away from the judged view.
bool is_wide_enough(const std::vector<OtherView>& others) {
  const auto nearest = std::max_element(others.begin(), others.end(),
                                        [](const OtherView& a, const OtherView& b) { return a.cosine < b.cosine; });
  return std::any_of(others.begin(), others.end(), [&](const OtherView& other) {
    return glm::dot(other.direction, nearest->direction) <= std::sqrt((1 + nearest->cosine) / 2);
  });
}

// `others` are all evidence there is.
bool is_contradicted(const glm::dvec3& low, const glm::dvec3& high, std::vector<OtherView>& others,
                     const TrustOptions& options) {
  if (others.size() < options.least_views || !is_wide_enough(others)) return false;
  const Consensus all = consensus(others);
  if (!differs(low, high, all, options)) return false;
  if (!may_be_highlight(low, high, all)) return true;
  const double near = std::cos(glm::radians(options.highlight_deg));
  std::erase_if(others, [near](const OtherView& other) { return other.cosine < near; });
  return others.size() >= options.least_views && differs(low, high, consensus(others), options);
}

class Judge {
 public:
  Judge(const Camera& camera, const PhotographSpan& photograph, const VisibilityBuffer& visible, const Atlas& atlas,
        std::span<const std::optional<ComparedView>> views, std::optional<ViewSlot> self, const TrustOptions& options)
      : camera_(camera),
        photograph_(photograph),
        visible_(visible),
        atlas_(atlas),
        views_(views),
        self_(self),
        options_(options),
        comparable_(std::cos(glm::radians(options.comparable_deg))),
        centers_(views.size()) {
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (views[slot]) centers_[slot] = views[slot]->camera.center();
    }
  }

  // `others` is filled anew.
  [[nodiscard]] Judgement at(const TrustGrid& grid, std::uint32_t x, std::uint32_t y,
                             std::vector<OtherView>& others) const {
    const std::size_t block = std::size_t{y} * grid.width + x;
    if (visible_.face[block] == FaceId::none || agrees_with_most(grid, x, y, others)) return Judgement::trusted;
    return is_contradicted(grid.low[block], grid.high[block], others, options_) ? Judgement::contradicted
                                                                                : Judgement::trusted;
  }

 private:
  // Looks at the views that are evidence for or against the block until more than half of all that can be are near
  // enough to its colours: then so is their median, whatever the others show.
  [[nodiscard]] bool agrees_with_most(const TrustGrid& grid, std::uint32_t x, std::uint32_t y,
                                      std::vector<OtherView>& others) const {
    const std::size_t block = std::size_t{y} * grid.width + x;
    const double z = static_cast<double>(visible_.depth[block]);
    const glm::dvec3 center = camera_.center();
    const glm::dvec3 position = center + z * camera_.ray(image_of(photograph_, grid, x, y));
    const glm::dvec3 direction = glm::normalize(center - position);
    const double block_size = z / camera_.fx * photograph_.width / grid.width;
    const auto& references = atlas_.references(atlas_.surface()->cells.cell_of_face[visible_.face[block]]);
    std::size_t unseen = references.size(), near = 0;
    others.clear();
    for (const ViewSlot slot : references) {
      --unseen;
      if (slot == self_ || !views_[slot]) continue;
      const glm::dvec3 towards = glm::normalize(centers_[slot] - position);
      const double cosine = glm::dot(direction, towards);
      if (cosine < comparable_) continue;
      const std::optional<glm::dvec3> color = color_in_view(*views_[slot], position, block_size);
      if (!color || std::max({color->r, color->g, color->b}) > kOverexposed) continue;
      others.push_back({encoded(views_[slot]->gain * *color), towards, cosine});
      near += distance_from(grid.low[block], grid.high[block], others.back().color) <= options_.least_difference;
      if (2 * near > others.size() + unseen) return true;
    }
    return false;
  }

  const Camera& camera_;
  const PhotographSpan& photograph_;
  const VisibilityBuffer& visible_;
  const Atlas& atlas_;
  std::span<const std::optional<ComparedView>> views_;
  std::optional<ViewSlot> self_;
  const TrustOptions& options_;
  double comparable_;                // cosine
  std::vector<glm::dvec3> centers_;  // the views' camera centres
};

int count_around(const std::vector<Judgement>& judgements, const TrustGrid& grid, std::uint32_t x, std::uint32_t y) {
  int count = 0;
  for (std::uint32_t ny = y - (y > 0); ny <= std::min(y + 1, grid.height - 1); ++ny) {
    for (std::uint32_t nx = x - (x > 0); nx <= std::min(x + 1, grid.width - 1); ++nx) {
      count += judgements[std::size_t{ny} * grid.width + nx] == Judgement::contradicted;
    }
  }
  return count;
}

// Five of every nine blocks in a square are judged first, wherever the square lies.
bool is_judged_first(std::uint32_t x, std::uint32_t y) {
  return (3 * (y % 3) + x % 3) % 2 == 0;
}

// Returns whether a block can be among kNeighboursAgreeing that are contradicted, if those that are not judged yet are
// too.
bool may_be_coherent(const std::vector<Judgement>& judgements, const TrustGrid& grid, std::uint32_t x,
                     std::uint32_t y) {
  int unjudged = 0;
  for (std::uint32_t ny = y - (y > 0); ny <= std::min(y + 1, grid.height - 1); ++ny) {
    for (std::uint32_t nx = x - (x > 0); nx <= std::min(x + 1, grid.width - 1); ++nx) {
      unjudged += !is_judged_first(nx, ny);
    }
  }
  return count_around(judgements, grid, x, y) + unjudged >= kNeighboursAgreeing;
}

// Only where those that are judged first leave it open whether some block is coherent are the others judged: what is
// left after cleaned() is the same.
std::vector<Judgement> judged(const Judge& judge, const TrustGrid& grid) {
  std::vector<Judgement> judgements(grid.size(), Judgement::trusted);
  const auto judge_those = [&](const auto& are_meant) {
    tbb::parallel_for(0u, grid.height, [&](std::uint32_t y) {
      std::vector<OtherView> others;
      for (std::uint32_t x = 0; x < grid.width; ++x) {
        if (are_meant(x, y)) judgements[std::size_t{y} * grid.width + x] = judge.at(grid, x, y, others);
      }
    });
  };
  judge_those(is_judged_first);
  std::vector<std::uint8_t> wanted(grid.size(), 0);
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      if (!may_be_coherent(judgements, grid, x, y)) continue;
      for (std::uint32_t ny = y - (y > 0); ny <= std::min(y + 1, grid.height - 1); ++ny) {
        for (std::uint32_t nx = x - (x > 0); nx <= std::min(x + 1, grid.width - 1); ++nx) {
          wanted[std::size_t{ny} * grid.width + nx] = !is_judged_first(nx, ny);
        }
      }
    }
  }
  judge_those([&](std::uint32_t x, std::uint32_t y) { return wanted[std::size_t{y} * grid.width + x] != 0; });
  return judgements;
}

// Blocks that stand alone are taken for misalignment and dropped. What is left grows by one block, because its edges
// are blurred.
std::vector<Judgement> cleaned(const std::vector<Judgement>& judgements, const TrustGrid& grid) {
  std::vector<Judgement> coherent(judgements.size(), Judgement::trusted);
  std::vector<Judgement> grown = coherent;
  const auto sweep = [&](const std::vector<Judgement>& from, int least, std::vector<Judgement>& to) {
    for (std::uint32_t y = 0; y < grid.height; ++y) {
      for (std::uint32_t x = 0; x < grid.width; ++x) {
        if (count_around(from, grid, x, y) >= least) to[std::size_t{y} * grid.width + x] = Judgement::contradicted;
      }
    }
  };
  sweep(judgements, kNeighboursAgreeing, coherent);
  sweep(coherent, 1, grown);
  return grown;
}

// Returns the position of a pixel among the blocks' middles along one axis, held at the ends.
float block_position(std::uint32_t pixel, std::uint32_t pixels, std::uint32_t blocks) {
  const float position =
      (static_cast<float>(pixel) + 0.5f) * static_cast<float>(blocks) / static_cast<float>(pixels) - 0.5f;
  return std::clamp(position, 0.0f, static_cast<float>(blocks - 1));
}

// Bilinear between the blocks' middles.
std::vector<std::uint8_t> enlarged(const std::vector<Judgement>& judgements, const TrustGrid& grid,
                                   const PhotographSpan& photograph) {
  std::vector<std::uint8_t> mask(std::size_t{photograph.width} * photograph.height);
  const auto trust = [&](std::uint32_t x, std::uint32_t y) {
    return judgements[std::size_t{y} * grid.width + x] == Judgement::trusted ? 255.0f : 0.0f;
  };
  tbb::parallel_for(0u, photograph.height, [&](std::uint32_t py) {
    const float y = block_position(py, photograph.height, grid.height);
    const auto top = static_cast<std::uint32_t>(y);
    const std::uint32_t bottom = std::min(top + 1, grid.height - 1);
    for (std::uint32_t px = 0; px < photograph.width; ++px) {
      const float x = block_position(px, photograph.width, grid.width);
      const auto left = static_cast<std::uint32_t>(x);
      const std::uint32_t right = std::min(left + 1, grid.width - 1);
      const float above = glm::mix(trust(left, top), trust(right, top), x - static_cast<float>(left));
      const float below = glm::mix(trust(left, bottom), trust(right, bottom), x - static_cast<float>(left));
      mask[std::size_t{py} * photograph.width + px] =
          static_cast<std::uint8_t>(glm::mix(above, below, y - static_cast<float>(top)) + 0.5f);
    }
  });
  return mask;
}

constexpr Requirement trust_requires{"trust"};

}  // namespace

void check(const TrustOptions& options) {
  trust_requires(options.grid_px >= 8, "grid_px", options.grid_px, "at least 8");
  trust_requires(options.least_difference > 0 && options.least_difference <= 1, "least_difference",
                 options.least_difference, "in (0, 1]");
  trust_requires(std::isfinite(options.least_to_spread) && options.least_to_spread >= 0, "least_to_spread",
                 options.least_to_spread, "finite and not negative");
  trust_requires(options.least_views >= 1, "least_views", options.least_views, "at least 1");
  trust_requires(options.comparable_deg >= 0 && options.comparable_deg <= 180, "comparable_deg", options.comparable_deg,
                 "in [0, 180]");
  trust_requires(options.highlight_deg >= 0 && options.highlight_deg <= 180, "highlight_deg", options.highlight_deg,
                 "in [0, 180]");
}

std::vector<std::uint8_t> trust_mask(const Camera& camera, const Pyramid& photograph, const glm::dvec3& gain,
                                     const VisibilityBuffer& visible, const Atlas& atlas,
                                     std::span<const std::optional<ComparedView>> views, std::optional<ViewSlot> self,
                                     const TrustOptions& options) {
  check(options);
  trust_requires.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  trust_requires(photograph.level(0).width == camera.width, "camera.width", camera.width, "the photograph's");
  trust_requires(photograph.level(0).height == camera.height, "camera.height", camera.height, "the photograph's");
  trust_requires(visible.width >= 1 && visible.height >= 1, "visible.width", visible.width,
                 "at least 1, and so the height");
  const std::size_t pixels = std::size_t{visible.width} * visible.height;
  trust_requires.has_size(visible.depth.size(), pixels, "visible.depth", "the number of its pixels");
  trust_requires.has_size(visible.face.size(), pixels, "visible.face", "the number of its pixels");
  const TrustGrid grid = make_grid(photograph, gain, visible);
  const Judge judge(camera, photograph.level(0), visible, atlas, views, self, options);
  const std::vector<Judgement> judgements = cleaned(judged(judge, grid), grid);
  if (std::find(judgements.begin(), judgements.end(), Judgement::contradicted) == judgements.end()) return {};
  return enlarged(judgements, grid, photograph.level(0));
}

}  // namespace lumatlas
