// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/block_cut.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

void make_blocks(const ChunkedSurface& city, std::size_t block_faces, CityPlan& plan) {
  for (std::size_t chunk = 0; chunk < city.chunks.size(); ++chunk) {
    const ChunkCounts& counts = city.chunks[chunk];
    if (plan.blocks.empty() || plan.blocks.back().size.faces + counts.faces > block_faces) plan.blocks.emplace_back();
    CityBlock& block = plan.blocks.back();
    block.size.cells += counts.cells;
    block.size.faces += counts.faces;
    block.chunks.push_back(chunk);
    ++block.own_chunks;
  }
  if (city.far.mesh.faces.empty()) return;
  CityBlock far;
  far.far = true;
  far.size = {city.far.cells.cells.size(), city.far.mesh.faces.size()};
  far.chunks.resize(city.chunks.size());
  std::iota(far.chunks.begin(), far.chunks.end(), std::size_t{0});
  plan.blocks.push_back(std::move(far));
}

// The photographs in which one cell has most pixels.
class BestViews {
 public:
  void offer(std::uint32_t pixels, std::uint32_t view) {
    if (best_.size() == kViewsPerCell) {
      if (pixels <= best_.front().first) return;
      std::pop_heap(best_.begin(), best_.end(), std::greater<>());
      best_.pop_back();
    }
    best_.emplace_back(pixels, view);
    std::push_heap(best_.begin(), best_.end(), std::greater<>());
  }
  void add_to(std::set<std::size_t>& views) const {
    for (const auto& [pixels, view] : best_) views.insert(view);
  }

 private:
  std::vector<std::pair<std::uint32_t, std::uint32_t>> best_;  // pixels and view, the fewest pixels first
};

// Looks through all cameras of a plan at the whole surface.
class Sight {
 public:
  Sight(const ChunkedSurface& city, const CityPlan& plan)
      : plan_(plan), surface_(with_far_sphere(city.surface, city.far)), rays_(make_ray_visibility(surface_.mesh)) {}

  [[nodiscard]] const Surface& surface() const { return surface_; }

  // Calls use(view, small camera, buffer) for each view.
  template <typename Use>
  void for_each_view(const BuildCallback& callback, const char* stage_name, const Use& use) const {
    BuildStage stage(callback, stage_name, plan_.views.size());
    VisibilityBuffer buffer;
    for (std::size_t view = 0; view < plan_.views.size(); ++view) {
      throw_if_interrupted();
      const Camera camera = plan_.views[view].camera.shrunk_to(plan_.build.planner.visibility_px);
      rays_->trace(camera, buffer);
      use(view, camera, buffer);
      stage.tick();
    }
    stage.finish();
  }

 private:
  const CityPlan& plan_;
  Surface surface_;
  std::unique_ptr<Visibility> rays_;
};

void find_views(const Sight& sight, const BuildCallback& callback, CityPlan& plan) {
  std::vector<BestViews> best(sight.surface().cells.cells.size());
  sight.for_each_view(callback, "looking through all cameras",
                      [&](std::size_t view, const Camera&, const auto& buffer) {
                        for (const CellPixels& part : count_cell_pixels(buffer, sight.surface().cells)) {
                          best[part.cell].offer(part.pixels, static_cast<std::uint32_t>(view));
                        }
                      });
  std::size_t cell = 0;
  for (CityBlock& block : plan.blocks) {
    std::set<std::size_t> views;
    for (std::size_t i = 0; i < block.size.cells; ++i) best[cell++].add_to(views);
    block.views.assign(views.begin(), views.end());
  }
}

Bounds box_of(const Mesh& mesh, std::size_t first_face, std::size_t faces) {
  Bounds box;
  for (const glm::uvec3& face : std::span(mesh.faces).subspan(first_face, faces)) {
    for (int corner = 0; corner < 3; ++corner) {
      box = with(box, glm::dvec3(mesh.positions[face[corner]]));
    }
  }
  return box;
}

// The pixels in which a camera shows a box, or would without what stands before it, and the depth of its far end.
struct ShownBox {
  std::uint32_t left = 0, top = 0, right = 0, bottom = 0;  // the last two are beyond it
  double depth = 0;
};

