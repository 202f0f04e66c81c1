// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/continued_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "mesh/base/id.h"
#include "tools/base/process/interrupt.h"
#include "tools/pipeline/surface/filled_depth.h"
#include "tools/scene/for_each_index.h"

namespace lumatlas {

namespace {

constexpr double kFewestLacking = 0.002;  // share of a photograph's pixels from which it offers faces
constexpr double kSameSurface = 0.05;  // share of the depth by which the surface beside a hole may differ from its fill
constexpr double kBehind = 1.003;      // depth of a sheet where it overlaps the surface, in that of the surface
constexpr double kInFront = 0.97;      // share of a surface's depth below which a point stands before it
constexpr std::uint32_t kSquarePx = 16;  // side of the squares, pixels of the small photograph

class SheetMaker {
 public:
  SheetMaker(const Camera& camera, const Sight& sight, const Sights& sights)
      : camera_(camera),
        sight_(sight),
        sights_(sights),
        filled_(filled_inverse_depth(sight.inverse_depth, camera.width, camera.height)),
        vertices_(sight.lacking.size()),
        contradicted_(sight.lacking.size()) {}

  [[nodiscard]] Sheet make() && {
    const std::uint32_t columns = (camera_.width + kSquarePx - 1) / kSquarePx;
    sheet_.squares = std::size_t{columns} * ((camera_.height + kSquarePx - 1) / kSquarePx);
    for (std::uint32_t y = 0; y + 1 < camera_.height; ++y) {
      for (std::uint32_t x = 0; x + 1 < camera_.width; ++x) {
        const std::size_t pixel = std::size_t{y} * camera_.width + x;
        const std::array<std::size_t, 4> corners{pixel, pixel + 1, pixel + camera_.width, pixel + camera_.width + 1};
        const auto lacks = [this](std::size_t corner) { return sight_.lacking[corner] != 0; };
        if (std::none_of(corners.begin(), corners.end(), lacks)) continue;
        const std::uint32_t square = y / kSquarePx * columns + x / kSquarePx;
        add_face(corners[0], corners[2], corners[1], square);
        add_face(corners[1], corners[2], corners[3], square);
      }
    }
    return std::move(sheet_);
  }

 private:
  void add_face(std::size_t a, std::size_t b, std::size_t c, std::uint32_t square) {
    const glm::uvec3 face(vertex_at(a), vertex_at(b), vertex_at(c));
    if (contradicted_[a] + contradicted_[b] + contradicted_[c] > 0) return;
    sheet_.mesh.faces.push_back(face);
    sheet_.square_of_face.push_back(square);
  }

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

  // Returns the vertex of a pixel. Those of the picture's border lie a pixel outside.
  VertexId vertex_at(std::size_t pixel) {
    VertexId& vertex = vertices_[pixel];
    if (vertex != VertexId::none) return vertex;
    const auto x = static_cast<std::uint32_t>(pixel % camera_.width),
               y = static_cast<std::uint32_t>(pixel / camera_.width);
    const auto place = [](std::uint32_t at, std::uint32_t size) {
      return at + 0.5 + (at == 0 ? -1 : 0) + (at + 1 == size ? 1 : 0);
    };
    const glm::dvec3 point =
        camera_.center() + depth_at(pixel) * camera_.ray({place(x, camera_.width), place(y, camera_.height)});
    contradicted_[pixel] = sights_.contradict(point) ? 1 : 0;
    vertex = VertexId(static_cast<std::uint32_t>(sheet_.mesh.positions.size()));
    sheet_.mesh.positions.emplace_back(point);
    return vertex;
  }

  const Camera& camera_;
  const Sight& sight_;
  const Sights& sights_;
  std::vector<double> filled_;
  std::vector<VertexId> vertices_;          // one per pixel, none until a face needs it
  std::vector<std::uint8_t> contradicted_;  // one per pixel, 1 where other photographs contradict its vertex
  Sheet sheet_;
};

}  // namespace

bool Sight::lacks_much() const {
  return static_cast<double>(lacking_count) > kFewestLacking * static_cast<double>(lacking.size());
}

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

Sights::Sights(const std::vector<SmallPhotograph>& photographs, const Visibility& surface, const Visibility* far)
    : photographs_(photographs), sights_(photographs.size()) {
  for_each_index(photographs.size(), [&](std::size_t i) {
    throw_if_interrupted();
    sights_[i] = sight_of(photographs[i], surface, far, nullptr);
  });
}

std::vector<std::size_t> Sights::order() const {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    if (sights_[i].lacks_much()) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
    return sights_[a].lacking_count > sights_[b].lacking_count;
  });
  return order;
}

bool Sights::contradict(const glm::dvec3& point) const {
  int contradicts = 0, agrees = 0;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    const Camera& camera = photographs_[i].camera;
    const glm::dvec3 cam = camera.cam_from_world(point);
    if (!(cam.z > 0)) continue;
    const glm::dvec2 at = camera.image_from_cam(cam);
    if (!(at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height)) continue;
    const std::size_t pixel = static_cast<std::size_t>(at.y) * camera.width + static_cast<std::size_t>(at.x);
    const double inverse = sights_[i].inverse_depth[pixel];
    if (sights_[i].far[pixel] != 0 || (inverse > 0 && cam.z * inverse < kInFront)) ++contradicts;
    if (sights_[i].lacking[pixel] != 0) ++agrees;
  }
  return contradicts > agrees;
}

Sheet continued_sheet(const SmallPhotograph& photograph, const Sight& sight, const Sights& sights) {
  return SheetMaker(photograph.camera, sight, sights).make();
}

}  // namespace lumatlas
