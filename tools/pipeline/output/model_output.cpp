// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/output/model_output.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "blend/blend_options.h"
#include "blend/tables/fade_zone_shares.h"
#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kPlanFile = "plan.json";

json object_in(const json& object, const char* name) {
  if (!object.is_object() || !object.contains(name) || !object[name].is_object()) return {};
  return object[name];
}

// Null: there is no such file.
json object_of_file(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {};
  json value = read_json(file);
  if (!value.is_object()) throw InputError(file.string() + ": must be a JSON object, as `lumatlas build` writes it");
  return value;
}

// Allows a .glb to be replaced only if lumatlas wrote it: another program's file has no other copy here.
void check_replaceable_glb(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return;  // nothing to lose, or refused as an AtomicFile
  std::string generator;
  try {
    const json gltf = parse_json(read_model_json(file), file.string());
    generator = object_in(gltf, "asset").value("generator", "");
  } catch (const std::runtime_error&) {  // no model at all
  } catch (const json::exception&) {
  }
  if (generator == "lumatlas") return;
  throw InputError(file.string() + ": is no model that `lumatlas build` wrote and will not be replaced, name another " +
                   "output or remove it");
}

}  // namespace

fs::path scratch_folder_for(const fs::path& output) {
  std::error_code ignored;
  const char* const named = std::getenv("TMPDIR");
  if (named != nullptr && fs::is_directory(named, ignored)) return named;
  return fs::absolute(output).lexically_normal().parent_path();
}

ModelNotes read_model_notes(const fs::path& model) {
  const fs::path gltf_file = fs::is_directory(model) ? model / kTilesetName : model;
  const json gltf = parse_json(read_model_json(model), gltf_file.string());
  const json extras = object_in(object_in(gltf, "asset"), "extras");
  if (extras.contains("options")) return {object_in(extras, "options"), object_in(extras, "plan")};
  const fs::path folder = fs::is_directory(model) ? model : model.parent_path();
  return {object_in(object_of_file(folder / kMarkerFile), "options"), object_of_file(folder / kPlanFile)};
}

std::string length_unit_of(const fs::path& model) {
  const json document = parse_json(read_model_json(model), model.string());
  const json lumigraph = object_in(object_in(document, "extensions"), "LUMATLAS_lumigraph");
  return lumigraph.contains("georeference") ? "m" : "";
}

std::optional<HoldOut> hold_out_of(const ModelNotes& notes, const fs::path& model) {
  if (!notes.options.contains("hold_out")) {
    throw InputError(model.string() +
                     ": does not say which views were held out: name a model that `lumatlas build` wrote, or give the "
                     "--hold that it was built with");
  }
  const json& recorded = notes.options["hold_out"];
  if (!recorded.is_object() || !recorded.value("hold", json()).is_number_unsigned() ||
      !recorded.value("block", json()).is_number_unsigned()) {
    return std::nullopt;
  }
  return HoldOut{recorded["hold"].get<std::size_t>(), recorded["block"].get<std::size_t>()};
}

bool skips_bad(const ModelNotes& notes) {
  const json recorded = notes.options.is_object() ? notes.options.value("skip_bad", json()) : json();
  return recorded.is_boolean() && recorded.get<bool>();
}

ModelOutput::ModelOutput(const fs::path& path) : target_(path) {
  if (path.extension() == ".glb") {
    check_replaceable_glb(path);
    file_ = std::make_unique<AtomicFile>(path);
  } else {
    folder_ = std::make_unique<OutputFolder>(path, "build");
  }
}

void ModelOutput::commit(const Snapshot& snapshot, const ValidityOptions& validity, const ImageCoding& photographs,
                         const ModelNotes& notes, const BaseTexture* texture) {
  const CellShares shares = drawn_shares(*snapshot.surface, snapshot.references, BlendOptions{}.border_width);
  FormOptions form;
  form.photographs = photographs;
  form.texture = texture;
  form.shares = &shares;
  if (folder_) {
    write_model(folder_->path(), snapshot, validity, form);
    commit_folder(notes);
    return;
  }
  const json extras = {{"lumatlas", LUMATLAS_VERSION}, {"options", notes.options}, {"plan", notes.plan}};
  write_glb(file_->stream(), snapshot, validity, form, json_text(extras));
  throw_if_interrupted();
  file_->commit();
}

void ModelOutput::commit(const PiecewiseModel& model, const ValidityOptions& validity, const ImageCoding& photographs,
                         const ModelNotes& notes) {
  if (is_one_file()) throw std::logic_error("model output: one file takes no pieces");
  FormOptions form;
  form.photographs = photographs;
  write_model(folder_->path(), model, validity, form);
  commit_folder(notes);
}

void ModelOutput::commit_folder(const ModelNotes& notes) {
  write_json(folder_->path() / kPlanFile, notes.plan);
  folder_->commit(notes.options);
}

}  // namespace lumatlas
