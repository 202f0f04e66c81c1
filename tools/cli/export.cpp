// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/model_file.h"
#include "mesh/base/errors.h"
#include "mesh/upright.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/progress.h"
#include "tools/base/strict_json.h"
#include "tools/cli/commands.h"
#include "tools/cli/json_output.h"
#include "tools/cli/option_rules.h"
#include "tools/paths/camera_tours.h"
#include "tools/pipeline/lens_notes.h"
#include "tools/pipeline/model_output.h"
#include "tools/pipeline/offered_scene.h"
#include "tools/pipeline/worth_saving.h"
#include "tools/texture/textured_mesh.h"
#include "tools/texture/write_textured_mesh.h"
#include "tools/viewer/scaled_view.h"
#include "tools/viewer/site.h"

namespace lumatlas {

namespace {

using nlohmann::json;

const Names<ColorOptions::Exposure> kTextureExposures{{"nearby", ColorOptions::Exposure::nearby},
                                                      {"model", ColorOptions::Exposure::model}};
enum class ExportFormat { glb, gltf, obj, web };
const Names<ExportFormat> kFormats{
    {"glb", ExportFormat::glb}, {"gltf", ExportFormat::gltf}, {"obj", ExportFormat::obj}, {"web", ExportFormat::web}};
const Names<PageFormat> kImages{{"png", PageFormat::png}, {"jpeg", PageFormat::jpeg}, {"webp", PageFormat::webp}};

struct ExportFlags {
  std::filesystem::path model, output, from;
  PictureFlags pictures;
  ExportFormat format = ExportFormat::glb;
  TextureOptions texture;
  PageCoding image;
  bool as_scene = false;
  bool json_output = false;
  bool quiet = false;
  CLI::Option* quality = nullptr;
  CLI::Option* image_option = nullptr;
  std::vector<CLI::Option*> of_textures;  // that a page has no use for

  // What a page for browsers is made of, JPEG unless told otherwise.
  [[nodiscard]] ImageCoding web_coding() const {
    const bool exact = image_option->count() > 0 && image.format == PageFormat::png;
    const int web_quality = quality->count() > 0 ? image.quality : SiteOptions{}.photographs.quality;
    return {exact ? ImageFormat::png : ImageFormat::jpeg, web_quality};
  }

  void check() const {
    if (format == ExportFormat::web) return check_web();
    if (quality->count() > 0 && image.format == PageFormat::png) {
      throw CLI::ValidationError("--quality", "needs --image jpeg or webp: PNG is exact");
    }
    if (image.format == PageFormat::webp && format == ExportFormat::obj) {
      throw CLI::ValidationError("--image", "webp is for glb and gltf: programs that read OBJ do not know it");
    }
    if (image.format == PageFormat::webp && texture.layout.most_side_px > kLongestWebp) {
      throw CLI::ValidationError("--texture", "must be at most " + std::to_string(kLongestWebp) + " with --image webp");
    }
    if (format == ExportFormat::glb && output.extension() != ".glb") {
      throw CLI::ValidationError("--output", "must end in .glb with --to glb" + other_form());
    }
    check_usage(texture);
  }

  // ": for OBJ, --to obj writes a folder" where the output's name asks for another form.
  [[nodiscard]] std::string other_form() const {
    const std::string ending = output.extension().string();
    if (ending == ".obj")
      return ": for OBJ, `--to obj -o " + output.stem().string() + "` writes a folder with scene.obj";
    if (ending == ".gltf") return ": for glTF in files, `--to gltf -o " + output.stem().string() + "` writes a folder";
    if (ending == ".html") return ": for a page, --to web writes " + output.filename().string();
    return {};
  }

  void check_web() const {
    for (const CLI::Option* option : of_textures) {
      if (option->count() > 0) throw CLI::ValidationError(option->get_name(), "is not for --to web");
    }
    if (image_option->count() > 0 && image.format == PageFormat::webp) {
      throw CLI::ValidationError("--image", "webp is not for --to web");
    }
    if (quality->count() > 0 && web_coding().format == ImageFormat::png) {
      throw CLI::ValidationError("--quality", "needs JPEG: PNG is exact");
    }
  }

