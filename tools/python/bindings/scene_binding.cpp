// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <vector>

#include "mesh/base/errors.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/pictures.h"
#include "tools/python/scene_arrays.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;
using Names = std::vector<std::string>;

Scene load_scene(const Path& path, const std::optional<Path>& images, const std::optional<Path>& masks, bool skip_bad) {
  const py::gil_scoped_release unlocked;
  const PictureFolders pictures{images, masks, skip_bad};
  return {path, pictures, read_scene_views(path, glm::dvec3(0), pictures), nullptr};
}

const SceneView& view_of(const Scene& scene, const std::string& name) {
  const auto& views = scene.views.views;
  const auto found = std::find_if(views.begin(), views.end(), [&](const SceneView& view) { return view.name == name; });
  if (found == views.end()) throw InputError(scene.path.string() + ": has no photograph named " + name);
  return *found;
}

Names names_of(const Scene& scene) {
  Names names;
  for (const SceneView& view : scene.views.views) names.push_back(view.name);
  return names;
}

std::map<std::string, Camera> cameras_of(const Scene& scene) {
  std::map<std::string, Camera> cameras;
  for (const SceneView& view : scene.views.views) cameras.emplace(view.name, view.camera);
  return cameras;
}

std::map<std::string, std::string> bad_of(const Scene& scene) {
  std::map<std::string, std::string> bad;
  for (const SceneView& view : scene.views.views) {
    if (!view.bad.empty()) bad.emplace(view.name, view.bad);
  }
  return bad;
}

Names held_out(const Scene& scene, std::size_t hold, std::size_t block) {
  Names names;
  for (const std::size_t rank : split_to_score(scene.views, HoldOut{hold, block}).scored) {
    names.push_back(scene.views.views[rank].name);
  }
  return names;
}

py::array_t<std::uint8_t> photograph(const Scene& scene, const std::string& name) {
  const SceneView& view = view_of(scene, name);
  Photograph read;
  {
    const py::gil_scoped_release unlocked;
    read = load_photograph(view);
  }
  return picture_array(std::move(read));
}

}  // namespace

void bind_scene(py::module_& module) {
  py::class_<Scene>(module, "Scene", "Posed photographs, of `load_scene` or of arrays")
      .def_static("from_arrays", &scene_of_arrays, py::arg("photographs"), py::arg("cameras"),
                  py::arg("vertices") = py::none(), py::arg("faces") = py::none(), py::kw_only(),
                  py::arg("masks") = py::none(), py::arg("points") = py::none(),
                  "A scene of arrays: photographs by name, (height, width, 3) of uint8, their cameras, a mesh, masks "
                  "that are 0 where pixels are not used, and dense points")
      .def_property_readonly("path", [](const Scene& scene) { return scene.path; })
      .def_property_readonly("names", &names_of, "The names of the photographs, in order")
      .def_property_readonly("cameras", &cameras_of, "The camera of each photograph once its lens is undone, by name")
      .def_property_readonly("bad", &bad_of, "With skip_bad, why photographs are left out, by name")
      .def("held_out", &held_out, py::arg("hold") = 8, py::arg("block") = 1,
           "Names of the photographs that `build` leaves out, and `validate` scores, for these numbers")
      .def("photograph", &photograph, py::arg("name"),
           "The photograph as its camera of `cameras` would have taken it: (height, width, 3), sRGB")
      .def("__len__", [](const Scene& scene) { return scene.views.views.size(); });
  module.def(
      "load_scene", &load_scene, py::arg("path"), py::kw_only(), py::arg("images") = py::none(),
      py::arg("masks") = py::none(), py::arg("skip_bad") = false,
      "Read the cameras of a COLMAP workspace or a transforms.json, and look at the photographs; skip_bad: go on "
      "without those that are missing or damaged");
}

}  // namespace lumatlas::python
