// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/scene_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "mesh/finite.h"
#include "mesh/repair/repair.h"
#include "tools/meshing/cut/smoothing.h"
#include "tools/meshing/cut/thinning.h"
#include "tools/meshing/depth/depth_mesh.h"
#include "tools/meshing/estimated_views.h"
#include "tools/meshing/mesh_completion.h"
#include "tools/meshing/photograph_mesh.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {
namespace {

// In median longest edges.
constexpr double kLongestEdge = 20, kLongestEdgeOfPhotographs = 30;

void check_field(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(std::string(field) + ": " + number_text(value) + ", must be in [" + number_text(least) +
                              ", " + number_text(most) + "]");
}

std::vector<glm::dvec3> finite(std::vector<glm::dvec3> positions) {
  std::erase_if(positions, [](const glm::dvec3& position) { return !is_finite(position); });
  return positions;
}

// The middle point by each coordinate: far outliers do not move it. The origin if there are none.
glm::dvec3 median_position(const std::vector<glm::dvec3>& positions) {
  glm::dvec3 result(0);
  if (positions.empty()) return result;
  std::vector<double> values(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(positions.begin(), positions.end(), values.begin(), [&](const glm::dvec3& p) { return p[axis]; });
    result[axis] = upper_median(values);
  }
  return result;
}

std::vector<Camera> cameras_of(const SceneViews& scene) {
  std::vector<Camera> cameras;
  cameras.reserve(scene.views.size());
  for (const SceneView& view : scene.views) cameras.push_back(view.camera);
  return cameras;
}

std::vector<std::string> names_of(const SceneViews& scene) {
  std::vector<std::string> names;
  for (const SceneView& view : scene.views) names.push_back(view.name);
  return names;
}

double longest_edge(const std::vector<glm::dvec3>& positions, const glm::uvec3& face) {
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    longest = std::max(longest, glm::distance(positions[face[i]], positions[face[(i + 1) % 3]]));
  }
  return longest;
}

// Only vertices that faces use, in the order of the points.
TriangleSoup surface_of(const ScenePoints& points, const std::vector<glm::uvec3>& faces, const glm::dvec3& offset) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> vertex_of(points.positions.size(), kUnused);
  for (const glm::uvec3& face : faces) {
    for (int i = 0; i < 3; ++i) vertex_of[face[i]] = 0;
  }
  TriangleSoup surface;
  std::vector<float> deviations;
  for (std::size_t i = 0; i < vertex_of.size(); ++i) {
    if (vertex_of[i] == kUnused) continue;
    vertex_of[i] = static_cast<std::uint32_t>(surface.positions.size());
    surface.positions.push_back(points.positions[i] + offset);
    if (!points.deviations.empty()) deviations.push_back(points.deviations[i]);
    if (!points.colors.empty()) surface.colors.push_back(points.colors[i]);
  }
  for (const glm::uvec3& face : faces) {
    surface.faces.emplace_back(vertex_of[face[0]], vertex_of[face[1]], vertex_of[face[2]]);
  }
  if (!deviations.empty()) smooth(surface, deviations);
  return surface;
}

std::vector<glm::dvec3> centers_of(const std::vector<Camera>& views) {
  std::vector<glm::dvec3> centers;
  centers.reserve(views.size());
  for (const Camera& view : views) centers.push_back(view.center());
  return centers;
}

void leave_out_long_faces(const std::vector<glm::dvec3>& positions, double longest, std::vector<glm::uvec3>& faces) {
  if (faces.empty()) return;
  std::vector<double> lengths;
  lengths.reserve(faces.size());
  for (const glm::uvec3& face : faces) lengths.push_back(longest_edge(positions, face));
  const double most = longest * upper_median(lengths);
  std::erase_if(faces, [&](const glm::uvec3& face) { return longest_edge(positions, face) > most; });
}

// Thinned to the spacing, or to a wider one at which no more than most_points are left.
ScenePoints thinned_to_fit(const ScenePoints& points, std::span<const Camera> views, const SceneMeshOptions& options,
                           double& spacing_px) {
  ScenePoints result = thinned(points, views, spacing_px);
  while (result.positions.size() > options.most_points) {
    spacing_px = std::max(1.0, spacing_px * 1.3);
    result = thinned(points, views, spacing_px);
  }
  return result;
}

