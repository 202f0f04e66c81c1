// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/gpu_budget.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

using nlohmann::json;

// Parts of what a model takes on the GPU, in the order in which they are told.
constexpr std::array kParts{"mesh", "vertices", "tables", "depth", "masks", "colors"};

// The share of a budget that may be left.
constexpr std::uint64_t kUnused = 100;

std::string megabytes(std::uint64_t bytes) {
  std::array<char, 32> text{};
  (void)std::snprintf(text.data(), text.size(), "%.1f", static_cast<double>(bytes) / 1e6);
  return text.data();
}

}  // namespace

GpuBudget::GpuBudget(std::uint64_t bytes, const std::shared_ptr<const Surface>& surface, const TileOptions& layout,
                     const std::filesystem::path& mesh_file)
    : bytes_(bytes), of_surface_(0), mesh_file_(mesh_file), count_(surface) {
  of_surface_ = count_.of_surface();
  if (const std::uint64_t least = of_surface_ + place_bytes(layout); least > bytes) refuse(least);
}

void GpuBudget::refuse(std::uint64_t least) const {
  throw InputError(mesh_file_.string() + ": the mesh and its tables alone take " + std::to_string(of_surface_) +
                   " bytes on the GPU, and with one tile of a photograph " + std::to_string(least) +
                   ", more than the budget of " + std::to_string(bytes_) +
                   ": give at least that as --budget, or fewer faces (--faces) or larger cells (--cell-size)");
}

double GpuBudget::fitting_share(Atlas& atlas) const {
  atlas.set_tile_limit(0);
  const GpuBytes bytes = count_.of(atlas.snapshot());
  const std::uint64_t others = bytes.sum() - bytes.photographs(), one = place_bytes(atlas.layout());
  const std::uint64_t room = std::max(others < bytes_ ? bytes_ - others : 0, one);
  return static_cast<double>(room) / static_cast<double>(std::max(bytes.photographs(), one));
}

// Between a number of tiles that fits and one that does not. Where fewer tiles make more cells refer to the same views,
// the mesh takes less too, so that the sum rises faster than the tiles.
Snapshot GpuBudget::fitted_snapshot(Atlas& atlas) const {
  constexpr int kMostTries = 8;
  atlas.set_tile_limit(0);
  Snapshot best = atlas.snapshot();
  GpuBytes bytes = count_.of(best);
  if (bytes.sum() <= bytes_) return best;
  const TileOptions layout = atlas.layout();
  const std::uint64_t tolerance = bytes_ / kUnused / place_bytes(layout) + 1;
  std::uint32_t fit = 0, too_many = best.tiles.resident_tiles();
  for (int tries = 0; fit == 0 || (tries < kMostTries && too_many - fit > tolerance); ++tries) {
    throw_if_interrupted();
    if (too_many <= 1) refuse(bytes.sum());
    const std::uint64_t others = bytes.sum() - bytes.photographs();
    const std::uint64_t room = others < bytes_ ? (bytes_ - others) / place_bytes(layout) : 0;
    const bool between = fit < room && room < too_many;
    const std::uint32_t wanted = between ? static_cast<std::uint32_t>(room) : fit + (too_many - fit + 1) / 2;
    const std::uint32_t tiles = std::max(places_within(wanted * place_bytes(layout), layout), 1u);
    if (tiles <= fit) break;
    atlas.set_tile_limit(tiles);
    Snapshot next = atlas.snapshot();
    bytes = count_.of(next);
    if (bytes.sum() > bytes_) {
      too_many = std::min(tiles, too_many - 1);
      continue;
    }
    fit = tiles;
    best = std::move(next);
  }
  return best;
}

json gpu_bytes_json(const GpuBytes& bytes) {
  return {{"mesh", bytes.mesh},   {"vertices", bytes.vertices}, {"tables", bytes.tables}, {"depth", bytes.depth},
          {"masks", bytes.masks}, {"colors", bytes.colors},     {"sum", bytes.sum()}};
}

std::string gpu_bytes_text(const json& bytes) {
  std::string text = megabytes(bytes["sum"].get<std::uint64_t>()) + " MB";
  const char* separator = ": ";
  for (const char* const part : kParts) {
    text += separator + std::string(part) + ' ' + megabytes(bytes[part].get<std::uint64_t>());
    separator = ", ";
  }
  return text;
}

}  // namespace lumatlas
