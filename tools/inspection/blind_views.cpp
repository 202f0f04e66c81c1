// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/inspection/blind_views.h"

#include <algorithm>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

constexpr const char* kOtherCoordinates = "mesh and cameras are in different coordinates, or the mesh is the wrong one";

}  // namespace

double covered_share(const VisibilityBuffer& buffer) {
  const auto empty = std::count(buffer.face.begin(), buffer.face.end(), FaceId::none);
  return 1 - static_cast<double>(empty) / static_cast<double>(buffer.face.size());
}

bool sees_next_to_nothing(const VisibilityBuffer& buffer) {
  constexpr double kLittleSeen = 0.01;  // share of the pixels
  return covered_share(buffer) < kLittleSeen;
}

std::string blind_views_warning(std::size_t blind, std::size_t views, const std::string& first) {
  if (blind == 0) return {};
  return std::to_string(blind) + " of " + std::to_string(views) +
         " views see next to nothing of the mesh, the first is " + first + ": " +
         (blind == views ? kOtherCoordinates : "their poses may be wrong, or the mesh is incomplete");
}

std::string empty_frames_warning(double covered) {
  constexpr double kEnough = 0.75;
  if (covered >= kEnough) return {};
  return "the views see the mesh on only " + percent_text(covered) +
         " of their pixels: `lumatlas build` adds what photographs show beside it, unless --mesh-as-given is given";
}

BlindViews blind_views(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                       const Visibility& visibility) {
  constexpr std::size_t kMostLooks = 100;
  const std::size_t step = (ranks.size() + kMostLooks - 1) / kMostLooks;
  BlindViews result;
  VisibilityBuffer buffer;
  double covered = 0;
  for (std::size_t i = 0; i < ranks.size(); i += step, ++result.looks) {
    throw_if_interrupted();
    const SceneView& view = views[ranks[i]];
    visibility.trace(view.camera.shrunk_to(kGlancePx), buffer);
    covered += covered_share(buffer);
    if (!sees_next_to_nothing(buffer)) continue;
    if (result.blind++ == 0) result.first = view.name;
  }
  if (result.looks > 0) result.covered = covered / static_cast<double>(result.looks);
  return result;
}

void require_seen(const std::filesystem::path& mesh_file, const BlindViews& views, const std::string& likely) {
  if (4 * views.blind <= 3 * views.looks) return;
  throw InputError(
      mesh_file.string() + ": " + std::to_string(views.blind) + " of " + std::to_string(views.looks) +
      " views that were looked through see next to nothing of it: " + (likely.empty() ? kOtherCoordinates : likely) +
      " (see lumatlas inspect; --any-mesh builds all the same)");
}

}  // namespace lumatlas
