// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/completed_surface.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/temporary_entry.h"
#include "mesh/repair/repair.h"
#include "tools/base/interrupt.h"
#include "tools/meshing/mesh_completion.h"
#include "tools/meshing/photograph_mesh.h"
#include "tools/pipeline/surface/far_background.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

namespace {

constexpr double kLittleLacking = 0.01;    // share of all pixels below which nothing is added
constexpr double kLackingInView = 0.005;   // share of a view's pixels from which its photograph is matched
constexpr std::size_t kMostMatched = 100;  // photographs
constexpr std::uint32_t kMatchedPx = 256;  // longer side: a third of the time of 512, and nearly the same surface
constexpr double kAddedLongestEdge = 60;   // longest edge of an added face, in medians: faces have to close holes

std::vector<Camera> completion_cameras(const SceneViews& views, const std::vector<std::size_t>& ranks) {
  std::vector<Camera> cameras;
  cameras.reserve(ranks.size());
  for (const std::size_t rank : ranks) cameras.push_back(views.views[rank].camera);
  return cameras;
}

// What views see of a mesh, and of what is far past it.
struct Outlook {
  FarSphere far;
  std::vector<double> lacking;  // by camera: share of its pixels that see neither, masks left out of account
  FrameShares shares;           // of the photographs' valid pixels
};

void add_shares(const std::vector<SmallPhotograph>& photographs, const Visibility& visibility, const Visibility* far,
                FrameShares& shares) {
  double surface = 0, beyond = 0, pixels = 0;
  for (const SmallPhotograph& photograph : photographs) {
    const FrameShare share = frame_share(photograph.camera, visibility, far, photograph.valid);
    const auto count = static_cast<double>(share.pixels);
    surface += count * share.surface;
    beyond += count * share.far;
    pixels += count;
  }
  if (pixels > 0) shares = {surface / pixels, 0, beyond / pixels};
}

Outlook outlook_of(const std::vector<SmallPhotograph>& photographs, const std::vector<Camera>& cameras,
                   const Mesh& mesh, bool far_sphere) {
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(mesh);
  Outlook result;
  if (far_sphere) result.far = find_far_sphere(photographs, cameras, mesh, *visibility);
  std::unique_ptr<Visibility> far;
  if (!result.far.mesh.faces.empty()) far = make_ray_visibility(result.far.mesh);
  for (const Camera& camera : cameras) {
    throw_if_interrupted();
    const FrameShare share = frame_share(camera, *visibility, far.get());
    result.lacking.push_back(1 - share.surface - share.far);
  }
  add_shares(photographs, *visibility, far.get(), result.shares);
  return result;
}

// The ranks of the views that lack most, ascending; none where the mesh lacks too little.
std::vector<std::size_t> lacking_ranks(const Outlook& seen, const std::vector<std::size_t>& ranks) {
  if (1 - seen.shares.surface - seen.shares.far <= kLittleLacking) return {};
  std::vector<std::pair<double, std::size_t>> lacking;
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (seen.lacking[i] >= kLackingInView) lacking.emplace_back(-seen.lacking[i], ranks[i]);
  }
  std::sort(lacking.begin(), lacking.end());
  lacking.resize(std::min(lacking.size(), kMostMatched));
  std::vector<std::size_t> result;
  if (lacking.size() < 2) return result;  // a photograph is matched with others
  result.reserve(lacking.size());
  for (const auto& [share, rank] : lacking) result.push_back(rank);
  std::sort(result.begin(), result.end());
  return result;
}

TriangleSoup soup_of(const Mesh& mesh) {
  return {{mesh.positions.begin(), mesh.positions.end()}, mesh.colors, mesh.faces};
}

// Reads the points of the scene, in the frame of the mesh. Returns none where they cannot be read: they only help.
ScenePoints points_around(const std::filesystem::path& scene, const glm::dvec3& offset) {
  try {
    ScenePoints points = find_scene_points(scene, std::nullopt).value_or(ScenePoints{});
    for (glm::dvec3& position : points.positions) position -= offset;
    return points;
  } catch (const InputError&) {
    return {};
  }
}

// Shows the photographs' matching, which takes nearly all of the time and is reported on the caller's thread, until the
// next stage begins.
StageProgress shown_by(const BuildCallback& callback, std::optional<BuildStage>& stage) {
  return [&](const std::string& name, std::size_t steps) -> std::function<void(std::size_t)> {
    if (stage) stage->finish();
    stage.reset();
    if (name != kMatchingStage) return [](std::size_t) { throw_if_interrupted(); };
    stage.emplace(callback, "finding what the mesh lacks", steps);
    return [&](std::size_t done) {
      throw_if_interrupted();
      for (std::size_t i = 0; i < done; ++i) stage->tick();
    };
  };
}

