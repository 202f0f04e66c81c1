// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/drawn_zones.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "blend/tables/view_pyramid.h"

namespace lumatlas {

namespace {

constexpr double kRoundingOfPlaces = 1e-5;  // of the shader's points, as a share of their distance
constexpr double kCellsAcross = 4;          // of a chunk
constexpr std::uint32_t kNotDrawn = ~0u;    // source of a vertex of a chunk that is not there any more
// Chunks of a batch are laid out again where less than half of it is drawn, and, where there are this many batches,
// those of the smaller half.
constexpr std::size_t kMostBatches = 32;

Ball ball_around(const std::vector<glm::vec3>& positions, std::span<const glm::uvec3> faces) {
  glm::dvec3 least(positions[faces.front().x]);
  glm::dvec3 most = least;
  for (const glm::uvec3& face : faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position(positions[face[corner]]);
      least = glm::min(least, position);
      most = glm::max(most, position);
    }
  }
  return {(least + most) / 2.0, glm::distance(least, most) / 2};
}

// The first of some elements of a batch.
struct Firsts {
  std::uint32_t zone = 0, vertex = 0;
  std::array<std::uint32_t, kCellsOfShader.size()> face{};
};

std::vector<Firsts> firsts_of(std::span<const ChunkMesh> chunks) {
  std::vector<Firsts> firsts(chunks.size());
  std::uint32_t zone = 0, vertex = 0, face = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    firsts[i].zone = zone;
    firsts[i].vertex = vertex;
    zone += static_cast<std::uint32_t>(chunks[i].zone_cells.cell.size());
    vertex += static_cast<std::uint32_t>(chunks[i].zones.size());
  }
  for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      firsts[i].face.at(shader) = face;
      face += static_cast<std::uint32_t>(chunks[i].faces.at(shader).size());
    }
  }
  return firsts;
}

template <typename T>
void copy_to(const std::vector<T>& from, std::vector<T>& to, std::uint32_t first) {
  std::copy(from.begin(), from.end(), to.begin() + first);
}

ZoneMesh joined_chunks(std::span<const ChunkMesh> chunks, std::span<const Firsts> firsts) {
  ZoneMesh mesh;
  std::size_t vertices = 0, faces = 0;
  for (const ChunkMesh& chunk : chunks) {
    vertices += chunk.zones.size();
    for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
      mesh.face_counts.at(shader) += chunk.faces.at(shader).size();
      faces += chunk.faces.at(shader).size();
    }
  }
  mesh.positions.resize(vertices);
  mesh.shares.resize(vertices);
  mesh.zones.resize(vertices);
  mesh.faces.resize(faces);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
    const ChunkMesh& chunk = chunks[i];
    const Firsts& first = firsts[i];
    copy_to(chunk.positions, mesh.positions, first.vertex);
    copy_to(chunk.shares, mesh.shares, first.vertex);
    std::transform(chunk.zones.begin(), chunk.zones.end(), mesh.zones.begin() + first.vertex,
                   [&](std::uint32_t zone) { return first.zone + zone; });
    for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
      std::transform(chunk.faces.at(shader).begin(), chunk.faces.at(shader).end(),
                     mesh.faces.begin() + first.face.at(shader),
                     [&](const glm::uvec3& face) { return face + glm::uvec3(first.vertex); });
    }
  });
  return mesh;
}

// `names` ascend. `cells`: of the surface, those of the mesh that the chunk was made of; empty: they are the same.
ChunkLayout layout_of(ChunkMesh chunk, const Firsts& first, std::span<const CellId> names,
                      std::span<const CellId> cells) {
  const auto number_of = [&](std::uint32_t cell) {
    const CellId name = cells.empty() ? CellId(cell) : cells[cell];
    return static_cast<std::uint32_t>(std::lower_bound(names.begin(), names.end(), name) - names.begin());
  };
  ChunkLayout layout;
  layout.first_zone = first.zone;
  layout.first_vertex = first.vertex;
  layout.balls = balls_of_combinations(chunk);
  for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
    const std::span<const glm::uvec3> faces = chunk.faces.at(shader);
    for (std::uint32_t i = 0; i < faces.size(); i += kFacesOfRun) {
      const auto count = std::min(kFacesOfRun, static_cast<std::uint32_t>(faces.size()) - i);
      layout.runs.at(shader).push_back(
          {{first.face.at(shader) + i, count}, ball_around(chunk.positions, faces.subspan(i, count))});
    }
  }
  layout.sources = std::move(chunk.sources);
  layout.zone_cells = std::move(chunk.zone_cells);
  for (std::uint32_t& cell : layout.zone_cells.cell) cell = number_of(cell);
  for (CellShares::Zone& zone : layout.zone_cells.combinations) {
    for (CellId& cell : zone) {
      if (cell != CellId::none) cell = CellId(number_of(cell));
    }
  }
  return layout;
}

