// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/city_plan.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/output_folder.h"
#include "tools/base/strict_json.h"
#include "tools/pipeline/build_settings.h"
#include "tools/scene/geo_reference.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMost = std::size_t{1} << 31;
constexpr int kPlanVersion = 3;
constexpr std::array kPartsOfPlan{kPlanName, "surface", "blocks", "logs", "costs", "stereo", "Snakefile"};

json numbers_json(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json camera_json(const Camera& camera) {
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation.push_back(camera.cam_from_world_rotation[column][row]);
  }
  return {{"size", {camera.width, camera.height}},
          {"focal", {camera.fx, camera.fy}},
          {"principal", {camera.cx, camera.cy}},
          {"rotation", std::move(rotation)},
          {"translation", numbers_json(camera.cam_from_world_translation)}};
}

json view_json(const CityView& view) {
  const LensCorrection& lens = view.correction;
  const auto& [turn, shift] = view.motion;
  return {{"name", view.name},
          {"camera", camera_json(view.camera)},
          {"correction", {lens.focal, lens.principal.x, lens.principal.y, lens.k1, lens.k2, lens.p1, lens.p2}},
          {"motion", {turn.x, turn.y, turn.z, shift.x, shift.y, shift.z}},
          {"gain", numbers_json(view.gain)},
          {"black_rim", view.black_rim}};
}

json block_json(const CityBlock& block) {
  return {{"far", block.far},       {"cells", block.size.cells},      {"faces", block.size.faces},
          {"chunks", block.chunks}, {"own_chunks", block.own_chunks}, {"views", block.views}};
}

json chunk_json(const CityChunk& chunk) {
  const Bounds& box = chunk.box;
  return {{"cells", chunk.size.cells},
          {"faces", chunk.size.faces},
          {"box", {box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z}}};
}

std::vector<double> numbers(const JsonPlace& place, std::size_t count) {
  std::vector<double> values;
  for (const JsonPlace& element : place.elements()) values.push_back(element.number());
  if (values.size() != count) {
    place.refuse("has " + std::to_string(values.size()) + " numbers, must have " + std::to_string(count));
  }
  return values;
}

std::vector<std::size_t> indices(const JsonPlace& place, std::size_t end) {
  std::vector<std::size_t> values;
  for (const JsonPlace& element : place.elements()) {
    if (end == 0) element.refuse("is a number of a list that is empty");
    values.push_back(element.count(0, end - 1));
  }
  return values;
}

glm::dvec3 vector(const JsonPlace& place) {
  const std::vector<double> values = numbers(place, 3);
  return {values[0], values[1], values[2]};
}

Camera camera_of(const JsonPlace& place) {
  Camera camera;
  const std::vector<double> size = numbers(place.at("size"), 2), focal = numbers(place.at("focal"), 2),
                            principal = numbers(place.at("principal"), 2), rotation = numbers(place.at("rotation"), 9);
  camera.width = static_cast<std::uint32_t>(place.at("size").elements()[0].count(1, 65536));
  camera.height = static_cast<std::uint32_t>(place.at("size").elements()[1].count(1, 65536));
  camera.fx = focal[0];
  camera.fy = focal[1];
  camera.cx = principal[0];
  camera.cy = principal[1];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      camera.cam_from_world_rotation[column][row] =
          rotation[3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)];
    }
  }
  camera.cam_from_world_translation = vector(place.at("translation"));
  try {
    check(camera);
  } catch (const std::invalid_argument& error) {
    place.refuse(error.what());
  }
  return camera;
}

CityView view_of(const JsonPlace& place) {
  place.expect_keys({"name", "camera", "correction", "motion", "gain", "black_rim"}, {});
  CityView view;
  view.name = place.at("name").text();
  view.camera = camera_of(place.at("camera"));
  const std::vector<double> lens = numbers(place.at("correction"), 7);
  view.correction = {lens[0], {lens[1], lens[2]}, lens[3], lens[4], lens[5], lens[6]};
  const std::vector<double> motion = numbers(place.at("motion"), 6);
  view.motion = {{motion[0], motion[1], motion[2]}, {motion[3], motion[4], motion[5]}};
  view.gain = vector(place.at("gain"));
  view.black_rim = place.at("black_rim").boolean();
  return view;
}

