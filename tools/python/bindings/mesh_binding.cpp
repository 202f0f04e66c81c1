// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "mesh/readers/mesh_file.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/meshing/mesh_json.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/mesh_sources.h"
#include "tools/python/progress.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;

// Arguments that were given, and the sources that use them.
struct SourceArguments {
  std::vector<std::pair<const char*, bool>> given;
  std::vector<MeshSource> sources;
};

// Throws std::invalid_argument for an argument that would be ignored.
void check_used(const std::vector<SourceArguments>& arguments, MeshSource source) {
  for (const SourceArguments& some : arguments) {
    if (std::find(some.sources.begin(), some.sources.end(), source) != some.sources.end()) continue;
    for (const auto& [name, given] : some.given) {
      if (!given) continue;
      std::string meant;
      for (const MeshSource of : some.sources) meant += (meant.empty() ? "" : " and ") + name_of(of);
      throw std::invalid_argument(std::string(name) + " is for " + meant + ", and this mesh is made of " +
                                  name_of(source));
    }
  }
}

template <typename Value>
void set_if_given(Value& field, const std::optional<Value>& given) {
  if (given) field = *given;
}

py::object make_mesh(const Scene& scene, const Path& output, const std::optional<std::string>& source,
                     const std::optional<Path>& points, const std::optional<Path>& complete,
                     std::optional<std::size_t> hold, std::size_t block, std::optional<std::uint32_t> match_size,
                     std::optional<std::size_t> neighbors, std::optional<std::size_t> most_photographs,
                     std::optional<double> voxel, std::optional<double> depth_unit,
                     std::optional<std::size_t> most_faces, std::optional<double> spacing,
                     std::optional<std::size_t> most_points, std::optional<double> longest_edge,
                     const py::object& progress) {
  if (output.extension() != ".ply") {
    throw std::invalid_argument("output is '" + output.string() + "', must end in .ply");
  }
  const auto start = std::chrono::steady_clock::now();
  SceneMeshOptions options;
  if (source) options.from = mesh_source(*source);
  options.points = points;
  options.complete = complete;
  options.pictures = scene.pictures;
  options.stereo_folder = output.string() + ".stereo";
  options.hold_out = protocol_of(hold, block);
  set_if_given(options.stereo.longest_px, match_size);
  set_if_given(options.stereo.neighbors, neighbors);
  set_if_given(options.most_photographs, most_photographs);
  options.voxel = voxel;
  options.depth_unit = depth_unit;
  set_if_given(options.most_faces, most_faces);
  set_if_given(options.spacing_px, spacing);
  set_if_given(options.most_points, most_points);
  options.longest_edge = longest_edge;
  check(options);
  check_apart(output, std::array{scene.path, points.value_or(Path()), complete.value_or(Path())});
  const std::vector<SourceArguments> arguments{
      {{{"match_size", match_size.has_value()},
        {"neighbors", neighbors.has_value()},
        {"most_photographs", most_photographs.has_value()},
        {"hold", hold.has_value()}},
       {MeshSource::photographs}},
      {{{"voxel", voxel.has_value()}, {"depth_unit", depth_unit.has_value()}, {"most_faces", most_faces.has_value()}},
       {MeshSource::depth_images}},
      {{{"points", points.has_value()},
        {"spacing", spacing.has_value()},
        {"most_points", most_points.has_value()},
        {"longest_edge", longest_edge.has_value()}},
       {MeshSource::points, MeshSource::photographs}}};
  const Progress told("mesh", progress);
  nlohmann::json facts;
  {
    const py::gil_scoped_release unlocked;
    AtomicFile file(output);
    const SceneMesh made = mesh_from_scene(scene.path, options, told.of_stages(),
                                           [&](MeshSource chosen) { check_used(arguments, chosen); });
    write_ply(file.stream(), made.surface);
    file.commit();
    if (made.source == MeshSource::photographs) remove_stereo_work(options.stereo_folder);
    facts = mesh_json(made, output, ms_since(start));
  }
  return to_python(facts);
}

}  // namespace

void bind_mesh(py::module_& module) {
  module.def("make_mesh", &make_mesh, py::arg("scene"), py::arg("output"), py::kw_only(),
             py::arg("source") = py::none(), py::arg("points") = py::none(), py::arg("complete") = py::none(),
             py::arg("hold") = py::none(), py::arg("block") = 1, py::arg("match_size") = py::none(),
             py::arg("neighbors") = py::none(), py::arg("most_photographs") = py::none(), py::arg("voxel") = py::none(),
             py::arg("depth_unit") = py::none(), py::arg("most_faces") = py::none(), py::arg("spacing") = py::none(),
             py::arg("most_points") = py::none(), py::arg("longest_edge") = py::none(),
             py::arg("progress") = py::none(),
             "Write a PLY mesh of the scene's photographs, depth images or points; returns what `lumatlas mesh --json` "
             "prints");
}

}  // namespace lumatlas::python
