// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/surface/surface_input.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/cells/split_faces.h"
#include "mesh/finite.h"
#include "mesh/readers/ply_header.h"
#include "mesh/repair/holes.h"
#include "mesh/repair/simplification.h"
#include "mesh/scene_extent.h"
#include "tools/base/process/interrupt.h"
#include "tools/scene/mesh/mesh_coordinate_step.h"
#include "tools/scene/scene.h"

namespace lumatlas {

namespace {

// Most times that a mesh may be as large as its bulk: floats at its end are then 2^-14 of the bulk apart at worst.
constexpr double kMostStray = 1000;

// At most some hundred thousand, evenly over the faces: enough for a share of them.
std::vector<glm::dvec3> sampled_corners(const TriangleSoup& soup) {
  constexpr std::size_t kSamples = 100'000;
  const std::size_t stride = 3 * soup.faces.size() / kSamples + 1;
  std::vector<glm::dvec3> corners;
  for (std::size_t i = 0; i < 3 * soup.faces.size(); i += stride) {
    const glm::dvec3& corner = soup.positions[soup.faces[i / 3][static_cast<int>(i % 3)]];
    if (is_finite(corner)) corners.push_back(corner);
  }
  return corners;
}

// Returns the box without the outermost hundredth on each side of each axis. `corners` is not empty.
Bounds bulk_of(const std::vector<glm::dvec3>& corners) {
  Bounds bulk;
  std::vector<double> values(corners.size());
  const std::size_t outermost = corners.size() / 100;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < corners.size(); ++i) values[i] = corners[i][axis];
    const auto low = values.begin() + static_cast<std::ptrdiff_t>(outermost);
    const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(outermost);
    std::nth_element(values.begin(), low, values.end());
    bulk.min[axis] = *low;
    std::nth_element(values.begin(), high, values.end());
    bulk.max[axis] = *high;
  }
  return bulk;
}

Bounds finite_bounds(const TriangleSoup& soup) {
  Bounds box;
  for (const glm::uvec3& face : soup.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3& position = soup.positions[face[corner]];
      if (!is_finite(position)) continue;
      box = with(box, position);
    }
  }
  return box;
}

double longest_side(const Bounds& box) {
  const glm::dvec3 extent = box.max - box.min;
  return std::max({extent.x, extent.y, extent.z});
}

glm::dvec3 middle(const Bounds& box) {
  return box.min / 2.0 + box.max / 2.0;
}

