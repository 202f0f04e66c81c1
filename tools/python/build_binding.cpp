// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "mesh/mesh_file.h"
#include "tools/base/output_folder.h"
#include "tools/meshing/scene_mesh.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/save_model.h"
#include "tools/python/bindings.h"
#include "tools/python/model.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;

// Ctrl-C of somebody who types at Python, as the exception that Python has for it. Needs Python's lock.
void throw_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

bool truth_of(const py::object& answer) {
  try {
    return answer.cast<bool>();
  } catch (const py::cast_error&) {
    throw py::type_error("progress: has returned a value of type " +
                         py::type::of(answer).attr("__name__").cast<std::string>() +
                         ", must return None, True or False");
  }
}

// Calls `progress`, which may be None, with the stage, the steps done and their number; False ends the build.
BuildCallback callback_of(const py::object& progress) {
  return [progress](const BuildProgress& build) {
    const py::gil_scoped_acquire locked;
    throw_signals();
    if (progress.is_none()) return true;
    const py::object answer = progress(build.stage, build.done, build.total);
    return answer.is_none() || truth_of(answer);
  };
}

RefineMode refine_mode(const std::string& name) {
  static const std::map<std::string, RefineMode> kModes{{"none", RefineMode::none},
                                                        {"exposure", RefineMode::exposure},
                                                        {"pose", RefineMode::pose},
                                                        {"all", RefineMode::all},
                                                        {"joint", RefineMode::joint}};
  const auto found = kModes.find(name);
  if (found != kModes.end()) return found->second;
  throw std::invalid_argument("refine is '" + name + "', must be none, exposure, pose, all or joint");
}

ImageCoding coding_of(const std::string& image) {
  if (image == "png") return {ImageFormat::png};
  if (image == "jpeg" || image == "jpg") return {ImageFormat::jpeg};
  throw std::invalid_argument("image is '" + image + "', must be png or jpeg");
}

std::shared_ptr<Model> build(const Scene& scene, const Path& output, const std::optional<Path>& mesh,
                             std::optional<std::size_t> hold, std::size_t block, std::optional<std::uint32_t> max_views,
                             const std::string& refine, const std::string& image, const py::object& progress) {
  BuildOptions options;
  options.mesh = mesh;
  options.pictures = scene.pictures;
  options.completion.surface = true;
  options.completion.stereo_folder = stereo_folder_of(output);
  options.hold_out = protocol_of(hold, block);
  options.max_views = max_views;
  options.refine = refine_mode(refine);
  const ImageCoding coding = coding_of(image);
  const BuildCallback callback = callback_of(progress);
  const py::gil_scoped_release unlocked;
  ModelOutput opened(output);
  const BuildResult result = build_model(scene.path, options, callback);
  (void)save_model(result, opened, coding);
  remove_stereo_work(options.completion.stereo_folder);
  return open_model(output);
}

nlohmann::json trust_json(const SceneMesh& made) {
  return {{"vertices", made.surface.positions.size()},
          {"faces", made.surface.faces.size()},
          {"points_on_surface", made.trust.points_on_surface},
          {"pixels_covered", made.trust.pixels_covered},
          {"frames_mostly_empty", made.trust.frames_mostly_empty},
          {"pixels_guessed", made.trust.pixels_guessed},
          {"warnings", made.warnings}};
}

py::object make_mesh(const Scene& scene, const Path& output, const std::optional<Path>& points) {
  SceneMeshOptions options;
  options.points = points;
  options.pictures = scene.pictures;
  options.stereo_folder = output.string() + ".stereo";
  nlohmann::json trust;
  {
    const py::gil_scoped_release unlocked;
    const StageProgress stages = [](const std::string&, std::size_t) {
      return [](std::size_t) {
        const py::gil_scoped_acquire locked;
        throw_signals();
      };
    };
    AtomicFile file(output);
    const SceneMesh made = mesh_from_scene(scene.path, options, stages);
    write_ply(file.stream(), made.surface);
    file.commit();
    if (made.source == MeshSource::photographs) remove_stereo_work(options.stereo_folder);
    trust = trust_json(made);
  }
  return to_python(trust);
}

}  // namespace

void bind_build(py::module_& module) {
  module.def("make_mesh", &make_mesh, py::arg("scene"), py::arg("output"), py::kw_only(),
             py::arg("points") = py::none(),
             "Write a mesh of the scene's depth images, dense points or photographs; returns how far to trust it");
  module.def("build", &build, py::arg("scene"), py::arg("output"), py::kw_only(), py::arg("mesh") = py::none(),
             py::arg("hold") = py::none(), py::arg("block") = 1,
             py::arg("max_views") = BuildOptions{}.max_views.value_or(0), py::arg("refine") = "joint",
             py::arg("image") = "png", py::arg("progress") = py::none(),
             "Choose photographs, save them as a model (a folder, or one .glb), and open it. `progress(stage, done, "
             "total)` is called after each step; where it returns False the build ends with a RuntimeError");
}

}  // namespace lumatlas::python
