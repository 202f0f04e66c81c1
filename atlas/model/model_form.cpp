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
#include "atlas/model/surface/chunk_source.h"
#include "atlas/model/surface/coarse_surface.h"
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

// Writes the chunks of a surface, and the coarse surfaces that stand in for them.
class SurfaceWriter {
 public:
  SurfaceWriter(const ModelParts& model, const FormOptions& options, const PutFormFile& put, ChunkSource& source)
      : options_(options),
        put_(put),
        source_(source),
        several_(source.count() > 1),
        step_(packed_step(model, options)),
        cell_size_(model.cell_size),
        upright_(gltf_from_scene(model.snapshot)) {}

  // Returns the root of the tileset.
  ModelTile write() {
    if (options_.texture) texture_ = put_texture(*options_.texture);
    WrittenTile root = tile_of(tile_tree(source_.count()));
    if (!needs_coarse_surface(root.faces, options_.coarse_faces)) return std::move(root.tile);
    const TileContent coarse = put_coarse(root, FormPart::coarse);
    if (several_) {
      root.tile.content = coarse;
      return std::move(root.tile);
    }
    return {coarse, {std::move(root.tile)}};
  }

 private:
  struct WrittenTile {
    ModelTile tile;
    std::size_t faces = 0;  // of its chunks
    Mesh mesh;              // the chunks' surface, or what stands in for it
    double error = 0;       // by which that is off, scene units
    CoarseSource source = CoarseSource::surface;
  };

  // Returns a tile without content of its own, which its chunks have.
  [[nodiscard]] WrittenTile tile_of(const TileRange& range) {
    if (range.children.empty()) return chunk_tile(range.first);
    WrittenTile tile;
    for (const TileRange& child : range.children) add_child(tile, child);
    return tile;
  }

  // Adds a tile below one; where it needs no coarse surface, the tiles below it.
  void add_child(WrittenTile& parent, const TileRange& range) {
    WrittenTile child = tile_of(range);
    const bool is_chunk = range.children.empty();
    std::vector<ModelTile>& children = parent.tile.children;
    if (!is_chunk && needs_coarse_surface(child.faces, options_.coarse_faces)) {
      child.tile.content = put_coarse(child, FormPart::surface);
      children.push_back(std::move(child.tile));
    } else if (is_chunk) {
      children.push_back(std::move(child.tile));
    } else {
      std::move(child.tile.children.begin(), child.tile.children.end(), std::back_inserter(children));
    }
    parent.faces += child.faces;
    parent.error = std::max(parent.error, child.error);
    if (child.source == CoarseSource::coarse_surfaces) parent.source = child.source;
    if (options_.coarse_faces > 0) append(child.mesh, parent.mesh);
  }

  static void append(const Mesh& from, Mesh& to) {
    const auto first = static_cast<std::uint32_t>(to.positions.size());
    to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
    to.colors.insert(to.colors.end(), from.colors.begin(), from.colors.end());
    for (const glm::uvec3& face : from.faces) to.faces.push_back(face + first);
  }

  // Writes the coarse surface of a tile, and puts it in the place of the tile's mesh.
  [[nodiscard]] TileContent put_coarse(WrittenTile& tile, FormPart part) const {
    CoarseSurface coarse = coarse_surface(tile.mesh, options_.coarse_faces, tile.source);
    coarse.error += tile.error;
    GltfBuilder gltf(options_.packed);
    add_coarse_surface(gltf, coarse, step_);
    add_scene(gltf.document(), upright_);
    TileContent content = put_glb(gltf, "coarse", part, put_);
    content.geometric_error = geometric_error(coarse);
    tile.mesh = std::move(coarse.mesh);
    tile.error = coarse.error;
    tile.source = CoarseSource::coarse_surfaces;
    return content;
  }

  [[nodiscard]] std::string put_texture(const BaseTexture& texture) const {
    const std::vector<std::uint8_t> file = encode_image(texture.image, texture.coding);
    const auto [stem, ending] = texture_name(texture.coding);
    return put_({stem, ending, mime_type(texture.coding.format), FormPart::texture, file});
  }

