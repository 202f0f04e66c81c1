// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/export/export_options.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

using nlohmann::json;

template <typename Names, typename Value>
std::string name_in(const Names& names, Value value) {
  return std::find_if(names.begin(), names.end(), [&](const auto& named) { return named.second == value; })->first;
}

json web_options_json(const ExportOptions& options, const std::filesystem::path& model) {
  const bool exact = options.photographs.format == ImageFormat::png;
  return {{"command", "export"},
          {"model", model.string()},
          {"to", name_in(kExportFormsByName, options.form)},
          {"image", exact ? "png" : "jpeg"},
          {"quality", exact ? json() : json(options.photographs.quality)}};
}

}  // namespace

void check(const ExportOptions& options, const std::filesystem::path& output) {
  if (options.form == ExportForm::web) return check(options.photographs);
  if (options.image.format == PageFormat::webp && options.form == ExportForm::obj) {
    throw std::invalid_argument("image: webp is for glb and gltf: programs that read OBJ do not know it");
  }
  if (options.image.format == PageFormat::webp && options.texture.layout.most_side_px > kLongestWebp) {
    throw std::invalid_argument("texture: must be at most " + std::to_string(kLongestWebp) + " with webp images");
  }
  if (options.form == ExportForm::glb && output.extension() != ".glb") {
    throw std::invalid_argument("output: is '" + output.string() + "', must end in .glb with the form glb");
  }
  check(options.image);
  check(options.texture);
}

json export_options_json(const ExportOptions& options, const std::filesystem::path& model) {
  if (options.form == ExportForm::web) return web_options_json(options, model);
  const TextureOptions& texture = options.texture;
  return {{"command", "export"},
          {"model", model.string()},
          {"to", name_in(kExportFormsByName, options.form)},
          {"texture", texture.layout.most_side_px},
          {"pages", texture.layout.most_pages},
          {"density", texture.texels_per_pixel},
          {"exposure", name_in(kTextureExposuresByName, texture.color.exposure)},
          {"image", name_in(kPageFormatsByName, options.image.format)},
          {"quality", options.image.format == PageFormat::png ? json() : json(options.image.quality)},
          {"as_scene", options.as_scene},
          {"settings", values_of(texture_settings(), texture)},
          {"from", options.scene ? json(options.scene->string()) : json()}};
}

}  // namespace lumatlas