ShownBox shown_box(const Camera& camera, const Bounds& box) {
  glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
  ShownBox shown{0, 0, camera.width, camera.height, 0};
  bool behind = false;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 world((corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                           (corner & 4) != 0 ? box.max.z : box.min.z);
    const glm::dvec3 cam = camera.cam_from_world(world);
    shown.depth = std::max(shown.depth, cam.z);
    behind = behind || cam.z <= 0;
    if (behind) continue;
    const glm::dvec2 image = camera.image_from_cam(cam);
    low = glm::min(low, image);
    high = glm::max(high, image);
  }
  if (behind) return shown;  // it reaches around the camera: the whole image
  const glm::dvec2 size(camera.width, camera.height);
  low = glm::clamp(glm::floor(low), glm::dvec2(0), size);
  high = glm::clamp(glm::ceil(high), low, size);
  return {static_cast<std::uint32_t>(low.x), static_cast<std::uint32_t>(low.y), static_cast<std::uint32_t>(high.x),
          static_cast<std::uint32_t>(high.y), shown.depth};
}

std::vector<Bounds> boxes_of_blocks(const Mesh& mesh, const CityPlan& plan) {
  std::vector<Bounds> boxes;
  std::size_t first_face = 0;
  for (const CityBlock& block : plan.blocks) {
    if (block.far) continue;
    boxes.push_back(box_of(mesh, first_face, block.size.faces));
    first_face += block.size.faces;
  }
  return boxes;
}

// Adds the chunks that one camera shows where it shows a box, as far as the box reaches.
void add_shown_chunks(const Camera& camera, const Bounds& box, const VisibilityBuffer& buffer,
                      const std::vector<std::uint32_t>& chunk_of_face, std::set<std::size_t>& chunks) {
  const ShownBox shown = shown_box(camera, box);
  for (std::uint32_t y = shown.top; y < shown.bottom; ++y) {
    for (std::uint32_t x = shown.left; x < shown.right; ++x) {
      const std::size_t pixel = std::size_t{y} * camera.width + x;
      const FaceId face = buffer.face[pixel];
      const bool is_near = face != FaceId::none && face < chunk_of_face.size();
      if (is_near && static_cast<double>(buffer.depth[pixel]) <= shown.depth) chunks.insert(chunk_of_face[face]);
    }
  }
}

void find_chunks(const ChunkedSurface& city, const Sight& sight, const BuildCallback& callback, CityPlan& plan) {
  std::vector<std::uint32_t> chunk_of_face;
  for (std::size_t chunk = 0; chunk < city.chunks.size(); ++chunk) {
    chunk_of_face.insert(chunk_of_face.end(), city.chunks[chunk].faces, static_cast<std::uint32_t>(chunk));
  }
  const std::vector<Bounds> boxes = boxes_of_blocks(city.surface.mesh, plan);
  std::vector<std::vector<std::size_t>> blocks_of_view(plan.views.size());
  for (std::size_t block = 0; block < boxes.size(); ++block) {
    for (const std::size_t view : plan.blocks[block].views) blocks_of_view[view].push_back(block);
  }
  std::vector<std::set<std::size_t>> before(boxes.size());  // by block
  sight.for_each_view(callback, "looking for what stands before blocks",
                      [&](std::size_t view, const Camera& camera, const VisibilityBuffer& buffer) {
                        for (const std::size_t block : blocks_of_view[view]) {
                          add_shown_chunks(camera, boxes[block], buffer, chunk_of_face, before[block]);
                        }
                      });
  for (std::size_t block = 0; block < boxes.size(); ++block) {
    std::vector<std::size_t>& chunks = plan.blocks[block].chunks;
    const std::size_t first = chunks.front(), last = chunks.back();
    for (const std::size_t chunk : before[block]) {
      if (chunk < first || chunk > last) chunks.push_back(chunk);
    }
  }
}

}  // namespace

void cut_into_blocks(const ChunkedSurface& city, std::size_t block_faces, const BuildCallback& callback,
                     CityPlan& plan) {
  make_blocks(city, block_faces, plan);
  const Sight sight(city, plan);
  find_views(sight, callback, plan);
  find_chunks(city, sight, callback, plan);
}

}  // namespace lumatlas
