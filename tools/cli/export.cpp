// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/images/scaled_view.h"
#include "atlas/model/model_file.h"
#include "tools/base/output_folder.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/cli/output/stage_bars.h"
#include "tools/export/export_model.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

using nlohmann::json;

const Names<ColorOptions::Exposure> kTextureExposures(kTextureExposuresByName.begin(), kTextureExposuresByName.end());
const Names<ExportForm> kForms(kExportFormsByName.begin(), kExportFormsByName.end());
const Names<PageFormat> kImages(kPageFormatsByName.begin(), kPageFormatsByName.end());

struct ExportFlags {
  std::filesystem::path model, output, from;
  PictureFlags pictures;
  ExportOptions options;
  SettingFlags<TextureOptions> settings{texture_settings()};
  bool json_output = false;
  bool quiet = false;
  CLI::Option* quality = nullptr;
  CLI::Option* image = nullptr;
  std::vector<CLI::Option*> of_textures;  // options that a page has no use for

  // Throws CLI::ValidationError for options that do not go together.
  [[nodiscard]] ExportOptions checked_options() const {
    ExportOptions checked = options;
    settings.apply(checked.texture);
    if (checked.form == ExportForm::web) {
      set_web_coding(checked);
    } else if (quality->count() > 0 && checked.image.format == PageFormat::png) {
      throw CLI::ValidationError("--quality", "needs --image jpeg or webp: PNG is exact");
    }
    if (checked.form == ExportForm::glb && output.extension() != ".glb") {
      throw CLI::ValidationError("--output", "must end in .glb with --to glb" + other_form());
    }
    if (!from.empty()) checked.scene = from;
    checked.pictures = pictures.folders();
    try {
      check(checked, output);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError(error.what());
    }
    return checked;
  }

 private:
  // ": for OBJ, --to obj writes a folder" where the output's name asks for another form.
  [[nodiscard]] std::string other_form() const {
    const std::string ending = output.extension().string();
    if (ending == ".obj")
      return ": for OBJ, `--to obj -o " + output.stem().string() + "` writes a folder with scene.obj";
    if (ending == ".gltf") return ": for glTF in files, `--to gltf -o " + output.stem().string() + "` writes a folder";
    if (ending == ".html") return ": for a page, --to web writes " + output.filename().string();
    return {};
  }

  // The photographs of a page are JPEG unless --image says PNG.
  void set_web_coding(ExportOptions& web) const {
    for (const CLI::Option* option : of_textures) {
      if (option->count() > 0) throw CLI::ValidationError(option->get_name(), "is not for --to web");
    }
    settings.given().refuse_all("is not for --to web");
    if (image->count() > 0 && web.image.format == PageFormat::webp) {
      throw CLI::ValidationError("--image", "webp is not for --to web");
    }
    if (image->count() > 0 && web.image.format == PageFormat::png) web.photographs.format = ImageFormat::png;
    if (quality->count() == 0) return;
    if (web.photographs.format == ImageFormat::png) {
      throw CLI::ValidationError("--quality", "needs JPEG: PNG is exact");
    }
    web.photographs.quality = web.image.quality;
  }
};

std::string texture_text(const json& summary) {
  const json& texture = summary["texture"];
  const double texels = texture["texels"].get<double>();
  const double room = std::pow(texture["side"].get<double>(), 2) * texture["pages"].get<double>();
  std::ostringstream text;
  text << std::fixed << summary["output"].get<std::string>() << ": " << texture["pages"]
       << (texture["pages"] == 1 ? " page of " : " pages of ") << texture["side"] << "x" << texture["side"] << ", "
       << summary["charts"] << " charts\n"
       << std::setprecision(2) << "density: " << texture["per_pixel"].get<double>()
       << " texels for each pixel of a photograph along a side; " << std::setprecision(0)
       << 100 * texels / std::max(room, 1.0) << " % of the texture is surface, "
       << 100 * texture["unseen"].get<double>() / std::max(texels, 1.0)
       << " % of that was seen by no photograph in the model\n";
  return text.str();
}

std::string web_text(const json& summary) {
  const json& bytes = summary["bytes"];
  const auto megabytes = [&](const char* key) { return bytes[key].get<double>() / 1e6; };
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << summary["output"].get<std::string>() << ": " << megabytes("all")
       << " MB, of which " << megabytes("photographs") << " MB are " << summary["views"] << " photographs, "
       << megabytes("mesh") << " MB the mesh and " << megabytes("masks") << " MB masks\n";
  const double scale = summary["scale"].get<double>();
  if (scale < 1) {
    text << "photographs are scaled to " << std::setprecision(0) << 100 * scale << " %, for a side of " << kMostSidePx
         << " pixels is what every browser takes\n";
  }
  return text.str();
}

void run(const ExportFlags& flags) {
  const ExportOptions options = flags.checked_options();
  check_apart(flags.output, std::array{flags.model, flags.from, flags.pictures.images, flags.pictures.masks});
  const json totals =
      export_model(read_model(flags.model), flags.model, flags.output, options, bars_on_standard_error(flags.quiet));
  if (flags.json_output) {
    print_result(totals, flags.output);
  } else {
    print_result(options.form == ExportForm::web ? web_text(totals) : texture_text(totals), flags.output);
  }
}

}  // namespace

void add_export_command(CLI::App& program) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* command =
      program.add_subcommand("export", "Write a model as a page for browsers, or as a plain textured mesh");
  add_file(*command, "MODEL", flags->model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  begin_group(*command, "Files");
  add_choice(*command, "--to", flags->options.form, kForms,
             "Form: one glTF file, a folder with scene.gltf or scene.obj, or a page");
  add_file(*command, "-o,--output", flags->output, "PATH",
           "File or folder; --to web: a folder, or one file NAME.html. An earlier export there is replaced")
      ->required();
  flags->image = add_choice(*command, "--image", flags->options.image.format, kImages,
                            "Image format of the texture; --to web: jpeg, without webp");
  flags->quality =
      command->add_option("--quality", flags->options.image.quality, "Quality of the files, with --image jpeg or webp")
          ->type_name("Q")
          ->transform(whole_number(1, 100));
  command->add_flag("--as-scene", flags->options.as_scene,
                    "Keep the scene's axes; without it up, as the cameras were held, is +y");
  begin_group(*command, "Texture");
  LayoutOptions& layout = flags->options.texture.layout;
  command->add_option("--texture", layout.most_side_px, "Longest side of a texture page")
      ->type_name("PX")
      ->transform(whole_number(64, 16384));
  command->add_option("--pages", layout.most_pages, "Most texture pages")
      ->type_name("N")
      ->transform(whole_number(1, 64));
  command
      ->add_option("--density", flags->options.texture.texels_per_pixel,
                   "Texels along the side of a photograph's pixel")
      ->type_name("D")
      ->check(number_between(0.01, 4));
  add_choice(*command, "--exposure", flags->options.texture.color.exposure, kTextureExposures,
             "Use the exposure of the photographs that see a place, or one exposure for the whole model");
  add_file(
      *command, "--from", flags->from, "SCENE",
      "Take colours also from photographs of this scene that the model did not keep; those that `build --hold` left "
      "out are not used");
  flags->pictures.add_to(*command);
  for (const char* name : {"--images", "--masks"}) command->get_option(name)->needs(command->get_option("--from"));
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  flags->settings.add_to(*command);
  for (const char* name :
       {"--texture", "--pages", "--density", "--exposure", "--from", "--images", "--masks", "--as-scene"}) {
    flags->of_textures.push_back(command->get_option(name));
  }
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