// A sentence if the vertices of a PLY file have colours under names that are not read.
std::optional<std::string> unread_colors_warning(const std::filesystem::path& file) {
  constexpr std::array kNames{"r", "g", "b", "red", "green", "blue", "color", "colour", "rgb", "rgba"};
  constexpr std::size_t kMostHeaderBytes = 1 << 16;
  std::string head(kMostHeaderBytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  if (!head.starts_with("ply")) return std::nullopt;
  std::string found;
  try {
    for (const PlyElement& element : parse_ply_header(head, file.string()).elements) {
      if (element.name != "vertex") continue;
      for (const PlyProperty& property : element.properties) {
        std::string name = property.name.substr(property.name.rfind('_') + 1);  // npos + 1 is 0
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        if (std::find(kNames.begin(), kNames.end(), name) == kNames.end()) continue;
        found += (found.empty() ? "" : ", ") + short_reason(property.name);
      }
    }
  } catch (const InputError&) {
    return std::nullopt;  // the reader has taken it: the header is longer than what is looked at
  }
  if (found.empty()) return std::nullopt;
  return file.string() + ": its vertices have colours that are not read, named " + found +
         ": name them red, green and blue";
}

// Known before large faces are split.
double cell_size(const Mesh& mesh, const CellOptions& options, const std::filesystem::path& file) {
  if (options.size > 0) return options.size;
  const double size = automatic_cell_size(mesh);
  if (!(size > 0)) throw InputError(file.string() + ": its faces have no area, so there is nothing to show");
  return size;
}

// `strays`: the warning of faces that may be what cannot be split, if there is one.
Mesh split_for_cells(const Mesh& mesh, double size, const std::filesystem::path& file,
                     const std::optional<std::string>& strays) {
  try {
    return split_large_faces(mesh, size, throw_if_interrupted);
  } catch (const std::invalid_argument& error) {
    std::ostringstream message;
    message << file.string() << ": cannot be cut into cells of size " << size << " (" << error.what()
            << "): give a larger --cell-size";
    if (strays) message << "; " << *strays;
    throw InputError(message.str());
  }
}

// The share of the surface that does not count: where cameras come nearest, their pixels are finer than those of most
// photographs.
constexpr double kNearestShare = 0.05;

SimplificationBound bound_of(const Mesh& mesh, const FaceOptions& faces, std::span<const Camera> cameras) {
  SimplificationBound bound;
  if (faces.faces) {
    bound.faces = *faces.faces;
  } else {
    const double distance = faces.pixels > 0 ? faces.pixels * pixel_size(mesh, cameras, kNearestShare) : 0;
    bound.distance = std::isfinite(distance) ? distance : 0;  // nothing is seen, which others tell
  }
  return bound;
}

void simplify(Mesh& mesh, const SimplificationBound& bound, SurfaceInput& result) {
  SimplifiedMesh fewer = simplified(mesh, bound);
  result.simplified_faces += mesh.faces.size() - fewer.mesh.faces.size();
  result.simplified_distance += fewer.distance;
  mesh = std::move(fewer.mesh);
}

// The surface of a mesh, with cells of options.size, which is not 0 any more.
void cut_into_cells(const Mesh& mesh, const CellOptions& options, const glm::dvec3& offset,
                    const std::optional<std::string>& strays, SurfaceInput& result) {
  const auto surface = std::make_shared<Surface>();
  surface->offset = offset;
  surface->mesh = split_for_cells(mesh, options.size, result.mesh_file, strays);
  result.split_faces = surface->mesh.faces.size() - mesh.faces.size();
  surface->cells = make_cells(surface->mesh, options, throw_if_interrupted);
  result.surface = surface;
}

// Centres and repairs the triangles.
void take_mesh(const TriangleSoup& soup, MeshInput& input) {
  input.offset = scene_origin(soup);
  try {
    RepairedMesh repaired = repair(soup, input.offset, throw_if_interrupted);
    input.mesh = std::move(repaired.mesh);
    input.facts.repair = repaired.report;
  } catch (const InputError& error) {
    throw InputError(input.facts.mesh_file.string() + ": " + error.what());
  }
}

void warn_of_strays(MeshInput& input) {
  input.strays = stray_faces_warning(input.mesh, input.offset, input.facts.mesh_file);
  if (input.strays) input.facts.warnings.push_back(*input.strays);
}

}  // namespace

void check(const FaceOptions& options) {
  if (options.faces == std::size_t{0}) throw std::invalid_argument("faces: faces is 0, must be at least 1");
  if (!(options.pixels >= 0 && std::isfinite(options.pixels))) {
    throw std::invalid_argument("faces: pixels is " + std::to_string(options.pixels) +
                                ", must be finite and not negative");
  }
}

glm::dvec3 scene_origin(const TriangleSoup& soup) {
  const Bounds box = finite_bounds(soup);
  if (box.empty()) return glm::dvec3(0);
  const std::vector<glm::dvec3> corners = sampled_corners(soup);
  if (corners.empty()) return middle(box);
  const Bounds bulk = bulk_of(corners);
  return longest_side(box) > kMostStray * longest_side(bulk) ? middle(bulk) : middle(box);
}

std::optional<std::string> stray_faces_warning(const Mesh& mesh, const glm::dvec3& offset,
                                               const std::filesystem::path& file) {
  constexpr double kFar = 4;  // diameters from the middle of the bulk
  const SceneExtent extent = scene_extent(mesh);
  const glm::dvec3 center = middle(extent.core);
  std::size_t strays = 0;
  glm::dvec3 furthest = center;
  for (const glm::uvec3& face : mesh.faces) {
    bool is_stray = false;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 position(mesh.positions[face[corner]]);
      const double distance = glm::distance(position, center);
      is_stray = is_stray || distance > kFar * extent.diameter;
      if (distance > glm::distance(furthest, center)) furthest = position;
    }
    if (is_stray) ++strays;
  }
  if (strays == 0) return std::nullopt;
  furthest += offset;
  std::ostringstream sentence;
  sentence << file.string() << ": " << strays << " of " << mesh.faces.size() << " faces reach further than " << kFar
           << " times the diameter of the scene, " << extent.diameter << ", from its middle, the furthest to ("
           << furthest.x << ", " << furthest.y << ", " << furthest.z
           << "); cells are sized without them: remove them if they are stray";
  return sentence.str();
}

