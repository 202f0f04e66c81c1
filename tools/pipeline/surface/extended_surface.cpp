// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/extended_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <utility>

#include "tools/base/process/interrupt.h"
#include "tools/pipeline/surface/filled_depth.h"
#include "tools/pipeline/surface/frame_prediction.h"
#include "tools/scene/for_each_index.h"

namespace lumatlas {

namespace {

constexpr double kFewestLacking = 0.002;  // share of a photograph's pixels from which it offers faces
constexpr double kSameSurface = 0.05;  // share of the depth by which the surface beside a hole may differ from its fill
constexpr double kBehind = 1.003;      // depth of the extension where it overlaps the surface, in that of the surface
constexpr double kInFront = 0.97;      // share of a surface's depth below which a vertex stands before it
constexpr std::uint32_t kSquarePx = 16;      // side of the squares of a photograph whose faces stay or go together
constexpr std::size_t kFewestPredicted = 8;  // pixels of all photographs that tell whether a square's faces stay
constexpr double kClearlyBetter = 0.85;      // error of the prediction, in that of the fill, from which faces go

// The faces of one square of a photograph's picture.
struct Square {
  double predicted = 0, filled = 0;  // sums of squared errors over the pixels that see the faces and can be predicted
  std::size_t predictable = 0;       // number of these pixels, in all photographs

  void add(const Square& other) {
    predicted += other.predicted;
    filled += other.filled;
    predictable += other.predictable;
  }
};

// The faces that one photograph offers.
struct Sheet {
  Mesh mesh;
  std::vector<std::uint32_t> square_of_face;
  std::size_t squares = 0;
};

// What a photograph's pixels see.
struct Sight {
  std::vector<double> inverse_depth;  // 0 where nothing is known
  std::vector<std::uint8_t> lacking;  // 1 where a valid pixel sees nothing
  std::vector<std::uint8_t> far;      // 1 where a pixel sees the far sphere
  std::size_t lacking_count = 0;
};

Sight sight_of(const SmallPhotograph& photograph, const Visibility& surface, const Visibility* far,
               const Visibility* extension) {
  const VisibilityBuffer near = surface.trace(photograph.camera);
  const VisibilityBuffer beyond = far != nullptr ? far->trace(photograph.camera) : VisibilityBuffer();
  const VisibilityBuffer added = extension != nullptr ? extension->trace(photograph.camera) : VisibilityBuffer();
  const std::size_t pixels = near.face.size();
  Sight sight{std::vector<double>(pixels), std::vector<std::uint8_t>(pixels), std::vector<std::uint8_t>(pixels), 0};
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    if (near.face[pixel] != FaceId::none) {
      sight.inverse_depth[pixel] = 1 / double{near.depth[pixel]};
    } else if (extension != nullptr && added.face[pixel] != FaceId::none) {
      sight.inverse_depth[pixel] = 1 / double{added.depth[pixel]};
    } else if (far != nullptr && beyond.face[pixel] != FaceId::none) {
      sight.far[pixel] = 1;
    } else if (photograph.valid[pixel] != 0) {
      sight.lacking[pixel] = 1;
      ++sight.lacking_count;
    }
  }
  return sight;
}

bool lacks_much(const Sight& sight) {
  return static_cast<double>(sight.lacking_count) > kFewestLacking * static_cast<double>(sight.lacking.size());
}

// Counts how photographs see a place: one that sees something behind it contradicts it.
struct Evidence {
  int contradicts = 0, agrees = 0;
};

class Sights {
 public:
  Sights(const std::vector<SmallPhotograph>& photographs, const Visibility& surface, const Visibility* far)
      : photographs_(photographs), sights_(photographs.size()) {
    for_each_index(photographs.size(), [&](std::size_t i) {
      throw_if_interrupted();
      sights_[i] = sight_of(photographs[i], surface, far, nullptr);
    });
  }

