// SPDX-License-Identifier: GPL-3.0-or-later
// The plan of a large scene: its surface in blocks, and all that the blocks must agree on, which was found once for the
// whole scene. It is a folder:
//
//   plan.json    this struct; written last
//   surface/     the surface in small chunks, those of each block one after the other (city_surface.h)
//   blocks/K/    what the job of block K made (block_job.h)
//   logs/K.txt   what that job said
//   stereo/      depths of photographs, while the scene is planned
//   Snakefile    the jobs as a workflow (workflow.h)
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "atlas/model/surface/chunked_surface.h"
#include "mesh/camera/camera.h"
#include "mesh/camera/lens_correction.h"
#include "mesh/camera/shutter_motion.h"
#include "tools/pipeline/build_options.h"

namespace lumatlas {

inline constexpr const char* kPlanName = "plan.json";

// A job keeps pixels of photographs and masks in at most the plan's memory divided by this (PixelMemoryBound).
inline constexpr std::uint64_t kPixelShare = 4;
inline constexpr std::uint64_t kLeastBlockMemory = std::uint64_t{512} << 20;  // bytes

// A photograph, as all blocks see it.
struct CityView {
  std::string name;
  Camera camera;              // its pose relative to the surface's offset
  LensCorrection correction;  // of the lens
  ShutterMotion motion;       // as SceneView::motion
  glm::dvec3 gain{1.0};       // as Snapshot::gains
  bool black_rim = false;     // see SceneView::black_rim
};

// A chunk of the surface, without the far sphere.
struct CityChunk {
  ChunkCounts size;
  Bounds box;  // around its vertices, in the frame of the surface
};

struct CityBlock {
  // The far sphere, which is a block of its own, the last: its job reads the whole surface, whose cells count as one.
  bool far = false;
  ChunkCounts size;  // of its own part of the surface
  // Lists the chunks of the surface that its job reads: its own chunks, which follow each other, then those that may
  // stand between it and a camera.
  std::vector<std::size_t> chunks;
  std::size_t own_chunks = 0;  // how many of them are its own; 0 for the far sphere
  // Numbers in CityPlan::views, ascending: the photographs among those that see some cell best.
  std::vector<std::size_t> views;
};

struct CityPlan {
  std::filesystem::path scene;        // absolute
  BuildOptions build;                 // of each block's job: pictures, max_views, and what settings name
  double usual_distance = 0;          // from camera to surface, scene units, > 0
  std::vector<CityView> views;        // sorted by name
  std::uint64_t memory = 0;           // that planning, each job and joining may take, bytes
  double cell_size = 0;               // of the surface's cells, scene units, > 0
  std::vector<CityChunk> chunks;      // of the surface, in their order
  std::vector<CityBlock> blocks;      // in the order of the surface's chunks; each chunk is one block's own
  std::vector<std::string> left_out;  // photographs that agree with no others, or add nothing
  std::optional<HoldOut> hold_out;    // of the photographs that are held out
  std::vector<std::string> warnings;  // sentences about the scene
  std::optional<GeoReference> georeference;
  std::string stamp;  // differs where the plan was made from other inputs
};

// Returns folders within a plan.
[[nodiscard]] std::filesystem::path surface_folder(const std::filesystem::path& plan);
[[nodiscard]] std::filesystem::path block_folder(const std::filesystem::path& plan, std::size_t block);
[[nodiscard]] std::filesystem::path block_log(const std::filesystem::path& plan, std::size_t block);

// Makes the folder of a plan, unless it is there. Throws InputError if it holds anything that is not of a plan.
void open_plan_folder(const std::filesystem::path& plan);
// Removes what is of a plan, and the folder if nothing else is in it.
void remove_plan(const std::filesystem::path& plan);

// Returns whether the folder holds a plan that was finished.
[[nodiscard]] bool is_city_plan(const std::filesystem::path& folder);

// Both throw InputError, reading for a plan that breaks a rule, with file, place and value.
void write_city_plan(const std::filesystem::path& folder, const CityPlan& plan);
[[nodiscard]] CityPlan read_city_plan(const std::filesystem::path& folder);

}  // namespace lumatlas
