// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_form.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <sstream>
#include <vector>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_document.h"
#include "atlas/model/model_parts.h"
#include "atlas/model/surface/surface_chunks.h"
#include "atlas/model/surface/tile_tree.h"

namespace lumatlas {

namespace {

using nlohmann::json;

FormPart part_of(ModelImageKind kind) {
  switch (kind) {
    case ModelImageKind::photograph:
      return FormPart::photograph;
    case ModelImageKind::thumbnail:
      return FormPart::thumbnail;
    case ModelImageKind::poster:
      return FormPart::poster;
    case ModelImageKind::lens_mask:
    case ModelImageKind::trust_mask:
    case ModelImageKind::mask:
      break;
  }
  return FormPart::mask;
}

std::string glb_text(GltfBuilder& gltf) {
  const std::vector<std::string> uris{""};
  const std::vector<std::vector<unsigned char>> buffers = gltf.finish(uris);
  std::ostringstream file;
  write_glb_frame(file, gltf.document().dump(), buffers.front());
  return file.str();
}

TileContent put_glb(GltfBuilder& gltf, const std::string& stem, FormPart part, const PutFormFile& put) {
  const std::string text = glb_text(gltf);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  return {put({stem, ".glb", "model/gltf-binary", part, bytes}), text.size(), 0, {}};
}

// Returns ascending numbers as pairs: the first of a run, and how many follow each other.
std::vector<std::uint32_t> runs_of(const std::vector<std::uint32_t>& numbers) {
  std::vector<std::uint32_t> runs;
  for (const std::uint32_t number : numbers) {
    const bool follows = !runs.empty() && number == runs[runs.size() - 2] + runs.back();
    if (follows) {
      ++runs.back();
    } else {
      runs.insert(runs.end(), {number, 1});
    }
  }
  return runs;
}

// Writes the chunks of a surface.
class SurfaceWriter {
 public:
  SurfaceWriter(const ModelParts& model, const FormOptions& options, const PutFormFile& put)
      : snapshot_(model.snapshot),
        options_(options),
        put_(put),
        step_(packed_step(model.snapshot, options)),
        cell_size_(written_cell_size(*model.snapshot.surface)),
        maker_(model.snapshot, options.shares, options.texture ? &options.texture->faces : nullptr, options.chunk_faces,
               step_) {}

  // Returns the root of the tileset.
  ModelTile write() {
    if (options_.texture) put_texture(*options_.texture);
    ModelTile root = tile_of(tile_tree(maker_.count()));
    if (options_.coarse_faces == 0) return root;
    const TileContent coarse = put_coarse(coarse_surface_of(snapshot_, options_.coarse_faces), FormPart::coarse);
    if (coarse.uri.empty()) return root;
    if (!root.children.empty()) {
      root.content = coarse;
      return root;
    }
    return {coarse, {std::move(root)}};
  }

 private:
  // Returns a tile without content of its own, which its chunks have.
  [[nodiscard]] ModelTile tile_of(const TileRange& range) const {
    if (range.children.empty()) return {put_chunk(range.first), {}};
    ModelTile tile;
    for (const TileRange& child : range.children) add_child(tile, child);
    return tile;
  }

  // Adds a tile below one; where it needs no coarse surface, the tiles below it.
  void add_child(ModelTile& parent, const TileRange& range) const {
    ModelTile tile = tile_of(range);
    if (!range.children.empty()) {
      const Mesh part = maker_.part(range.first, range.count);
      if (options_.coarse_faces > 0) {
        tile.content = put_coarse(coarse_surface(part, part.colors, options_.coarse_faces), FormPart::surface);
      }
      if (tile.content.uri.empty()) {
        std::move(tile.children.begin(), tile.children.end(), std::back_inserter(parent.children));
        return;
      }
      tile.content.volume = tile_volume(part, {}, gltf_from_scene(snapshot_));
    }
    parent.children.push_back(std::move(tile));
  }

