// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/frame_time.h"

#include <epoxy/gl.h>

#include <chrono>
#include <ctime>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/base/elapsed.h"

namespace lumatlas {

std::vector<Camera> cameras_between_views(const Snapshot& model, std::size_t count, const FrameSize& size) {
  if (size.width == 0 || size.height == 0) {
    throw std::invalid_argument("frame size: it is " + size_text(size.width, size.height) + " pixels, must have some");
  }
  std::vector<Camera> stored;
  for (const auto& view : model.views) {
    if (view) stored.push_back(view->camera);
  }
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < count && !stored.empty(); ++i) {
    const std::size_t at = i * stored.size() / count;
    Camera camera = stored[at];
    const glm::dvec3 center = (camera.center() + stored[(at + 1) % stored.size()].center()) / 2.0;
    camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
    const double scale = static_cast<double>(size.width) / camera.width;
    camera.fx *= scale;
    camera.fy *= scale;
    camera.cx = size.width / 2.0;
    camera.cy = size.height / 2.0;
    camera.width = size.width;
    camera.height = size.height;
    cameras.push_back(camera);
  }
  return cameras;
}

PictureTime time_picture(Renderer& renderer, const Camera& camera, const BlendOptions& blend) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor_start = std::clock();
  renderer.draw(camera, blend);
  glFinish();
  return {ms_since(start), 1e3 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC};
}

FrameTime frame_time(Renderer& renderer, const std::vector<Camera>& cameras, const BlendOptions& blend) {
  if (cameras.empty()) throw std::invalid_argument("frame time: there are no cameras, must be at least 1");
  (void)time_picture(renderer, cameras.front(), blend);
  std::vector<double> wall, processor;
  for (const Camera& camera : cameras) {
    const PictureTime time = time_picture(renderer, camera, blend);
    wall.push_back(time.wall);
    processor.push_back(time.processor);
  }
  return {percentile(wall, 0.5), percentile(processor, 0.5), percentile(wall, 0.95), percentile(processor, 0.95)};
}

}  // namespace lumatlas