SoupInput load_soup(const std::filesystem::path& scene, const std::optional<std::filesystem::path>& mesh_file,
                    const MeshFrame& frame) {
  check(frame);
  SoupInput input;
  SurfaceInput& facts = input.facts;
  facts.mesh_file = find_mesh(scene, mesh_file);
  input.soup = read_scene_mesh(facts.mesh_file);
  const TriangleSoup& soup = input.soup;
  facts.file_vertices = soup.positions.size();
  facts.file_faces = soup.faces.size();
  facts.file_has_colors = !soup.colors.empty();
  if (soup.colors.empty()) {
    if (const auto warning = unread_colors_warning(facts.mesh_file)) facts.warnings.push_back(*warning);
  }
  facts.frame = frame;
  facts.coordinate_step = frame.scale * mesh_coordinate_step(soup);
  move_to_frame_of_poses(input.soup, frame);
  return input;
}

MeshInput load_mesh(const std::filesystem::path& scene, const std::optional<std::filesystem::path>& mesh_file,
                    double largest_hole, const MeshFrame& frame) {
  SoupInput read = load_soup(scene, mesh_file, frame);
  MeshInput input;
  input.facts = std::move(read.facts);
  take_mesh(read.soup, input);
  ClosedHoles closed = close_holes(input.mesh, largest_hole, throw_if_interrupted);
  input.facts.closed_holes = closed.holes;
  input.mesh = std::move(closed.mesh);
  warn_of_strays(input);
  return input;
}

MeshInput mesh_input_of(const TriangleSoup& soup, const std::filesystem::path& name) {
  MeshInput input;
  SurfaceInput& facts = input.facts;
  facts.mesh_file = name;
  facts.file_vertices = soup.positions.size();
  facts.file_faces = soup.faces.size();
  facts.file_has_colors = !soup.colors.empty();
  facts.coordinate_step = mesh_coordinate_step(soup);
  take_mesh(soup, input);
  warn_of_strays(input);
  return input;
}

SurfaceInput make_surface(MeshInput input, CellOptions cells, const FaceOptions& faces,
                          std::span<const Camera> cameras) {
  check(cells);
  check(faces);
  SurfaceInput result = std::move(input.facts);
  cells.size = cell_size(input.mesh, cells, result.mesh_file);
  simplify(input.mesh, bound_of(input.mesh, faces, cameras), result);
  cut_into_cells(input.mesh, cells, input.offset, input.strays, result);
  return result;
}

SurfaceInput with_fewer_faces(const SurfaceInput& input, CellOptions cells, const FaceOptions& faces,
                              std::span<const Camera> cameras) {
  check(faces);
  check(cells);
  if (cells.size == 0) cells.size = input.surface->cells.size;
  Mesh mesh = near_surface(*input.surface).mesh;
  const FarSphere far = far_sphere_of(*input.surface);
  SurfaceInput result = input;
  simplify(mesh, bound_of(mesh, faces, cameras), result);
  result.simplified_faces -= std::min(result.simplified_faces, input.split_faces);  // which did not come with the file
  cut_into_cells(mesh, cells, input.surface->offset, std::nullopt, result);
  if (!far.mesh.faces.empty()) result.surface = std::make_shared<const Surface>(with_far_sphere(*result.surface, far));
  return result;
}

SurfaceInput load_surface(const std::filesystem::path& scene, const std::optional<std::filesystem::path>& mesh_file,
                          CellOptions options, const MeshFrame& frame) {
  check(options);
  return make_surface(load_mesh(scene, mesh_file, 0, frame), options);
}

}  // namespace lumatlas
