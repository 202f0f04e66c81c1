// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/model.h"
#include "tools/python/progress.h"
#include "tools/score/validation.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using nlohmann::json;

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
                    const std::set<std::string>& baselines, bool aligned, const py::object& progress) {
  check_baselines(baselines);
  const Progress told("validation", progress);
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
    options.told = [&](std::size_t done, std::size_t total) { told.tell("validating", done, total); };
    SceneViews views = read_scene_views(scene.path, model.offset(), scene.pictures);
    if (!options.protocol) options.protocol = protocol_to_score(model, views);
    correct_photographs(views.views, model.notes(), model.path());
    const EglContext context;
    scores = report_json(validate_model(model.model().snapshot, views, context, options, std::filesystem::path()));
  }
  return to_python(scores);
}

}  // namespace

void bind_validate(py::module_& module) {
  module.def("validate", &validate, py::arg("model"), py::arg("scene"), py::kw_only(), py::arg("hold") = py::none(),
             py::arg("block") = 1, py::arg("baselines") = std::set<std::string>(), py::arg("aligned") = false,
             py::arg("progress") = py::none(),
             "Score a model on the photographs that it was built without; what `lumatlas validate --json` prints");
}

}  // namespace lumatlas::python
