// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/joining/join_blocks.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "atlas/images/pixel_memory.h"
#include "atlas/model/model_file.h"
#include "blend/blend_options.h"
#include "blend/tables/fade_zone_shares.h"
#include "mesh/base/errors.h"
#include "mesh/base/freed_memory.h"
#include "tools/base/process/interrupt.h"
#include "tools/city/block_job.h"
#include "tools/city/joining/chunk_texture.h"
#include "tools/city/joining/joined_views.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Refuses a block that does not begin with its own part of the surface.
void require_part(const Snapshot& part, const ChunkCounts& size, const fs::path& folder) {
  const Surface& surface = *part.surface;
  if (surface.cells.cells.size() >= size.cells && surface.mesh.faces.size() >= size.faces) {
    return;
  }
  throw InputError(folder.string() + ": is not the block that was planned: remove the folder and make it again");
}

// Returns the first of a block's own among `all` cells or faces of its model.
std::size_t first_own(const CityBlock& block, std::size_t own, std::size_t all) {
  return block.far ? all - own : 0;
}

// Appends the values of a block's own cells, zeros where there are none.
template <typename T>
void append_own(const std::vector<T>& from, const CityBlock& block, std::vector<T>& to) {
  const std::size_t own = block.size.cells;
  if (from.empty()) {
    to.insert(to.end(), own, T{});
    return;
  }
  const auto first = from.begin() + static_cast<std::ptrdiff_t>(first_own(block, own, from.size()));
  to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(own));
}

// Appends the references of a block's own cells.
void append_references(const ReferenceTable& from, const CityBlock& block, const std::vector<ViewSlot>& slots,
                       ReferenceTable& to) {
  const std::size_t own = block.size.cells, first = first_own(block, own, from.offsets.size() - 1);
  for (std::size_t cell = first; cell < first + own; ++cell) {
    for (const ViewSlot slot : from.of_cell(cell)) to.views.push_back(slots[slot]);
    to.offsets.push_back(static_cast<std::uint32_t>(to.views.size()));
  }
}

// Returns the colours of the corners of a block's own faces.
std::vector<glm::u8vec3> corner_colors(const Snapshot& part, const CityBlock& block) {
  const std::vector<glm::uvec3>& faces = part.surface->mesh.faces;
  const std::vector<glm::u8vec3>& of_vertex = part.vertex_colors.get();
  const std::size_t first = first_own(block, block.size.faces, faces.size());
  std::vector<glm::u8vec3> colors;
  colors.reserve(3 * block.size.faces);
  for (std::size_t face = first; face < first + block.size.faces; ++face) {
    for (int corner = 0; corner < 3; ++corner) colors.push_back(of_vertex[faces[face][corner]]);
  }
  return colors;
}

void require_all_done(const fs::path& folder, const CityPlan& plan) {
  for (std::size_t block = 0; block < plan.blocks.size(); ++block) {
    if (is_block_done(folder, plan, block)) continue;
    throw InputError(folder.string() + ": block " + std::to_string(block) + " of " +
                     std::to_string(plan.blocks.size()) + " is missing: `lumatlas city " + folder.string() + " --job " +
                     std::to_string(block) + "` makes it");
  }
}

bool is_within(const Bounds& a, const Bounds& b, double distance) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.min[axis] > b.max[axis] + distance || b.min[axis] > a.max[axis] + distance) return false;
  }
  return true;
}

// Returns the rows of these cells.
ReferenceTable picked_references(const ReferenceTable& all, const std::vector<std::size_t>& cells) {
  ReferenceTable picked;
  for (const std::size_t cell : cells) {
    const auto views = all.of_cell(cell);
    picked.views.insert(picked.views.end(), views.begin(), views.end());
    picked.offsets.push_back(static_cast<std::uint32_t>(picked.views.size()));
  }
  return picked;
}

template <typename T>
std::vector<T> picked_values(const std::vector<T>& all, const std::vector<std::size_t>& cells) {
  std::vector<T> picked;
  if (all.empty()) return picked;
  for (const std::size_t cell : cells) picked.push_back(all[cell]);
  return picked;
}

}  // namespace

