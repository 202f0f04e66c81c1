// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/far_background.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/far_sphere.h"
#include "mesh/used_vertices.h"
#include "tools/base/process/interrupt.h"
#include "tools/inspection/blind_views.h"
#include "tools/scene/for_each_index.h"

namespace lumatlas {

namespace {

// Longest edge of a face and size of a cell of the sphere, in its radii: 5 and 10 degrees.
constexpr double kSphereEdge = 0.08, kSphereCell = 0.17;
constexpr std::size_t kMostGlimpses = 60;

// The part of a small photograph that shows no surface.
struct Glimpse {
  const SmallPhotograph& photograph;
  std::vector<std::uint8_t> past;  // one per pixel: 1 where neither it nor a neighbour shows the surface or is left out
  glm::vec3 offset{0};             // how much brighter it is than the others on average
};

// Returns the mean colour of the part of the photograph that each small pixel covers. `valid` becomes 0 where that part
// has an invalid pixel.
std::vector<glm::vec3> shrunk(const Photograph& photograph, const Camera& small, std::vector<std::uint8_t>& valid) {
  std::vector<glm::vec3> colors(std::size_t{small.width} * small.height);
  const auto first = [](std::uint32_t at, std::uint32_t of, std::uint32_t size) {
    return static_cast<std::uint32_t>(std::uint64_t{at} * size / of);
  };
  for (std::uint32_t y = 0; y < small.height; ++y) {
    for (std::uint32_t x = 0; x < small.width; ++x) {
      glm::vec3 sum(0);
      std::uint32_t count = 0;
      bool whole = true;
      const std::uint32_t bottom = first(y + 1, small.height, photograph.height);
      const std::uint32_t right = first(x + 1, small.width, photograph.width);
      for (std::uint32_t row = first(y, small.height, photograph.height); row < bottom; ++row) {
        for (std::uint32_t column = first(x, small.width, photograph.width); column < right; ++column) {
          const std::size_t pixel = std::size_t{row} * photograph.width + column;
          whole = whole && (photograph.valid.empty() || photograph.valid[pixel] != 0);
          const std::uint8_t* rgb = &photograph.rgb[3 * pixel];
          sum += glm::vec3(rgb[0], rgb[1], rgb[2]);
          ++count;
        }
      }
      const std::size_t at = std::size_t{y} * small.width + x;
      colors[at] = sum / static_cast<float>(std::max(count, 1U));
      if (!whole || count == 0) valid[at] = 0;
    }
  }
  return colors;
}

std::vector<std::uint8_t> eroded(const std::vector<std::uint8_t>& mask, std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint8_t> result(mask.size(), 0);
  for (std::uint32_t y = 1; y + 1 < height; ++y) {
    for (std::uint32_t x = 1; x + 1 < width; ++x) {
      bool all = true;
      for (std::uint32_t row = y - 1; row <= y + 1; ++row) {
        for (std::uint32_t column = x - 1; column <= x + 1; ++column) {
          all = all && mask[std::size_t{row} * width + column] != 0;
        }
      }
      result[std::size_t{y} * width + x] = all ? 1 : 0;
    }
  }
  return result;
}

std::vector<Glimpse> glimpses_of(const std::vector<SmallPhotograph>& photographs, const Visibility& visibility) {
  std::vector<Glimpse> glimpses;
  VisibilityBuffer visible;
  for (const SmallPhotograph& photograph : photographs) {
    throw_if_interrupted();
    visibility.trace(photograph.camera, visible);
    std::vector<std::uint8_t> past = photograph.valid;
    for (std::size_t pixel = 0; pixel < past.size(); ++pixel) {
      if (visible.face[pixel] != FaceId::none) past[pixel] = 0;
    }
    past = eroded(past, photograph.camera.width, photograph.camera.height);
    if (std::count(past.begin(), past.end(), 1) > 0) glimpses.push_back({photograph, std::move(past)});
  }
  return glimpses;
}

// Returns the colour of a point past the surface in a glimpse; null if the glimpse does not show the point.
const glm::vec3* color_at(const Glimpse& glimpse, const glm::dvec3& point) {
  const glm::dvec3 cam = glimpse.photograph.camera.cam_from_world(point);
  if (!(cam.z > 0)) return nullptr;
  const glm::dvec2 image = glimpse.photograph.camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < glimpse.photograph.camera.width &&
        image.y < glimpse.photograph.camera.height)) {
    return nullptr;
  }
  const std::size_t pixel =
      static_cast<std::size_t>(image.y) * glimpse.photograph.camera.width + static_cast<std::size_t>(image.x);
  return glimpse.past[pixel] != 0 ? &glimpse.photograph.color[pixel] : nullptr;
}

constexpr std::size_t kPoints = 16;  // points on a face

