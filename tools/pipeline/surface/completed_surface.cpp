// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/completed_surface.h"

#include <algorithm>
#include <functional>
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
#include "tools/base/process/interrupt.h"
#include "tools/meshing/contradicted_faces.h"
#include "tools/meshing/faces_before.h"
#include "tools/meshing/measured_views.h"
#include "tools/meshing/mesh_completion.h"
#include "tools/meshing/photograph_mesh.h"
#include "tools/pipeline/surface/completion_gain.h"
#include "tools/pipeline/surface/extended_surface.h"
#include "tools/pipeline/surface/far_background.h"
#include "tools/pipeline/surface/points_through_mesh.h"
#include "tools/scene/for_each_index.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

namespace {

constexpr double kLittleLacking = 0.01;    // share of all pixels below which nothing is added
constexpr double kLittleToExtend = 0.005;  // share of all pixels up to which the mesh is not continued
constexpr double kLeastGain = 0.6;         // dB that added surface must be able to bring, for its time
constexpr const char* kWorseThanGiven =
    "nothing is added to the mesh: the surface that photographs show beside it makes pictures worse";
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

// The parts of a mesh and of the far sphere that views see.
struct Outlook {
  FarSphere far;
  std::vector<double> lacking;  // one per camera: share of its pixels that see neither, without masked ones
  FrameShares shares;           // shares of the photographs' valid pixels
  std::unique_ptr<Visibility> surface, beyond;  // visibility of the mesh and of the far sphere, null if there is none
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

// The photographs to match, and the gain that matching can bring.
struct MatchingPlan {
  std::vector<std::size_t> ranks;         // ascending; empty: nothing is worth it
  std::size_t through = 0;                // number of these that look through the mesh
  std::optional<double> largest_gain_db;  // none: the mesh lacks too little, or photographs cannot be compared
};

MatchingPlan plan_matching(const Outlook& seen, const std::vector<SmallPhotograph>& photographs,
                           const SceneViews& views, const std::vector<std::size_t>& ranks, const ScenePoints& points) {
  MatchingPlan plan{lacking_ranks(seen, ranks), 0, std::nullopt};
  if (!plan.ranks.empty()) plan.largest_gain_db = largest_gain_db(photographs, *seen.surface, seen.beyond.get());
  if (plan.largest_gain_db && *plan.largest_gain_db < kLeastGain) plan.ranks.clear();
  const std::vector<std::size_t> through = views_through_mesh(points, views.views, ranks, *seen.surface);
  plan.through = through.size();
  plan.ranks.insert(plan.ranks.end(), through.begin(), through.end());
  std::sort(plan.ranks.begin(), plan.ranks.end());
  plan.ranks.erase(std::unique(plan.ranks.begin(), plan.ranks.end()), plan.ranks.end());
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

std::vector<MeasuredView> measured_views(const SceneStereo& stereo) {
  std::vector<MeasuredView> views(stereo.views().size());
  for_each_index(views.size(), [&](std::size_t i) {
    throw_if_interrupted();
    SmallPhotograph photograph = small_photograph(stereo.views()[i], stereo.camera(i));
    views[i] = {stereo.depth(i), std::move(photograph.color), std::move(photograph.valid)};
  });
  return views;
}

// Returns the mesh without some of its faces, given in ascending order.
TriangleSoup soup_without(const Mesh& mesh, const std::vector<std::uint32_t>& faces) {
  TriangleSoup soup = soup_of(mesh);
  soup.faces.clear();
  auto next = faces.begin();
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    if (next != faces.end() && *next == face) {
      ++next;
    } else {
      soup.faces.push_back(mesh.faces[face]);
    }
  }
  return soup;
}

// Makes a mesh of what the views of these ranks show. `matched` is called with the depths.
TriangleSoup surface_of_photographs(const SceneViews& views, const std::vector<std::size_t>& ranks,
                                    const ScenePoints& points, const std::filesystem::path& folder,
                                    const BuildCallback& callback,
                                    const std::function<void(const SceneStereo&)>& matched) {
  SceneViews some;
  some.root = views.root;
  for (const std::size_t rank : ranks) some.views.push_back(views.views[rank]);
  SceneMeshOptions options;
  options.stereo.longest_px = kMatchedPx;
  options.longest_edge = kAddedLongestEdge;
  options.stereo_folder = folder;
  std::optional<BuildStage> stage;
  try {
    return mesh_from_photographs(std::move(some), points_of_views(points, ranks), options, shown_by(callback, stage),
                                 matched)
        .surface;
  } catch (const InputError&) {
    if (stage) stage->finish();
    throw;
  }
}

// The input of a completion, in the frame of the mesh.
struct CompletionInput {
  const SceneViews& views;
  ScenePoints points;
  std::vector<Camera> cameras;
  std::vector<SmallPhotograph> photographs;
  bool far_sphere;

