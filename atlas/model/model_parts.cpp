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
void require_readable(const Snapshot& snapshot, const glm::dvec3& offset) {
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

void require_cells_fit(std::size_t cells) {
  if (cells <= kMostCells) return;
  throw InputError("the model has " + std::to_string(cells) + " cells, a model file holds " +
                   std::to_string(kMostCells) + ": give a larger --cell-size");
}

// Leaves out views without a resident tile, which show nothing.
Snapshot checked(const Snapshot& snapshot) {
  require_cells_fit(snapshot.cell_seen.size());
  check(snapshot);
  Snapshot shown = snapshot;  // the photographs are shared
  leave_out_views_without_tiles(shown);
  require_readable(shown, shown.surface->offset);
  return shown;
}

// Fills in the images and properties of the views.
void add_views(const ValidityOptions& validity, const FormOptions& options, ModelParts& parts) {
  const Snapshot& snapshot = parts.snapshot;
  std::vector<std::uint8_t> shown;
  for (const auto& view : snapshot.views) shown.push_back(view ? 1 : 0);
  const std::size_t views = static_cast<std::size_t>(std::count(shown.begin(), shown.end(), 1));
  const ViewSlot first = views > 0 ? first_view_slot(snapshot, shown) : ViewSlot(0);
  parts.images = images_of(snapshot, options.photographs, first, options.packed);
  const auto number = static_cast<std::uint32_t>(std::count(shown.begin(), shown.begin() + first, 1));
  parts.properties = model_properties(snapshot, parts.before_far, validity, number);
  if (views == 0) return;  // glTF has no empty arrays
  parts.properties["views"] = views_with_images(snapshot, parts.before_far, parts.images);
  parts.properties["poster"] = parts.images.size() - 1;
}

}  // namespace

ModelParts model_parts(const Snapshot& given, const ValidityOptions& validity, const FormOptions& options) {
  check(validity);
  check(options.photographs);
  if (options.chunk_faces < 1) throw std::invalid_argument("form: chunk_faces is 0, must be at least 1");
  ModelParts parts;
  parts.snapshot = checked(given);
  const Surface& surface = *parts.snapshot.surface;
  if (options.texture) check(*options.texture, surface.near_faces());
  if (options.shares) check(*options.shares, surface.mesh.faces.size(), surface.cells.cells.size());
  parts.offset = surface.offset;
  parts.cell_size = written_cell_size(surface);
  parts.before_far = depth_before_far(surface);
  add_views(validity, options, parts);
  return parts;
}

ModelParts model_parts(const PiecewiseModel& given, const ValidityOptions& validity, const FormOptions& options) {
  check(validity);
  check(options.photographs);
  if (given.surface.chunks < 1) throw std::invalid_argument("pieces: have no chunk, must have at least one");
  ModelParts parts;
  parts.snapshot = given.whole;
  require_cells_fit(parts.snapshot.references.offsets.size() - 1);
  check_gains(parts.snapshot);
  for (ViewSlot slot{0}; slot < parts.snapshot.views.size(); ++slot) {
    if (!parts.snapshot.views[slot]) continue;
    check(*parts.snapshot.views[slot]);
    if (parts.snapshot.tiles.whole_views() || parts.snapshot.tiles.has_resident_tile(slot)) continue;
    throw std::invalid_argument("pieces: view " + std::to_string(slot) + " has no resident tile");
  }
  require_readable(parts.snapshot, given.surface.offset);
  parts.offset = given.surface.offset;
  parts.cell_size = given.surface.cell_size;
  parts.before_far = given.surface.before_far;
  add_views(validity, options, parts);
  return parts;
}

std::optional<double> packed_step(const ModelParts& model, const FormOptions& options) {
  constexpr double kStepsPerPixel = 16, kStepsPerCell = 100;
  if (!options.packed) return std::nullopt;
  double step = model.cell_size / kStepsPerCell;
  for (const auto& view : model.snapshot.views) {
    if (!view) continue;
    const double depth = median_depth(*view, model.before_far);
    if (depth > 0) step = std::min(step, depth / (std::max(view->camera.fx, view->camera.fy) * kStepsPerPixel));
  }
  return step;
}

}  // namespace lumatlas
