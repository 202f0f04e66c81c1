// SPDX-License-Identifier: GPL-3.0-or-later
// Camera paths through a model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "tools/picture/paths/kept_path.h"

namespace lumatlas {

struct TourOptions {
  enum class Kind {
    orbit,    // once around what the stored views look at
    walk,     // through the cameras of the stored views, in the order of their names
    hilbert,  // along a Hilbert curve over the ground of the scene
    keys,     // smoothly through the key frames of `path`
  };
  Kind kind = Kind::orbit;
  std::filesystem::path path;          // for Kind::keys: JSON, see tools/picture/README.md
  std::size_t frames = 120;            // >= 1
  std::uint32_t width = 1280;          // pixels, [1, 65536]
  std::uint32_t height = 720;          // pixels, [1, 65536]
  double fov_deg = 70;                 // horizontal field of view where `path` names none, [1, 170]
  std::uint32_t hilbert_order = 3;     // for Kind::hilbert: the curve has 2^order turns a side, [1, kMostHilbertOrder]
  bool anywhere = false;               // orbits and Hilbert flights may lead past what no photograph shows
  std::function<void()> cancel_check;  // called again and again; what it throws ends the work; empty: not called
};

// Returns the cameras of the stored views by name, which is the order in which a video was taken.
[[nodiscard]] std::vector<Camera> stored_cameras(const Snapshot& snapshot);

// Lays the path, in the frame of the model. Throws std::invalid_argument for a number outside of its range and, with
// another kind than keys, for a model without views; InputError where `path` cannot be read.
[[nodiscard]] KeptPath model_tour(const Snapshot& snapshot, const TourOptions& options);

}  // namespace lumatlas