  [[nodiscard]] const Sight& of(std::size_t photograph) const { return sights_[photograph]; }
  // Returns the photographs that lack enough to add faces, those that lack most first.
  [[nodiscard]] std::vector<std::size_t> order() const {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      if (lacks_much(sights_[i])) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
      return sights_[a].lacking_count > sights_[b].lacking_count;
    });
    return order;
  }
  [[nodiscard]] Evidence evidence_at(const glm::dvec3& point) const {
    Evidence evidence;
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      const Camera& camera = photographs_[i].camera;
      const glm::dvec3 cam = camera.cam_from_world(point);
      if (!(cam.z > 0)) continue;
      const glm::dvec2 at = camera.image_from_cam(cam);
      if (!(at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height)) continue;
      const std::size_t pixel = static_cast<std::size_t>(at.y) * camera.width + static_cast<std::size_t>(at.x);
      const double inverse = sights_[i].inverse_depth[pixel];
      if (sights_[i].far[pixel] != 0 || (inverse > 0 && cam.z * inverse < kInFront)) ++evidence.contradicts;
      if (sights_[i].lacking[pixel] != 0) ++evidence.agrees;
    }
    return evidence;
  }

 private:
  const std::vector<SmallPhotograph>& photographs_;
  std::vector<Sight> sights_;
};

// Makes the faces that one photograph offers: a grid with a vertex at the middle of each pixel.
class SheetMaker {
 public:
  SheetMaker(const SmallPhotograph& photograph, const Sight& sight)
      : camera_(photograph.camera),
        sight_(sight),
        filled_(filled_inverse_depth(sight.inverse_depth, camera_.width, camera_.height)),
        vertex_(sight.lacking.size(), kNoVertex) {}

  [[nodiscard]] Sheet make(const Sights& sights) {
    Sheet sheet;
    const std::uint32_t columns = (camera_.width + kSquarePx - 1) / kSquarePx;
    std::vector<std::uint32_t> square_at(std::size_t{columns} * ((camera_.height + kSquarePx - 1) / kSquarePx),
                                         kNoVertex);
    for (std::uint32_t y = 0; y + 1 < camera_.height; ++y) {
      for (std::uint32_t x = 0; x + 1 < camera_.width; ++x) {
        const std::size_t pixel = std::size_t{y} * camera_.width + x;
        const std::array<std::size_t, 4> corners{pixel, pixel + 1, pixel + camera_.width, pixel + camera_.width + 1};
        const auto lacks = [this](std::size_t corner) { return sight_.lacking[corner] != 0; };
        if (std::none_of(corners.begin(), corners.end(), lacks)) continue;
        std::array<std::uint32_t, 4> vertices{};
        for (std::size_t i = 0; i < 4; ++i) vertices.at(i) = vertex_at(corners.at(i), sights, sheet.mesh);
        std::uint32_t& square = square_at[std::size_t{y / kSquarePx} * columns + x / kSquarePx];
        for (const auto& [a, b, c] : {std::array{0, 2, 1}, std::array{1, 2, 3}}) {
          const glm::uvec3 face(vertices.at(a), vertices.at(b), vertices.at(c));
          if (face.x == kRefused || face.y == kRefused || face.z == kRefused) continue;
          if (square == kNoVertex) square = static_cast<std::uint32_t>(sheet.squares++);
          sheet.mesh.faces.push_back(face);
          sheet.square_of_face.push_back(square);
        }
      }
    }
    return sheet;
  }

 private:
  static constexpr std::uint32_t kNoVertex = 0xffffffff, kRefused = 0xfffffffe;

