// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "blend/tables/tiles.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/model.h"
#include "tools/python/pictures.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;
}  // namespace

Model::Model(const Path& path) : path_(path), model_(read_model(path)), notes_(read_model_notes(path)) {}

Model::~Model() {
  if (!context_) return;
  const CurrentContext current(*context_);
  whole_.reset();
  near_.reset();
}

void Model::draw(bool with_far_sphere, const Drawing& drawing) {
  const std::lock_guard lock(drawing_);
  if (!context_) context_.emplace(EglContext::Options{.stays_current = false});
  const CurrentContext current(*context_);
  std::optional<Drawn>& drawn = with_far_sphere ? whole_ : near_;
  if (!drawn) {
    Drawn fresh{with_far_sphere ? model_.snapshot : without_far_sphere(model_.snapshot), Renderer()};
    fresh.renderer.load(fresh.snapshot);
    drawn.emplace(std::move(fresh));
  }
  drawing(drawn->snapshot, drawn->renderer);
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
  const nlohmann::json& plan = model.notes().plan;
  return to_python(plan.is_object() ? plan.value("summary", nlohmann::json()) : nlohmann::json());
}

}  // namespace

void bind_model(py::module_& module) {
  py::class_<Model, std::shared_ptr<Model>>(module, "Model", "A model that `build` or `open_model` gives")
      .def_property_readonly("path", &Model::path)
      .def_property_readonly("cameras", &cameras_of_model, "Of the stored photographs, by name")
      .def_property_readonly("summary", &summary_of,
                             "What `lumatlas build --json` printed; None where the model does not say")
      .def("depth", &depth, py::arg("camera"), "Depth z of the surface, scene units; NaN where there is none");
  module.def("open_model", &open_model, py::arg("path"), py::call_guard<py::gil_scoped_release>(),
             "Open what `build` wrote: a folder, or a .glb");
}

}  // namespace lumatlas::python
