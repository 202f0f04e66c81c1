// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts a scene into blocks, and finds what they must agree on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "tools/budget/build_progress.h"
#include "tools/city/city_plan.h"
#include "tools/pipeline/build_options.h"

namespace lumatlas {

struct CityOptions {
  // Says for the whole scene which mesh it has, what is refined and which photographs are held out, and for each block
  // max_views and what settings name. RefineMode::none refines nothing; every other mode refines poses, exposures and
  // lenses jointly.
  BuildOptions build;
  std::size_t block_faces = 400'000;  // largest number of faces in a block, >= 1
  // Bytes that planning, the job of each block and joining take at most, each: see plan_in_pieces.h and job_bytes().
  // >= kLeastBlockMemory
  std::uint64_t memory = std::uint64_t{2} << 30;
  // Faces of the pieces in which the mesh is read and cut into cells, at most; 0: as many as fit into the memory.
  std::size_t piece_faces = 0;
  std::string stamp;  // of the plan
};

// Plans the scene and writes the plan's folder (open_plan_folder()). The mesh is divided into cells
// as `build` does it, and cut into blocks of whole cells (block_cut.h). With RefineMode::none one photograph is read;
// otherwise all are stored and refined together, as `build` would without a bound on their number, and those that agree
// with no others are left out. Throws as build_model().
CityPlan plan_city(const std::filesystem::path& scene, const CityOptions& options, const std::filesystem::path& folder,
                   const BuildCallback& callback);

}  // namespace lumatlas
