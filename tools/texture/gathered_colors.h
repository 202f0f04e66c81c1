// SPDX-License-Identifier: GPL-3.0-or-later
// The formula of surface_color.h from photographs that come one after the other, so that memory does not grow with
// their number. What they agree on is smooth, so it is gathered at a place for every 4 x 4 texels, in a round of its
// own that starts from what the stored views agree on. Then detail is gathered for each texel.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tools/texture/layout/charts.h"
#include "tools/texture/layout/filled_page.h"
#include "tools/texture/layout/texture_layout.h"
#include "tools/texture/surface_color.h"

namespace lumatlas {

// The inputs that stay the same over all photographs. Keeps references.
struct GatheredOn {
  const SurfacePlaces& places;
  const std::vector<Chart>& charts;
  const TextureLayout& layout;
  const ColorOptions& options;
};

// A place of a chart that something is gathered at.
struct GatheredPlace {
  FaceId face;
  float share_b, share_c;
  std::uint16_t x, y;  // in the chart's rectangle, texels
  bool inside;         // the texel's middle lies on the face
};

// Places of some charts, one chart after the other.
struct GatheredPlaces {
  std::vector<std::uint32_t> charts;
  std::vector<std::size_t> first;  // one more than there are charts
  std::vector<GatheredPlace> places;
};

// The consensus of all photographs, 100 bytes for every 4 x 4 texels.
class ConsensusMap {
 public:
  // Starts with what the stored views agree on.
  ConsensusMap(const GatheredOn& on, const SurfaceColors& stored);

  void add(const TextureView& view);
  // Makes the sums of this round the consensus; places without a sum keep theirs.
  void finish_round();

  // At a point of a chart's rectangle in the fine layout.
  [[nodiscard]] Consensus at(std::uint32_t chart, const glm::dvec2& in_rectangle) const;

 private:
  GatheredOn on_;
  TextureLayout coarse_;
  GatheredPlaces gathered_;
  std::vector<std::uint32_t> number_;     // for each coarse texel its place; kNoPlace: none
  std::vector<std::size_t> first_texel_;  // each chart's first in number_
  std::vector<Consensus> consensus_;
  std::vector<ConsensusSums> sums_;
};

// The colours of some charts' texels, 36 bytes a texel.
class DetailMap {
 public:
  DetailMap(const GatheredOn& on, const ConsensusMap& consensus, std::vector<std::uint32_t> charts);

  void add(const TextureView& view);

  struct Counts {
    std::uint64_t texels = 0, unseen_texels = 0;
  };
  // Onto the charts' page.
  Counts color(FilledPage& page) const;

 private:
  GatheredOn on_;
  const ConsensusMap& consensus_;
  GatheredPlaces gathered_;
  std::vector<glm::vec4> sums_;  // detail, weight
};

// An upper bound of a chart's texels.
[[nodiscard]] std::uint64_t texels_of(const ChartPlace& place);

}  // namespace lumatlas
