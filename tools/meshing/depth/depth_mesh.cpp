// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/depth_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "mesh/repair/decimation.h"
#include "mesh/repair/repair.h"
#include "tools/meshing/cut/small_pieces.h"
#include "tools/meshing/depth/depth_agreement.h"
#include "tools/meshing/depth/depth_fusion.h"
#include "tools/meshing/depth/scene_depth.h"
#include "tools/meshing/length_text.h"

namespace lumatlas {
namespace {

// Width of a voxel in pixels of a depth image at the middle depth. Smaller ones would fall between measurements.
constexpr double kVoxelPixels = 1.5;
// A sensor's noise at a few metres is two or three of its pixels there.
constexpr double kTruncationVoxels = 4;
constexpr std::size_t kSamples = 200'000;
constexpr std::size_t kFewestFaces = 100;  // fewest faces of a piece that is not taken for noise

double median_of(std::vector<double> values) {
  return upper_median(values);
}

// Moves all near the origin, into the axes of the grid. Returns what was subtracted.
glm::dvec3 centre(SceneViews& scene) {
  glm::dvec3 offset;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const SceneDepth& depth : scene.depths) values.push_back(depth.camera.center()[axis]);
    offset[axis] = median_of(std::move(values));
  }
  const auto move = [&](Camera& camera) {
    camera.cam_from_world_translation += camera.cam_from_world_rotation * offset;
    camera.cam_from_world_rotation *= glm::transpose(grid_from_scene());
  };
  for (SceneDepth& depth : scene.depths) move(depth.camera);
  for (SceneView& view : scene.views) move(view.camera);
  return offset;
}

double spread(const std::vector<SceneDepth>& depths) {
  double farthest = 0;
  for (const SceneDepth& depth : depths) farthest = std::max(farthest, glm::length(depth.camera.center()));
  return farthest;
}

// Returns the confirmed share of the samples that nothing hides from another image; 1 if there are none.
double confirmed_share(const DepthAgreement& agreement) {
  const std::size_t in_sight = agreement.confirmed + agreement.seen_through;
  return in_sight == 0 ? 1 : static_cast<double>(agreement.confirmed) / static_cast<double>(in_sight);
}

std::string unit_advice(const SceneDepth& first) {
  return "is a step of " + first.file.filename().string() + " " + number_text(first.unit) +
         " units of the poses? --depth-unit says what it is";
}

// Returns the evidence that the unit or the poses cannot be right; empty: there is none.
std::string contradiction(const SceneViews& scene, const DepthSamples& samples, const DepthAgreement& agreement) {
  constexpr double kAbsurdDistance = 300;  // in distances between cameras: no pixel would move from one to the other
  constexpr double kHardlyAny = 0.05;
  constexpr std::size_t kEnoughToTell = 200;
  const double width = spread(scene.depths), depth = median_of(samples.depth);
  const std::string where = scene.root.string() + ": ";
  if (width > 0 && depth > kAbsurdDistance * width) {
    return where + "its depth images see surfaces " + number_text(depth, 3) + " away, but all were taken within " +
           number_text(width, 3) + " of one place: " + unit_advice(scene.depths.front());
  }
  const double share = static_cast<double>(agreement.confirmed) / static_cast<double>(agreement.compared());
  if (agreement.compared() >= kEnoughToTell && share < kHardlyAny) {
    return where + "only " + percent_text(share) +
           " of the depths in the view of another depth image are confirmed by it: " +
           unit_advice(scene.depths.front()) + "; or the poses are wrong";
  }
  return {};
}

