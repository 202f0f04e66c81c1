// SPDX-License-Identifier: GPL-3.0-or-later
// The options of an export.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "atlas/images/photograph.h"
#include "tools/scene/scene.h"
#include "tools/texture/layout/page_image.h"
#include "tools/texture/textured_mesh.h"
#include "tools/viewer/site.h"

namespace lumatlas {

enum class ExportForm {
  glb,   // one glTF file of a textured mesh
  gltf,  // a folder with scene.gltf
  obj,   // a folder with scene.obj
  web,   // a page for browsers: a folder, or one file NAME.html
};
inline const std::array<std::pair<std::string, ExportForm>, 4> kExportFormsByName{
    {{"glb", ExportForm::glb}, {"gltf", ExportForm::gltf}, {"obj", ExportForm::obj}, {"web", ExportForm::web}}};
inline const std::array<std::pair<std::string, PageFormat>, 3> kPageFormatsByName{
    {{"png", PageFormat::png}, {"jpeg", PageFormat::jpeg}, {"webp", PageFormat::webp}}};
inline const std::array<std::pair<std::string, ColorOptions::Exposure>, 2> kTextureExposuresByName{
    {{"nearby", ColorOptions::Exposure::nearby}, {"model", ColorOptions::Exposure::model}}};

struct ExportOptions {
  ExportForm form = ExportForm::glb;
  ImageCoding photographs = SiteOptions{}.photographs;  // for ExportForm::web, which uses nothing else of these

  TextureOptions texture;
  PageCoding image;                            // for the texture's pages; WebP is for glb and gltf
  bool as_scene = false;                       // keep the scene's axes; else up, as the cameras were held, is +y
  std::optional<std::filesystem::path> scene;  // its photographs give the colours too, but none that was held out
  PictureFolders pictures;                     // the pictures of `scene`
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks; also where `output` has an
// ending that is not the form's.
void check(const ExportOptions& options, const std::filesystem::path& output);

// Returns the options in effect, as they stand beside an export; "settings" has those of texture_settings().
[[nodiscard]] nlohmann::json export_options_json(const ExportOptions& options, const std::filesystem::path& model);

}  // namespace lumatlas
