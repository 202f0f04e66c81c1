// SPDX-License-Identifier: GPL-3.0-or-later
// A model as Python holds it.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>

#include "atlas/model_file.h"
#include "blend/egl_context.h"
#include "blend/renderer.h"
#include "mesh/visibility.h"
#include "tools/pipeline/model_output.h"
#include "tools/python/initialised_caster.h"

namespace lumatlas::python {

// It is read once, and drawn by a renderer that is made for the first picture. Cameras are in the scene's coordinates.
// Its functions may be called from any thread; they need no lock of Python's.
class Model {
 public:
  explicit Model(const std::filesystem::path& path);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const ModelNotes& notes() const { return notes_; }
  [[nodiscard]] const lumatlas::Model& model() const { return model_; }
  [[nodiscard]] const glm::dvec3& offset() const { return model_.snapshot.surface->offset; }

  [[nodiscard]] Rendering render(const Camera& camera);
  [[nodiscard]] VisibilityBuffer trace(const Camera& camera);

 private:
  std::filesystem::path path_;
  lumatlas::Model model_;
  ModelNotes notes_;
  std::mutex drawing_;
  std::optional<EglContext> context_;
  std::optional<Renderer> renderer_;
  std::unique_ptr<Visibility> visibility_;
};

[[nodiscard]] std::shared_ptr<Model> open_model(const std::filesystem::path& path);

}  // namespace lumatlas::python

namespace pybind11::detail {

template <>
class type_caster<lumatlas::python::Model> : public lumatlas::python::InitialisedCaster<lumatlas::python::Model> {};

}  // namespace pybind11::detail