CityChunk chunk_of(const JsonPlace& place) {
  place.expect_keys({"cells", "faces", "box"}, {});
  CityChunk chunk;
  chunk.size = {place.at("cells").count(1, kMost), place.at("faces").count(1, kMost)};
  const std::vector<double> box = numbers(place.at("box"), 6);
  chunk.box = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  return chunk;
}

CityBlock block_of(const JsonPlace& place, std::size_t chunks, std::size_t views) {
  place.expect_keys({"far", "cells", "faces", "chunks", "own_chunks", "views"}, {});
  CityBlock block;
  block.far = place.at("far").boolean();
  block.size = {place.at("cells").count(1, kMost), place.at("faces").count(1, kMost)};
  block.chunks = indices(place.at("chunks"), chunks);
  block.own_chunks = place.at("own_chunks").count(block.far ? 0 : 1, block.chunks.size());
  block.views = indices(place.at("views"), views);
  return block;
}

// Refuses blocks whose own chunks are not all chunks, one after the other.
void require_each_chunk_once(const JsonPlace& place, const CityPlan& plan) {
  std::size_t next = 0;
  for (std::size_t number = 0; number < plan.blocks.size(); ++number) {
    const CityBlock& block = plan.blocks[number];
    ChunkCounts size;
    for (std::size_t i = 0; i < block.own_chunks; ++i, ++next) {
      if (block.chunks[i] != next) {
        place.refuse("block " + std::to_string(number) + " has chunk " + std::to_string(block.chunks[i]) +
                     " of its own, must have " + std::to_string(next));
      }
      size.cells += plan.chunks[next].size.cells;
      size.faces += plan.chunks[next].size.faces;
    }
    if (block.far || (size.cells == block.size.cells && size.faces == block.size.faces)) continue;
    place.refuse("block " + std::to_string(number) + " has " + std::to_string(block.size.faces) +
                 " faces, its own chunks have " + std::to_string(size.faces));
  }
  if (next != plan.chunks.size()) {
    place.refuse("of " + std::to_string(plan.chunks.size()) + " chunks " + std::to_string(next) + " are a block's own");
  }
}

json path_json(const std::optional<fs::path>& path) {
  return path ? json(path->string()) : json();
}

std::optional<fs::path> path_of(const JsonPlace& place) {
  if (place.value().is_null()) return std::nullopt;
  return fs::path(place.text());
}

json build_json(const BuildOptions& build) {
  return {{"images", path_json(build.pictures.images)},
          {"masks", path_json(build.pictures.masks)},
          {"skip_bad", build.pictures.skip_bad},
          {"max_views", build.max_views ? json(*build.max_views) : json()},
          {"settings", values_of(build_settings(), build)}};
}

BuildOptions build_of(const JsonPlace& place) {
  place.expect_keys({"images", "masks", "skip_bad", "max_views", "settings"}, {});
  BuildOptions build;
  build.pictures = {path_of(place.at("images")), path_of(place.at("masks")), place.at("skip_bad").boolean()};
  const JsonPlace most = place.at("max_views");
  build.max_views.reset();
  if (!most.value().is_null()) build.max_views = static_cast<std::uint32_t>(most.count(1, kMost));
  try {
    assign_values(build_settings(), build, place.at("settings").value());
    check(build);
  } catch (const std::exception& error) {
    place.refuse(error.what());
  }
  return build;
}

json hold_out_json(const std::optional<HoldOut>& protocol) {
  if (!protocol) return {};
  return {{"hold", protocol->hold}, {"block", protocol->block}};
}

std::optional<GeoReference> georeference_of(const JsonPlace& place) {
  if (place.value().is_null()) return std::nullopt;
  std::optional<GeoReference> reference = geo_reference_of(place.value());
  if (!reference) place.refuse("is no georeference");
  return reference;
}

std::optional<HoldOut> hold_out_of(const JsonPlace& place) {
  if (place.value().is_null()) return std::nullopt;
  return HoldOut{place.at("hold").count(2, kMost), place.at("block").count(1, kMost)};
}

}  // namespace

