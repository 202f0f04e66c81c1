// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_form.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <vector>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/model_document.h"
#include "atlas/model/model_parts.h"

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
  return {put({stem, ".glb", "model/gltf-binary", part, bytes}), text.size(), 0};
}

TileContent put_surface(const ModelParts& model, const FormOptions& options, const PutFormFile& put) {
  GltfBuilder gltf(options.packed);
  SurfaceForm form;
  form.packed = options.packed;
  if (options.texture) {
    const ImageCoding& coding = options.texture->coding;
    const std::vector<std::uint8_t> file = encode_image(options.texture->image, coding);
    const auto [stem, ending] = texture_name(coding);
    form.texture = gltf.add_image_file(put({stem, ending, mime_type(coding.format), FormPart::texture, file}));
  }
  const WrittenSurface written =
      written_surface(*model.snapshot.surface, options.shares, options.texture, packed_step(model.snapshot, options));
  json properties = add_surface(gltf, model.snapshot, written, view_tables(model.snapshot), form);
  add_scene(gltf.document(), gltf_from_scene(model.snapshot));
  set_lumigraph(gltf.document(), std::move(properties));
  return put_glb(gltf, "surface", FormPart::surface, put);
}

TileContent put_coarse(const ModelParts& model, const FormOptions& options, const PutFormFile& put) {
  const CoarseSurface coarse = coarse_surface_of(model.snapshot);
  if (coarse.mesh.faces.empty()) return {};
  GltfBuilder gltf(options.packed);
  add_coarse_surface(gltf, coarse, packed_step(model.snapshot, options));
  add_scene(gltf.document(), gltf_from_scene(model.snapshot));
  TileContent content = put_glb(gltf, "coarse", FormPart::coarse, put);
  content.geometric_error = geometric_error(coarse);
  return content;
}

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
  const TileContent surface = put_surface(model, options, put);
  const TileContent coarse = put_coarse(model, options, put);
  if (tick) tick();
  return tileset_json(model.snapshot, surface, coarse, std::move(properties)).dump(options.packed ? -1 : 1) + "\n";
}

}  // namespace lumatlas
