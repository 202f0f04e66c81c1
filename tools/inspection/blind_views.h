// SPDX-License-Identifier: GPL-3.0-or-later
// Tests whether the views of a scene see its mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tools/scene/scene.h"

namespace lumatlas {

inline constexpr std::uint32_t kGlancePx = 160;  // longer side of the image that a view is looked through at

// The share of the pixels that show the mesh, [0, 1].
[[nodiscard]] double covered_share(const VisibilityBuffer& buffer);

// Returns whether less than 1 % of the pixels show the mesh. Such a view is called blind.
[[nodiscard]] bool sees_next_to_nothing(const VisibilityBuffer& buffer);

// The warning that `blind` of `views` are blind, `first` being the name of one; empty where none is.
[[nodiscard]] std::string blind_views_warning(std::size_t blind, std::size_t views, const std::string& first);

// The warning that the views see the mesh on a small share of their pixels; empty where it is large enough.
[[nodiscard]] std::string empty_frames_warning(double covered);

struct BlindViews {
  std::size_t looks = 0;  // views for which the mesh was drawn
  std::size_t blind = 0;  // how many of these are blind
  std::string first;      // the name of the first blind one; empty: none is
  double covered = 1;     // share of the pixels of all that see the mesh, [0, 1]
};

// Draws the mesh for the views of these ranks, or evenly for 100 of them at most. Throws Interrupted soon after a
// signal.
[[nodiscard]] BlindViews blind_views(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                                     const Visibility& visibility);

// Throws InputError, naming the mesh, if more than three quarters of the views that were looked through are blind: a
// mesh in other coordinates, or of another scene, is seen by chance. `likely` says what is likely to be wrong, see
// MeshDiagnosis; empty: not known.
void require_seen(const std::filesystem::path& mesh_file, const BlindViews& views, const std::string& likely);

}  // namespace lumatlas
