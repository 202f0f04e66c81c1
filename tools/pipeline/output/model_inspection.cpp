// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/output/model_inspection.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "planner/planner.h"
#include "tools/budget/gpu_budget.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/scene/geo_reference.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::uint64_t pixels_of(const std::vector<Camera>& views) {
  std::uint64_t pixels = 0;
  for (const Camera& view : views) pixels += std::uint64_t{view.width} * view.height;
  return pixels;
}

json tiles_json(const TileTable& tiles) {
  if (tiles.whole_views()) return nullptr;
  return {{"size", tiles.options.tile_px},
          {"gutter", tiles.options.gutter_px},
          {"resident", tiles.resident_tiles()},
          {"of", tiles.places.size()}};
}

std::uint64_t texels_of(const ModelFacts& facts) {
  if (facts.tiles.whole_views()) return pixels_of(facts.views);
  return std::uint64_t{facts.tiles.resident_tiles()} * facts.tiles.options.place_px() * facts.tiles.options.place_px();
}

std::uint64_t bytes_of(const ModelFacts& facts) {
  if (!facts.tiles.whole_views()) return place_bytes(facts.tiles.options) * facts.tiles.resident_tiles();
  std::uint64_t bytes = 0;
  for (const Camera& view : facts.views) bytes += stored_bytes(view);
  return bytes;
}

GpuBytes gpu_bytes_of(const ModelFacts& facts) {
  return GpuByteCount(facts.surface).of(facts.references, facts.views, facts.tiles);
}

// Returns the budget that the model was built with.
json budget_in(const json& options) {
  return options.is_object() && options.contains("budget") ? options["budget"] : json();
}

bool has_number(const json& object, const char* name) {
  return object.is_object() && object.contains(name) && object[name].is_number();
}

// Returns whether parsimony_text() can print it.
bool is_parsimony(const json& parsimony) {
  const auto is_part = [&](const char* part) {
    return parsimony.contains(part) && has_number(parsimony[part], "stored") &&
           has_number(parsimony[part], "unbounded");
  };
  return has_number(parsimony, "predicted_loss_db") && has_number(parsimony, "bound_db") && is_part("views") &&
         is_part("references") && parsimony.contains("short_of_room") && parsimony["short_of_room"].is_boolean() &&
         (!parsimony.contains("references_given_up") || has_number(parsimony, "references_given_up")) &&
         (!parsimony.contains("texel_loss_db") || has_number(parsimony, "texel_loss_db")) &&
         (!parsimony.contains("face_loss_db") || has_number(parsimony, "face_loss_db")) &&
         (!parsimony.contains("gpu_bytes") ||
          (has_number(parsimony["gpu_bytes"], "stored") && has_number(parsimony["gpu_bytes"], "before"))) &&
         (!parsimony.contains("measured_loss_db") || parsimony["measured_loss_db"].is_null() ||
          has_number(parsimony, "measured_loss_db"));
}

// Null: the plan has none. Throws InputError for a plan that `lumatlas build` did not write.
json parsimony_in(const json& plan, const fs::path& model) {
  if (!plan.is_object() || !plan.contains("summary")) return nullptr;
  const json& summary = plan["summary"];
  json parsimony = summary.is_object() ? summary.value("parsimony", json()) : json();
  if (summary.is_object() && (parsimony.is_null() || is_parsimony(parsimony))) return parsimony;
  throw InputError(model.string() + ": its plan (plan.json, or the extras of a .glb) has a \"summary\" that " +
                   "`lumatlas build` did not write: build the model again, or remove plan.json");
}

// Returns shares of pixels from the plan of a model, such as those of its frames; null where the plan has none.
json shares_in(const json& plan, const char* name, std::initializer_list<const char*> fields) {
  const json summary = plan.is_object() ? plan.value("summary", json()) : json();
  json shares = summary.is_object() ? summary.value(name, json()) : json();
  if (!shares.is_object()) return nullptr;
  for (const char* const field : fields) {
    if (!shares.contains(field) || !shares[field].is_number()) return nullptr;
  }
  return shares;
}

// Returns where the model's coordinates lie on the Earth, and its middle; null: that is not known.
json georeference_json(const ModelFacts& facts) {
  if (!facts.georeference) return nullptr;
  json result = json_of(*facts.georeference);
  const std::optional<glm::dmat4> geocentric = geocentric_from_scene(*facts.georeference);
  if (!geocentric) return result;
  const Bounds box = bounds(near_surface(*facts.surface).mesh);
  const glm::dvec3 middle = 0.5 * (box.min + box.max) + facts.surface->offset;
  const GeodeticPoint point = geodetic_of(*geocentric * glm::dvec4(middle, 1));
  result["middle"] = {
      {"latitude", point.latitude_deg}, {"longitude", point.longitude_deg}, {"altitude", point.altitude_m}};
  return result;
}

