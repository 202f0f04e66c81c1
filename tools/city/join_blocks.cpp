// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/join_blocks.h"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"
#include "tools/city/block_job.h"
#include "tools/city/joined_views.h"

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

// Gives the vertices of a block's own faces the colours that they have in its model. `first_face` is the first of these
// faces in the whole. Faces are in the same order in both, vertices are not.
void take_colors(const Snapshot& part, const CityBlock& block, const Mesh& whole, std::size_t first_face,
                 std::vector<glm::u8vec3>& colors) {
  const std::vector<glm::uvec3>& faces = part.surface->mesh.faces;
  const std::vector<glm::u8vec3>& of_part = part.vertex_colors.get();
  const std::size_t own = first_own(block, block.size.faces, faces.size());
  for (std::size_t face = 0; face < block.size.faces; ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      colors[whole.faces[first_face + face][corner]] = of_part[faces[own + face][corner]];
    }
  }
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

std::shared_ptr<const Surface> whole_surface(const fs::path& folder, const CityPlan& plan) {
  std::vector<std::size_t> chunks;
  for (const CityBlock& block : plan.blocks) {
    const auto own = std::span(block.chunks).first(block.own_chunks);
    chunks.insert(chunks.end(), own.begin(), own.end());
  }
  const ChunkedSurface city = read_chunks(surface_folder(folder), chunks);
  return std::make_shared<const Surface>(with_far_sphere(city.surface, city.far));
}

void require_all_done(const fs::path& folder, const CityPlan& plan) {
  for (std::size_t block = 0; block < plan.blocks.size(); ++block) {
    if (is_block_done(folder, plan, block)) continue;
    throw InputError(folder.string() + ": block " + std::to_string(block) + " of " +
                     std::to_string(plan.blocks.size()) + " is missing: `lumatlas city " + folder.string() + " --job " +
                     std::to_string(block) + "` makes it");
  }
}

// Holds the blocks as they were read, whose references are still to their own view slots.
struct ReadBlocks {
  std::vector<Snapshot> parts;  // without surfaces and colours
  JoinedViews views;
  std::vector<glm::u8vec3> colors;  // of the whole's vertices
  ValidityOptions validity;
};

ReadBlocks read_blocks(const fs::path& folder, const CityPlan& plan, const Mesh& whole, const BuildCallback& callback) {
  ReadBlocks read;
  read.colors.resize(whole.positions.size());
  std::size_t first_face = 0;
  BuildStage stage(callback, "joining blocks", plan.blocks.size());
  for (std::size_t number = 0; number < plan.blocks.size(); ++number) {
    throw_if_interrupted();
    const CityBlock& block = plan.blocks[number];
    Model model = read_model(block_folder(folder, number));
    require_part(model.snapshot, block.size, block_folder(folder, number));
    if (!block.views.empty()) read.validity = model.validity;
    read.views.add(model.snapshot);
    take_colors(model.snapshot, block, whole, first_face, read.colors);
    first_face += block.size.faces;
    model.snapshot.surface.reset();
    model.snapshot.vertex_colors = {};
    read.parts.push_back(std::move(model.snapshot));
    stage.tick();
  }
  stage.finish();
  return read;
}

}  // namespace

JoinedCity join_blocks(const fs::path& folder, const CityPlan& plan, const BuildCallback& callback) {
  require_all_done(folder, plan);
  JoinedCity city;
  Snapshot& joined = city.snapshot;
  joined.surface = whole_surface(folder, plan);
  ReadBlocks read = read_blocks(folder, plan, joined.surface->mesh, callback);
  city.validity = read.validity;
  joined.georeference = plan.georeference;
  read.views.fill(joined);
  joined.vertex_colors = std::move(read.colors);
  const auto any = [&](auto table) {
    return std::any_of(read.parts.begin(), read.parts.end(),
                       [&](const Snapshot& part) { return !(part.*table).empty(); });
  };
  const bool covered = any(&Snapshot::cell_coverage), deviates = any(&Snapshot::cell_deviation);
  for (std::size_t number = 0; number < plan.blocks.size(); ++number) {
    const CityBlock& block = plan.blocks[number];
    const Snapshot& part = read.parts[number];
    append_own(part.cell_seen, block, joined.cell_seen);
    if (covered) append_own(part.cell_coverage, block, joined.cell_coverage);
    if (deviates) append_own(part.cell_deviation, block, joined.cell_deviation);
    append_references(part.references, block, read.views.slots_of(part), joined.references);
  }
  return city;
}

}  // namespace lumatlas