// Returns another number each time.
std::uint64_t new_number() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

// Makes the mesh of one surface.
class Layout {
 public:
  Layout(const std::shared_ptr<const Surface>& surface, const ZoneOptions& options, const DrawnZones* former)
      : options_(options),
        surface_(*surface),
        width_(options.border_width * surface->cells.size),
        plan_(*surface, kCellsAcross),
        faces_(surface->cells),
        zones_(std::make_shared<DrawnZones>()) {
    zones_->surface = surface;
    zones_->border_width = options.border_width;
    zones_->is_joined = !options.stands_for.empty();
    zones_->can_follow = options.will_change && !zones_->is_joined && surface_.far_cells == 0 && plan_.are_even();
    const bool follows = zones_->can_follow && former != nullptr && former->can_follow &&
                         former->border_width == options.border_width &&
                         former->surface->cells.size == surface_.cells.size;
    former_ = follows ? former : nullptr;
  }

  MadeZones run() {
    list_chunks();
    if (former_ != nullptr) keep_chunks();
    MadeZones made;
    made.mesh = add_batch();
    assemble();
    made.zones = std::move(zones_);
    return made;
  }

 private:
  void list_chunks() {
    std::vector<std::uint64_t> hashes;
    auto all = std::make_shared<std::vector<CellId>>();
    if (zones_->can_follow) {
      hashes = hashes_of_cells(surface_.mesh, faces_, surface_.cells.cells.size());
    } else {
      for (std::uint32_t cell = 0; cell < surface_.cells.cells.size(); ++cell) all->emplace_back(cell);
    }
    zones_->chunks.resize(plan_.all().size());
    tbb::parallel_for(std::size_t{0}, zones_->chunks.size(), [&](std::size_t i) {
      DrawnChunk& chunk = zones_->chunks[i];
      chunk.cube = plan_.all()[i].cube;
      chunk.cells = plan_.all()[i].cells;
      if (!zones_->can_follow) {
        chunk.names = all;
        return;
      }
      auto names = std::make_shared<std::vector<CellId>>(plan_.around(plan_.all()[i], width_));
      chunk.content = hash_of_chunk(chunk.cells, *names, hashes);
      chunk.names = std::move(names);
    });
  }