JoinedCity::JoinedCity(fs::path folder, const CityPlan& plan, const JoinOptions& options, const BuildCallback& callback)
    : folder_(std::move(folder)), plan_(plan), options_(options), callback_(callback), surface_(folder_) {
  require_all_done(folder_, plan_);
  far_ = surface_.read(std::vector<std::size_t>{0}).far;
  find_chunks();
  read_blocks(callback);
}

std::size_t JoinedCity::faces() const {
  return std::accumulate(plan_.blocks.begin(), plan_.blocks.end(), std::size_t{0},
                         [](std::size_t sum, const CityBlock& block) { return sum + block.size.faces; });
}

// Puts chunks of the plan together, as many as have at most chunk_faces faces.
void JoinedCity::find_chunks() {
  std::size_t cells = 0;
  for (const CityChunk& chunk : plan_.chunks) {
    first_cell_.push_back(cells);
    cells += chunk.size.cells;
  }
  for (const CityBlock& block : plan_.blocks) {
    std::vector<std::size_t>& counts = chunks_.emplace_back();
    std::size_t faces = 0;
    for (std::size_t i = 0; i < block.own_chunks; ++i) {
      const std::size_t more = plan_.chunks[block.chunks[i]].size.faces;
      if (counts.empty() || faces + more > options_.chunk_faces) {
        counts.push_back(0);
        faces = 0;
      }
      ++counts.back();
      faces += more;
    }
  }
}

void JoinedCity::read_blocks(const BuildCallback& callback) {
  JoinedViews views;
  std::vector<Snapshot> parts;  // without surfaces and colours; references are to their own view slots
  BuildStage stage(callback, "joining blocks", plan_.blocks.size());
  for (std::size_t number = 0; number < plan_.blocks.size(); ++number) {
    throw_if_interrupted();
    const CityBlock& block = plan_.blocks[number];
    Model model = read_model(block_folder(folder_, number));
    require_part(model.snapshot, block.size, block_folder(folder_, number));
    if (!block.views.empty()) validity_ = model.validity;
    views.add(model.snapshot);
    colors_.emplace_back(corner_colors(model.snapshot, block));
    model.snapshot.surface.reset();
    model.snapshot.vertex_colors = {};
    parts.push_back(std::move(model.snapshot));
    stage.tick();
  }
  stage.finish();
  std::vector<std::vector<ViewSlot>> slots;
  for (Snapshot& part : parts) {
    slots.push_back(views.slots_of(part));
    part.views.clear();
  }
  views.fill(whole_);
  whole_.georeference = plan_.georeference;
  const auto any = [&](auto table) {
    return std::any_of(parts.begin(), parts.end(), [&](const Snapshot& part) { return !(part.*table).empty(); });
  };
  const bool covered = any(&Snapshot::cell_coverage), deviates = any(&Snapshot::cell_deviation);
  for (std::size_t number = 0; number < plan_.blocks.size(); ++number) {
    const CityBlock& block = plan_.blocks[number];
    Snapshot& part = parts[number];
    append_own(part.cell_seen, block, whole_.cell_seen);
    if (covered) append_own(part.cell_coverage, block, whole_.cell_coverage);
    if (deviates) append_own(part.cell_deviation, block, whole_.cell_deviation);
    append_references(part.references, block, slots[number], whole_.references);
    part = {};
  }
}

PiecewiseModel JoinedCity::model() {
  PiecewiseModel model;
  model.whole = whole_;
  PiecewiseSurface& surface = model.surface;
  for (const std::vector<std::size_t>& counts : chunks_) surface.chunks += counts.size();
  Bounds box;
  for (const CityChunk& chunk : plan_.chunks) box = with(box, chunk.box);
  surface.cell_size = std::min(plan_.cell_size, glm::length(box.max - box.min));
  const ChunkedSurface first = surface_.read(std::vector<std::size_t>{0});
  surface.offset = first.surface.offset;
  surface.before_far = depth_before_far(with_far_sphere(first.surface, far_));
  surface.next = [this] { return next_piece(); };
  return model;
}

SurfacePiece JoinedCity::next_piece() {
  const bool has_far = plan_.blocks.back().far;
  const std::size_t count = plan_.blocks.size() - (has_far ? 1 : 0);
  if (next_block_ == 0) writing_.emplace(callback_, "writing blocks", count);
  SurfacePiece made = piece(next_block_++);
  if (options_.texture_px > 0) add_textures(made);
  writing_->tick();
  if (next_block_ == count) writing_->finish();
  return made;
}

