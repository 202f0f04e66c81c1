// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/completed_surface.h"

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
#include "mesh/repair.h"
#include "tools/base/interrupt.h"
#include "tools/meshing/mesh_completion.h"
#include "tools/meshing/photograph_mesh.h"
#include "tools/pipeline/completion_gain.h"
#include "tools/pipeline/far_background.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

namespace {

constexpr double kLittleLacking = 0.01;    // share of all pixels below which nothing is added
constexpr double kLeastGain = 0.6;         // dB that added surface must be able to bring, for its time
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
  std::unique_ptr<Visibility> surface, beyond;  // of the mesh and of the far sphere, null if there is none
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
  Outlook result;
  result.surface = make_ray_visibility(mesh);
  if (far_sphere) result.far = find_far_sphere(photographs, cameras, mesh, *result.surface);
  if (!result.far.mesh.faces.empty()) result.beyond = make_ray_visibility(result.far.mesh);
  for (const Camera& camera : cameras) {
    throw_if_interrupted();
    const FrameShare share = frame_share(camera, *result.surface, result.beyond.get());
    result.lacking.push_back(1 - share.surface - share.far);
  }
  add_shares(photographs, *result.surface, result.beyond.get(), result.shares);
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

// What is to be matched, and what that can bring.
struct MatchingPlan {
  std::vector<std::size_t> ranks;         // ascending; empty: nothing is worth it
  std::optional<double> largest_gain_db;  // none: the mesh lacks too little, or photographs cannot be compared
};

MatchingPlan plan_matching(const Outlook& seen, const std::vector<SmallPhotograph>& photographs,
                           const std::vector<std::size_t>& ranks) {
  MatchingPlan plan{lacking_ranks(seen, ranks), std::nullopt};
  if (plan.ranks.empty()) return plan;
  plan.largest_gain_db = largest_gain_db(photographs, *seen.surface, seen.beyond.get());
  if (plan.largest_gain_db && *plan.largest_gain_db < kLeastGain) plan.ranks.clear();
  return plan;
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

// What a mesh is completed from: the scene, its views in the frame of the mesh, and small photographs of them.
struct CompletionInput {
  const std::filesystem::path& scene;
  const SceneViews& views;
  std::vector<Camera> cameras;
  std::vector<SmallPhotograph> photographs;
  bool far_sphere;

  [[nodiscard]] Outlook outlook(const Mesh& mesh) const { return outlook_of(photographs, cameras, mesh, far_sphere); }
};

// Returns the mesh with what the views `matched` show and it lacks.
CompletedMesh with_added_surface(const CompletionInput& input, const std::vector<std::size_t>& matched,
                                 const std::filesystem::path& folder, const BuildCallback& callback,
                                 const MeshInput& mesh) {
  const ScenePoints points = points_around(input.scene, mesh.offset);
  const TriangleSoup other = surface_of_photographs(input.views, matched, points, folder, callback);
  BuildStage stage(callback, "adding what the mesh lacks", 0);
  CompletedMesh both =
      completed(soup_of(mesh.mesh), other, input.cameras, glm::dvec3(0), [] { throw_if_interrupted(); });
  stage.finish();
  return both;
}

// Adds surface to the mesh, unless photographs would be predicted worse with it. `seen` becomes what is seen then.
void add_surface(const CompletionInput& input, const std::vector<std::size_t>& matched,
                 const std::filesystem::path& folder, const BuildCallback& callback, MeshInput& mesh, Outlook& seen,
                 CompletedSurface& result) {
  const CompletedMesh both = with_added_surface(input, matched, folder, callback, mesh);
  result.matched = matched.size();
  if (both.added_faces == 0) return;
  Mesh completed_mesh = repair(both.surface, glm::dvec3(0), throw_if_interrupted).mesh;
  Outlook after = input.outlook(completed_mesh);
  result.gain_db = completion_gain_db(input.photographs, *seen.surface, seen.beyond.get(), *after.surface);
  if (result.gain_db && *result.gain_db <= 0) {
    result.failure = "the mesh is taken as it is: the surface that photographs show beside it makes pictures worse";
    return;
  }
  mesh.mesh = std::move(completed_mesh);
  result.added_faces = both.added_faces;
  result.shares = {seen.shares.surface, std::max(after.shares.surface - seen.shares.surface, 0.0), after.shares.far};
  seen = std::move(after);
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
  const std::vector<SmallPhotograph> photographs = small_photographs(views.views, ranks);
  const Outlook seen = outlook_of(photographs, completion_cameras(views, ranks), mesh, true);
  const MatchingPlan plan = plan_matching(seen, photographs, ranks);
  return {seen.shares, plan.ranks.size(), plan.largest_gain_db};
}

nlohmann::json frames_json(const SceneViews& views, const Mesh& mesh) {
  std::vector<std::size_t> ranks(views.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  leave_out_bad(views, ranks);
  const CompletionPlan plan = plan_completion(views, ranks, mesh);
  return {{"surface", plan.shares.surface},
          {"far", plan.shares.far},
          {"lacking", std::max(0.0, 1 - plan.shares.surface - plan.shares.far)},
          {"largest_gain_db", plan.largest_gain_db ? nlohmann::json(*plan.largest_gain_db) : nlohmann::json()},
          {"to_match", plan.to_match}};
}

CompletedSurface complete_surface(const std::filesystem::path& scene, const SceneViews& views,
                                  const std::vector<std::size_t>& ranks, const CompletionOptions& options,
                                  const BuildCallback& callback, MeshInput& mesh) {
  BuildStage stage(callback, "looking past the mesh", 0);
  const CompletionInput input{scene, views, completion_cameras(views, ranks), small_photographs(views.views, ranks),
                              options.far_sphere};
  Outlook seen = input.outlook(mesh.mesh);
  MatchingPlan plan;
  if (options.surface) plan = plan_matching(seen, input.photographs, ranks);
  stage.finish();
  CompletedSurface result;
  result.shares = seen.shares;
  if (!plan.ranks.empty()) {
    std::optional<TemporaryEntry> temporary;
    if (options.stereo_folder.empty()) {
      temporary.emplace(TemporaryEntry::Kind::folder, std::filesystem::temp_directory_path(),
                        [] { return random_temporary_name(); });
    }
    try {
      add_surface(input, plan.ranks, temporary ? temporary->path() : options.stereo_folder, callback, mesh, seen,
                  result);
    } catch (const InputError& error) {
      result.failure = std::string("the mesh is taken as it is, though photographs show more: ") + error.what();
    }
  }
  result.far = std::move(seen.far);
  return result;
}

}  // namespace lumatlas
