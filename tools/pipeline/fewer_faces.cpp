// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/fewer_faces.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "blend/gpu_bytes.h"
#include "tools/base/interrupt.h"

namespace lumatlas {

namespace {

std::uint64_t bytes_of(const SurfaceInput& input) {
  return GpuByteCount(input.surface).of_surface();
}

std::vector<Camera> stored_cameras(const Atlas& atlas) {
  std::vector<Camera> cameras;
  for (std::uint32_t slot = 0; slot < atlas.capacity(); ++slot) {
    if (const auto view = atlas.view(slot)) cameras.push_back(view->camera);
  }
  return cameras;
}

// All cells are new.
void put_under(const SeenSurface& seen, Planner& planner) {
  throw_if_interrupted();
  const std::size_t cells = seen.input.surface->cells.cells.size();
  planner.update_surface(seen.input.surface, *seen.visibility, std::vector<std::uint32_t>(cells, kNoCell),
                         std::vector<std::uint8_t>(cells, 1));
}

}  // namespace

SurfaceInput with_room_for_photographs(const SurfaceInput& input, const CellOptions& cells,
                                       std::uint64_t budget_bytes) {
  constexpr double kShare = 1.0 / 8;  // references, which differ from cell to cell, make it almost a quarter
  constexpr std::size_t kFacesOfCell = 4;
  constexpr int kMostTries = 4;  // bytes do not quite go by faces
  const auto share_of_room = [&](const SurfaceInput& surface) {
    return kShare * static_cast<double>(budget_bytes) / static_cast<double>(bytes_of(surface));
  };
  const std::size_t least = kFacesOfCell * input.surface->cells.cells.size();
  std::size_t faces = input.surface->mesh.faces.size() - input.split_faces;
  SurfaceInput fewer = input;
  double share = share_of_room(input);
  for (int tries = 0; tries < kMostTries && share < 1 && faces > least; ++tries) {
    throw_if_interrupted();
    faces = std::max(least, static_cast<std::size_t>(share * static_cast<double>(faces)));
    fewer = with_fewer_faces(input, cells, {.faces = faces});
    share = share_of_room(fewer);
  }
  return fewer;
}

std::optional<MeasuredLoss> give_up_faces_within(double max_loss_db, double reference_loss_db, double pixels,
                                                 const CellOptions& cells, const MakeVisibility& make_visibility,
                                                 SeenSurface& seen, const Atlas& atlas, Planner& planner,
                                                 HeldOutLoss& measured) {
  SeenSurface fewer;
  fewer.input = with_fewer_faces(seen.input, cells, {.faces = {}, .pixels = pixels}, stored_cameras(atlas));
  if (fewer.input.surface->mesh.faces.size() >= seen.input.surface->mesh.faces.size()) return std::nullopt;
  fewer.visibility = make_visibility(*fewer.input.surface);
  put_under(fewer, planner);
  std::swap(seen, fewer);  // whose views were of the one before
  try {
    const MeasuredLoss loss = measured.now({{}, reference_loss_db}, max_loss_db);
    if (loss.at_most_db() <= max_loss_db) return loss;
  } catch (const GlError&) {
    put_under(fewer, planner);
    std::swap(seen, fewer);
    throw;
  }
  put_under(fewer, planner);
  std::swap(seen, fewer);
  return std::nullopt;
}

}  // namespace lumatlas