std::vector<std::string> warnings_of(const SurfaceTrust& trust, const std::vector<std::string>& names) {
  constexpr double kMuchGuessed = 0.4, kFewOnSurface = 0.5;
  std::vector<std::string> warnings;
  if (std::string empty = coverage_warning(trust, names, "points"); !empty.empty())
    warnings.push_back(std::move(empty));
  if (trust.pixels_guessed > kMuchGuessed) {
    warnings.push_back(percent_text(trust.pixels_guessed) +
                       " of what photographs see of the mesh is far from every point and a guess: take more "
                       "photographs, or give denser points (--points)");
  }
  if (trust.points_on_surface < kFewOnSurface) {
    warnings.push_back("only " + percent_text(trust.points_on_surface) +
                       " of the points lie on the mesh: they are noisy, or many are wrong");
  }
  return warnings;
}

void estimate_views(ScenePoints& points, const std::vector<Camera>& views, const StageProgress& progress) {
  const auto tick = progress("finding the views of the points", views.size());
  points.views = estimated_views(points.positions, points.normals, views, [&] { tick(1); });
}

std::vector<glm::uvec3> faces_between(const ScenePoints& points, const std::vector<Camera>& views,
                                      const SceneMeshOptions& options, const StageProgress& progress) {
  const auto tick = progress("following lines of sight", points.positions.size());
  std::vector<glm::uvec3> faces =
      cut_surface(points.positions, points.views, points.deviations, centers_of(views), options.cut, tick);
  const double usual = points.deviations.empty() ? kLongestEdge : kLongestEdgeOfPhotographs;
  leave_out_long_faces(points.positions, options.longest_edge.value_or(usual), faces);
  return faces;
}

SurfaceTrust trust_of(const TriangleSoup& surface, const glm::dvec3& offset, const ScenePoints& points,
                      const std::vector<Camera>& views, const StageProgress& progress) {
  const auto tick = progress("looking at the mesh", std::min(views.size(), kMostTrustViews));
  return surface_trust(repair(surface, offset).mesh, points, views, [&] { tick(1); });
}

// Its views, if it may have depth images: COLMAP's models have none, and are read in the frame of their points.
std::optional<SceneViews> views_with_depths(const std::filesystem::path& scene, const SceneMeshOptions& options) {
  const std::vector<CaptureForm> forms = forms_in(scene);
  if (forms.empty() || !forms.front().read) return std::nullopt;
  SceneViews views = read_scene_views(scene, glm::dvec3(0), options.pictures);
  return views.depths.empty() ? std::nullopt : std::optional(std::move(views));
}

MeshSource best_source(const std::filesystem::path& scene, const SceneMeshOptions& options, bool has_depths) {
  if (options.from) return *options.from;
  if (options.points) return MeshSource::points;
  if (has_depths) return MeshSource::depth_images;
  return has_dense_points(scene) ? MeshSource::points : MeshSource::photographs;
}

}  // namespace

std::string name_of(MeshSource source) {
  if (source == MeshSource::depth_images) return "depth images";
  return source == MeshSource::points ? "points" : "photographs";
}

void check(const SceneMeshOptions& options) {
  check(options.complete_frame);
  check_field("spacing_px", options.spacing_px, 0, 1000);
  if (options.most_points < 4) {
    throw std::invalid_argument("most_points: " + std::to_string(options.most_points) + ", must be 4 or more");
  }
  if (options.longest_edge) check_field("longest_edge", *options.longest_edge, 1, 1e6);
  for (const auto& [field, value] : {std::pair("voxel", options.voxel), std::pair("depth_unit", options.depth_unit)}) {
    if (value) check_field(field, *value, 1e-9, 1e9);
  }
  if (options.most_faces < 100) {
    throw std::invalid_argument("most_faces: " + std::to_string(options.most_faces) + ", must be 100 or more");
  }
  check_field("block_px", options.block_px, 1, 64);
  if (options.most_photographs < 2) {
    throw std::invalid_argument("most_photographs: " + std::to_string(options.most_photographs) +
                                ", must be 2 or more");
  }
  check(options.cut);
  check(options.stereo);
  if (options.hold_out) check(*options.hold_out);
}

std::string coverage_warning(const SurfaceTrust& trust, const std::vector<std::string>& names,
                             const std::string& lacking) {
  constexpr double kLittleCovered = 0.5, kManyFrames = 0.1;
  if (trust.pixels_covered >= kLittleCovered && trust.frames_mostly_empty < kManyFrames) return "";
  const std::string share = percent_text(trust.frames_mostly_empty);
  std::string sentence = "the mesh covers only " + percent_text(trust.pixels_covered) + " of the photographs' pixels";
  if (trust.frames_mostly_empty > 0) sentence += ", and less than half of " + share + " of the photographs";
  if (trust.emptiest_view < names.size()) {
    sentence += ", least of " + names[trust.emptiest_view] + " (" + percent_text(trust.emptiest_covered) + ")";
  }
  return sentence + ": the rest stays empty, for lack of " + lacking + " there";
}

