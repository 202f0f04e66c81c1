// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/export/export_model.h"

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/upright.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/export/replaceable_export.h"
#include "tools/pipeline/offered_scene.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/output/worth_saving.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/scene/geo_reference.h"
#include "tools/texture/write_textured_mesh.h"
#include "tools/viewer/page_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

std::vector<Camera> cameras_in(const Snapshot& snapshot) {
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) {
    if (view) cameras.push_back(view->camera);
  }
  return cameras;
}

// A textured mesh that appears complete or not at all.
class TexturedOutput {
 public:
  TexturedOutput(const fs::path& output, ExportForm form) : form_(form) {
    if (form == ExportForm::glb) {
      check_replaceable_export(output);
      file_ = std::make_unique<AtomicFile>(output);
    } else {
      folder_ = std::make_unique<OutputFolder>(output, "export");
    }
  }

  TextureFacts write(const TexturedMesh& mesh, const TexturedFileOptions& options, const CancelCheck& cancel_check) {
    if (file_) return write_textured_glb(file_->stream(), mesh, options, cancel_check);
    const auto write = form_ == ExportForm::gltf ? write_textured_gltf : write_textured_obj;
    return write(folder_->path(), mesh, options, cancel_check);
  }

  void commit(const json& effective) {
    if (file_) return file_->commit();
    folder_->commit(effective);
  }

 private:
  ExportForm form_;
  std::unique_ptr<OutputFolder> folder_;  // one of the two
  std::unique_ptr<AtomicFile> file_;
};

json texture_json(const json& effective, const fs::path& output, const TexturedMesh& mesh, const TextureFacts& facts,
                  double total_ms) {
  const TextureLayout& layout = mesh.layout();
  return {{"output", output.string()},
          {"format", effective["to"]},
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

json web_json(const json& effective, const fs::path& output, const SiteFacts& facts, double total_ms) {
  return {{"output", output.string()},
          {"format", effective["to"]},
          {"views", facts.views},
          {"scale", facts.scale},
          {"bytes",
           {{"all", facts.bytes()},
            {"first", facts.page_bytes + facts.scene_bytes},
            {"mesh", facts.mesh_bytes},
            {"photographs", facts.photograph_bytes},
            {"masks", facts.mask_bytes}}},
          {"time_ms", {{"total", total_ms}}}};
}

CancelCheck ticks_of(const StageProgress& progress, const std::string& stage, std::size_t ticks) {
  return [one = progress(stage, ticks)] { one(1); };
}

json export_page(const Model& model, const fs::path& file, const fs::path& output, const json& effective,
                 const ExportOptions& options, const StageProgress& progress) {
  const auto start = Clock::now();
  const Snapshot& snapshot = model.snapshot;
  SiteOptions site;
  site.title = title_of(file);
  if (snapshot.georeference) site.unit = "m";
  site.page_file = read_page_file(file);
  site.validity = model.validity;
  site.photographs = options.photographs;
  const CancelCheck cancel_check = ticks_of(progress, "page: photographs", site_ticks(snapshot));
  SiteFacts facts;
  if (output.extension() == ".html") {
    check_replaceable_page(output);
    AtomicFile page(output);
    facts = write_one_page(page.stream(), snapshot, site, cancel_check);
    page.commit();
  } else {
    OutputFolder folder(output, "export");
    facts = write_site_folder(folder.path(), snapshot, site, cancel_check);
    folder.commit(effective);
  }
  return web_json(effective, output, facts, ms_since(start));
}

// The photographs of the scene that the model may have learnt from; none without a scene.
OfferedPhotographs offered(const Model& model, const fs::path& file, const ExportOptions& options) {
  if (!options.scene) return {};
  const ModelNotes notes = read_model_notes(file);
  PictureFolders pictures = options.pictures;
  pictures.skip_bad = skips_bad(notes);
  SceneViews scene = read_scene_views(*options.scene, model.snapshot.surface->offset, pictures);
  correct_photographs(scene.views, notes, file);
  return offered_photographs(scene, hold_out_of(notes, file), model.validity, notes, file);
}

json export_texture(const Model& model, const fs::path& file, const fs::path& output, const json& effective,
                    const ExportOptions& options, const StageProgress& progress) {
  const auto start = Clock::now();
  TexturedOutput opened(output, options.form);
  TexturedFileOptions written;
  written.image = options.image;
  const std::vector<Camera> cameras = cameras_in(model.snapshot);
  if (!options.as_scene && !cameras.empty()) written.file_from_scene = upright(cameras, upward(cameras));
  std::optional<GeoReference> reference;  // an export in other axes than the scene's has none
  if (options.as_scene) reference = model.snapshot.georeference;
  if (reference) {
    written.georeference = json_text(json_of(*reference));
    written.georeference_sentence = "Coordinates are " + text_of(*reference);
  }
  written.notes = json_text({{"lumatlas", LUMATLAS_VERSION}, {"options", effective}});
  const TexturedMesh mesh(model.snapshot, options.texture, offered(model, file, options));
  const std::string stage = options.scene ? "texture: photographs" : "texture: charts";
  const TextureFacts facts = opened.write(mesh, written, ticks_of(progress, stage, mesh.ticks()));
  opened.commit(effective);
  json result = texture_json(effective, output, mesh, facts, ms_since(start));
  result["georeference"] = reference ? json_of(*reference) : json();
  return result;
}

}  // namespace

json export_model(const Model& model, const fs::path& file, const fs::path& output, const ExportOptions& options,
                  const StageProgress& progress) {
  check(options, output);
  require_views(model.snapshot, file);
  const json effective = export_options_json(options, file);
  if (options.form == ExportForm::web) {
    return export_page(model, file, output, effective, options, progress);
  }
  return export_texture(model, file, output, effective, options, progress);
}

}  // namespace lumatlas
