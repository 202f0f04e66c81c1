// SPDX-License-Identifier: GPL-3.0-or-later
// A model as Python holds it.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "atlas/model/model_file.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "mesh/visibility/visibility.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/python/initialised_caster.h"

namespace lumatlas::python {

// It is read once, and drawn by renderers that are made for the first pictures. Cameras are in the scene's coordinates.
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

  // Draws with a renderer that has the snapshot loaded, on a current context. One drawing at a time. The first one
  // loads the model.
  using Drawing = std::function<void(const Snapshot&, Renderer&)>;
  void draw(bool with_far_sphere, const Drawing& drawing);
  [[nodiscard]] VisibilityBuffer trace(const Camera& camera);

 private:
  std::filesystem::path path_;
  lumatlas::Model model_;
  ModelNotes notes_;
  std::mutex drawing_;
  std::optional<EglContext> context_;
  struct Drawn {
    Snapshot snapshot;
    Renderer renderer;
  };
  std::optional<Drawn> whole_, near_;  // with the far sphere, and without
  std::unique_ptr<Visibility> visibility_;
};

[[nodiscard]] std::shared_ptr<Model> open_model(const std::filesystem::path& path);

}  // namespace lumatlas::python

namespace pybind11::detail {

template <>
class type_caster<lumatlas::python::Model> : public lumatlas::python::InitialisedCaster<lumatlas::python::Model> {};

}  // namespace pybind11::detail
