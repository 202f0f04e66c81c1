// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/captured_stream.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/text_rows.h"

namespace lumatlas {

namespace {

// Pictures taken within this time of each other are one frame, seconds: TUM's own tools take 20 ms.
constexpr double kTogether = 0.02;

using Times = std::map<std::filesystem::path, double>;

// Returns the times of a TUM list, by file; empty where there is no such list.
Times times_in(const std::filesystem::path& folder, const char* list) {
  std::error_code ignored;
  const std::filesystem::path path = folder / list;
  if (!std::filesystem::exists(path, ignored)) return {};
  const std::string text = read_whole_file(path);
  Times times;
  for (const TextRow& row : rows_of(text)) {
    if (row.fields.size() == 2) times[(folder / row.fields[1]).lexically_normal()] = number_in(row, 0, path);
  }
  return times;
}

void move_by(Camera& camera, const glm::dvec3& offset) {
  camera.cam_from_world_translation += camera.cam_from_world_rotation * offset;
}

// Returns a distance of two poses, 0 for the same pose.
double pose_difference(const Camera& a, const Camera& b) {
  double sum = glm::distance(a.center(), b.center());
  for (int column = 0; column < 3; ++column) {
    sum += glm::distance(a.cam_from_world_rotation[column], b.cam_from_world_rotation[column]);
  }
  return sum;
}

// Returns the time of the photograph whose pose is nearest.
double time_of_pose(const Camera& camera, const SceneViews& scene, const std::vector<double>& view_times) {
  double least = std::numeric_limits<double>::infinity(), time = 0;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const double difference = pose_difference(camera, scene.views[i].camera);
    if (difference >= least) continue;
    least = difference;
    time = view_times[i];
  }
  return time;
}

std::vector<double> times_of_views(const SceneViews& scene, double rate) {
  const Times listed = times_in(scene.root, "rgb.txt");
  std::vector<double> times;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const auto found = listed.find(scene.views[i].image.lexically_normal());
    times.push_back(found == listed.end() ? static_cast<double>(i) / rate : found->second);
  }
  return times;
}

std::vector<double> times_of_depths(const SceneViews& scene, const std::vector<double>& view_times) {
  const Times listed = times_in(scene.root, "depth.txt");
  std::vector<double> times;
  for (const SceneDepth& depth : scene.depths) {
    const auto found = listed.find(depth.file.lexically_normal());
    times.push_back(found == listed.end() ? time_of_pose(depth.camera, scene, view_times) : found->second);
  }
  return times;
}

// Puts each depth image with a photograph of its time, if there is one that has none yet.
std::vector<CapturedFrame> frames_of(const std::vector<std::pair<double, std::size_t>>& views,
                                     const std::vector<double>& depth_times) {
  std::vector<CapturedFrame> frames;
  frames.reserve(views.size() + depth_times.size());
  for (const auto& [time, view] : views) frames.push_back({time, view, std::nullopt});
  const auto earlier = [](const CapturedFrame& a, const CapturedFrame& b) { return a.time < b.time; };
  std::stable_sort(frames.begin(), frames.end(), earlier);
  std::vector<CapturedFrame> alone;
  for (std::size_t depth = 0; depth < depth_times.size(); ++depth) {
    const double time = depth_times[depth];
    const auto near = std::find_if(frames.begin(), frames.end(), [&](const CapturedFrame& frame) {
      return !frame.depth && std::abs(frame.time - time) <= kTogether;
    });
    if (near != frames.end()) {
      near->depth = depth;
    } else {
      alone.push_back({time, std::nullopt, depth});
    }
  }
  frames.insert(frames.end(), alone.begin(), alone.end());
  std::stable_sort(frames.begin(), frames.end(), earlier);
  const double first = frames.front().time;
  for (CapturedFrame& frame : frames) frame.time -= first;
  return frames;
}

}  // namespace

CapturedStream read_captured_stream(const std::filesystem::path& folder, const PictureFolders& folders,
                                    const std::optional<HoldOut>& hold_out, double rate) {
  CapturedStream stream;
  stream.scene = read_scene_views(folder, glm::dvec3(0), folders);
  SceneViews& scene = stream.scene;
  if (scene.depths.empty()) {
    throw InputError(folder.string() + ": has no depth images, of which a live surface is made: it is read as " +
                     scene.form);
  }
  stream.offset = glm::round(scene.views.front().camera.center());
  for (SceneView& view : scene.views) move_by(view.camera, stream.offset);
  for (SceneDepth& depth : scene.depths) move_by(depth.camera, stream.offset);
  const std::vector<double> view_times = times_of_views(scene, rate);
  std::vector<std::pair<double, std::size_t>> views;
  std::vector<std::uint8_t> is_played(scene.views.size(), 0);
  for (const std::size_t rank : split(scene, hold_out).input) {
    views.emplace_back(view_times[rank], rank);
    is_played[rank] = 1;
  }
  for (std::size_t rank = 0; rank < is_played.size(); ++rank) {
    if (is_played[rank] == 0) stream.held_out.push_back(rank);
  }
  stream.frames = frames_of(views, times_of_depths(scene, view_times));
  return stream;
}

}  // namespace lumatlas
