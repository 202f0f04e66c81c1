// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/fewer_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/gpu_bytes.h"
#include "mesh/base/errors.h"
#include "planner/geometry_follower.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

std::uint64_t bytes_of(const SurfaceInput& input) {
  return GpuByteCount(input.surface).of_surface();
}

std::vector<Camera> stored_cameras(const Atlas& atlas) {
  std::vector<Camera> cameras;
  for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
    if (const auto view = atlas.view(slot)) cameras.push_back(view->camera);
  }
  return cameras;
}

// All cells are new.
void put_under(const SeenSurface& seen, const std::vector<Camera>& turned_away, Planner& planner) {
  throw_if_interrupted();
  const std::size_t cells = seen.input.surface->cells.cells.size();
  try {
    GeometryFollower(planner).update_surface(seen.input.surface, *seen.visibility,
                                             std::vector<CellId>(cells, CellId::none),
                                             std::vector<std::uint8_t>(cells, 1));
    for (const Camera& camera : turned_away) planner.count_demand(camera);
  } catch (const GlError& error) {
    throw std::runtime_error(std::string("the stored views cannot be seen again: ") + error.what());
  }
}

// Returns nothing if no face would be left of the mesh, or none that can be cut into cells.
std::optional<SurfaceInput> fewer_if_any(const SurfaceInput& input, const CellOptions& cells, const FaceOptions& faces,
                                         const std::vector<Camera>& cameras = {}) {
  try {
    return with_fewer_faces(input, cells, faces, cameras);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

SurfaceInput with_room_for_photographs(const SurfaceInput& input, CellOptions cells, std::uint64_t budget_bytes,
                                       std::uint64_t photograph_bytes) {
  constexpr std::uint64_t kShare = 8;  // references, which differ from cell to cell, make it almost a quarter
  constexpr double kFacesOfCell = 4;
  constexpr double kMostGrown = 4;    // a cell's size, of what it is without a budget
  constexpr int kMostTries = 5;       // bytes do not quite go by faces
  constexpr double kMostLeft = 1.15;  // times what is taken, of the room for it
  const std::uint64_t left = budget_bytes - std::min(budget_bytes, photograph_bytes);
  const auto room = static_cast<double>(std::max(left, budget_bytes / kShare));
  const double most_grown = cells.size > 0 ? 1 : kMostGrown;
  // `faces` are those that a surface has, those that were split for its cells included; of the file there are fewer.
  const auto all = static_cast<double>(input.surface->mesh.faces.size());
  const double of_file = all - static_cast<double>(input.split_faces);
  // For cells as they are.
  const double few = std::min(kFacesOfCell * static_cast<double>(input.surface->cells.cells.size()), all);
  const double least = few / (most_grown * most_grown);
  SurfaceInput best = input;
  double faces = all, share = room / static_cast<double>(bytes_of(input)), best_share = share;
  if (share >= 1) return best;
  for (int tries = 0; tries < kMostTries && !(share >= 1 && share < kMostLeft); ++tries) {
    throw_if_interrupted();
    const double before = std::exchange(faces, std::clamp(share * faces, least, all));
    if (faces == before) break;
    cells.size = input.surface->cells.size * std::sqrt(std::max(few / faces, 1.0));
    const std::optional<SurfaceInput> fewer =
        fewer_if_any(input, cells, {.faces = static_cast<std::size_t>(std::ceil(std::min(faces, of_file)))});
    if (!fewer) break;
    share = room / static_cast<double>(bytes_of(*fewer));
    const bool is_better = best_share < 1 ? share > best_share : share >= 1 && share < best_share;
    if (!is_better) continue;
    best = *fewer;
    best_share = share;
  }
  return best;
}

std::optional<MeasuredLoss> give_up_faces_within(const FaceLimits& limits, double reference_loss_db,
                                                 const std::vector<Camera>& turned_away,
                                                 const MakeVisibility& make_visibility, SeenSurface& seen,
                                                 const Atlas& atlas, Planner& planner, HeldOutLoss& measured) {
  std::optional<SurfaceInput> input =
      fewer_if_any(seen.input, limits.cells, {.faces = {}, .pixels = limits.pixels}, stored_cameras(atlas));
  if (!input || input->surface->mesh.faces.size() >= seen.input.surface->mesh.faces.size()) return std::nullopt;
  SeenSurface fewer{std::move(*input), {}};
  fewer.visibility = make_visibility(*fewer.input.surface);
  put_under(fewer, turned_away, planner);
  std::swap(seen, fewer);  // whose views were of the one before
  const auto undo = [&] {
    put_under(fewer, turned_away, planner);
    std::swap(seen, fewer);
  };
  try {
    const MeasuredLoss loss = measured.now({{}, reference_loss_db}, limits.max_loss_db);
    if (loss.at_most_db() <= limits.max_loss_db) return loss;
  } catch (const GlError&) {
    undo();
    throw;
  }
  undo();
  return std::nullopt;
}

}  // namespace lumatlas
