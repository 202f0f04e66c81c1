// SPDX-License-Identifier: GPL-3.0-or-later
// The Python module's parts, one file a subject. What Python sees is in the coordinates of the scene, its offset not
// subtracted. InputError, GlError and Stopped become exceptions of the module, std::invalid_argument becomes
// ValueError, with the same sentence; other exceptions get the sentence that the program prints
// (tools/base/error_sentence.h). Whatever takes long runs without Python's lock.
#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "mesh/base/temporary_entry.h"
#include "mesh/camera/camera.h"
#include "tools/python/initialised_caster.h"
#include "tools/scene/scene.h"

namespace lumatlas::python {

void bind_exceptions(pybind11::module_& module);
void bind_camera(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_model(pybind11::module_& module);
void bind_build(pybind11::module_& module);
void bind_capture(pybind11::module_& module);
void bind_export(pybind11::module_& module);
void bind_inspect(pybind11::module_& module);
void bind_mesh(pybind11::module_& module);
void bind_render(pybind11::module_& module);
void bind_validate(pybind11::module_& module);

// A scene that was looked at once: where it is, and its views in its own coordinates.
struct Scene {
  std::filesystem::path path;
  PictureFolders pictures;
  SceneViews views;
  std::shared_ptr<TemporaryEntry> folder = {};  // `path`, of a scene that Python made; null: of a scene on disk
};

// The camera in the scene's coordinates of one whose coordinates have `offset` subtracted, and the other way round.
[[nodiscard]] Camera in_scene(Camera camera, const glm::dvec3& offset);
[[nodiscard]] Camera in_model(Camera camera, const glm::dvec3& offset);

// Dicts, lists, numbers and None. Needs Python's lock.
[[nodiscard]] pybind11::object to_python(const nlohmann::json& value);

// Issues a UserWarning of Python. Needs Python's lock; throws what Python makes of the warning.
void warn(const std::string& sentence);

// Without both, no photograph is held out. Throws std::invalid_argument for a block without hold.
[[nodiscard]] std::optional<HoldOut> protocol_of(std::optional<std::size_t> hold, std::size_t block);

}  // namespace lumatlas::python

namespace pybind11::detail {

template <>
class type_caster<lumatlas::Camera> : public lumatlas::python::InitialisedCaster<lumatlas::Camera> {};
template <>
class type_caster<lumatlas::python::Scene> : public lumatlas::python::InitialisedCaster<lumatlas::python::Scene> {};

}  // namespace pybind11::detail
