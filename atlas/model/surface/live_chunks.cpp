// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/live_chunks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "atlas/model/surface/surface_chunks.h"

namespace lumatlas {

namespace {

using SharesOf = std::function<CellShares(const Surface& surface)>;

std::uint32_t place_in(const std::vector<CellId>& ascending, CellId cell) {
  return static_cast<std::uint32_t>(std::lower_bound(ascending.begin(), ascending.end(), cell) - ascending.begin());
}

std::vector<LiveChunk> listed_chunks(const Surface& surface, const GridChunks& plan, const FacesOfCells& faces,
                                     double width) {
  const std::vector<std::uint64_t> hashes = hashes_of_cells(surface.mesh, faces, surface.cells.cells.size());
  std::vector<LiveChunk> chunks(plan.all().size());
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
    const GridChunk& planned = plan.all()[i];
    LiveChunk& chunk = chunks[i];
    chunk.cube = planned.cube;
    chunk.cells = planned.cells;
    chunk.around = plan.around(planned, width);
    chunk.content = hash_of_chunk(chunk.cells, chunk.around, hashes);
  });
  return chunks;
}

// Keeps the forms of chunks that have not changed.
void keep_forms(const LiveChunks& former, LiveChunks& now) {
  const bool same_grid = former.options.width == now.options.width &&
                         former.options.cells_across == now.options.cells_across && former.cell_size == now.cell_size &&
                         former.offset == now.offset;
  if (!same_grid) return;
  auto before = former.chunks.begin();
  for (LiveChunk& chunk : now.chunks) {
    while (before != former.chunks.end() && before->cube < chunk.cube) ++before;
    if (before == former.chunks.end()) return;
    if (before->cube == chunk.cube && before->content == chunk.content) chunk.form = before->form;
  }
}

// A snapshot of a surface alone.
Snapshot bare_snapshot(Surface surface) {
  Snapshot snapshot;
  const std::size_t cells = surface.cells.cells.size();
  snapshot.vertex_colors = std::vector<glm::u8vec3>(surface.mesh.positions.size());
  snapshot.cell_seen.resize(cells);
  snapshot.references.offsets.resize(cells + 1);
  snapshot.surface = std::make_shared<const Surface>(std::move(surface));
  return snapshot;
}

// Returns for each vertex of a chunk what it copies.
std::vector<CornerOfCell> sources_of(const Surface& surface) {
  std::vector<CornerOfCell> sources(surface.mesh.positions.size());
  std::vector<std::uint32_t> corners(surface.cells.cells.size());  // of each cell, so far
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const CellId cell = surface.cells.cell_of_face[face];
    for (int corner = 0; corner < 3; ++corner) {
      sources[surface.mesh.faces[face][corner]] = {std::uint32_t{cell}, corners[cell]++};
    }
  }
  return sources;
}

// `cells`: of the whole surface, those of the part that `piece` is of.
std::shared_ptr<const LiveChunkForm> form_of(SurfaceChunk piece, const std::vector<CellId>& cells,
                                             const std::vector<CellId>& around) {
  auto form = std::make_shared<LiveChunkForm>();
  form->surface = *piece.snapshot.surface;
  form->mesh = written_surface(form->surface, &*piece.shares, nullptr, std::nullopt);
  form->origin = piece.origin;
  form->sources = sources_of(form->surface);
  for (const std::uint32_t guest : piece.guests) form->guests.push_back(place_in(around, cells[guest]));
  return form;
}

// Makes the forms of chunks that have none, of the part of the surface that they depend on.
void make_forms(const Surface& surface, const SharesOf& shares_of, LiveChunks& all) {
  std::vector<LiveChunk*> made;
  std::vector<CellId> cells;  // of the part
  for (LiveChunk& chunk : all.chunks) {
    if (chunk.form) continue;
    made.push_back(&chunk);
    cells.insert(cells.end(), chunk.around.begin(), chunk.around.end());
  }
  if (made.empty()) return;
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  Surface part = part_of_cells(surface, all.faces, cells);
  part.offset = surface.offset;
  const CellShares shares = shares_of(part);
  std::vector<std::vector<CellId>> of_chunks(made.size() + 1);  // the last has all other cells
  std::vector<std::uint8_t> is_made(cells.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    for (const CellId cell : made[i]->cells) {
      of_chunks[i].emplace_back(place_in(cells, cell));
      is_made[of_chunks[i].back()] = 1;
    }
  }
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
    if (!is_made[cell]) of_chunks.back().emplace_back(cell);
  }
  const Snapshot snapshot = bare_snapshot(std::move(part));
  const ChunkMaker maker(snapshot, &shares, nullptr, std::move(of_chunks), std::nullopt);
  tbb::parallel_for(std::size_t{0}, made.size(),
                    [&](std::size_t i) { made[i]->form = form_of(maker.chunk(i), cells, made[i]->around); });
}

}  // namespace

LiveChunks live_chunks(const Surface& surface, const LiveChunkOptions& options, const SharesOf& shares_of,
                       const LiveChunks* former) {
  LiveChunks all;
  if (surface.mesh.faces.size() < options.least_faces || surface.far_faces > 0) return all;
  constexpr std::size_t kMostChunks = 1024;
  const GridChunks plan(surface, options.cells_across);
  if (plan.all().size() < 2 || plan.all().size() > kMostChunks || !plan.are_even()) return all;
  all.options = options;
  all.cell_size = surface.cells.size;
  all.offset = surface.offset;
  all.faces = FacesOfCells(surface.cells);
  all.chunks = listed_chunks(surface, plan, all.faces, options.width);
  if (former) keep_forms(*former, all);
  make_forms(surface, shares_of, all);
  return all;
}

Snapshot chunk_snapshot(const Snapshot& snapshot, const FacesOfCells& faces, const LiveChunk& chunk) {
  const LiveChunkForm& form = *chunk.form;
  Snapshot part;
  part.surface = std::shared_ptr<const Surface>(chunk.form, &form.surface);
  std::vector<CellId> cells = chunk.cells;
  const auto take = [&](const auto& values, auto& taken) {
    if (values.empty()) return;
    taken.reserve(cells.size());
    for (const CellId cell : cells) taken.push_back(values[cell]);
  };
  take(snapshot.cell_seen, part.cell_seen);
  take(snapshot.cell_deviation, part.cell_deviation);
  for (const std::uint32_t guest : form.guests) cells.push_back(chunk.around[guest]);
  for (const CellId cell : cells) {
    const auto views = snapshot.references.of_cell(cell);
    part.references.views.insert(part.references.views.end(), views.begin(), views.end());
    part.references.offsets.push_back(static_cast<std::uint32_t>(part.references.views.size()));
  }
  const std::vector<glm::u8vec3>& all = snapshot.vertex_colors.get();
  std::vector<glm::u8vec3> colors;
  colors.reserve(form.sources.size());
  for (const auto& [cell, corner] : form.sources) {
    const std::uint32_t face = faces.of(chunk.cells[cell])[corner / 3];
    colors.push_back(all[snapshot.surface->mesh.faces[face][static_cast<int>(corner % 3)]]);
  }
  part.vertex_colors = std::move(colors);
  return part;
}

}  // namespace lumatlas
