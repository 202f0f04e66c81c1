// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/model_output.h"

#include <fstream>

#include "mesh/base/errors.h"
#include "tools/base/interrupt.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kPlanFile = "plan.json";

json parsed(std::istream& text) {
  json value = json::parse(text, nullptr, false);
  return value.is_object() ? value : json();
}

json object_in(const json& object, const char* name) {
  if (!object.is_object() || !object.contains(name) || !object[name].is_object()) return {};
  return object[name];
}

}  // namespace

ModelNotes read_model_notes(const fs::path& model) {
  const json gltf = json::parse(read_model_json(model), nullptr, false);
  const json extras = object_in(object_in(gltf, "asset"), "extras");
  if (!extras.is_null()) return {object_in(extras, "options"), object_in(extras, "plan")};
  const fs::path folder = fs::is_directory(model) ? model : model.parent_path();
  std::ifstream marker(folder / kMarkerFile), plan(folder / kPlanFile);
  return {object_in(parsed(marker), "options"), parsed(plan)};
}

ModelOutput::ModelOutput(const fs::path& path) {
  if (path.extension() == ".glb") {
    file_ = std::make_unique<AtomicFile>(path);
  } else {
    folder_ = std::make_unique<OutputFolder>(path);
  }
}

void ModelOutput::commit(const Snapshot& snapshot, const ValidityOptions& validity, const ImageCoding& photographs,
                         const ModelNotes& notes) {
  if (folder_) {
    write_model(folder_->path(), snapshot, validity, photographs);
    write_json(folder_->path() / kPlanFile, notes.plan);
    folder_->commit(notes.options);
    return;
  }
  const json extras = {{"lumatlas", LUMATLAS_VERSION}, {"options", notes.options}, {"plan", notes.plan}};
  write_glb(file_->stream(), snapshot, validity, photographs, json_text(extras));
  throw_if_interrupted();
  file_->commit();
}

}  // namespace lumatlas