std::string georeference_line(const json& georeference) {
  const std::optional<GeoReference> reference = geo_reference_of(georeference);
  if (!reference) return {};
  constexpr int kDigitsOfDegrees = 7, kDigitsOfMetres = 2;  // a centimetre
  std::string line = "on Earth   ";
  if (georeference.contains("middle")) {
    const auto number = [&](const char* name, int digits) {
      return number_text(georeference["middle"][name].get<double>(), digits);
    };
    line += "the middle at latitude " + number("latitude", kDigitsOfDegrees) + ", longitude " +
            number("longitude", kDigitsOfDegrees) + ", altitude " + number("altitude", kDigitsOfMetres) + " m; ";
  }
  return line + "coordinates are " + text_of(*reference) + '\n';
}

json file_json(const ModelFacts& facts) {
  return {{"path", facts.file.string()},
          {"json", facts.json_bytes},
          {"mesh", facts.mesh_bytes},
          {"vertices", facts.vertex_bytes},
          {"tables", facts.table_bytes},
          {"photographs", facts.photograph_bytes},
          {"masks", facts.mask_bytes},
          {"previews", facts.preview_bytes},
          {"texture", facts.texture_bytes},
          {"sum", facts.json_bytes + facts.mesh_bytes + facts.vertex_bytes + facts.table_bytes +
                      facts.photograph_bytes + facts.mask_bytes + facts.preview_bytes + facts.texture_bytes}};
}

std::string in_megabytes(const json& bytes) {
  char text[32];
  (void)std::snprintf(text, sizeof text, "%.1f MB", bytes.get<double>() / 1e6);
  return text;
}

std::string tiles_line(const json& model) {
  const json& tiles = model["tiles"];
  if (tiles.is_null()) return "whole views";
  std::ostringstream line;
  line << tiles["resident"] << " of " << tiles["of"] << " tiles of " << tiles["size"] << " px with a gutter of "
       << tiles["gutter"] << " px, " << model["texels"]["format"].get<std::string>();
  return line.str();
}

}  // namespace

bool is_model(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) || fs::is_regular_file(path / kTilesetName, ignored);
}

json inspect_model(const fs::path& model) {
  const ModelFacts facts = read_model_facts(model);
  const ModelNotes notes = read_model_notes(model);
  return {
      {"mesh",
       {{"vertices", facts.surface->mesh.positions.size() - facts.surface->far_vertices},
        {"faces", facts.surface->near_faces()},
        {"far_faces", facts.surface->far_faces}}},
      {"frames", shares_in(notes.plan, "frames", {"surface", "added", "far", "filled"})},
      {"trust", shares_in(notes.plan, "trust", {"within_1_px", "within_2_px", "within_4_px", "measured"})},
      {"cells", {{"count", facts.surface->cells.cells.size()}, {"seen", facts.cells_seen}}},
      {"references", {{"count", facts.references.views.size()}, {"per_cell", cells_by_references(facts.references)}}},
      {"views", {{"count", facts.views.size()}, {"pixels", pixels_of(facts.views)}}},
      {"tiles", tiles_json(facts.tiles)},
      {"texels", {{"resident", texels_of(facts)}, {"format", name_of(facts.tiles.options.texels)}}},
      {"bytes", {{"resident", bytes_of(facts)}, {"budget", budget_in(notes.options)}}},
      {"gpu", gpu_bytes_json(gpu_bytes_of(facts))},
      {"parsimony", parsimony_in(notes.plan, model)},
      {"georeference", georeference_json(facts)},
      {"file", file_json(facts)}};
}

json file_bytes_json(const fs::path& model) {
  return file_json(read_model_facts(model));
}

std::string file_bytes_text(const json& file) {
  std::string text = in_megabytes(file["sum"]);
  const char* separator = ": ";
  for (const char* const part : {"photographs", "masks", "previews", "texture", "mesh", "vertices", "tables", "json"}) {
    text += separator + std::string(part) + ' ' + in_megabytes(file[part]);
    separator = ", ";
  }
  return text;
}

std::string inspection_text(const json& model) {
  std::ostringstream text;
  const json &file = model["file"], &bytes = model["bytes"];
  text << "model      " << file["path"].get<std::string>() << ": " << model["mesh"]["faces"] << " faces, "
       << model["mesh"]["vertices"] << " vertices (split where cells meet)\n"
       << "cells      " << model["cells"]["count"] << ", " << model["cells"]["seen"] << " of them seen\n"
       << "views      " << model["views"]["count"] << " of " << model["views"]["pixels"]
       << " pixels in all: " << tiles_line(model) << '\n'
       << "on the GPU " << gpu_bytes_text(model["gpu"]) << "; "
       << (bytes["budget"].is_number() ? "budget " + in_megabytes(bytes["budget"]) : "no budget") << '\n'
       << "on disk    " << file_bytes_text(file) << '\n'
       << "references " << model["references"]["count"] << "; cells by how many they have, from 0:";
  for (const json& cells : model["references"]["per_cell"]) text << ' ' << cells;
  text << '\n';
  if (!model["frames"].is_null()) text << "frames     " << frames_text(model["frames"]) << '\n';
  if (!model["trust"].is_null()) text << "trust      " << trust_text(model["trust"]) << '\n';
  text << georeference_line(model["georeference"]);
  if (!model["parsimony"].is_null()) text << "parsimony  " << parsimony_text(model["parsimony"]) << '\n';
  return text.str();
}

}  // namespace lumatlas