SceneMesh mesh_from_points(ScenePoints points, const SceneViews& scene, const SceneMeshOptions& options,
                           const StageProgress& progress) {
  const glm::dvec3 offset = median_position(points.positions);
  for (glm::dvec3& position : points.positions) position -= offset;
  std::vector<Camera> views = cameras_of(scene);
  for (Camera& view : views) view.cam_from_world_translation += view.cam_from_world_rotation * offset;
  SceneMesh result;
  result.points_file = points.file;
  result.points = points.positions.size();
  result.views = views.size();
  result.views_estimated =
      std::all_of(points.views.begin(), points.views.end(), [](const auto& list) { return list.empty(); });
  if (result.views_estimated) estimate_views(points, views, progress);
  result.spacing_px = options.spacing_px;
  const ScenePoints used = thinned_to_fit(points, views, options, result.spacing_px);
  result.points_used = used.positions.size();
  const std::vector<glm::uvec3> faces = faces_between(used, views, options, progress);
  if (faces.empty()) {
    throw InputError(points.file.string() + ": its " + std::to_string(result.points) + " points make no surface; " +
                     std::to_string(result.points_used) +
                     " are left of those that some view saw, at least some hundred must be, and not in one plane");
  }
  result.surface = surface_of(used, faces, offset);
  result.trust = trust_of(result.surface, offset, points, views, progress);
  result.warnings = warnings_of(result.trust, names_of(scene));
  return result;
}

namespace {

SceneMesh mesh_of_scene(const std::filesystem::path& scene, const SceneMeshOptions& options,
                        const StageProgress& progress, const std::function<void(MeshSource)>& chosen) {
  std::optional<SceneViews> with_depths = views_with_depths(scene, options);
  const MeshSource source = best_source(scene, options, with_depths.has_value());
  if (chosen) chosen(source);
  if (source == MeshSource::points) {
    return mesh_from_points(read_scene_points(scene, options.points),
                            read_scene_views(scene, glm::dvec3(0), options.pictures), options, progress);
  }
  if (source == MeshSource::photographs) {
    return mesh_from_photographs(read_scene_views(scene, glm::dvec3(0), options.pictures),
                                 find_scene_points(scene, options.points).value_or(ScenePoints{}), options, progress);
  }
  if (!with_depths) throw InputError(scene.string() + ": has no depth images to make a mesh of");
  SceneMesh made = mesh_from_depths(*std::move(with_depths), options, progress);
  made.source = MeshSource::depth_images;
  return made;
}

// Throws InputError naming the file if no face of the mesh can be used.
void require_faces(const TriangleSoup& mesh, const std::filesystem::path& file, const glm::dvec3& offset) {
  try {
    (void)repair(mesh, offset);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
}

// The cameras whose pixels decide what is added, less the offset: all but those of held-out photographs.
std::vector<Camera> cameras_to_complete(const std::filesystem::path& scene, const glm::dvec3& offset,
                                        const SceneMeshOptions& options) {
  const SceneViews views = read_scene_views(scene, offset, options.pictures);
  std::vector<Camera> cameras;
  for (const std::size_t rank : split(views, options.hold_out).input) {
    cameras.push_back(views.views[rank].camera);
  }
  return cameras;
}

void complete(const std::filesystem::path& scene, const TriangleSoup& given, const glm::dvec3& offset,
              const SceneMeshOptions& options, const StageProgress& progress, SceneMesh& made) {
  const std::vector<Camera> views = cameras_to_complete(scene, offset, options);
  const auto tick = progress("looking for what the mesh lacks", views.size());
  CompletedMesh both = completed(given, made.surface, views, offset, [&] { tick(1); });
  made.surface = std::move(both.surface);
  made.trust.pixels_covered = both.covered;
  made.warnings.clear();  // they are about the part that was made, which need not cover what is there already
  made.completion = CompletionFacts{*options.complete, both.added_faces, both.covered_before, both.covered};
}

}  // namespace

SceneMesh mesh_from_scene(const std::filesystem::path& scene, const SceneMeshOptions& options,
                          const StageProgress& progress, const std::function<void(MeshSource)>& chosen) {
  check(options);
  if (!options.complete) return mesh_of_scene(scene, options, progress, chosen);
  // The file is read first: a fault in it is told before the long work.
  TriangleSoup given = read_scene_mesh(*options.complete);
  move_to_frame_of_poses(given, options.complete_frame);
  const glm::dvec3 offset = median_position(finite(given.positions));
  require_faces(given, *options.complete, offset);
  SceneMesh made = mesh_of_scene(scene, options, progress, chosen);
  complete(scene, given, offset, options, progress, made);
  return made;
}

}  // namespace lumatlas