  // Keeps the layouts of chunks that have not changed, in batches that are worth it.
  void keep_chunks() {
    std::vector<const DrawnChunk*> kept(zones_->chunks.size());
    std::vector<std::size_t> drawn(former_->batches.size());  // vertices
    auto before = former_->chunks.begin();
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const DrawnChunk& chunk = zones_->chunks[i];
      while (before != former_->chunks.end() && before->cube < chunk.cube) ++before;
      if (before == former_->chunks.end()) break;
      if (before->cube != chunk.cube || before->content != chunk.content) continue;
      kept[i] = &*before;
      drawn[before->batch] += before->layout->sources.size();
    }
    const std::vector<std::uint32_t> number = batches_kept(drawn);
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (kept[i] == nullptr || number[kept[i]->batch] == kNotDrawn) continue;
      zones_->chunks[i].layout = kept[i]->layout;
      zones_->chunks[i].batch = number[kept[i]->batch];
    }
  }

  // Returns for each batch before which one it is now, or kNotDrawn. `drawn`: vertices that are drawn still.
  std::vector<std::uint32_t> batches_kept(std::span<const std::size_t> drawn) {
    std::vector<std::uint32_t> order(drawn.size());
    std::iota(order.begin(), order.end(), 0u);
    std::erase_if(order, [&](std::uint32_t batch) {
      return drawn[batch] == 0 || 2 * drawn[batch] < former_->batches[batch].sources.size();
    });
    if (order.size() >= kMostBatches) {
      std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return drawn[a] > drawn[b]; });
      order.resize(kMostBatches / 2);
      std::sort(order.begin(), order.end());
    }
    std::vector<std::uint32_t> number(drawn.size(), kNotDrawn);
    for (const std::uint32_t batch : order) {
      number[batch] = static_cast<std::uint32_t>(zones_->batches.size());
      const DrawnBatch& before = former_->batches[batch];
      zones_->batches.push_back(
          {before.number, 0, before.zones, std::vector<std::uint32_t>(before.sources.size(), kNotDrawn)});
    }
    return number;
  }

  // Lays the chunks out that no batch has.
  std::optional<ZoneMesh> add_batch() {
    std::vector<DrawnChunk*> added;
    for (DrawnChunk& chunk : zones_->chunks) {
      if (!chunk.layout) added.push_back(&chunk);
    }
    if (added.empty()) return std::nullopt;
    std::vector<ChunkMesh> meshes;
    std::vector<CellId> cells;  // of the part that the meshes are of; empty: all
    if (2 * added.size() < zones_->chunks.size()) {
      for (const DrawnChunk* chunk : added) cells.insert(cells.end(), chunk->names->begin(), chunk->names->end());
      std::sort(cells.begin(), cells.end());
      cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
      const Surface part = part_of_cells(surface_, faces_, cells);
      meshes = meshes_of(part, FacesOfCells(part.cells), added, cells);
    } else {
      meshes = meshes_of(surface_, faces_, added, cells);
    }
    const std::vector<Firsts> firsts = firsts_of(meshes);
    ZoneMesh mesh = joined_chunks(meshes, firsts);
    const auto batch = static_cast<std::uint32_t>(zones_->batches.size());
    zones_->batches.push_back({new_number(), 0,
                               firsts.back().zone + static_cast<std::uint32_t>(meshes.back().zone_cells.cell.size()),
                               std::vector<std::uint32_t>(mesh.positions.size(), kNotDrawn)});
    tbb::parallel_for(std::size_t{0}, added.size(), [&](std::size_t i) {
      DrawnChunk& chunk = *added[i];
      chunk.batch = batch;
      chunk.layout =
          std::make_shared<const ChunkLayout>(layout_of(std::move(meshes[i]), firsts[i], *chunk.names, cells));
    });
    return mesh;
  }

  // `cells`: of the surface, that those of the part are; empty: they are the same.
  std::vector<ChunkMesh> meshes_of(const Surface& part, const FacesOfCells& faces, std::span<DrawnChunk* const> chunks,
                                   std::span<const CellId> cells) const {
    CellShares shares = options_.shares && cells.empty() ? *options_.shares : share_cells(part, width_);
    if (zones_->is_joined) shares = joined(std::move(shares), options_.stands_for);
    std::vector<ChunkMesh> meshes(chunks.size());
    tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
      std::vector<CellId> own;
      for (const CellId cell : chunks[i]->cells) {
        own.push_back(cells.empty() ? cell
                                    : CellId(static_cast<std::uint32_t>(
                                          std::lower_bound(cells.begin(), cells.end(), cell) - cells.begin())));
      }
      meshes[i] = chunk_mesh(part.mesh, faces, own, shares);
    });
    return meshes;
  }

  // Lists the zones of all batches, and which vertices of the surface theirs are.
  void assemble() {
    std::uint32_t zones = 0;
    for (DrawnBatch& batch : zones_->batches) {
      batch.first_zone = zones;
      zones += batch.zones;
    }
    ZoneCells& all = zones_->cells;
    all.cell.assign(zones, 0);  // a zone that is not drawn any more is that of any cell
    all.combination.assign(zones, 0);
    for (const DrawnChunk& chunk : zones_->chunks) {
      const ZoneCells& of_chunk = chunk.layout->zone_cells;
      const std::vector<CellId>& names = *chunk.names;
      const auto first_combination = static_cast<std::uint32_t>(all.combinations.size());
      for (CellShares::Zone zone : of_chunk.combinations) {
        for (CellId& cell : zone) {
          if (cell != CellId::none) cell = names[cell];
        }
        all.combinations.push_back(zone);
      }
      zones_->balls.insert(zones_->balls.end(), chunk.layout->balls.begin(), chunk.layout->balls.end());
      const std::uint32_t first = zones_->batches[chunk.batch].first_zone + chunk.layout->first_zone;
      for (std::uint32_t i = 0; i < of_chunk.cell.size(); ++i) {
        all.cell[first + i] = names[of_chunk.cell[i]];
        all.combination[first + i] = first_combination + of_chunk.combination[i];
      }
    }
    tbb::parallel_for(std::size_t{0}, zones_->chunks.size(), [&](std::size_t i) {
      const DrawnChunk& chunk = zones_->chunks[i];
      std::uint32_t* source = &zones_->batches[chunk.batch].sources[chunk.layout->first_vertex];
      for (const auto& [cell, corner] : chunk.layout->sources) {
        const std::uint32_t face = faces_.of(chunk.cells[cell])[corner / 3];
        *source++ = surface_.mesh.faces[face][static_cast<int>(corner % 3)];
      }
    });
  }

  const ZoneOptions& options_;
  const Surface& surface_;
  double width_;  // scene units
  GridChunks plan_;
  FacesOfCells faces_;
  std::shared_ptr<DrawnZones> zones_;
  const DrawnZones* former_ = nullptr;  // null: nothing stays
};

}  // namespace

