// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <vector>

#include "blend/tiles.h"
#include "mesh/base/errors.h"
#include "tools/pipeline/lens_notes.h"
#include "tools/python/bindings.h"
#include "tools/python/model.h"
#include "tools/python/pictures.h"
#include "tools/score/validation.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;
using nlohmann::json;

}  // namespace

Model::Model(const Path& path) : path_(path), model_(read_model(path)), notes_(read_model_notes(path)) {}

Model::~Model() {
  if (!context_) return;
  const CurrentContext current(*context_);
  renderer_.reset();
}

Rendering Model::render(const Camera& camera) {
  check_picture_size(camera);
  const std::lock_guard lock(drawing_);
  if (!context_) context_.emplace(EglContext::Options{.stays_current = false});
  const CurrentContext current(*context_);
  if (!renderer_) {
    Renderer fresh;
    fresh.load(model_.snapshot);
    renderer_.emplace(std::move(fresh));
  }
  return render_tiled(*renderer_, in_model(camera, offset()), BlendOptions());
}

VisibilityBuffer Model::trace(const Camera& camera) {
  check_picture_size(camera);
  {
    const std::lock_guard lock(drawing_);
    if (!visibility_) visibility_ = make_ray_visibility(model_.snapshot.surface->mesh);
  }
  return visibility_->trace(in_model(camera, offset()));
}

std::shared_ptr<Model> open_model(const Path& path) {
  return std::make_shared<Model>(path);
}

namespace {

std::map<std::string, Camera> cameras_of_model(const Model& model) {
  std::map<std::string, Camera> cameras;
  for (const auto& view : model.model().snapshot.views) {
    if (view) cameras.emplace(view->name, in_scene(view->camera, model.offset()));
  }
  return cameras;
}

Rendering draw(Model& model, const Camera& camera) {
  const py::gil_scoped_release unlocked;
  return model.render(camera);
}

py::tuple render_with_state(Model& model, const Camera& camera) {
  Rendering rendering = draw(model, camera);
  std::vector<std::uint8_t> states(rendering.state.size());
  std::transform(rendering.state.begin(), rendering.state.end(), states.begin(),
                 [](PixelState state) { return static_cast<std::uint8_t>(state); });
  return py::make_tuple(picture_array(std::move(rendering.picture)),
                        array_of(std::move(states), {py::ssize_t{camera.height}, py::ssize_t{camera.width}}));
}

py::array_t<float> depth(Model& model, const Camera& camera) {
  VisibilityBuffer seen;
  {
    const py::gil_scoped_release unlocked;
    seen = model.trace(camera);
    for (float& z : seen.depth) {
      if (!std::isfinite(z)) z = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return array_of(std::move(seen.depth), {py::ssize_t{camera.height}, py::ssize_t{camera.width}});
}

py::object summary_of(const Model& model) {
  const json& plan = model.notes().plan;
  return to_python(plan.is_object() ? plan.value("summary", json()) : json());
}

void check_baselines(const std::set<std::string>& baselines) {
  for (const std::string& name : baselines) {
    if (name == "texture" || name == "unbounded" || name == "vertex") continue;
    throw std::invalid_argument("baselines holds '" + name + "', must be of texture, unbounded and vertex");
  }
}

std::optional<HoldOut> protocol_to_score(const Model& model, const SceneViews& scene) {
  if (const std::optional<HoldOut> built = hold_out_of(model.notes(), model.path())) return *built;
  if (held_out_views(scene) > 0) return std::nullopt;
  throw InputError(model.path().string() +
                   ": was built from every photograph, so none is left to score: build it with hold=8, for example");
}

py::object validate(const Model& model, const Scene& scene, std::optional<std::size_t> hold, std::size_t block,
                    const std::set<std::string>& baselines, bool aligned) {
  check_baselines(baselines);
  json scores;
  {
    const py::gil_scoped_release unlocked;
    ValidationOptions options;
    options.protocol = protocol_of(hold, block);
    options.validity = model.model().validity;
    options.unbounded = baselines.contains("unbounded");
    options.texture = baselines.contains("texture");
    options.vertex = baselines.contains("vertex");
    options.aligned = aligned;
    options.pictures = false;
    options.quiet = true;
    SceneViews views = read_scene_views(scene.path, model.offset(), scene.pictures);
    if (!options.protocol) options.protocol = protocol_to_score(model, views);
    correct_lenses(views.views, model.notes(), model.path());
    const EglContext context;
    scores = report_json(validate_model(model.model().snapshot, views, context, options, Path()));
  }
  return to_python(scores);
}

}  // namespace

void bind_model(py::module_& module) {
  py::class_<Model, std::shared_ptr<Model>>(module, "Model", "A model that `build` or `open_model` gives")
      .def_property_readonly("path", &Model::path)
      .def_property_readonly("cameras", &cameras_of_model, "Of the stored photographs, by name")
      .def_property_readonly("summary", &summary_of,
                             "What `lumatlas build --json` printed; None where the model does not say")
      .def(
          "render", [](Model& model, const Camera& camera) { return picture_array(draw(model, camera).picture); },
          py::arg("camera"), "The picture from there: (height, width, 3), sRGB")
      .def("render_with_state", &render_with_state, py::arg("camera"),
           "The picture, and why each pixel has its colour: 0 no surface, 1 seen by no photograph, 2 by none that is "
           "stored, 3 from photographs")
      .def("depth", &depth, py::arg("camera"), "Depth z of the surface, scene units; NaN where there is none");
  module.def("open_model", &open_model, py::arg("path"), py::call_guard<py::gil_scoped_release>(),
             "Open what `build` wrote: a folder, or a .glb");
  module.def("validate", &validate, py::arg("model"), py::arg("scene"), py::kw_only(), py::arg("hold") = py::none(),
             py::arg("block") = 1, py::arg("baselines") = std::set<std::string>(), py::arg("aligned") = false,
             "Score a model on the photographs that it was built without; what `lumatlas validate --json` prints");
}

}  // namespace lumatlas::python