// Below which a voxel says nothing: a few images' worth where many overlap, a glance where only one saw it.
double least_weight(const DepthSamples& samples, const DepthAgreement& agreement, std::size_t images) {
  constexpr double kGlance = 0.02, kShareOfUsual = 0.02;
  const double compared = std::min<double>(static_cast<double>(samples.positions.size()), 20'000);
  const double looked_through = std::min<double>(static_cast<double>(images), kMostAgreementImages);
  const double overlap = static_cast<double>(agreement.confirmed) / std::max(1.0, compared) *
                         (static_cast<double>(images) / looked_through);
  const double far = percentile(samples.depth, 0.9);
  return std::max(kGlance, kShareOfUsual * overlap) / (far * far);
}

FusionOptions fusion_options(const SceneMeshOptions& options, const DepthSamples& samples,
                             const DepthAgreement& agreement, std::size_t images) {
  FusionOptions fusion;
  fusion.voxel = options.voxel.value_or(kVoxelPixels * median_of(samples.pixel_width));
  fusion.truncation = kTruncationVoxels * fusion.voxel;
  fusion.least_weight = least_weight(samples, agreement, images);
  fusion.max_blocks = std::size_t{1} << 16U;  // 256 MiB, and some ten times as much for the faces that may come of it
  fusion.may_enlarge = !options.voxel;
  return fusion;
}

// Returns points that the nearest photograph has seen, by which their distance from the surface is measured in pixels.
ScenePoints points_of(const DepthSamples& samples, const SceneViews& scene) {
  std::vector<std::uint32_t> nearest_view;
  for (const SceneDepth& depth : scene.depths) {
    const glm::dvec3 center = depth.camera.center();
    const auto nearer = [&](const SceneView& a, const SceneView& b) {
      return glm::distance(a.camera.center(), center) < glm::distance(b.camera.center(), center);
    };
    const auto nearest = std::min_element(scene.views.begin(), scene.views.end(), nearer);
    nearest_view.push_back(static_cast<std::uint32_t>(nearest - scene.views.begin()));
  }
  ScenePoints points;
  points.positions = samples.positions;
  for (const std::uint32_t image : samples.image) points.views.push_back({nearest_view[image]});
  return points;
}

std::vector<std::string> warnings_of(const SurfaceTrust& trust, const std::vector<std::string>& names,
                                     const DepthAgreement& agreement) {
  constexpr double kMuchSeenThrough = 0.3, kFewOnSurface = 0.5;
  std::vector<std::string> warnings;
  if (std::string empty = coverage_warning(trust, names, "depths"); !empty.empty())
    warnings.push_back(std::move(empty));
  const double through = 1 - confirmed_share(agreement);
  if (through > kMuchSeenThrough) {
    warnings.push_back("depth images look through " + percent_text(through) +
                       " of what others measured: the poses, the unit or the depths are inexact");
  }
  if (trust.points_on_surface < kFewOnSurface) {
    warnings.push_back("only " + percent_text(trust.points_on_surface) +
                       " of the depths lie on the mesh: they are noisy, or its voxels are coarse");
  }
  return warnings;
}

TriangleSoup soup_of(const Mesh& mesh, const glm::dvec3& offset) {
  TriangleSoup soup;
  soup.faces = mesh.faces;
  const glm::dmat3 scene_from_grid = glm::transpose(grid_from_scene());
  for (const glm::vec3& position : mesh.positions) {
    soup.positions.push_back(scene_from_grid * glm::dvec3(position) + offset);
  }
  return soup;
}

std::string why_nothing_is_measured(const std::vector<SceneDepth>& depths) {
  std::size_t above_zero = 0;
  for (const SceneDepth& depth : depths) above_zero += pixels_above_zero(depth);
  if (above_zero == 0) return "has measured anything, all of their pixels are 0";
  return "shows a surface: " + std::to_string(above_zero) +
         " of their pixels are above 0, but none has a measured neighbour beside it and one above or below it at a "
         "depth like its own";
}

class DepthMesher {
 public:
  DepthMesher(SceneViews scene, const SceneMeshOptions& options, const StageProgress& progress)
      : scene_(std::move(scene)), options_(options), progress_(progress), offset_(centre(scene_)) {
    if (!options.depth_unit) return;
    for (SceneDepth& depth : scene_.depths) depth.unit = *options.depth_unit;
  }

  SceneMesh make() {
    look_at_depths();
    const Mesh mesh = fuse();
    result_.surface = soup_of(mesh, offset_);
    judge(mesh);
    return std::move(result_);
  }

 private:
  [[nodiscard]] DepthSource source() const {
    return [this](std::size_t index) { return read_depth(scene_.depths[index]); };
  }

  void look_at_depths() {
    const std::size_t count = scene_.depths.size();
    const auto tick = progress_("looking at depth images", count + std::min(count, kMostAgreementImages));
    samples_ = sample_depths(count, source(), kSamples, tick);
    if (samples_.positions.empty()) {
      throw InputError(scene_.depths.front().file.string() + ": neither it nor another of the " +
                       std::to_string(count) + " depth images " + why_nothing_is_measured(scene_.depths));
    }
    agreement_ = depth_agreement(samples_, count, source(), tick);
    const std::string broken = contradiction(scene_, samples_, agreement_);
    if (broken.empty()) return;
    if (!options_.depth_unit) throw InputError(broken);
    result_.warnings.push_back(broken);
  }

  FusedSurface fused_surface() {
    const FusionOptions fusion = fusion_options(options_, samples_, agreement_, scene_.depths.size());
    const auto tick = progress_("fusing depth images", 2 * scene_.depths.size());
    try {
      return fused(scene_.depths.size(), source(), fusion, tick);
    } catch (const std::invalid_argument& error) {
      throw InputError(scene_.root.string() + ": " + error.what());
    } catch (const InputError& error) {
      if (fusion.may_enlarge) throw;
      throw InputError("--voxel: " + std::string(error.what()));
    }
  }

  Mesh fuse() {
    FusedSurface fusion = fused_surface();
    const RemovedPieces removed = remove_small_pieces(fusion.surface, kFewestFaces);
    if (fusion.surface.faces.empty()) {
      throw InputError(scene_.root.string() + ": its " + std::to_string(scene_.depths.size()) +
                       " depth images make no surface in voxels of " + length_text(fusion.voxel) +
                       " scene units: name another size with --voxel");
    }
    const double footprint = median_of(samples_.pixel_width);
    result_.depth =
        DepthFacts{scene_.depths.size(),       samples_.measured,           fusion.voxel,   fusion.truncation,
                   fusion.voxel / footprint,   confirmed_share(agreement_), removed.pieces, removed.faces,
                   fusion.surface.faces.size()};
    const auto tick = progress_("simplifying the mesh", 1);
    Mesh mesh = repair(fusion.surface, glm::dvec3(0)).mesh;
    if (mesh.faces.size() > options_.most_faces) mesh = decimated(mesh, options_.most_faces);
    tick(1);
    return mesh;
  }

  void judge(const Mesh& mesh) {
    std::vector<Camera> cameras;
    std::vector<std::string> names;
    for (const SceneView& view : scene_.views) {
      cameras.push_back(view.camera);
      names.push_back(view.name);
    }
    const auto tick = progress_("looking at the mesh", std::min(cameras.size(), kMostTrustViews));
    result_.views = cameras.size();
    result_.trust = surface_trust(mesh, points_of(samples_, scene_), cameras, [&] { tick(1); });
    for (std::string& warning : warnings_of(result_.trust, names, agreement_))
      result_.warnings.push_back(std::move(warning));
  }

  SceneViews scene_;
  const SceneMeshOptions& options_;
  const StageProgress& progress_;
  glm::dvec3 offset_;
  DepthSamples samples_;
  DepthAgreement agreement_;
  SceneMesh result_;
};

}  // namespace

SceneMesh mesh_from_depths(SceneViews scene, const SceneMeshOptions& options, const StageProgress& progress) {
  return DepthMesher(std::move(scene), options, progress).make();
}

}  // namespace lumatlas