  [[nodiscard]] Outlook outlook(const Mesh& mesh) const { return outlook_of(photographs, cameras, mesh, far_sphere); }
};

// Tells that photographs contradict too much of a mesh for single faces to be wrong.
std::string too_much_contradicted(const ContradictedFaces& contradicted) {
  return "photographs see through " + percent_text(contradicted.pixels) +
         " of what they show of the mesh: it stays as it is, for it or the poses must be wrong; see whether they "
         "belong together";
}

// Takes a changed mesh; `kept`: share of the photographs' pixels that see what is left of the given one.
void take(Mesh changed, Outlook after, double kept, MeshInput& mesh, Outlook& seen, CompletedSurface& result) {
  result.shares = {kept, std::max(after.shares.surface - kept, 0.0), after.shares.far};
  mesh.mesh = std::move(changed);
  seen = std::move(after);
}

// Removes contradicted faces from the mesh, and adds surface to it unless photographs are predicted worse with it.
// `seen` becomes what is seen then.
void change_mesh(const CompletionInput& input, const ContradictedFaces& contradicted, const TriangleSoup& other,
                 const BuildCallback& callback, MeshInput& mesh, Outlook& seen, CompletedSurface& result) {
  BuildStage stage(callback, "adding what the mesh lacks", 0);
  const auto go_on = [] { throw_if_interrupted(); };
  const TriangleSoup rest = soup_without(mesh.mesh, contradicted.faces);
  const CompletedMesh both = completed(rest, other, input.cameras, glm::dvec3(0), go_on);
  std::optional<Mesh> kept;
  double kept_share = seen.shares.surface;
  if (!contradicted.faces.empty()) {
    kept = repair(rest, glm::dvec3(0), throw_if_interrupted).mesh;
    FrameShares shares;
    add_shares(input.photographs, *make_ray_visibility(*kept), nullptr, shares);
    kept_share = shares.surface;
  }
  if (both.added_faces > 0) {
    Mesh whole = repair(both.surface, glm::dvec3(0), throw_if_interrupted).mesh;
    Outlook after = input.outlook(whole);
    result.gain_db = completion_gain_db(input.photographs, *seen.surface, seen.beyond.get(), *after.surface);
    if (!result.gain_db || *result.gain_db > 0) {
      result.added_faces = both.added_faces;
      take(std::move(whole), std::move(after), kept_share, mesh, seen, result);
      kept.reset();
    } else {
      result.warnings.emplace_back(kWorseThanGiven);
    }
  }
  if (kept) {
    Outlook after = input.outlook(*kept);
    take(*std::move(kept), std::move(after), kept_share, mesh, seen, result);
  }
  result.contradicted = contradicted;
  stage.finish();
}

// Adds faces to the mesh and returns true, unless photographs are predicted worse with them. `seen` becomes what is
// seen then.
bool add_if_better(const CompletionInput& input, const TriangleSoup& part, MeshInput& mesh, Outlook& seen,
                   CompletedSurface& result) {
  TriangleSoup surface = soup_of(mesh.mesh);
  append_faces(part, surface);
  Mesh whole = repair(surface, glm::dvec3(0), throw_if_interrupted).mesh;
  Outlook after = input.outlook(whole);
  const std::optional<double> gain =
      completion_gain_db(input.photographs, *seen.surface, seen.beyond.get(), *after.surface);
  if (!gain || !(*gain > 0)) return false;
  result.added_faces += part.faces.size();
  take(std::move(whole), std::move(after), result.shares.surface, mesh, seen, result);
  return true;
}

// Adds the faces of the other surface that photographs show before the mesh, unless photographs are predicted worse
// with them. `seen` becomes what is seen then.
void add_before(const CompletionInput& input, const std::vector<MeasuredView>& views, const TriangleSoup& other,
                const BuildCallback& callback, MeshInput& mesh, Outlook& seen, CompletedSurface& result) {
  BuildStage stage(callback, "adding what stands before the mesh", 0);
  const Mesh other_mesh = repair(other, glm::dvec3(0), throw_if_interrupted).mesh;
  const FacesBefore before = faces_before(mesh.mesh, other_mesh, views, throw_if_interrupted);
  if (!before.faces.empty()) {
    TriangleSoup part = soup_of(other_mesh);
    part.faces.clear();
    for (const std::uint32_t face : before.faces) part.faces.push_back(other_mesh.faces[face]);
    if (add_if_better(input, part, mesh, seen, result)) result.faces_before = before.faces.size();
  }
  stage.finish();
}

// Matches the photographs of some views, and changes the mesh by what they show.
void match_and_change(const CompletionInput& input, const std::vector<std::size_t>& matched,
                      const std::filesystem::path& folder, const BuildCallback& callback, MeshInput& mesh,
                      Outlook& seen, CompletedSurface& result) {
  std::vector<MeasuredView> views;
  const TriangleSoup other = surface_of_photographs(input.views, matched, input.points, folder, callback,
                                                    [&](const SceneStereo& stereo) { views = measured_views(stereo); });
  ContradictedFaces contradicted = contradicted_faces(mesh.mesh, views, throw_if_interrupted);
  result.matched = matched.size();
  if (contradicted.pixels > kMostContradicted) {
    result.warnings.push_back(too_much_contradicted(contradicted));
    contradicted = {};
  }
  change_mesh(input, contradicted, other, callback, mesh, seen, result);
  add_before(input, views, other, callback, mesh, seen, result);
}

// Extends the mesh by guesses (extended_surface.h), unless photographs are predicted worse with them.
void extend_mesh(const CompletionInput& input, const BuildCallback& callback, MeshInput& mesh, Outlook& seen,
                 CompletedSurface& result) {
  if (1 - seen.shares.surface - seen.shares.far <= kLittleToExtend) return;
  BuildStage stage(callback, "extending the mesh", 0);
  const Mesh part = surface_extension(input.photographs, mesh.mesh, *seen.surface, seen.beyond.get());
  if (!part.faces.empty()) add_if_better(input, soup_of(part), mesh, seen, result);
  stage.finish();
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

CompletionPlan plan_completion(const SceneViews& views, const std::vector<std::size_t>& ranks, const Mesh& mesh,
                               const glm::dvec3& offset) {
  const std::vector<SmallPhotograph> photographs = small_photographs(views.views, ranks);
  const Outlook seen = outlook_of(photographs, completion_cameras(views, ranks), mesh, true);
  const MatchingPlan plan = plan_matching(seen, photographs, views, ranks, points_around(views.root, offset));
  return {seen.shares, plan.ranks.size(), plan.through, plan.largest_gain_db};
}

nlohmann::json frames_json(const SceneViews& views, const Mesh& mesh, const glm::dvec3& offset) {
  std::vector<std::size_t> ranks(views.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  leave_out_bad(views, ranks);
  const CompletionPlan plan = plan_completion(views, ranks, mesh, offset);
  return {{"surface", plan.shares.surface},
          {"far", plan.shares.far},
          {"lacking", std::max(0.0, 1 - plan.shares.surface - plan.shares.far)},
          {"largest_gain_db", plan.largest_gain_db ? nlohmann::json(*plan.largest_gain_db) : nlohmann::json()},
          {"to_match", plan.to_match},
          {"through", plan.through}};
}

CompletedSurface complete_surface(const std::filesystem::path& scene, const SceneViews& views,
                                  const std::vector<std::size_t>& ranks, const CompletionOptions& options,
                                  const BuildCallback& callback, MeshInput& mesh) {
  BuildStage stage(callback, "looking past the mesh", 0);
  const CompletionInput input{views, options.surface ? points_around(scene, mesh.offset) : ScenePoints(),
                              completion_cameras(views, ranks), small_photographs(views.views, ranks),
                              options.far_sphere};
  Outlook seen = input.outlook(mesh.mesh);
  MatchingPlan plan;
  if (options.surface) plan = plan_matching(seen, input.photographs, views, ranks, input.points);
  stage.finish();
  CompletedSurface result;
  result.shares = seen.shares;
  // Where too little is lacking to look for a gain, guesses can do little harm.
  bool extends = options.surface && plan.largest_gain_db.value_or(kLeastGain) >= kLeastGain;
  if (!plan.ranks.empty()) {
    std::optional<TemporaryEntry> temporary;
    if (options.stereo_folder.empty()) {
      temporary.emplace(TemporaryEntry::Kind::folder, std::filesystem::temp_directory_path(),
                        [] { return random_temporary_name(); });
    }
    try {
      match_and_change(input, plan.ranks, temporary ? temporary->path() : options.stereo_folder, callback, mesh, seen,
                       result);
    } catch (const InputError& error) {
      result.warnings.push_back(std::string("the mesh is used as given, although photographs show more: ") +
                                error.what());
      extends = false;
    }
  }
  if (extends) extend_mesh(input, callback, mesh, seen, result);
  result.far = std::move(seen.far);
  return result;
}

}  // namespace lumatlas