  [[nodiscard]] WrittenTile chunk_tile(std::size_t number) {
    const SurfaceChunk chunk = source_.chunk(number);
    const Surface& surface = *chunk.snapshot.surface;
    GltfBuilder gltf(options_.packed);
    SurfaceForm form;
    form.packed = options_.packed;
    const std::string texture = chunk.texture ? put_texture(*chunk.texture) : texture_;
    if (!texture.empty()) form.texture = gltf.add_image_file(texture);
    const TexturePlaces* const places = chunk.texture ? &chunk.texture->faces : chunk.places ? &*chunk.places : nullptr;
    const WrittenSurface written = written_surface(surface, chunk.shares ? &*chunk.shares : nullptr, places, step_);
    ViewTables tables = view_tables(chunk.snapshot);
    if (number > 0) tables.resident.clear();  // those of the whole model are in the first
    json properties = add_surface(gltf, chunk.snapshot, written, tables, form);
    properties["cellSize"] = cell_size_;
    if (several_) {
      add_place(gltf, chunk, properties);
      add_moved_scene(gltf.document(), upright_, chunk.origin);
    } else {
      add_scene(gltf.document(), upright_);
    }
    set_lumigraph(gltf.document(), std::move(properties));
    WrittenTile tile;
    tile.tile.content = put_glb(gltf, "surface", FormPart::surface, put_);
    tile.tile.content.volume = tile_volume(near_surface(surface).mesh, chunk.origin, upright_);
    tile.faces = surface.near_faces();
    if (options_.coarse_faces > 0) tile.mesh = placed_mesh(chunk);
    return tile;
  }

  // Adds where the chunk's positions and numbers are in the model. Without numbers its cells, vertices and faces follow
  // those of the chunk before.
  void add_place(GltfBuilder& gltf, const SurfaceChunk& chunk, json& properties) const {
    const glm::dvec3& origin = chunk.origin;
    properties["origin"] = {origin.x, origin.y, origin.z};
    if (!chunk.guests.empty()) properties["guestCells"] = chunk.guests.size();
    if (options_.packed || chunk.cells.empty()) return;
    properties["cellRuns"] = add_whole_numbers(gltf, runs_of(chunk.cells));
    properties["vertexRuns"] = add_whole_numbers(gltf, runs_of(chunk.vertices));
    properties["faceRuns"] = add_whole_numbers(gltf, runs_of(chunk.faces));
  }

  const FormOptions& options_;
  const PutFormFile& put_;
  ChunkSource& source_;
  bool several_;
  std::optional<double> step_;  // of packed positions
  double cell_size_;
  glm::dmat3 upright_;
  std::string texture_;  // name of the model's; empty: it has none
};

json put_images(const ModelParts& model, const PutFormFile& put, const CancelCheck& cancel_check) {
  std::vector<json> images(model.images.size());
  tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t index) {
    const ModelImage& image = model.images[index];
    const std::vector<std::uint8_t> file = encoded(image, model.snapshot);
    const std::string name =
        put({image.name.stem, image.name.ending, mime_type(image.coding.format), part_of(image.kind), file});
    images[index] = {{"uri", name}, {"byteLength", file.size()}};
    if (cancel_check && image.kind == ModelImageKind::photograph) cancel_check();
  });
  return images;
}

// Moves the views and their images into a file of their own. The properties keep the view where a visitor begins, with
// the poster as its image.
void put_views(json& properties, const PutFormFile& put) {
  json images = std::move(properties["images"]), views = std::move(properties["views"]);
  json poster = std::move(images.back());
  images.erase(images.size() - 1);
  json start = views[properties["firstView"].get<std::size_t>()];
  for (const char* kind : {"lensMask", "trustMask", "mask", "thumbnail"}) start.erase(kind);
  start["image"] = 0;
  const std::string text = json{{"images", std::move(images)}, {"views", std::move(views)}}.dump() + "\n";
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  const std::string name = put({"views", ".json", "application/json", FormPart::views, bytes});
  properties.erase("views");
  properties["images"] = json::array({std::move(poster)});
  properties["poster"] = 0;
  properties["start"] = std::move(start);
  properties["viewFile"] = {{"uri", name}, {"byteLength", text.size()}};
}

// Writes the images of a model, then its surface, and returns the text of the tileset.
std::string write_parts(ModelParts model, ChunkSource& source, const FormOptions& options, const PutFormFile& put,
                        const CancelCheck& cancel_check) {
  json images = put_images(model, put, cancel_check);
  if (!images.empty()) model.properties["images"] = std::move(images);
  const bool is_long = model.properties.contains("views") && model.properties["views"].size() > options.listed_views;
  if (is_long) put_views(model.properties, put);
  const ModelTile root = SurfaceWriter(model, options, put, source).write();
  check_cancelled(cancel_check);
  return tileset_json(model.snapshot, model.offset, root, std::move(model.properties)).dump(options.packed ? -1 : 1) +
         "\n";
}

}  // namespace

std::string write_form(const Snapshot& snapshot, const ValidityOptions& validity, const FormOptions& options,
                       const PutFormFile& put, const CancelCheck& cancel_check) {
  const ModelParts model = model_parts(snapshot, validity, options);
  return write_parts(model, *whole_surface(model, options), options, put, cancel_check);
}

std::string write_form(const PiecewiseModel& given, const ValidityOptions& validity, const FormOptions& options,
                       const PutFormFile& put, const CancelCheck& cancel_check) {
  const ModelParts model = model_parts(given, validity, options);
  return write_parts(model, *surface_in_pieces(model, given.surface, options), options, put, cancel_check);
}

}  // namespace lumatlas
