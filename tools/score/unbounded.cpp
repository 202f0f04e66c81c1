// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/unbounded.h"

#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/colors/vertex_colors.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/photometry.h"
#include "tools/scene/photograph_stream.h"

namespace lumatlas {

namespace {

// Views by cell, each cell's in ascending order, from the cells of each view.
ReferenceTable table_of(const std::vector<std::vector<CellPixels>>& cells_of_view, std::size_t cell_count) {
  std::vector<std::uint32_t> next(cell_count + 1, 0);
  for (const auto& cells : cells_of_view) {
    for (const CellPixels& seen : cells) ++next[seen.cell + 1];
  }
  for (std::size_t cell = 0; cell < cell_count; ++cell) next[cell + 1] += next[cell];
  ReferenceTable table;
  table.offsets = next;
  table.views.resize(next.back());
  for (ViewSlot view{0}; view < cells_of_view.size(); ++view) {
    for (const CellPixels& seen : cells_of_view[view]) table.views[next[seen.cell]++] = view;
  }
  return table;
}

}  // namespace

Snapshot unbounded_lumigraph(std::shared_ptr<const Surface> surface, const std::vector<SceneView>& views,
                             const std::vector<std::size_t>& ranks, const ValidityOptions& options, Progress& progress,
                             bool keep_views) {
  if (!surface) throw std::invalid_argument("unbounded lumigraph: surface is null");
  check(*surface);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface->mesh);
  const Cells& cells = surface->cells;
  std::vector<std::vector<CellPixels>> cells_of_view;
  constexpr glm::dvec3 kPhotographsAsTheyAre(1);
  VertexColorMean colors(surface->mesh);
  Snapshot snapshot;
  snapshot.cell_seen.assign(cells.cells.size(), 0);
  PhotographStream photographs(views, ranks);
  for (const std::size_t rank : ranks) {
    Photograph photograph = photographs.next();
    VisibilityBuffer buffer = visibility->trace(views[rank].camera);
    std::vector<CellPixels> seen_cells = count_cell_pixels(buffer, cells);
    for (const CellPixels& seen : seen_cells) snapshot.cell_seen[seen.cell] = 1;
    const auto view = std::make_shared<const StoredView>(
        make_stored_view(views[rank].name, views[rank].camera, std::move(photograph), std::move(buffer), options));
    colors.add(*view, kPhotographsAsTheyAre);
    if (keep_views) {
      snapshot.views.push_back(view);
      snapshot.gains.push_back(kPhotographsAsTheyAre);
      cells_of_view.push_back(std::move(seen_cells));
    }
    progress.tick();
  }
  snapshot.references = table_of(cells_of_view, cells.cells.size());
  snapshot.vertex_colors = colors.colors();
  snapshot.surface = std::move(surface);
  return snapshot;
}

Snapshot without_views(const Snapshot& snapshot) {
  Snapshot bare = snapshot;
  bare.views.clear();
  bare.gains.clear();
  bare.references.views.clear();
  bare.references.offsets.assign(snapshot.references.offsets.size(), 0);
  return bare;
}

std::optional<Snapshot> with_given_poses(const Snapshot& snapshot, const std::vector<SceneView>& views,
                                         const Visibility& visibility, const ValidityOptions& options) {
  std::map<std::string, const Camera*> given;
  for (const SceneView& view : views) given[view.name] = &view.camera;
  Snapshot unmoved = snapshot;
  bool any_moved = false;
  for (std::shared_ptr<const StoredView>& view : unmoved.views) {
    const auto found = view ? given.find(view->name) : given.end();
    if (found == given.end() || same_pose(view->camera, *found->second)) continue;
    any_moved = true;
    Camera camera = view->camera;
    camera.cam_from_world_rotation = found->second->cam_from_world_rotation;
    camera.cam_from_world_translation = found->second->cam_from_world_translation;
    view = std::make_shared<const StoredView>(make_stored_view(
        view->name, camera, view->photograph, visibility.trace(camera), options, view->mask->trust.all()));
  }
  if (!any_moved) return std::nullopt;
  return unmoved;
}

}  // namespace lumatlas
