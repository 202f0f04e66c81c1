// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_parts.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_document.h"
#include "atlas/model/model_extension.h"
#include "atlas/model/model_ranges.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// Refuses what read_model() would refuse, of a snapshot that passes check().
void require_readable(const Snapshot& snapshot) {
  const glm::dvec3& offset = snapshot.surface->offset;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(offset[axis]) <= kMostOffset) continue;
    throw InputError("the surface's offset[" + std::to_string(axis) + "] is " + number_text(offset[axis]) +
                     ", a model file holds at most " + number_text(kMostOffset) + ": move the scene nearer to 0");
  }
  for (const auto& view : snapshot.views) {
    try {
      if (view) check_model_ranges(view->camera);
    } catch (const std::invalid_argument& error) {
      throw InputError("view " + unicode_name(view->name) + " does not fit into a model file: " + error.what());
    }
  }
}

// Leaves out views without a resident tile, which show nothing.
Snapshot checked(const Snapshot& snapshot) {
  if (snapshot.cell_seen.size() > kMostCells) {
    throw InputError("the model has " + std::to_string(snapshot.cell_seen.size()) + " cells, a model file holds " +
                     std::to_string(kMostCells) + ": give a larger --cell-size");
  }
  check(snapshot);
  Snapshot shown = snapshot;  // the photographs are shared
  leave_out_views_without_tiles(shown);
  require_readable(shown);
  return shown;
}

}  // namespace

ModelParts model_parts(const Snapshot& given, const ValidityOptions& validity, const FormOptions& options) {
  check(validity);
  check(options.photographs);
  if (options.chunk_faces < 1) throw std::invalid_argument("form: chunk_faces is 0, must be at least 1");
  ModelParts parts{checked(given), {}, {}};
  const Snapshot& snapshot = parts.snapshot;
  const Surface& surface = *snapshot.surface;
  if (options.texture) check(*options.texture, surface.near_faces());
  if (options.shares) check(*options.shares, surface.mesh.faces.size(), surface.cells.cells.size());
  std::vector<std::uint8_t> shown;
  for (const auto& view : snapshot.views) shown.push_back(view ? 1 : 0);
  const std::size_t views = static_cast<std::size_t>(std::count(shown.begin(), shown.end(), 1));
  const ViewSlot first = views > 0 ? first_view_slot(snapshot, shown) : ViewSlot(0);
  parts.images = images_of(snapshot, options.photographs, first, options.packed);
  const auto number = static_cast<std::uint32_t>(std::count(shown.begin(), shown.begin() + first, 1));
  parts.properties = model_properties(snapshot, validity, number);
  if (views == 0) return parts;  // glTF has no empty arrays
  parts.properties["views"] = views_with_images(snapshot, parts.images);
  parts.properties["poster"] = parts.images.size() - 1;
  return parts;
}

std::optional<double> packed_step(const Snapshot& snapshot, const FormOptions& options) {
  constexpr double kStepsPerPixel = 16, kStepsPerCell = 100;
  if (!options.packed) return std::nullopt;
  double step = snapshot.surface->cells.size / kStepsPerCell;
  for (const auto& view : snapshot.views) {
    if (!view) continue;
    const double depth = median_depth(*view, depth_before_far(*snapshot.surface));
    if (depth > 0) step = std::min(step, depth / (std::max(view->camera.fx, view->camera.fy) * kStepsPerPixel));
  }
  return step;
}

CoarseSurface coarse_surface_of(const Snapshot& snapshot, std::size_t faces) {
  const Mesh mesh = near_surface(*snapshot.surface).mesh;
  return coarse_surface(mesh, std::span(snapshot.vertex_colors.get()).first(mesh.positions.size()), faces);
}

}  // namespace lumatlas
