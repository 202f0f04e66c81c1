// SPDX-License-Identifier: GPL-3.0-or-later
// Multi-view stereo of a scene: depth maps of its photographs, estimated from each other.
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
  std::uint32_t longest_px =
      512;                    // longer side of a photograph as it is matched, [64, 8192]; time grows with its square
  std::size_t neighbors = 4;  // number of photographs that each one is matched with, [1, 16]
};

// Throws std::invalid_argument naming the field, its value and the rule.
void check(const StereoOptions& options);

class SceneStereo {
 public:
  // `views` and `points` are in one frame; `points` may be empty, and only positions and views of them are used.
  // match() makes `folder` and writes two files a photograph there, of 16 bytes a pixel each. A later match() uses the
  // files again whose photograph, pose, lens and neighbours are the same. Memory holds a few photographs at a time.
  SceneStereo(std::vector<SceneView> views, const ScenePoints& points, const StereoOptions& options,
              std::filesystem::path folder);
  ~SceneStereo();

  // Matches each photograph with its neighbours, then once more with the planes of these (geometric consistency). The
  // result is the same for any number of threads. `progress` is called after each of steps() steps; what it throws ends
  // the work. Throws InputError for a photograph that cannot be read and for a folder that cannot be written.
  [[nodiscard]] std::size_t steps() const;
  void match(const std::function<void(std::size_t)>& progress);

  [[nodiscard]] const std::vector<SceneView>& views() const;
  [[nodiscard]] Camera camera(std::size_t view) const;  // for the size that the photograph is matched at
  // Views whose planes may confirm a depth of this view, best first: its neighbours, and as many views again.
  [[nodiscard]] const std::vector<std::size_t>& confirming(std::size_t view) const;
  // Returns the confirmed depths of a view. Call it after match(); any thread may. Throws InputError if a file is gone.
  [[nodiscard]] StereoDepth depth(std::size_t view) const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

// Removes the files that SceneStereo has written to `folder`, and the folder if it is then empty. Never throws.
void remove_stereo_work(const std::filesystem::path& folder);

// Returns the points with `views` renumbered: rank ranks[i] becomes i, and other ranks are left out. `ranks` ascend.
[[nodiscard]] ScenePoints points_of_views(ScenePoints points, std::span<const std::size_t> ranks);

}  // namespace lumatlas
