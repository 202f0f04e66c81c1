// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mesh/base/number_text.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/cell_flags.h"
#include "tools/cli/flags/mesh_frame_flags.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/inspection/inspection.h"
#include "tools/pipeline/output/model_inspection.h"
#include "tools/pipeline/surface/completed_surface.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

using nlohmann::json;

struct InspectFlags {
  std::filesystem::path scene, mesh;
  MeshFrameFlags mesh_frame;
  CellOptions cells;
  SettingFlags<CellOptions> settings{within<CellOptions>(
      "cells.", cell_settings(), [](auto& options) -> auto& { return options; })};
  std::vector<const CLI::Option*> of_scenes;
  bool json_output = false;
  bool quiet = false;
};

void print_mesh(const json& mesh) {
  std::cout << "mesh       " << mesh["file"].get<std::string>() << ": " << mesh["file_vertices"] << " vertices, "
            << mesh["file_faces"] << " faces" << (mesh["colors"] ? ", with colours" : ", without colours") << '\n';
  for (const auto& [what, count] : mesh["repairs"].items()) {
    if (count != 0) std::cout << "  repaired " << count << " " << what << '\n';
  }
  if (mesh["split_faces"] != 0)
    std::cout << "  split    faces larger than a cell: " << mesh["split_faces"] << " more\n";
  std::cout << "  in use   " << mesh["vertices"] << " vertices, " << mesh["faces"] << " faces, area "
            << mesh["area"].get<double>() << ", diameter " << mesh["diameter"].get<double>() << " (scene units)\n";
}

void print_views(const json& views) {
  std::cout << "views      " << views["count"] << ", " << views["form"].get<std::string>() << '\n';
  for (const json& note : views["notes"]) std::cout << "  " << note.get<std::string>() << '\n';
  for (const auto& [lens, count] : views["lenses"].items()) std::cout << "  " << count << " " << lens << '\n';
  if (views["masked"] != 0) std::cout << "  with a mask: " << views["masked"] << '\n';
  if (views["median_distance"].is_null()) return;
  std::cout << "  distance to the surface: median " << views["median_distance"].get<double>() << " (scene units)\n"
            << "  the mesh is seen on " << percent_text(views["covered"].get<double>()) << " of their pixels\n";
}

void print_fit(const json& fit) {
  if (fit.is_null() || fit["correlation"].is_null()) return;
  char text[200];
  std::snprintf(text, sizeof(text), "correlation %.2f (0 is chance), residual %.3f, outliers %.1f%%",
                fit["correlation"].get<double>(), fit["residual"].get<double>(), 100 * fit["outliers"].get<double>());
  std::cout << "fit        colours of the same points in different photographs: " << text << '\n';
}

std::string printed_db(double db) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f dB", db);
  return text.data();
}

void print_frames(const json& frames) {
  if (frames.is_null()) return;
  const auto percent = [&](const char* name) { return percent_text(frames[name].get<double>()); };
  std::cout << "frames     pixels of the photographs: " << percent("surface") << " show the mesh, " << percent("far")
            << " the far surroundings, " << percent("lacking") << " neither";
  const json& gain = frames["largest_gain_db"];
  if (frames["to_match"] == 0) {
    std::cout << ": build adds no surface"
              << (gain.is_null() ? "" : ", which can bring " + printed_db(gain.get<double>()) + " at most") << '\n';
  } else {
    std::cout << ": build matches " << frames["to_match"] << " photographs and adds what they agree on there\n";
  }
  if (frames["through"] != 0) {
    std::cout << "  " << frames["through"]
              << " photographs saw points that lie behind the mesh: build removes what they "
              << "plainly see through\n";
  }
}

void print_surface(const json& scene) {
  print_mesh(scene["mesh"]);
  const json& cells = scene["cells"];
  std::cout << "cells      " << cells["count"] << " of size " << cells["size"].get<double>() << "; area / size^2: 5% "
            << cells["area_share"]["p5"].get<double>() << ", median " << cells["area_share"]["median"].get<double>()
            << ", 95% " << cells["area_share"]["p95"].get<double>() << "; " << cells["unseen"] << " seen by no view\n";
}

void print(const json& scene) {
  if (scene["mesh"].is_null()) {
    std::cout << "mesh       none\n";
  } else {
    print_surface(scene);
  }
  print_views(scene["views"]);
  print_fit(scene["fit"]);
  print_frames(scene["frames"]);
  for (const json& warning : scene["warnings"]) std::cout << "warning    " << warning.get<std::string>() << '\n';
}

void inspect_as_model(const InspectFlags& flags) {
  const std::string why = "is for scenes, a model has its own mesh and cells";
  for (const CLI::Option* option : flags.of_scenes) {
    if (option->count() > 0) throw CLI::ValidationError(option->get_name(), why);
  }
  flags.settings.given().refuse_all(why);
  const json model = inspect_model(flags.scene);
  if (flags.json_output) {
    print_json(model);
  } else {
    std::cout << inspection_text(model);
  }
}

}  // namespace

void add_inspect_command(CLI::App& program) {
  auto flags = std::make_shared<InspectFlags>();
  CLI::App* command = program.add_subcommand("inspect", "Say what is in a scene or a model, and what is wrong with it");
  add_file(*command, "SCENE", flags->scene, "SCENE", "COLMAP workspace: sparse/ and images/, with a mesh; or a model")
      ->required();
  begin_group(*command, "For a scene");
  add_file(*command, "--mesh", flags->mesh, "FILE",
           "PLY, OBJ, STL or GLB; without it the usual names are tried in SCENE");
  flags->mesh_frame.add_to(*command);
  flags->of_scenes.push_back(add_cell_size(*command, flags->cells));
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  flags->settings.add_to(*command);
  flags->of_scenes.push_back(command->get_option("--mesh"));
  for (const CLI::Option* option : flags->mesh_frame.options) flags->of_scenes.push_back(option);
  command->callback([flags] {
    if (is_model(flags->scene)) return inspect_as_model(*flags);
    CellOptions cells = flags->cells;
    flags->settings.apply(cells);
    std::optional<std::filesystem::path> mesh;
    if (!flags->mesh.empty()) mesh = flags->mesh;
    const json scene = inspect_scene(flags->scene, mesh, flags->mesh_frame.frame().value_or(MeshFrame{}), cells,
                                     flags->quiet, frames_json);
    if (flags->json_output) {
      print_json(scene);
    } else {
      print(scene);
    }
  });
}

}  // namespace lumatlas
