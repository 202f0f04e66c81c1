// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/city/small_city.h"

#include "mesh/base/whole_file.h"
#include "tools/city/block_job.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas {

const std::filesystem::path& small_city_scene() {
  static const TemporaryFolder folder;
  static const std::filesystem::path scene = [] {
    SynthOptions options;
    options.kind = SynthKind::village;
    options.views = 16;
    options.width = 96;
    options.height = 72;
    options.samples = 2;
    options.triangles = 20000;
    write_synthetic_scene(options, folder.path());
    return folder.path();
  }();
  return scene;
}

CityOptions small_city_options(std::size_t block_faces) {
  CityOptions options;
  options.build.refine = RefineMode::none;
  options.build.cells.size = 4;  // few cells take little time
  options.build.planner.visibility_px = 96;
  options.build.georeference = GeoReference{GeoReference::Frame::east_north_up, 48.2, 16.375, 190, {}};
  options.block_faces = block_faces;
  options.stamp = "blocks of " + std::to_string(block_faces);
  return options;
}

SmallCity::SmallCity(std::size_t block_faces)
    : plan(plan_city(small_city_scene(), small_city_options(block_faces), folder.path(), {})) {}

void build_blocks(const std::filesystem::path& folder, const CityPlan& plan) {
  for (std::size_t block = 0; block < plan.blocks.size(); ++block) (void)build_block(folder, plan, block, {});
}

std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[entry.path().lexically_relative(folder).string()] = read_whole_file(entry.path());
  }
  return files;
}

}  // namespace lumatlas