void open_plan_folder(const fs::path& plan) {
  std::error_code error;
  fs::create_directories(plan, error);
  for (fs::directory_iterator entry(plan, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (std::find(kPartsOfPlan.begin(), kPartsOfPlan.end(), name) != kPartsOfPlan.end() || name.front() == '.')
      continue;
    throw InputError(entry->path().string() + ": is not of the plan of a city, so that " + plan.string() +
                     " cannot take one: name another folder or move the file away");
  }
  if (error) throw InputError(plan.string() + ": cannot be made or listed (" + error.message() + ")");
}

void remove_plan(const fs::path& plan) {
  std::error_code ignored;
  for (const char* const part : kPartsOfPlan) fs::remove_all(plan / part, ignored);
  fs::remove(plan, ignored);  // only if it is empty
}

fs::path surface_folder(const fs::path& plan) {
  return plan / "surface";
}

fs::path block_folder(const fs::path& plan, std::size_t block) {
  return plan / "blocks" / std::to_string(block);
}

fs::path block_log(const fs::path& plan, std::size_t block) {
  return plan / "logs" / (std::to_string(block) + ".txt");
}

bool is_city_plan(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kPlanName, ignored) && fs::is_directory(surface_folder(folder), ignored);
}

void write_city_plan(const fs::path& folder, const CityPlan& plan) {
  json views = json::array(), chunks = json::array(), blocks = json::array();
  for (const CityView& view : plan.views) views.push_back(view_json(view));
  for (const CityChunk& chunk : plan.chunks) chunks.push_back(chunk_json(chunk));
  for (const CityBlock& block : plan.blocks) blocks.push_back(block_json(block));
  write_json(folder / kPlanName, {{"lumatlas_city", kPlanVersion},
                                  {"scene", plan.scene.string()},
                                  {"build", build_json(plan.build)},
                                  {"usual_distance", plan.usual_distance},
                                  {"views", std::move(views)},
                                  {"memory", plan.memory},
                                  {"cell_size", plan.cell_size},
                                  {"chunks", std::move(chunks)},
                                  {"blocks", std::move(blocks)},
                                  {"left_out", plan.left_out},
                                  {"hold_out", hold_out_json(plan.hold_out)},
                                  {"warnings", plan.warnings},
                                  {"georeference", plan.georeference ? json_of(*plan.georeference) : json()},
                                  {"stamp", plan.stamp}});
}

CityPlan read_city_plan(const fs::path& folder) {
  if (!is_city_plan(folder)) {
    throw InputError(folder.string() + ": holds no plan that was finished: `lumatlas city SCENE --plan " +
                     folder.string() + "` makes one");
  }
  const fs::path file = folder / kPlanName;
  const json document = read_json(file);
  const JsonPlace place(file.string(), "", document);
  if (!document.contains("lumatlas_city") || place.at("lumatlas_city").count(0, kMost) != kPlanVersion) {
    place.refuse("is a plan of another lumatlas, make it again");
  }
  place.expect_keys({"lumatlas_city", "scene", "build", "usual_distance", "views", "memory", "cell_size", "chunks",
                     "blocks", "left_out", "hold_out", "warnings", "stamp"},
                    {"georeference"});
  CityPlan plan;
  plan.scene = place.at("scene").text();
  plan.build = build_of(place.at("build"));
  plan.usual_distance = place.at("usual_distance").number();
  if (!(plan.usual_distance > 0)) place.at("usual_distance").refuse("must be above 0");
  for (const JsonPlace& view : place.at("views").elements()) plan.views.push_back(view_of(view));
  plan.memory = place.at("memory").count(kLeastBlockMemory, std::size_t{1} << 50);
  plan.cell_size = place.at("cell_size").number();
  if (!(plan.cell_size > 0)) place.at("cell_size").refuse("must be above 0");
  for (const JsonPlace& chunk : place.at("chunks").elements()) plan.chunks.push_back(chunk_of(chunk));
  for (const JsonPlace& block : place.at("blocks").elements()) {
    plan.blocks.push_back(block_of(block, plan.chunks.size(), plan.views.size()));
  }
  require_each_chunk_once(place, plan);
  for (const JsonPlace& name : place.at("left_out").elements()) plan.left_out.push_back(name.text());
  plan.hold_out = hold_out_of(place.at("hold_out"));
  for (const JsonPlace& warning : place.at("warnings").elements()) plan.warnings.push_back(warning.text());
  if (place.has("georeference")) plan.georeference = georeference_of(place.at("georeference"));
  plan.stamp = place.at("stamp").text();
  return plan;
}

}  // namespace lumatlas
