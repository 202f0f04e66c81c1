// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/planning/block_cut.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <utility>

#include "mesh/visibility/shown_box.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

// The photographs in which each cell has most pixels. All entries are in one piece of memory, of which cells that are
// not seen touch nothing: small pieces would lie between the large ones of meshes that come and go.
class BestViews {
 public:
  explicit BestViews(std::size_t cells)
      : entries_(std::make_unique_for_overwrite<Entry[]>(cells * kViewsPerCell)), counts_(cells, 0) {}

  void offer(std::size_t cell, std::uint32_t pixels, std::uint32_t view) {
    Entry* const best = entries_.get() + cell * kViewsPerCell;  // a heap, the fewest pixels first
    std::uint8_t& count = counts_[cell];
    if (count == kViewsPerCell) {
      if (pixels <= best[0].pixels) return;
      std::pop_heap(best, best + count, more_pixels);
      --count;
    }
    best[count++] = {pixels, view};
    std::push_heap(best, best + count, more_pixels);
  }
  void add_to(std::size_t cell, std::vector<std::size_t>& views) const {
    const Entry* const best = entries_.get() + cell * kViewsPerCell;
    for (std::size_t i = 0; i < counts_[cell]; ++i) views.push_back(best[i].view);
  }

 private:
  struct Entry {
    std::uint32_t pixels, view;
  };
  static bool more_pixels(const Entry& a, const Entry& b) {
    return a.pixels != b.pixels ? a.pixels > b.pixels : a.view > b.view;
  }

  std::unique_ptr<Entry[]> entries_;
  std::vector<std::uint8_t> counts_;
};

