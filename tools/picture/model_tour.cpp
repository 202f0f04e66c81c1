// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/model_tour.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/upright.h"
#include "mesh/visibility/visibility.h"
#include "tools/base/process/interrupt.h"
#include "tools/picture/paths/camera_tours.h"
#include "tools/picture/paths/path_file.h"
#include "tools/picture/photographed_share.h"
#include "tools/picture/stored_depths.h"

namespace lumatlas {

namespace {

void check_tour(const TourOptions& options) {
  if (options.frames == 0) throw std::invalid_argument("frames is 0, must be at least 1");
  if (!(options.fov_deg >= 1 && options.fov_deg <= 170)) {
    throw std::invalid_argument("fov_deg is " + std::to_string(options.fov_deg) + ", must be 1 to 170");
  }
}

// Lays orbits and Hilbert flights, which know nothing of what is where they lead.
KeptPath laid_tour(const TourOptions& options, const Snapshot& snapshot, const std::vector<Camera>& stored,
                   double depth) {
  const auto visibility = make_ray_visibility(near_surface(*snapshot.surface).mesh);
  const PhotographedShare share = [&](const Vantage& vantage) {
    throw_if_interrupted();
    if (options.cancel_check) options.cancel_check();
    return photographed_share(snapshot, *visibility, camera_at(vantage, options.width, options.height));
  };
  const bool is_orbit = options.kind == TourOptions::Kind::orbit;
  const std::vector<Vantage> laid = is_orbit ? orbit(stored, depth, options.frames, options.fov_deg)
                                             : hilbert_flight(near_surface(*snapshot.surface).mesh, stored,
                                                              options.hilbert_order, options.frames, options.fov_deg);
  KeptPath kept = is_orbit ? kept_orbit(stored, depth, options.frames, options.fov_deg, share)
                           : keep_to_photographs(laid, stored, upward(stored), depth, false, share);
  if (!options.anywhere) return kept;
  return {laid, kept.covered_before, kept.covered_before, 0};
}

std::vector<Vantage> key_tour(const TourOptions& options, const Snapshot& snapshot, const std::vector<Camera>& stored) {
  PathDefaults defaults;
  defaults.offset = snapshot.surface->offset;
  if (!stored.empty()) defaults.up = upward(stored);
  defaults.fov_deg = options.fov_deg;
  return CameraPath(read_path(options.path, defaults)).evenly(options.frames);
}

}  // namespace

std::vector<Camera> stored_cameras(const Snapshot& snapshot) {
  std::vector<const StoredView*> views;
  for (const auto& view : snapshot.views) {
    if (view) views.push_back(view.get());
  }
  std::sort(views.begin(), views.end(), [](const StoredView* a, const StoredView* b) { return a->name < b->name; });
  std::vector<Camera> cameras;
  cameras.reserve(views.size());
  for (const StoredView* view : views) cameras.push_back(view->camera);
  return cameras;
}

KeptPath model_tour(const Snapshot& snapshot, const TourOptions& options) {
  check_tour(options);
  const std::vector<Camera> stored = stored_cameras(snapshot);
  KeptPath result;
  if (options.kind == TourOptions::Kind::keys) {
    result.vantages = key_tour(options, snapshot, stored);
    return result;
  }
  if (stored.empty()) throw std::invalid_argument("model: holds no views that say where to fly");
  std::vector<double> depths = sampled_depths(snapshot);
  const double depth = depths.empty() ? 1 : percentile(std::move(depths), 0.5);
  if (options.kind != TourOptions::Kind::walk) return laid_tour(options, snapshot, stored, depth);
  result.vantages = walk(stored, depth, options.frames, options.fov_deg);
  return result;
}

}  // namespace lumatlas