  [[nodiscard]] json effective() const {
    if (format == ExportFormat::web) {
      const ImageCoding coding = web_coding();
      return {{"command", "export"},
              {"model", model.string()},
              {"to", name_of(kFormats, format)},
              {"image", coding.format == ImageFormat::png ? "png" : "jpeg"},
              {"quality", coding.format == ImageFormat::png ? json() : json(coding.quality)}};
    }
    return {{"command", "export"},
            {"model", model.string()},
            {"to", name_of(kFormats, format)},
            {"texture", texture.layout.most_side_px},
            {"pages", texture.layout.most_pages},
            {"gutter", texture.layout.gutter_px},
            {"density", texture.texels_per_pixel},
            {"sharpness", texture.color.sharpness},
            {"tolerance", texture.color.tolerance},
            {"exposure", name_of(kTextureExposures, texture.color.exposure)},
            {"image", name_of(kImages, image.format)},
            {"quality", image.format == PageFormat::png ? json() : json(image.quality)},
            {"as_scene", as_scene},
            {"from", from.empty() ? json() : json(from.string())}};
  }
};

// A file that this command did not write would be somebody's only copy of it.
void check_replaceable_export(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return;  // nothing to lose, or refused as an AtomicFile
  std::string generator;
  try {
    const json gltf = parse_json(read_model_json(file), file.string());
    generator = gltf.at("asset").at("generator").get<std::string>();
  } catch (const std::runtime_error&) {  // no glTF at all
  } catch (const json::exception&) {
  }
  if (generator == kExportGenerator) return;
  throw InputError(file.string() +
                   ": is nothing that `lumatlas export` wrote and will not be replaced, name another output or remove "
                   "it");
}

void check_replaceable_page(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return;
  std::string head(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.find(kSiteGenerator) != std::string::npos) return;
  throw InputError(file.string() +
                   ": is no page that `lumatlas export` wrote and will not be replaced, name another output or remove "
                   "it");
}

std::vector<Camera> cameras_of(const Snapshot& snapshot) {
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) {
    if (view) cameras.push_back(view->camera);
  }
  return cameras;
}

// Where the result appears, complete or not at all.
class ExportOutput {
 public:
  explicit ExportOutput(const ExportFlags& flags) : flags_(flags) {
    if (flags.format == ExportFormat::glb) {
      check_replaceable_export(flags.output);
      file_ = std::make_unique<AtomicFile>(flags.output);
    } else {
      folder_ = std::make_unique<OutputFolder>(flags.output, "export");
    }
  }

  TextureFacts write(const TexturedMesh& mesh, const TexturedFileOptions& options, const Tick& tick) {
    if (file_) return write_textured_glb(file_->stream(), mesh, options, tick);
    const auto write = flags_.format == ExportFormat::gltf ? write_textured_gltf : write_textured_obj;
    return write(folder_->path(), mesh, options, tick);
  }

  void commit() {
    if (file_) return file_->commit();
    folder_->commit(flags_.effective());
  }