  // Returns what has no URI for a surface without faces.
  [[nodiscard]] TileContent put_coarse(const CoarseSurface& coarse, FormPart part) const {
    if (coarse.mesh.faces.empty()) return {};
    GltfBuilder gltf(options_.packed);
    add_coarse_surface(gltf, coarse, step_);
    add_scene(gltf.document(), gltf_from_scene(snapshot_));
    TileContent content = put_glb(gltf, "coarse", part, put_);
    content.geometric_error = geometric_error(coarse);
    return content;
  }

  void put_texture(const BaseTexture& texture) {
    const std::vector<std::uint8_t> file = encode_image(texture.image, texture.coding);
    const auto [stem, ending] = texture_name(texture.coding);
    texture_ = put_({stem, ending, mime_type(texture.coding.format), FormPart::texture, file});
  }

  [[nodiscard]] TileContent put_chunk(std::size_t number) const {
    const SurfaceChunk chunk = maker_.chunk(number);
    const Surface& surface = *chunk.snapshot.surface;
    GltfBuilder gltf(options_.packed);
    SurfaceForm form;
    form.packed = options_.packed;
    if (options_.texture) form.texture = gltf.add_image_file(texture_);
    const WrittenSurface written = written_surface(surface, chunk.shares ? &*chunk.shares : nullptr,
                                                   chunk.places ? &*chunk.places : nullptr, step_);
    ViewTables tables = view_tables(chunk.snapshot);
    if (number > 0) tables.resident.clear();  // those of the whole model are in the first
    json properties = add_surface(gltf, chunk.snapshot, written, tables, form);
    properties["cellSize"] = cell_size_;
    const glm::dmat3 upright = gltf_from_scene(snapshot_);
    if (maker_.count() > 1) {
      add_place(gltf, chunk, properties);
      add_moved_scene(gltf.document(), upright, chunk.origin);
    } else {
      add_scene(gltf.document(), upright);
    }
    set_lumigraph(gltf.document(), std::move(properties));
    TileContent content = put_glb(gltf, "surface", FormPart::surface, put_);
    content.volume = tile_volume(near_surface(surface).mesh, chunk.origin, upright);
    return content;
  }

  // Adds where the chunk's positions and numbers are in the model. Without numbers its cells, vertices and faces follow
  // those of the chunk before.
  void add_place(GltfBuilder& gltf, const SurfaceChunk& chunk, json& properties) const {
    const glm::dvec3& origin = chunk.origin;
    properties["origin"] = {origin.x, origin.y, origin.z};
    if (chunk.guest_cells > 0) properties["guestCells"] = chunk.guest_cells;
    if (options_.packed) return;
    properties["cellRuns"] = add_whole_numbers(gltf, runs_of(chunk.cells));
    properties["vertexRuns"] = add_whole_numbers(gltf, runs_of(chunk.vertices));
    properties["faceRuns"] = add_whole_numbers(gltf, runs_of(chunk.faces));
  }

  const Snapshot& snapshot_;
  const FormOptions& options_;
  const PutFormFile& put_;
  std::optional<double> step_;  // of packed positions
  double cell_size_;
  std::string texture_;  // its name
  ChunkMaker maker_;
};

json put_images(const ModelParts& model, const PutFormFile& put, const Tick& tick) {
  std::vector<json> images(model.images.size());
  tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t index) {
    const ModelImage& image = model.images[index];
    const std::vector<std::uint8_t> file = encoded(image, model.snapshot);
    const std::string name =
        put({image.name.stem, image.name.ending, mime_type(image.coding.format), part_of(image.kind), file});
    images[index] = {{"uri", name}, {"byteLength", file.size()}};
    if (tick && image.kind == ModelImageKind::photograph) tick();
  });
  return images;
}

}  // namespace

std::string write_form(const Snapshot& snapshot, const ValidityOptions& validity, const FormOptions& options,
                       const PutFormFile& put, const Tick& tick) {
  const ModelParts model = model_parts(snapshot, validity, options);
  json properties = model.properties;
  json images = put_images(model, put, tick);
  if (!images.empty()) properties["images"] = std::move(images);
  const ModelTile root = SurfaceWriter(model, options, put).write();
  if (tick) tick();
  return tileset_json(model.snapshot, root, std::move(properties)).dump(options.packed ? -1 : 1) + "\n";
}

}  // namespace lumatlas