  // Returns the mean of the filled inverse depths around a pixel where photographs lack a surface.
  [[nodiscard]] double lacking_around(std::size_t pixel) const {
    const auto x = static_cast<std::int64_t>(pixel % camera_.width),
               y = static_cast<std::int64_t>(pixel / camera_.width);
    double sum = 0, count = 0;
    for (std::int64_t row = std::max<std::int64_t>(y - 1, 0); row <= std::min<std::int64_t>(y + 1, camera_.height - 1);
         ++row) {
      for (std::int64_t column = std::max<std::int64_t>(x - 1, 0);
           column <= std::min<std::int64_t>(x + 1, camera_.width - 1); ++column) {
        const auto at = static_cast<std::size_t>(row * camera_.width + column);
        if (sight_.lacking[at] == 0) continue;
        sum += filled_[at];
        ++count;
      }
    }
    return count > 0 ? sum / count : filled_[pixel];
  }

  // Where the sheet goes on under the surface it stays just behind it; where it passes behind a nearer object, or
  // before the far sphere, it keeps the depth of the lacking pixels.
  [[nodiscard]] double depth_at(std::size_t pixel) const {
    if (sight_.lacking[pixel] != 0) return 1 / filled_[pixel];
    const double around = lacking_around(pixel);
    const double own = sight_.inverse_depth[pixel];
    return own > 0 && std::abs(own / around - 1) < kSameSurface ? kBehind / own : 1 / around;
  }

  // Returns the vertex of a pixel, kRefused where other photographs contradict it. Those of the picture's border lie a
  // pixel outside, so that the sheet covers all of it.
  std::uint32_t vertex_at(std::size_t pixel, const Sights& sights, Mesh& mesh) {
    std::uint32_t& vertex = vertex_[pixel];
    if (vertex != kNoVertex) return vertex;
    const auto x = static_cast<std::uint32_t>(pixel % camera_.width),
               y = static_cast<std::uint32_t>(pixel / camera_.width);
    const auto place = [](std::uint32_t at, std::uint32_t size) {
      return at + 0.5 + (at == 0 ? -1 : 0) + (at + 1 == size ? 1 : 0);
    };
    const double depth = depth_at(pixel);
    const glm::dvec3 point =
        camera_.center() + depth * camera_.ray({place(x, camera_.width), place(y, camera_.height)});
    const Evidence evidence = sights.evidence_at(point);
    if (evidence.contradicts > evidence.agrees) return vertex = kRefused;
    vertex = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.emplace_back(point);
    return vertex;
  }

  const Camera& camera_;
  const Sight& sight_;
  std::vector<double> filled_;
  std::vector<std::uint32_t> vertex_;
};

// Adds faces to a mesh, with the vertices that they use. `kept`: whether each of the faces is added.
void add_faces(const Mesh& from, const std::vector<bool>& kept, Mesh& to) {
  constexpr std::uint32_t kUnused = 0xffffffff;
  std::vector<std::uint32_t> place(from.positions.size(), kUnused);
  for (std::size_t i = 0; i < from.faces.size(); ++i) {
    if (!kept[i]) continue;
    glm::uvec3 face = from.faces[i];
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& vertex = place[face[corner]];
      if (vertex == kUnused) {
        vertex = static_cast<std::uint32_t>(to.positions.size());
        to.positions.push_back(from.positions[face[corner]]);
      }
      face[corner] = vertex;
    }
    to.faces.push_back(face);
  }
}

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
    if (!lacks_much(sight)) continue;
    const Sheet sheet = SheetMaker(photographs[photograph], sight).make(sights);
    if (sheet.mesh.faces.empty()) continue;
    Mesh with_sheet = extension;
    add_faces(sheet.mesh, std::vector<bool>(sheet.mesh.faces.size(), true), with_sheet);
    const std::vector<bool> kept = kept_squares(predictions.compare(with_sheet, sheet));
    std::vector<bool> kept_faces;
    for (const std::uint32_t square : sheet.square_of_face) kept_faces.push_back(kept[square]);
    add_faces(sheet.mesh, kept_faces, extension);
    if (!extension.faces.empty()) added = make_ray_visibility(extension);
  }
  return extension;
}

}  // namespace lumatlas