// Returns the centroids of the 16 triangles that two quarterings of a face give.
std::array<glm::dvec3, kPoints> points_on(const Mesh& mesh, const glm::uvec3& face) {
  constexpr int kParts = 4;  // along an edge
  const glm::dvec3 a(mesh.positions[face.x]), b(mesh.positions[face.y]), c(mesh.positions[face.z]);
  std::array<glm::dvec3, kPoints> points;
  std::size_t next = 0;
  for (int row = 0; row < kParts; ++row) {
    for (int column = 0; column + row < kParts; ++column) {
      const auto add = [&](double third) {
        points.at(next++) = a + (b - a) * ((column + third) / kParts) + (c - a) * ((row + third) / kParts);
      };
      add(1.0 / 3);
      if (column + row + 1 < kParts) add(2.0 / 3);
    }
  }
  return points;
}

// The colours of a face's points in one glimpse; null where the glimpse does not show the point.
struct Look {
  std::size_t glimpse;
  std::array<const glm::vec3*, kPoints> colors;
};
std::vector<Look> looks_at(const std::vector<Glimpse>& glimpses, const Mesh& mesh, const glm::uvec3& face) {
  const std::array<glm::dvec3, kPoints> points = points_on(mesh, face);
  std::vector<Look> looks;
  for (std::size_t i = 0; i < glimpses.size(); ++i) {
    Look look{i, {}};
    bool any = false;
    for (std::size_t point = 0; point < kPoints; ++point) {
      look.colors.at(point) = color_at(glimpses[i], points.at(point));
      any = any || look.colors.at(point) != nullptr;
    }
    if (any) looks.push_back(look);
  }
  return looks;
}

struct PointMean {
  glm::vec3 sum{0};
  float count = 0;
};
std::array<PointMean, kPoints> means_of(const std::vector<Look>& looks, const std::vector<Glimpse>& glimpses) {
  std::array<PointMean, kPoints> means;
  for (const Look& look : looks) {
    for (std::size_t point = 0; point < kPoints; ++point) {
      if (look.colors.at(point) == nullptr) continue;
      means.at(point).sum += *look.colors.at(point) - glimpses[look.glimpse].offset;
      means.at(point).count += 1;
    }
  }
  return means;
}

// Estimates the offset of each glimpse, by which its colours differ from the mean of all glimpses at the same points.
void balance(const std::vector<std::vector<Look>>& looks, std::vector<Glimpse>& glimpses) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<PointMean> above(glimpses.size());
    for (const std::vector<Look>& of_face : looks) {
      const std::array<PointMean, kPoints> means = means_of(of_face, glimpses);
      for (const Look& look : of_face) {
        for (std::size_t point = 0; point < kPoints; ++point) {
          const PointMean& mean = means.at(point);
          if (look.colors.at(point) == nullptr || mean.count < 2) continue;
          above[look.glimpse].sum += *look.colors.at(point) - mean.sum / mean.count;
          above[look.glimpse].count += 1;
        }
      }
    }
    for (std::size_t i = 0; i < glimpses.size(); ++i) {
      if (above[i].count > 0) glimpses[i].offset = above[i].sum / above[i].count;
    }
  }
}

enum class Verdict : std::uint8_t {
  unseen,
  unknown,  // one photograph alone shows it
  near,     // photographs disagree
  far,
};

float square(const glm::vec3& v) {
  return (v.x * v.x + v.y * v.y + v.z * v.z) / 3;
}

// Compares two variances of colours: between photographs at a point, and over the face within a photograph. They are
// alike where photographs show different things; the first is small where all photographs show the same.
Verdict verdict_of(const std::vector<Look>& looks, const std::vector<Glimpse>& glimpses) {
  constexpr float kSmooth = 6 * 6, kSame = 0.3F;
  if (looks.empty()) return Verdict::unseen;
  const std::array<PointMean, kPoints> means = means_of(looks, glimpses);
  float between = 0, between_count = 0, within = 0, within_count = 0;
  for (const PointMean& mean : means) between_count += std::max(mean.count - 1, 0.0F);
  for (const Look& look : looks) {
    PointMean own;
    float squares = 0;
    for (std::size_t point = 0; point < kPoints; ++point) {
      if (look.colors.at(point) == nullptr) continue;
      const glm::vec3 color = *look.colors.at(point) - glimpses[look.glimpse].offset;
      between += square(color - means.at(point).sum / means.at(point).count);
      own.sum += color;
      own.count += 1;
      squares += square(color);
    }
    within += squares - own.count * square(own.sum / own.count);
    within_count += own.count - 1;
  }
  if (between_count == 0) return Verdict::unknown;
  const float detail = within_count > 0 ? within / within_count : 0;
  const float apart = between / between_count;
  return apart < kSmooth || apart < kSame * detail ? Verdict::far : Verdict::near;
}

// Numbers of faces that share a vertex with a face, by verdict; at each shared vertex once. The face itself counts.
struct Neighbors {
  std::uint32_t near = 0, far = 0, unknown = 0;

  void add(Verdict verdict) {
    if (verdict == Verdict::near) ++near;
    if (verdict == Verdict::far) ++far;
    if (verdict == Verdict::unknown) ++unknown;
  }
};
std::vector<Neighbors> neighbors_of(const Mesh& sphere, const std::vector<Verdict>& verdicts) {
  std::vector<Neighbors> at_vertex(sphere.positions.size());
  for (std::size_t face = 0; face < verdicts.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) at_vertex[sphere.faces[face][corner]].add(verdicts[face]);
  }
  std::vector<Neighbors> result(verdicts.size());
  for (std::size_t face = 0; face < verdicts.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const Neighbors& counts = at_vertex[sphere.faces[face][corner]];
      result[face].near += counts.near;
      result[face].far += counts.far;
      result[face].unknown += counts.unknown;
    }
  }
  return result;
}

