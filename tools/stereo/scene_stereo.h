// SPDX-License-Identifier: GPL-3.0-or-later
// Depths of all photographs of a scene, from each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"
#include "tools/stereo/agreeing_depths.h"
#include "tools/stereo/stereo_neighbors.h"

namespace lumatlas {

struct StereoOptions {
  std::uint32_t longest_px = 512;  // of a photograph as it is compared, [64, 8192]; time grows with its square
  std::size_t neighbors = 4;       // photographs that each is compared with, [1, 16]; time grows with it
};

// Throws std::invalid_argument naming the field, its value and the rule.
void check(const StereoOptions& options);

class SceneStereo {
 public:
  // `views` and `points` (positions and views; none are needed) in one frame. The work is kept in `folder`, which is
  // made: two files a photograph of 16 bytes a compared pixel each, from which work that was stopped goes on, and which
  // count for nothing once a photograph, its pose, its lens or its neighbors have changed. Memory holds a few
  // photographs at a time.
  SceneStereo(std::vector<SceneView> views, const ScenePoints& points, const StereoOptions& options,
              std::filesystem::path folder);
  ~SceneStereo();

  // Each photograph is matched by itself, and once more with what its neighbors have found. The same for any number of
  // threads. `progress` is called after each step of steps(); what it throws ends the work. Throws InputError for a
  // photograph that cannot be read, or a full disk.
  [[nodiscard]] std::size_t steps() const;
  void match(const std::function<void(std::size_t)>& progress);

  [[nodiscard]] const std::vector<SceneView>& views() const;
  [[nodiscard]] Camera camera(std::size_t view) const;  // of the size that the photograph is compared at
  // Those whose planes are asked whether they confirm a depth, the best first: its neighbors, and as many again.
  [[nodiscard]] const std::vector<std::size_t>& confirming(std::size_t view) const;
  // After match(). From any thread.
  [[nodiscard]] StereoDepth depth(std::size_t view) const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

// Removes what the work on a scene has left in `folder`, and the folder if nothing else is in it. Never throws.
void remove_stereo_work(const std::filesystem::path& folder);

// The points as the views of these ranks see them: views are numbered by their places in `ranks`, which ascend.
[[nodiscard]] ScenePoints points_of_views(ScenePoints points, std::span<const std::size_t> ranks);

}  // namespace lumatlas
