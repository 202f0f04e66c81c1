// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs of a folder that fills up, one after the other, as they come.
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/pipeline/build_model.h"
#include "tools/scene/growing_scene.h"

namespace lumatlas {

class WatchedScene {
 public:
  // `options` must outlive this.
  WatchedScene(const std::filesystem::path& scene, const glm::dvec3& offset, const PictureFolders& folders,
               const WatchOptions& options);

  // Waits for the first photograph, and gives what the scene lists by then. Throws InputError if the stream ends
  // before, and Interrupted.
  [[nodiscard]] SceneViews first_views();

  // Waits for the next photograph; none: the stream has ended. Throws Interrupted.
  [[nodiscard]] std::optional<SceneView> next();

  // The photograph that next() gave cannot be used, for this reason; it comes again when its file has changed.
  void give_back(const SceneView& view, const std::string& why) { scene_.give_back(view, why); }

  // Call it at the end: reports the photographs that were not reported yet. Returns those that are there but unusable.
  [[nodiscard]] std::vector<SceneView> left_out();
  [[nodiscard]] std::size_t listed() const { return scene_.listed().size(); }
  // See GrowingScene::notes().
  [[nodiscard]] std::vector<std::string> notes(const std::vector<SceneView>& used) const { return scene_.notes(used); }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] bool wait_for_one();
  void look();
  void warn(const std::vector<std::string>& warnings) const;

  std::filesystem::path root_;
  GrowingScene scene_;
  const WatchOptions& options_;
  std::deque<SceneView> ready_;
  std::optional<Clock::time_point> last_look_;
  Clock::time_point last_change_ = Clock::now();
};

}  // namespace lumatlas