// Makes a mesh of what the views of these ranks show.
TriangleSoup surface_of_photographs(const SceneViews& views, const std::vector<std::size_t>& ranks,
                                    const ScenePoints& points, const std::filesystem::path& folder,
                                    const BuildCallback& callback) {
  SceneViews some;
  some.root = views.root;
  for (const std::size_t rank : ranks) some.views.push_back(views.views[rank]);
  SceneMeshOptions options;
  options.stereo.longest_px = kMatchedPx;
  options.longest_edge = kAddedLongestEdge;
  options.stereo_folder = folder;
  std::optional<BuildStage> stage;
  try {
    return mesh_from_photographs(std::move(some), points_of_views(points, ranks), options, shown_by(callback, stage))
        .surface;
  } catch (const InputError&) {
    if (stage) stage->finish();
    throw;
  }
}

// Adds what the views `matched` show, of those of `ranks`, and the mesh lacks; returns the number of faces.
std::size_t add_surface(const std::filesystem::path& scene, const SceneViews& views,
                        const std::vector<std::size_t>& matched, const std::vector<Camera>& cameras,
                        const std::filesystem::path& folder, const BuildCallback& callback, MeshInput& mesh) {
  const ScenePoints points = points_around(scene, mesh.offset);
  const TriangleSoup other = surface_of_photographs(views, matched, points, folder, callback);
  BuildStage stage(callback, "adding what the mesh lacks", 0);
  const CompletedMesh both =
      completed(soup_of(mesh.mesh), other, cameras, glm::dvec3(0), [] { throw_if_interrupted(); });
  if (both.added_faces > 0) mesh.mesh = repair(both.surface, glm::dvec3(0), throw_if_interrupted).mesh;
  stage.finish();
  return both.added_faces;
}

}  // namespace

std::string filled_frames_warning(const FrameShares& shares) {
  constexpr double kMuchFilled = 0.25;
  const double filled = 1 - shares.surface - shares.added - shares.far;
  if (filled <= kMuchFilled) return {};
  return percent_text(filled) +
         " of the photographs' pixels see no surface, so that pictures are filled from their surroundings there: take "
         "more photographs that show the same, give a mesh of more of the scene (--mesh), or leave out --mesh-as-given";
}

std::filesystem::path stereo_folder_of(const std::filesystem::path& output) {
  std::filesystem::path folder = output.lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  folder += ".stereo";
  return folder;
}

CompletionPlan plan_completion(const SceneViews& views, const std::vector<std::size_t>& ranks, const Mesh& mesh) {
  const std::vector<Camera> cameras = completion_cameras(views, ranks);
  const Outlook seen = outlook_of(small_photographs(views.views, ranks), cameras, mesh, true);
  return {seen.shares, lacking_ranks(seen, ranks).size()};
}

nlohmann::json frames_json(const SceneViews& views, const Mesh& mesh) {
  std::vector<std::size_t> ranks(views.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  leave_out_bad(views, ranks);
  const CompletionPlan plan = plan_completion(views, ranks, mesh);
  return {{"surface", plan.shares.surface},
          {"far", plan.shares.far},
          {"lacking", std::max(0.0, 1 - plan.shares.surface - plan.shares.far)},
          {"to_match", plan.to_match}};
}

CompletedSurface complete_surface(const std::filesystem::path& scene, const SceneViews& views,
                                  const std::vector<std::size_t>& ranks, const CompletionOptions& options,
                                  const BuildCallback& callback, MeshInput& mesh) {
  BuildStage stage(callback, "looking past the mesh", 0);
  const std::vector<Camera> cameras = completion_cameras(views, ranks);
  const std::vector<SmallPhotograph> photographs = small_photographs(views.views, ranks);
  Outlook seen = outlook_of(photographs, cameras, mesh.mesh, options.far_sphere);
  stage.finish();
  CompletedSurface result;
  result.shares = seen.shares;
  const std::vector<std::size_t> to_match = lacking_ranks(seen, ranks);
  if (options.surface && !to_match.empty()) {
    std::optional<TemporaryEntry> temporary;
    if (options.stereo_folder.empty()) {
      temporary.emplace(TemporaryEntry::Kind::folder, std::filesystem::temp_directory_path(),
                        [] { return random_temporary_name(); });
    }
    try {
      result.added_faces = add_surface(scene, views, to_match, cameras,
                                       temporary ? temporary->path() : options.stereo_folder, callback, mesh);
      result.matched = to_match.size();
    } catch (const InputError& error) {
      result.failure = std::string("the mesh is taken as it is, though photographs show more: ") + error.what();
    }
  }
  if (result.added_faces > 0) {
    const double given = seen.shares.surface;
    seen = outlook_of(photographs, cameras, mesh.mesh, options.far_sphere);
    result.shares = {given, std::max(seen.shares.surface - given, 0.0), seen.shares.far};
  }
  result.far = std::move(seen.far);
  return result;
}

}  // namespace lumatlas