// Returns the block's own chunks, then those near enough for their cells to fade into its own.
std::vector<std::size_t> JoinedCity::chunks_around(std::size_t block) const {
  // Cells twice as far away as they fade decide which of a face's cells are left out where they are too many.
  const double reach = 2 * BlendOptions{}.border_width * plan_.cell_size;
  const auto own = std::span(plan_.blocks[block].chunks).first(plan_.blocks[block].own_chunks);
  std::vector<std::size_t> chunks(own.begin(), own.end());
  for (std::size_t other = 0; other < plan_.chunks.size(); ++other) {
    if (other >= own.front() && other <= own.back()) continue;
    const bool is_near = std::any_of(own.begin(), own.end(), [&](std::size_t chunk) {
      return is_within(plan_.chunks[chunk].box, plan_.chunks[other].box, reach);
    });
    if (is_near) chunks.push_back(other);
  }
  return chunks;
}

void JoinedCity::add_tables(const std::vector<std::size_t>& chunks, SurfacePiece& piece) const {
  std::vector<std::size_t> cells;  // numbers in the whole
  for (const std::size_t chunk : chunks) {
    for (std::size_t i = 0; i < plan_.chunks[chunk].size.cells; ++i) cells.push_back(first_cell_[chunk] + i);
  }
  for (std::size_t i = 0; i < piece.snapshot.surface->far_cells; ++i) {
    cells.push_back(whole_.cell_seen.size() - piece.snapshot.surface->far_cells + i);
  }
  piece.snapshot.references = picked_references(whole_.references, cells);
  piece.snapshot.cell_seen = picked_values(whole_.cell_seen, cells);
  piece.snapshot.cell_coverage = picked_values(whole_.cell_coverage, cells);
  piece.snapshot.cell_deviation = picked_values(whole_.cell_deviation, cells);
}

void JoinedCity::add_colors(std::size_t block, SurfacePiece& piece) const {
  const Surface& surface = *piece.snapshot.surface;
  std::vector<glm::u8vec3> colors(surface.mesh.positions.size(), glm::u8vec3(128));
  const auto take = [&](const CornerColors& of_corner, std::size_t first_face) {
    for (std::size_t i = 0; i < of_corner.size(); ++i) {
      colors[surface.mesh.faces[first_face + i / 3][static_cast<int>(i % 3)]] = of_corner[i];
    }
  };
  take(colors_[block], 0);
  if (surface.far_faces > 0) take(colors_.back(), surface.near_faces());
  piece.snapshot.vertex_colors = std::move(colors);
}

SurfacePiece JoinedCity::piece(std::size_t block) const {
  throw_if_interrupted();
  const std::vector<std::size_t> chunks = chunks_around(block);
  ChunkedSurface read = surface_.read(chunks);
  read.surface.cells.size = plan_.cell_size;
  SurfacePiece piece;
  piece.snapshot.surface = std::make_shared<const Surface>(
      block == 0 && !far_.mesh.faces.empty() ? with_far_sphere(read.surface, far_) : std::move(read.surface));
  add_tables(chunks, piece);
  add_colors(block, piece);
  std::size_t chunk = 0;
  std::uint32_t cell = 0;
  for (const std::size_t count : chunks_[block]) {
    std::vector<CellId>& cells = piece.chunks.emplace_back();
    for (const std::size_t end = chunk + count; chunk < end; ++chunk) {
      for (std::size_t i = 0; i < plan_.chunks[chunks[chunk]].size.cells; ++i) cells.emplace_back(cell++);
    }
  }
  piece.shares = drawn_shares(*piece.snapshot.surface, piece.snapshot.references, BlendOptions{}.border_width);
  return piece;
}

void JoinedCity::add_textures(SurfacePiece& piece) {
  Snapshot snapshot = piece.snapshot;
  snapshot.views = whole_.views;
  snapshot.gains = whole_.gains;
  snapshot.tiles = whole_.tiles;
  for (const std::vector<CellId>& cells : piece.chunks) {
    throw_if_interrupted();
    piece.textures.push_back(chunk_texture(snapshot, cells, options_.texture_px));
    if (!piece.textures.back()) ++chunks_without_texture_;
    give_back_scratch_pages();
    return_freed_memory();  // baking leaves much in small pieces
  }
}

}  // namespace lumatlas
