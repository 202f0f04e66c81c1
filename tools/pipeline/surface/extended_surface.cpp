// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/extended_surface.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "mesh/base/id.h"
#include "mesh/used_vertices.h"
#include "tools/base/process/interrupt.h"
#include "tools/pipeline/surface/continued_sheet.h"
#include "tools/pipeline/surface/frame_prediction.h"
#include "tools/scene/for_each_index.h"

namespace lumatlas {

namespace {

constexpr std::size_t kFewestPredicted = 8;  // pixels of all photographs that tell whether a square's faces stay
constexpr double kClearlyBetter = 0.7;       // error of the prediction, in that of the fill, from which faces go

// What photographs tell of the faces of one square.
struct Square {
  double predicted = 0, filled = 0;  // sums of squared errors over the pixels that see the faces and can be predicted
  std::size_t predictable = 0;       // number of these pixels, in all photographs

  void add(const Square& other) {
    predicted += other.predicted;
    filled += other.filled;
    predictable += other.predictable;
  }
};

// Predicts photographs with the surface and an extension of it.
class Predictions {
 public:
  Predictions(const std::vector<SmallPhotograph>& photographs, const Visibility& surface, std::size_t surface_faces,
              const std::vector<FrameError>& frames)
      : looks_(frame_looks_at(photographs, surface)), surface_faces_(surface_faces), frames_(frames) {}

  // Compares the prediction and the fill in all pixels that lack a surface and see a face of the sheet, which is the
  // end of the extension.
  [[nodiscard]] std::vector<Square> compare(const Mesh& extension, const Sheet& sheet) const {
    const std::unique_ptr<Visibility> visibility = make_ray_visibility(extension);
    std::vector<std::optional<FrameLook>> traced(looks_.size());
    for_each_index(looks_.size(), [&](std::size_t i) { traced[i].emplace(with_extension(looks_[i], *visibility)); });
    std::vector<FrameLook> looks;
    looks.reserve(traced.size());
    for (std::optional<FrameLook>& look : traced) looks.push_back(*std::move(look));
    const std::size_t first = surface_faces_ + extension.faces.size() - sheet.mesh.faces.size();
    std::vector<std::vector<Square>> each(looks.size());
    for_each_index(looks.size(), [&](std::size_t own) {
      throw_if_interrupted();
      each[own] = compared(looks, own, frames_[own], first, sheet);
    });
    std::vector<Square> squares(sheet.squares);
    for (const std::vector<Square>& of_one : each) {
      for (std::size_t i = 0; i < squares.size(); ++i) squares[i].add(of_one[i]);
    }
    return squares;
  }

 private:
  [[nodiscard]] FrameLook with_extension(const FrameLook& look, const Visibility& extension) const {
    VisibilityBuffer both = look.visible;
    const VisibilityBuffer added = extension.trace(look.photograph.camera);
    for (std::size_t pixel = 0; pixel < both.face.size(); ++pixel) {
      if (!(added.depth[pixel] < both.depth[pixel])) continue;
      both.depth[pixel] = added.depth[pixel];
      both.face[pixel] = FaceId(static_cast<std::uint32_t>(surface_faces_ + added.face[pixel]));
    }
    return {look.photograph, std::move(both)};
  }

  static std::vector<Square> compared(const std::vector<FrameLook>& looks, std::size_t own, const FrameError& frame,
                                      std::size_t first_face, const Sheet& sheet) {
    std::vector<Square> squares(sheet.squares);
    for (std::size_t i = 0; i < frame.lacking.size(); ++i) {
      const std::size_t pixel = frame.lacking[i];
      if (!looks[own].sees_surface(pixel)) continue;
      const std::size_t face = looks[own].visible.face[pixel];
      if (face < first_face) continue;
      const std::optional<glm::vec3> color = predicted_color(looks, own, pixel);
      if (!color) continue;
      squares[sheet.square_of_face[face - first_face]].add(
          {squared_error(frame.surface.gain * *color, looks[own].photograph.color[pixel]), frame.filled[i], 1});
    }
    return squares;
  }

  std::vector<FrameLook> looks_;
  std::size_t surface_faces_;
  const std::vector<FrameError>& frames_;
};

// Returns whether each square's faces stay. A square of which photographs tell too little goes the way of most pixels
// of the others.
std::vector<bool> kept_squares(const std::vector<Square>& squares) {
  std::vector<bool> kept;
  std::int64_t balance = 0;  // pixels that stay, less those that go
  for (const Square& square : squares) {
    kept.push_back(square.predicted < kClearlyBetter * square.filled);
    const auto pixels = static_cast<std::int64_t>(square.predictable);
    if (square.predictable >= kFewestPredicted) balance += kept.back() ? pixels : -pixels;
  }
  for (std::size_t i = 0; i < squares.size(); ++i) {
    if (squares[i].predictable < kFewestPredicted) kept[i] = balance > 0;
  }
  return kept;
}

}  // namespace

Mesh surface_extension(const std::vector<SmallPhotograph>& photographs, const Mesh& surface,
                       const Visibility& visibility, const Visibility* far) {
  const std::optional<std::vector<FrameError>> frames = frame_errors(frame_looks_at(photographs, visibility), far);
  if (!frames) return {};
  const Sights sights(photographs, visibility, far);
  const Predictions predictions(photographs, visibility, surface.faces.size(), *frames);
  Mesh extension;
  std::unique_ptr<Visibility> added;
  for (const std::size_t photograph : sights.order()) {
    const Sight sight = added ? sight_of(photographs[photograph], visibility, far, added.get()) : sights.of(photograph);
    if (!sight.lacks_much()) continue;
    const Sheet sheet = continued_sheet(photographs[photograph], sight, sights);
    if (sheet.mesh.faces.empty()) continue;
    Mesh with_sheet = extension;
    add_faces(
        sheet.mesh, [](std::size_t) { return true; }, with_sheet);
    const std::vector<bool> kept = kept_squares(predictions.compare(with_sheet, sheet));
    add_faces(
        sheet.mesh, [&](std::size_t face) { return kept[sheet.square_of_face[face]]; }, extension);
    if (!extension.faces.empty()) added = make_ray_visibility(extension);
  }
  return extension;
}

}  // namespace lumatlas