void sort_once(std::vector<std::size_t>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

// Spreads the lowest 10 bits of a number to every third bit.
std::uint32_t spread_bits(std::uint32_t bits) {
  std::uint32_t spread = 0;
  for (std::uint32_t bit = 0; bit < 10; ++bit) spread |= (bits >> bit & 1u) << (3 * bit);
  return spread;
}

// Returns the views so that those near each other follow each other, by a Morton curve through their places.
std::vector<std::size_t> neighbors_in_order(const std::vector<CityView>& views) {
  Bounds box;
  for (const CityView& view : views) box = with(box, view.camera.center());
  std::vector<std::pair<std::uint32_t, std::size_t>> keyed;
  for (std::size_t view = 0; view < views.size(); ++view) {
    const glm::dvec3 extent = glm::max(box.max - box.min, glm::dvec3(std::numeric_limits<double>::min()));
    const glm::dvec3 place = (views[view].camera.center() - box.min) / extent;
    std::uint32_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key |= spread_bits(static_cast<std::uint32_t>(1023 * glm::clamp(place[axis], 0.0, 1.0))) << axis;
    }
    keyed.emplace_back(key, view);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::size_t> order;
  order.reserve(keyed.size());
  for (const auto& [key, view] : keyed) order.push_back(view);
  return order;
}

// Looks through all cameras of a plan, and finds for each chunk the views that show one of its cells best, and for each
// view and chunk the chunks that may stand between them.
class Looks {
 public:
  Looks(const SeenCity& city, const CityPlan& plan, const BuildCallback& callback)
      : city_(city), plan_(plan), first_cell_(1, 0), before_(plan.views.size()) {
    for (std::size_t chunk = 0; chunk < plan.chunks.size(); ++chunk) {
      chunk_of_face_.insert(chunk_of_face_.end(), plan.chunks[chunk].size.faces, static_cast<std::uint32_t>(chunk));
      first_cell_.push_back(first_cell_.back() + plan.chunks[chunk].size.cells);
    }
    pixels_.resize(first_cell_.back() + city.far.cells, 0);
    look(callback);
  }

  // Returns the views that show some cell of these chunks best.
  [[nodiscard]] const std::vector<std::vector<std::size_t>>& views_of_chunks() const { return views_; }
  [[nodiscard]] const std::vector<std::size_t>& views_of_far() const { return far_views_; }

  // Returns the chunks that may stand between a view and a chunk.
  [[nodiscard]] std::span<const std::uint32_t> before(std::size_t view, std::size_t chunk) const {
    const Before& of_view = before_[view];
    const auto found = std::lower_bound(of_view.chunks.begin(), of_view.chunks.end(), chunk);
    if (found == of_view.chunks.end() || *found != chunk) return {};
    const auto place = static_cast<std::size_t>(found - of_view.chunks.begin());
    return std::span(of_view.others).subspan(of_view.first[place], of_view.first[place + 1] - of_view.first[place]);
  }

 private:
  // The chunks that a view may show, ascending, and what stands before each: others[first[i]] to others[first[i + 1]].
  struct Before {
    std::vector<std::uint32_t> chunks, first{0}, others;
  };

  void look(const BuildCallback& callback) {
    BuildStage stage(callback, "looking through all cameras", plan_.views.size());
    BestViews best(pixels_.size());
    const std::vector<std::size_t> order = neighbors_in_order(plan_.views);
    std::vector<Camera> cameras;
    cameras.reserve(order.size());
    for (const std::size_t view : order) {
      cameras.push_back(plan_.views[view].camera.shrunk_to(plan_.build.planner.visibility_px));
    }
    city_.look(cameras, [&](std::size_t number, const VisibilityBuffer& buffer) {
      throw_if_interrupted();
      offer(order[number], buffer, best);
      find_before(order[number], cameras[number], buffer);
      stage.tick();
    });
    stage.finish();
    const auto views_of = [&](std::size_t first, std::size_t end) {
      std::vector<std::size_t> views;
      for (std::size_t cell = first; cell < end; ++cell) best.add_to(cell, views);
      sort_once(views);
      return views;
    };
    for (std::size_t chunk = 0; chunk < plan_.chunks.size(); ++chunk) {
      views_.push_back(views_of(first_cell_[chunk], first_cell_[chunk + 1]));
    }
    far_views_ = views_of(first_cell_.back(), pixels_.size());
  }

  void offer(std::size_t view, const VisibilityBuffer& buffer, BestViews& best) {
    std::vector<std::uint32_t> seen;
    for (const FaceId face : buffer.face) {
      if (face == FaceId::none) continue;
      const CellId cell = city_.cell_of_face[face];
      if (pixels_[cell]++ == 0) seen.push_back(cell);
    }
    for (const std::uint32_t cell : seen) {
      best.offer(cell, pixels_[cell], static_cast<std::uint32_t>(view));
      pixels_[cell] = 0;
    }
  }

  void find_before(std::size_t view, const Camera& camera, const VisibilityBuffer& buffer) {
    std::vector<std::size_t> last(plan_.chunks.size(), plan_.chunks.size());  // the chunk that noted each one last
    Before found;
    for (std::size_t chunk = 0; chunk < plan_.chunks.size(); ++chunk) {
      const ShownBox shown = shown_box(camera, plan_.chunks[chunk].box);
      for (std::uint32_t y = shown.top; y < shown.bottom; ++y) {
        for (std::uint32_t x = shown.left; x < shown.right; ++x) {
          const std::size_t pixel = std::size_t{y} * camera.width + x;
          const FaceId face = buffer.face[pixel];
          if (face == FaceId::none || face >= chunk_of_face_.size()) continue;
          const std::uint32_t there = chunk_of_face_[face];
          if (there == chunk || last[there] == chunk || static_cast<double>(buffer.depth[pixel]) > shown.far) continue;
          last[there] = chunk;
          found.others.push_back(there);
        }
      }
      if (found.others.size() == found.first.back()) continue;
      found.chunks.push_back(static_cast<std::uint32_t>(chunk));
      found.first.push_back(static_cast<std::uint32_t>(found.others.size()));
    }
    before_[view] = found;  // a copy has no room to spare
  }

  const SeenCity& city_;
  const CityPlan& plan_;
  std::vector<std::uint32_t> chunk_of_face_;
  std::vector<std::size_t> first_cell_;  // of each chunk, and the end
  std::vector<std::uint32_t> pixels_;    // one per cell, 0 between looks
  std::vector<Before> before_;           // by view
  std::vector<std::vector<std::size_t>> views_;
  std::vector<std::size_t> far_views_;
};

// Returns the block of chunks that follow each other.
CityBlock block_of_chunks(const Looks& looks, const CityPlan& plan, std::size_t first, std::size_t count) {
  CityBlock block;
  block.own_chunks = count;
  for (std::size_t chunk = first; chunk < first + count; ++chunk) {
    const ChunkCounts& size = plan.chunks[chunk].size;
    block.size.cells += size.cells;
    block.size.faces += size.faces;
    const std::vector<std::size_t>& views = looks.views_of_chunks()[chunk];
    block.views.insert(block.views.end(), views.begin(), views.end());
    block.chunks.push_back(chunk);
  }
  sort_once(block.views);
  std::vector<std::size_t> others;
  for (const std::size_t view : block.views) {
    for (std::size_t chunk = first; chunk < first + count; ++chunk) {
      for (const std::uint32_t other : looks.before(view, chunk)) {
        if (other < first || other >= first + count) others.push_back(other);
      }
    }
  }
  sort_once(others);
  block.chunks.insert(block.chunks.end(), others.begin(), others.end());
  return block;
}

std::size_t faces_read(const CityPlan& plan, const CityBlock& block) {
  return std::accumulate(block.chunks.begin(), block.chunks.end(), std::size_t{0},
                         [&](std::size_t sum, std::size_t chunk) { return sum + plan.chunks[chunk].size.faces; });
}

CityBlock far_block(const SeenCity& city, const Looks& looks, const CityPlan& plan) {
  CityBlock far;
  far.far = true;
  far.size = city.far;
  far.chunks.resize(plan.chunks.size());
  std::iota(far.chunks.begin(), far.chunks.end(), std::size_t{0});
  far.views = looks.views_of_far();
  return far;
}

}  // namespace

std::uint64_t job_bytes(std::size_t faces, std::uint64_t memory) {
  constexpr std::uint64_t kBase = 150'000'000, kEachFace = 600;
  return kBase + kEachFace * faces + memory / kPixelShare;
}

void cut_into_blocks(const SeenCity& city, std::size_t block_faces, const BuildCallback& callback, CityPlan& plan) {
  const Looks looks(city, plan, callback);
  for (std::size_t first = 0; first < plan.chunks.size();) {
    CityBlock block = block_of_chunks(looks, plan, first, 1);
    while (first + block.own_chunks < plan.chunks.size()) {
      CityBlock larger = block_of_chunks(looks, plan, first, block.own_chunks + 1);
      if (larger.size.faces > block_faces || job_bytes(faces_read(plan, larger), plan.memory) > plan.memory) break;
      block = std::move(larger);
    }
    first += block.own_chunks;
    plan.blocks.push_back(std::move(block));
  }
  if (city.far.faces > 0) plan.blocks.push_back(far_block(city, looks, plan));
}

}  // namespace lumatlas
