// SPDX-License-Identifier: GPL-3.0-or-later
// The stored views as a texture is coloured from them, and which of them see each cell.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "atlas/images/image_levels.h"
#include "atlas/snapshot.h"

namespace lumatlas {

// The colour of a view at a point, in linear light and the model's exposure.
struct ViewColor {
  glm::vec3 color{0.0f};
  float trust = 0;  // [0, 1]; falls smoothly to 0 towards whatever may not be used
};

// A stored view, filtered at several scales. A place of its image may be used by its *trust*: the mask of validity,
// which falls to 0 over the fading width towards the image's border, depth edges, pixels that other views contradict,
// and parts that are not in the model. So where a view begins or ends to be used, its weight is about 0.
class TextureView {
 public:
  TextureView(const Snapshot& snapshot, ViewSlot slot);
  // Takes a whole photograph and keeps a reference to it. `gain` as in Snapshot::gains.
  TextureView(const StoredView& view, const glm::dvec3& gain);

  // The position of a surface point in the view: pixels, and z in its camera. False where the view does not see it.
  struct ImagePoint {
    glm::vec2 image{0.0f};
    float depth = 0;
  };
  [[nodiscard]] bool sees(const glm::vec3& point, ImagePoint& place) const {
    return locate(point, place) && shows(place);
  }
  // The same in two steps, with time between them for the processor to fetch what the second reads: whether the point
  // is in the image, and whether what the image shows there is that point and may be used. If locate() says no, `place`
  // has no meaning, and prefetch() and shows() must not be called with it.
  [[nodiscard]] bool locate(const glm::vec3& point, ImagePoint& place) const;
  void prefetch(const ImagePoint& place) const;
  [[nodiscard]] bool shows(const ImagePoint& place) const;

  // `footprint`: how many pixels the mean is taken over, a side.
  [[nodiscard]] ViewColor sharp(const glm::vec2& image, float footprint) const;
  // The mean of the surroundings, over about a hundredth of the image: what it shows without its detail.
  [[nodiscard]] glm::vec3 smooth(const glm::vec2& image) const;

  [[nodiscard]] const glm::vec3& center() const { return center_; }
  [[nodiscard]] float focal_px() const { return focal_px_; }
  // -ln of the gain, per channel: what its photograph has against the model's exposure.
  [[nodiscard]] glm::vec3 log_exposure() const;

 private:
  TextureView(const StoredView& view, const glm::dvec3& gain, std::vector<std::uint8_t> mask);
  void find_smooth();
  [[nodiscard]] std::size_t pixel_at(const glm::vec2& image, std::uint32_t width) const {
    return static_cast<std::size_t>(image.y) * width + static_cast<std::size_t>(image.x);
  }

  const StoredView& view_;
  glm::vec3 gain_, center_, translation_;
  glm::vec3 rows_[3];                   // rows of cam_from_world
  glm::vec2 focal_, principal_, size_;  // pixels
  float focal_px_;
  std::vector<ImageLevel> levels_;  // colour, trust
  std::uint32_t smooth_unit_ = 1;   // pixels a side that one value of the next stands for
  std::uint32_t smooth_width_ = 0, smooth_height_ = 0;
  std::vector<glm::vec3> smooth_;  // linear light in the model's exposure
};

// Calls use(number of the point, its place) for all points that a view sees, in their order. They may lie anywhere in
// its image, so pixels are fetched ahead.
template <typename Use>
void for_each_seen(const TextureView& view, std::span<const glm::vec3> points, const Use& use) {
  constexpr std::size_t kAtOnce = 32;  // whose pixels are fetched together
  TextureView::ImagePoint places[kAtOnce];
  bool in_image[kAtOnce];
  for (std::size_t first = 0; first < points.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, points.size() - first);
    for (std::size_t i = 0; i < count; ++i) {
      in_image[i] = view.locate(points[first + i], places[i]);
      if (in_image[i]) view.prefetch(places[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (in_image[i] && view.shows(places[i])) use(first + i, places[i]);
    }
  }
}

struct TextureViews {
  std::vector<TextureView> views;         // every view slot's view
  std::vector<std::uint32_t> first_seen;  // one more than there are cells
  std::vector<std::uint32_t> seen_by;     // numbers in `views`: those of cell k from first_seen[k] on, ascending
  std::vector<double> density;  // one per cell: pixels per scene unit of the median view that sees it; 0: none
};

// Takes about 6 bytes a pixel of the stored views beyond what the snapshot holds, to which it keeps references.
[[nodiscard]] TextureViews texture_views(const Snapshot& snapshot);

// Returns for each cell the pixels per scene unit with which the view shows it, the most of any vertex; 0 where it sees
// none.
[[nodiscard]] std::vector<float> densities_in(const TextureView& view, const Surface& surface);

}  // namespace lumatlas