namespace {

bool differ_in_places_alone(const Surface& a, const Surface& b) {
  return a.mesh.positions.size() == b.mesh.positions.size() && a.cells.cells.size() == b.cells.cells.size() &&
         a.far_faces == b.far_faces && a.far_vertices == b.far_vertices && a.far_cells == b.far_cells &&
         a.mesh.faces == b.mesh.faces && a.cells.cell_of_face == b.cells.cell_of_face;
}

// The movement of some vertices: that of the middle of their movements' box, and how far others are from it.
struct ChunkMotion {
  glm::dvec3 shift{0.0};
  double spread = 0;

  void move(Ball& ball) const {
    if (ball.radius < 0) return;
    ball.center += shift;
    ball.radius += spread;
  }
};

ChunkMotion motion_of(const Mesh& before, const Mesh& now, std::span<const std::uint32_t> vertices) {
  glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
  for (const std::uint32_t vertex : vertices) {
    const glm::dvec3 moved = glm::dvec3(now.positions[vertex]) - glm::dvec3(before.positions[vertex]);
    least = glm::min(least, moved);
    most = glm::max(most, moved);
  }
  if (vertices.empty()) return {};
  return {(least + most) / 2.0, glm::distance(least, most) / 2};
}

}  // namespace

std::shared_ptr<const DrawnZones> moved_zones(const std::shared_ptr<const Surface>& surface, double border_width,
                                              const DrawnZones& former) {
  if (former.is_joined || former.border_width != border_width || !differ_in_places_alone(*surface, *former.surface)) {
    return nullptr;
  }
  auto zones = std::make_shared<DrawnZones>(former);
  zones->surface = surface;
  zones->can_follow = false;  // what was laid out is not what would be
  zones->balls.clear();
  tbb::parallel_for(std::size_t{0}, zones->chunks.size(), [&](std::size_t i) {
    DrawnChunk& chunk = zones->chunks[i];
    ChunkLayout layout = *chunk.layout;
    const std::span<const std::uint32_t> vertices =
        std::span(zones->batches[chunk.batch].sources).subspan(layout.first_vertex, layout.sources.size());
    const ChunkMotion motion = motion_of(former.surface->mesh, surface->mesh, vertices);
    for (Ball& ball : layout.balls) motion.move(ball);
    for (auto& of_shader : layout.runs) {
      for (BallOfFaces& run : of_shader) motion.move(run.ball);
    }
    chunk.layout = std::make_shared<const ChunkLayout>(std::move(layout));
  });
  for (const DrawnChunk& chunk : zones->chunks) {
    zones->balls.insert(zones->balls.end(), chunk.layout->balls.begin(), chunk.layout->balls.end());
  }
  return zones;
}

std::vector<glm::vec3> copied_positions(const Mesh& mesh, const DrawnBatch& batch) {
  std::vector<glm::vec3> copies(batch.sources.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, copies.size(), 16384), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      if (batch.sources[i] != kNotDrawn) copies[i] = mesh.positions[batch.sources[i]];
    }
  });
  return copies;
}

RunsOfShaders DrawnZones::in_view(const Camera& camera) const {
  const ViewPyramid pyramid = view_pyramid(camera);
  RunsOfShaders seen;
  for (std::size_t shader = 0; shader < seen.size(); ++shader) {
    std::vector<DrawnRun>& of_shader = seen.at(shader);
    for (const DrawnChunk& chunk : chunks) {
      for (const auto& [faces, ball] : chunk.layout->runs.at(shader)) {
        // A little more than the ball, because the shader rounds.
        const glm::dvec3 center = camera.cam_from_world(ball.center);
        if (outside(pyramid, center, ball.radius + kRoundingOfPlaces * glm::length(center))) continue;
        if (!of_shader.empty() && of_shader.back().batch == chunk.batch &&
            of_shader.back().faces.first + of_shader.back().faces.count == faces.first) {
          of_shader.back().faces.count += faces.count;
        } else {
          of_shader.push_back({chunk.batch, faces});
        }
      }
    }
  }
  return seen;
}

MadeZones make_zones(const std::shared_ptr<const Surface>& surface, const ZoneOptions& options,
                     const DrawnZones* former) {
  return Layout(surface, options, former).run();
}

std::vector<glm::u8vec3> copied_colors(const FallbackColors& colors, const DrawnBatch& batch) {
  const FallbackColors::Colors& now = colors.get();
  std::vector<glm::u8vec3> copies(batch.sources.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, copies.size(), 16384), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      if (batch.sources[i] != kNotDrawn) copies[i] = now[batch.sources[i]];
    }
  });
  return copies;
}

}  // namespace lumatlas
