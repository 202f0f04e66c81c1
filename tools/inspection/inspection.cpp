// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/inspection/inspection.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "mesh/scene_extent.h"
#include "mesh/visibility/visibility.h"
#include "tools/base/progress.h"
#include "tools/inspection/blind_views.h"
#include "tools/inspection/mesh_diagnosis.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

using nlohmann::json;

json repairs_json(const RepairReport& repair) {
  return {{"vertices that were not finite", repair.non_finite_vertices},
          {"vertices merged with another at the same place", repair.merged_vertices},
          {"isolated vertices", repair.isolated_vertices},
          {"degenerate faces", repair.degenerate_faces},
          {"duplicate faces", repair.duplicate_faces},
          {"non-manifold edges, split", repair.non_manifold_edges},
          {"non-manifold vertices, split", repair.non_manifold_vertices},
          {"faces turned round", repair.reversed_faces}};
}

json cells_json(const Cells& cells, Partition partition) {
  std::vector<double> shares;
  for (const Cell& cell : cells.cells) shares.push_back(cell.area / (cells.size * cells.size));
  std::sort(shares.begin(), shares.end());
  const auto at = [&](double share) {
    return shares[std::min(shares.size() - 1, static_cast<std::size_t>(share * static_cast<double>(shares.size())))];
  };
  return {{"count", cells.cells.size()},
          {"size", cells.size},
          {"partition", partition == Partition::grid ? "grid" : "clusters"},
          {"area_share", {{"p5", at(0.05)}, {"median", at(0.5)}, {"p95", at(0.95)}}}};
}

// The part of the mesh that all cameras together see.
struct Glance {
  std::vector<std::string> blind;  // views with next to nothing of the mesh in their image
  std::size_t unseen_cells = 0;
  double median_distance = 0;  // scene units; 0: nothing is seen
  double covered = 0;          // mean share of the views' pixels that see the mesh
};

Glance glance(const Surface& surface, const Visibility& visibility, const SceneViews& scene, bool quiet) {
  std::vector<bool> seen(surface.cells.cells.size(), false);
  std::vector<float> depths;
  Glance result;
  VisibilityBuffer buffer;
  Progress progress("looking through every camera", scene.views.size(), ProgressOptions::standard_error(quiet));
  for (const SceneView& view : scene.views) {
    visibility.trace(view.camera.shrunk_to(kGlancePx), buffer);
    for (std::size_t pixel = 0; pixel < buffer.face.size(); ++pixel) {
      if (buffer.face[pixel] == FaceId::none) continue;
      seen[surface.cells.cell_of_face[buffer.face[pixel]]] = true;
      if (pixel % 61 == 0) depths.push_back(buffer.depth[pixel]);  // an even sample, whatever the width
    }
    result.covered += covered_share(buffer) / static_cast<double>(scene.views.size());
    if (sees_next_to_nothing(buffer)) result.blind.push_back(view.name);
    progress.tick();
  }
  result.unseen_cells = static_cast<std::size_t>(std::count(seen.begin(), seen.end(), false));
  if (!depths.empty()) {
    result.median_distance = static_cast<double>(upper_median(depths));
  }
  return result;
}

std::map<std::string, std::size_t> lenses_of(const SceneViews& scene) {
  std::map<std::string, std::size_t> lenses;
  for (const SceneView& view : scene.views) {
    ++lenses[std::string(name(view.lens.model)) + " " + size_text(view.lens.width, view.lens.height)];
  }
  return lenses;
}

std::string unseen_cells_warning(std::size_t unseen, std::size_t cells) {
  if (2 * unseen <= cells) return {};
  return std::to_string(unseen) + " of " + std::to_string(cells) +
         " cells are seen by no view: much of the mesh will have no photograph";
}

json warnings(const Glance& seen, const MeshDiagnosis& fit, const SceneViews& scene, const SurfaceInput& input) {
  json list = input.warnings;
  for (const std::string& sentence : fit.warnings) list.push_back(sentence);
  const std::string first = seen.blind.empty() ? "" : seen.blind.front();
  for (const std::string& sentence :
       {blind_views_warning(seen.blind.size(), scene.views.size(), first), empty_frames_warning(seen.covered),
        unseen_cells_warning(seen.unseen_cells, input.surface->cells.cells.size())}) {
    if (!sentence.empty()) list.push_back(sentence);
  }
  return list;
}

// Inspects a scene without a mesh.
json inspect_views(const std::filesystem::path& scene_path) {
  const SceneViews scene = read_scene_views(scene_path, glm::dvec3(0));
  json result{{"mesh", nullptr},
              {"cells", nullptr},
              {"views",
               {{"form", scene.form},
                {"notes", scene.notes},
                {"count", scene.views.size()},
                {"lenses", lenses_of(scene)},
                {"masked", masked_views(scene)},
                {"median_distance", nullptr},
                {"covered", nullptr},
                {"blind", json::array()}}},
              {"fit", nullptr},
              {"frames", nullptr},
              {"warnings", json::array()}};
  try {
    (void)find_mesh(scene_path, std::nullopt);
  } catch (const InputError& error) {
    result["warnings"].push_back(error.what());
  }
  return result;
}

}  // namespace

json inspect_scene(const std::filesystem::path& scene_path, const std::optional<std::filesystem::path>& mesh_file,
                   const MeshFrame& mesh_frame, const CellOptions& options, bool quiet, const LookPast& look_past) {
  if (!mesh_file && !mesh_beside(scene_path)) return inspect_views(scene_path);
  const SurfaceInput input = load_surface(scene_path, mesh_file, options, mesh_frame);
  const Surface& surface = *input.surface;
  const SceneViews scene = read_scene_views(scene_path, surface.offset);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface.mesh);
  const Glance seen = glance(surface, *visibility, scene, quiet);
  std::vector<std::size_t> ranks(scene.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  const MeshDiagnosis fit =
      diagnose_mesh(scene_path, input, surface.mesh, surface.offset, *visibility, scene.views, ranks);
  double area = 0;
  for (const Cell& cell : surface.cells.cells) area += cell.area;
  const double diameter = scene_diameter(surface.mesh);
  json result;
  result["mesh"] = {{"file", input.mesh_file.string()},
                    {"file_vertices", input.file_vertices},
                    {"file_faces", input.file_faces},
                    {"colors", input.file_has_colors},
                    {"repairs", repairs_json(input.repair)},
                    {"split_faces", input.split_faces},
                    {"vertices", surface.mesh.positions.size()},
                    {"faces", surface.mesh.faces.size()},
                    {"area", area},
                    {"diameter", diameter},
                    {"offset", {surface.offset.x, surface.offset.y, surface.offset.z}}};
  result["cells"] = cells_json(surface.cells, options.partition);
  result["cells"]["unseen"] = seen.unseen_cells;
  result["views"] = {{"form", scene.form},
                     {"notes", scene.notes},
                     {"count", scene.views.size()},
                     {"lenses", lenses_of(scene)},
                     {"masked", masked_views(scene)},
                     {"median_distance", seen.median_distance},
                     {"covered", seen.covered},
                     {"blind", seen.blind}};
  result["fit"] = mesh_diagnosis_json(fit);
  result["frames"] = look_past && fit.likely.empty() ? look_past(scene, surface.mesh, surface.offset) : json();
  result["warnings"] = warnings(seen, fit, scene, input);
  return result;
}

}  // namespace lumatlas
