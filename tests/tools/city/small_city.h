// SPDX-License-Identifier: GPL-3.0-or-later
// A village of some 20,000 faces, planned as a city of several blocks, which the tests of cities share.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tests/support/temporary_folder.h"
#include "tools/city/planning/plan_city.h"

namespace lumatlas {

// A scene of 16 photographs, made at the first call.
const std::filesystem::path& small_city_scene();

// Options with exact poses and the mesh as it is, for blocks of this size.
[[nodiscard]] CityOptions small_city_options(std::size_t block_faces);

// A plan in a folder of its own.
struct SmallCity {
  TemporaryFolder folder;
  CityPlan plan;

  explicit SmallCity(std::size_t block_faces);
};

// Makes the blocks of a plan on this thread.
void build_blocks(const std::filesystem::path& folder, const CityPlan& plan);

// Returns what each file in a folder holds, by its path in it.
[[nodiscard]] std::map<std::string, std::string> files_of(const std::filesystem::path& folder);

}  // namespace lumatlas
