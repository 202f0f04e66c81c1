// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: plans a scene whose poses and mesh are taken as they are given, piece by piece, in bounded
// memory.
#pragma once

#include <filesystem>

#include "tools/budget/build_progress.h"
#include "tools/city/planning/plan_city.h"

namespace lumatlas {

// Returns whether nothing is asked for that needs the whole surface in memory: refinement, completion, closing of holes
// and simplification do.
[[nodiscard]] bool can_plan_in_pieces(const CityOptions& options);

// Does what plan_city() does with such options: fills in the plan and writes its surface. Memory holds the triangles of
// the mesh file, then pieces of the surface, within the plan's memory unless the file's triangles alone are more.
void plan_in_pieces(const std::filesystem::path& scene, const CityOptions& options, const std::filesystem::path& folder,
                    const BuildCallback& callback, CityPlan& plan);

}  // namespace lumatlas
