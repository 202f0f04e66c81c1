// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_options.h"

#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

void check_watch(const BuildOptions& options) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw std::invalid_argument(std::string("build: watch is given, ") + rule);
  };
  const WatchOptions& watch = *options.watch;
  require(options.choice == ViewChoice::online, "choice must be ViewChoice::online");
  require(options.order == StreamOrder::given, "order must be StreamOrder::given");
  require(!options.hold_out, "hold_out must be empty: it needs the names of all photographs");
  require(options.max_views || options.planner.max_bytes + options.bound.gpu_bytes() > 0,
          "max_views, planner.max_bytes or bytes of the GPU must bound the model");
  require(watch.interval.count() > 0, "its interval must be above 0");
  require(watch.idle || watch.end, "it must have idle or end");
  require(!watch.idle || *watch.idle >= watch.interval, "its idle must not be below its interval");
}

void check_bound(const BuildOptions& options) {
  const Bound& bound = options.bound;
  check(bound);
  if (bound.texel_loss_db() + bound.face_loss_db() > 0 && !options.planner.max_loss_db) {
    throw std::invalid_argument("build: bound is on the loss, planner.max_loss_db must be given too");
  }
  if (bound.array_bytes() == 0) return;
  if (const std::uint64_t least = place_bytes(options.tiles); bound.array_bytes() < least) {
    throw std::invalid_argument("build: bound allows an array of " + std::to_string(bound.array_bytes()) +
                                " bytes, must be at least what a tile takes, " + std::to_string(least));
  }
}

}  // namespace

void check(const BuildOptions& options) {
  if (options.mesh_frame) check(*options.mesh_frame);
  check(options.cells);
  check(options.faces);
  PlannerOptions planner = options.planner;
  if (planner.coverage.ideal_distance == 0) planner.coverage.ideal_distance = 1;  // any, until the scene gives it
  check(planner);
  if (planner.max_loss_db && options.choice != ViewChoice::online) {
    throw std::invalid_argument("build: planner.max_loss_db is given, choice must be ViewChoice::online");
  }
  if (options.max_polish_steps < 1) throw std::invalid_argument("build: max_polish_steps is 0, must be at least 1");
  if (options.max_views == 0u) throw std::invalid_argument("build: max_views is 0, must be at least 1");
  if (options.hold_out) check(*options.hold_out);
  if (options.watch) check_watch(options);
  check(options.tiles);
  if (options.texture_px && !(*options.texture_px >= kLeastTexturePx && *options.texture_px <= kMostTexturePx)) {
    throw std::invalid_argument("build: texture_px is " + std::to_string(*options.texture_px) + ", must be in [" +
                                std::to_string(kLeastTexturePx) + ", " + std::to_string(kMostTexturePx) + "]");
  }
  if (options.tight_tiles) {
    check(*options.tight_tiles);
    if (options.tiles.whole_views() || options.tight_tiles->whole_views() || options.tight_tiles->max_tiles != 0) {
      throw std::invalid_argument("build: tight_tiles are given, both they and tiles must cut views, max_tiles be 0");
    }
  }
  if (options.tiles.max_tiles != 0) throw std::invalid_argument("build: tiles.max_tiles is not 0, give a bound");
  if (options.tiles.whole_views() && options.bound.bytes() > 0) {
    throw std::invalid_argument("build: bound is in bytes, but there are no tiles");
  }
  if (!(options.least_scale > 0 && options.least_scale <= 1)) {
    throw std::invalid_argument("build: least_scale is " + std::to_string(options.least_scale) +
                                ", must be above 0 and at most 1");
  }
  check_bound(options);
}

std::uint64_t photograph_bytes_for(std::uint64_t tile_bytes, const TileOptions& tiles) {
  TileOptions uncompressed = tiles;
  uncompressed.texels = TexelFormat::rgb8;
  const double times = static_cast<double>(place_bytes(uncompressed)) / static_cast<double>(place_bytes(tiles));
  return static_cast<std::uint64_t>(times * static_cast<double>(kPhotographsPerArray * tile_bytes));
}

}  // namespace lumatlas
