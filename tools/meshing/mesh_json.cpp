// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/mesh_json.h"

#include <nlohmann/json.hpp>

namespace lumatlas {

namespace {

nlohmann::json depth_json(const std::optional<DepthFacts>& depth) {
  if (!depth) return nullptr;
  return {{"images", depth->images},
          {"measured", depth->measured},
          {"voxel", depth->voxel},
          {"voxel_px", depth->voxel_px},
          {"truncation", depth->truncation},
          {"confirmed", depth->confirmed},
          {"removed_pieces", depth->removed_pieces},
          {"removed_faces", depth->removed_faces},
          {"fused_faces", depth->fused_faces}};
}

nlohmann::json points_json(const SceneMesh& made) {
  if (made.depth) return nullptr;
  return {{"file", made.points_file.string()},
          {"read", made.points},
          {"used", made.points_used},
          {"spacing_px", made.spacing_px}};
}

nlohmann::json completion_json(const std::optional<CompletionFacts>& completion) {
  if (!completion) return nullptr;
  return {{"mesh", completion->file.string()},
          {"added_faces", completion->added_faces},
          {"covered_before", completion->covered_before},
          {"covered", completion->covered}};
}

}  // namespace

nlohmann::json mesh_json(const SceneMesh& made, const std::filesystem::path& output, double time_ms) {
  return {{"output", output.string()},
          {"from", name_of(made.source)},
          {"points", points_json(made)},
          {"depth", depth_json(made.depth)},
          {"completion", completion_json(made.completion)},
          {"views", {{"count", made.views}, {"matched", made.matched}, {"estimated", made.views_estimated}}},
          {"mesh", {{"vertices", made.surface.positions.size()}, {"faces", made.surface.faces.size()}}},
          {"trust",
           {{"points_on_surface", made.trust.points_on_surface},
            {"pixels_covered", made.trust.pixels_covered},
            {"frames_mostly_empty", made.trust.frames_mostly_empty},
            {"pixels_guessed", made.trust.pixels_guessed}}},
          {"warnings", made.warnings},
          {"time_ms", {{"total", time_ms}}}};
}

}  // namespace lumatlas