// Islands get the verdict of the faces around them. A region that one photograph alone shows stays unknown: it does not
// spread from its border, because what is unknown is often a near surface that the mesh lacks.
void settle(const Mesh& sphere, std::vector<Verdict>& verdicts) {
  constexpr std::uint32_t kMostly = 3;
  constexpr std::uint32_t kItself = 3;  // how often a face counts among its own neighbours
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Neighbors> neighbors = neighbors_of(sphere, verdicts);
    for (std::size_t face = 0; face < verdicts.size(); ++face) {
      const Neighbors& around = neighbors[face];
      Verdict& verdict = verdicts[face];
      if (verdict == Verdict::far && around.near > kMostly * around.far) verdict = Verdict::near;
      if (verdict == Verdict::near && around.far > kMostly * around.near) verdict = Verdict::far;
      if (verdict == Verdict::unknown && around.far > kMostly * (around.near + around.unknown - kItself)) {
        verdict = Verdict::far;
      }
    }
  }
}

// Returns for each face of the sphere whether photographs agree that it is far.
std::vector<bool> far_faces(std::vector<Glimpse> glimpses, const Mesh& sphere) {
  std::vector<std::vector<Look>> looks(sphere.faces.size());
  for_each_index(looks.size(), [&](std::size_t face) { looks[face] = looks_at(glimpses, sphere, sphere.faces[face]); });
  balance(looks, glimpses);
  std::vector<Verdict> verdicts;
  verdicts.reserve(looks.size());
  for (const std::vector<Look>& of_face : looks) verdicts.push_back(verdict_of(of_face, glimpses));
  settle(sphere, verdicts);
  std::vector<bool> far;
  far.reserve(verdicts.size());
  for (const Verdict verdict : verdicts) far.push_back(verdict == Verdict::far);
  return far;
}

}  // namespace

SmallPhotograph small_photograph(const SceneView& view, const Camera& small) {
  SmallPhotograph result{small, {}, std::vector<std::uint8_t>(std::size_t{small.width} * small.height, 1)};
  try {
    result.color = shrunk(load_photograph(view), small, result.valid);
  } catch (const InputError&) {  // the build refuses it only if it stores it
    std::fill(result.valid.begin(), result.valid.end(), std::uint8_t{0});
    result.color.resize(result.valid.size());
  }
  return result;
}

std::vector<SmallPhotograph> small_photographs(const std::vector<SceneView>& views,
                                               const std::vector<std::size_t>& ranks) {
  const std::size_t count = std::min(kMostGlimpses, ranks.size());
  std::vector<SmallPhotograph> small(count);
  for_each_index(count, [&](std::size_t i) {
    throw_if_interrupted();
    const SceneView& view = views[ranks[i * ranks.size() / count]];
    small[i] = small_photograph(view, view.camera.shrunk_to(kGlancePx));
  });
  return small;
}

FarSphere find_far_sphere(const std::vector<SmallPhotograph>& photographs, std::span<const Camera> cameras,
                          const Mesh& mesh, const Visibility& visibility) {
  std::vector<Glimpse> glimpses = glimpses_of(photographs, visibility);
  if (glimpses.empty()) return {};
  const SphereShape shape = far_sphere_shape(cameras, mesh);
  const Mesh sphere = far_sphere(shape, kSphereEdge);
  FarSphere far;
  const std::vector<bool> is_far = far_faces(std::move(glimpses), sphere);
  add_faces(
      sphere, [&](std::size_t face) { return is_far[face]; }, far.mesh);
  if (!far.mesh.faces.empty()) {
    far.cells = make_cells(far.mesh, {.size = kSphereCell * shape.radius}, throw_if_interrupted);
  }
  return far;
}

FrameShare frame_share(const Camera& camera, const Visibility& visibility, const Visibility* far,
                       std::span<const std::uint8_t> valid) {
  const Camera small = camera.shrunk_to(kGlancePx);
  const VisibilityBuffer near_buffer = visibility.trace(small);
  const VisibilityBuffer far_buffer = far != nullptr ? far->trace(small) : VisibilityBuffer();
  std::size_t near = 0, beyond = 0, pixels = 0;
  for (std::size_t pixel = 0; pixel < near_buffer.face.size(); ++pixel) {
    if (!valid.empty() && valid[pixel] == 0) continue;
    ++pixels;
    if (near_buffer.face[pixel] != FaceId::none) {
      ++near;
    } else if (far != nullptr && far_buffer.face[pixel] != FaceId::none) {
      ++beyond;
    }
  }
  const auto all = static_cast<double>(std::max<std::size_t>(pixels, 1));
  return {static_cast<double>(near) / all, static_cast<double>(beyond) / all, pixels};
}

}  // namespace lumatlas