 private:
  const ExportFlags& flags_;
  std::unique_ptr<OutputFolder> folder_;  // one of the two
  std::unique_ptr<AtomicFile> file_;
};

json summary(const ExportFlags& flags, const TexturedMesh& mesh, const TextureFacts& facts, double total_ms) {
  const TextureLayout& layout = mesh.layout();
  return {{"output", flags.output.string()},
          {"format", name_of(kFormats, flags.format)},
          {"faces", mesh.mesh().faces.size()},
          {"charts", mesh.charts().size()},
          {"texture",
           {{"side", layout.side_px},
            {"pages", layout.pages},
            {"texels", facts.texels},
            {"unseen", facts.unseen_texels},
            {"per_pixel", facts.texels_per_pixel}}},
          {"photographs", {{"used", facts.photographs}, {"outliers", facts.outliers}}},
          {"time_ms", {{"total", total_ms}}}};
}

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

json web_summary(const ExportFlags& flags, const SiteFacts& facts, double total_ms) {
  return {{"output", flags.output.string()},
          {"format", name_of(kFormats, flags.format)},
          {"views", facts.views},
          {"scale", facts.scale},
          {"bytes",
           {{"all", facts.bytes()},
            {"first", facts.page_bytes + facts.scene_bytes},
            {"mesh", facts.mesh_bytes},
            {"tables", facts.table_bytes},
            {"photographs", facts.photograph_bytes},
            {"masks", facts.mask_bytes}}},
          {"time_ms", {{"total", total_ms}}}};
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

void run_web(const ExportFlags& flags) {
  const auto start = std::chrono::steady_clock::now();
  const bool one_page = flags.output.extension() == ".html";
  if (one_page) check_replaceable_page(flags.output);
  const Model model = read_model(flags.model);
  require_views(model.snapshot, flags.model);
  SiteOptions options;
  options.title = title_of(flags.model);
  options.photographs = flags.web_coding();
  Progress progress("page: photographs", site_ticks(model.snapshot), ProgressOptions::standard_error(flags.quiet));
  const auto tick = [&] { progress.tick(); };
  SiteFacts facts;
  if (one_page) {
    AtomicFile file(flags.output);
    facts = write_one_page(file.stream(), model.snapshot, options, tick);
    file.commit();
  } else {
    OutputFolder folder(flags.output, "export");
    facts = write_site_folder(folder.path(), model.snapshot, options, tick);
    folder.commit(flags.effective());
  }
  const double total_ms = ms_since(start);
  const json totals = web_summary(flags, facts, total_ms);
  if (flags.json_output) {
    print_result(totals, flags.output);
  } else {
    print_result(web_text(totals), flags.output);
  }
}

// The photographs of --from that the model may have learnt from; none without it.
OfferedPhotographs offered(const ExportFlags& flags, const Model& model) {
  if (flags.from.empty()) return {};
  const ModelNotes notes = read_model_notes(flags.model);
  PictureFolders pictures = flags.pictures.folders();
  pictures.skip_bad = skips_bad(notes);
  SceneViews scene = read_scene_views(flags.from, model.snapshot.surface->offset, pictures);
  correct_lenses(scene.views, notes, flags.model);
  return offered_photographs(scene, hold_out_of(notes, flags.model), model.validity, notes, flags.model);
}

void run(const ExportFlags& flags) {
  const auto start = std::chrono::steady_clock::now();
  flags.check();
  check_apart(flags.output, std::array{flags.model, flags.from, flags.pictures.images, flags.pictures.masks});
  if (flags.format == ExportFormat::web) return run_web(flags);
  ExportOutput output(flags);
  Model model = read_model(flags.model);
  require_views(model.snapshot, flags.model);
  TexturedFileOptions options;
  options.image = flags.image;
  const std::vector<Camera> cameras = cameras_of(model.snapshot);
  if (!flags.as_scene && !cameras.empty()) options.file_from_scene = upright(cameras, upward(cameras));
  options.notes = json_text({{"lumatlas", LUMATLAS_VERSION}, {"options", flags.effective()}});
  OfferedPhotographs photographs = offered(flags, model);
  const TexturedMesh mesh(std::move(model.snapshot), flags.texture, std::move(photographs));
  Progress progress(flags.from.empty() ? "texture: charts" : "texture: photographs", mesh.ticks(),
                    ProgressOptions::standard_error(flags.quiet));
  const TextureFacts facts = output.write(mesh, options, [&] { progress.tick(); });
  output.commit();
  const double total_ms = ms_since(start);
  const json totals = summary(flags, mesh, facts, total_ms);
  if (flags.json_output) {
    print_result(totals, flags.output);
  } else {
    print_result(texture_text(totals), flags.output);
  }
}

}  // namespace

void add_export_command(CLI::App& program) {
  auto flags = std::make_shared<ExportFlags>();
  CLI::App* command = program.add_subcommand(
      "export", "A model as a page for browsers, or as a plain textured mesh for other programs");
  add_file(*command, "MODEL", flags->model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  begin_group(*command, "Files");
  add_choice(*command, "--to", flags->format, kFormats,
             "One glTF file, a folder with scene.gltf or scene.obj, or a page");
  add_file(*command, "-o,--output", flags->output, "PATH",
           "An earlier export there is replaced; --to web writes a folder, or one file NAME.html")
      ->required();
  flags->image_option = add_choice(*command, "--image", flags->image.format, kImages,
                                   "How the texture is kept; --to web: jpeg, without webp");
  flags->quality = command->add_option("--quality", flags->image.quality, "With --image jpeg or webp, how well")
                       ->type_name("Q")
                       ->transform(whole_number(1, 100));
  command->add_flag("--as-scene", flags->as_scene,
                    "Keep the scene's axes; without it up, as the cameras were held, is +y");
  begin_group(*command, "Texture");
  LayoutOptions& layout = flags->texture.layout;
  command->add_option("--texture", layout.most_side_px, "The longest side that a page may have")
      ->type_name("PX")
      ->transform(whole_number(64, 16384));
  command->add_option("--pages", layout.most_pages, "Pages that it may take")
      ->type_name("N")
      ->transform(whole_number(1, 64));
  command->add_option("--density", flags->texture.texels_per_pixel, "Texels for each pixel of a photograph, a side")
      ->type_name("D")
      ->check(number_between(0.01, 4));
  add_choice(*command, "--exposure", flags->texture.color.exposure, kTextureExposures,
             "Expose each place as the photographs that see it, or one exposure for the model");
  add_file(*command, "--from", flags->from, "SCENE",
           "Colours also from its photographs that the model did not keep, but none that `build --hold` left out");
  flags->pictures.add_to(*command);
  for (const char* name : {"--images", "--masks"}) command->get_option(name)->needs(command->get_option("--from"));
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  begin_experiments(*command, "colours");
  command->add_option("--gutter", layout.gutter_px, "Around each chart")
      ->type_name("PX")
      ->transform(whole_number(1, 64));
  command
      ->add_option("--sharpness", flags->texture.color.sharpness,
                   "How much frontal and near photographs count for detail")
      ->type_name("P")
      ->check(number_between(0, 16));
  command
      ->add_option("--tolerance", flags->texture.color.tolerance,
                   "Difference of photographs that counts as one, of square roots of light")
      ->type_name("T")
      ->check(number_between(0.001, 10));
  for (const char* name : {"--texture", "--pages", "--density", "--gutter", "--sharpness", "--tolerance", "--exposure",
                           "--from", "--images", "--masks"}) {
    flags->of_textures.push_back(command->get_option(name));
  }
  flags->of_textures.push_back(command->get_option("--as-scene"));
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
