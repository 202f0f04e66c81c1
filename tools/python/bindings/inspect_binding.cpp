// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <variant>

#include "tools/inspection/inspection.h"
#include "tools/pipeline/output/model_inspection.h"
#include "tools/pipeline/surface/completed_surface.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/mesh_frames.h"
#include "tools/python/model.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;

py::object facts_of_model(const Model& model) {
  nlohmann::json facts;
  {
    const py::gil_scoped_release unlocked;
    facts = inspect_model(model.path());
  }
  return to_python(facts);
}

py::object facts_of_scene(const Scene& scene, const std::optional<Path>& mesh, const std::optional<MeshFrame>& frame,
                          double cell_size) {
  if (scene.pictures.images || scene.pictures.masks) {
    throw std::invalid_argument(
        "scene: was loaded with images or masks of its own, and inspect looks where they usually are");
  }
  CellOptions cells;
  cells.size = cell_size;
  check(cells);
  nlohmann::json facts;
  {
    const py::gil_scoped_release unlocked;
    facts = inspect_scene(scene.path, mesh, frame.value_or(MeshFrame{}), cells, true, frames_json);
  }
  return to_python(facts);
}

py::object facts_of(const std::variant<const Scene*, const Model*>& subject, const std::optional<Path>& mesh,
                    const std::optional<double>& mesh_scale, const std::optional<std::string>& mesh_axes,
                    const std::optional<std::array<double, 3>>& mesh_shift, double cell_size) {
  const std::optional<MeshFrame> frame = mesh_frame_of(mesh_scale, mesh_axes, mesh_shift);
  if (const auto* const scene = std::get_if<const Scene*>(&subject)) {
    return facts_of_scene(**scene, mesh, frame, cell_size);
  }
  if (mesh || frame || cell_size != 0) {
    throw std::invalid_argument("mesh, its frame and cell_size are for scenes, a model has its own mesh and cells");
  }
  return facts_of_model(*std::get<const Model*>(subject));
}

}  // namespace

void bind_inspect(py::module_& module) {
  module.def("inspect", &facts_of, py::arg("subject").none(false), py::kw_only(), py::arg("mesh") = py::none(),
             py::arg("mesh_scale") = py::none(), py::arg("mesh_axes") = py::none(), py::arg("mesh_shift") = py::none(),
             py::arg("cell_size") = 0.0,
             "What is in a scene and what is wrong with it, or what is in a model: `lumatlas inspect --json`");
}

}  // namespace lumatlas::python
