// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/kept_frames.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <numeric>
#include <system_error>
#include <utility>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

// Returns the ending that a photograph's file goes under: a PNG file begins so, and the others are JPEG.
const char* ending_of(const std::vector<std::uint8_t>& photograph) {
  return photograph.size() > 1 && photograph[1] == 'P' ? ".png" : ".jpg";
}

CameraModel lens_of(const Camera& camera) {
  CameraModel lens;
  lens.width = camera.width;
  lens.height = camera.height;
  lens.parameters = {camera.fx, camera.fy, camera.cx, camera.cy};
  return lens;
}

void forget_file(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!file.empty()) std::filesystem::remove(file, ignored);
}

}  // namespace

KeptFrames::KeptFrames(const std::filesystem::path& folder, std::uint64_t most_bytes) try
    : folder_(TemporaryEntry::Kind::folder, folder, [] { return random_temporary_name(); }), most_bytes_(most_bytes) {
} catch (const std::system_error& error) {
  throw InputError(folder.string() + ": frames cannot be kept there: " + error.what());
}

void KeptFrames::write(const std::filesystem::path& file, const std::vector<std::uint8_t>& bytes, Frame& frame) const {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    forget_file(file);
    throw InputError(folder_.path().parent_path().string() + ": frames cannot be kept there: the disk is full?");
  }
  frame.bytes += bytes.size();
}

void KeptFrames::keep(const FrameMessage& message) {
  if (came_++ % every_ != 0) return;
  Frame frame{message.name, message.camera, {}, {}, message.depth_unit, 0};
  const std::string number = std::to_string(came_);
  if (!message.photograph.empty()) {
    frame.photograph = folder_.path() / (number + ending_of(message.photograph));
    write(frame.photograph, message.photograph, frame);
  }
  if (!message.depth.empty()) {
    frame.depth = folder_.path() / (number + ".depth.png");
    write(frame.depth, encode_grey_image({message.camera.width, message.camera.height, message.depth}), frame);
  }
  bytes_ += frame.bytes;
  frames_.push_back(std::move(frame));
  while (bytes_ > most_bytes_ && frames_.size() > 1) thin();
}

void KeptFrames::thin() {
  every_ *= 2;
  std::vector<Frame> stay;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    if (i % 2 == 0) {
      stay.push_back(std::move(frames_[i]));
      continue;
    }
    forget_file(frames_[i].photograph);
    forget_file(frames_[i].depth);
    bytes_ -= frames_[i].bytes;
  }
  frames_ = std::move(stay);
}

void KeptFrames::move(const std::vector<MovedView>& views) {
  std::map<std::string, const Camera*> by_name;
  for (const MovedView& view : views) by_name[view.name] = &view.camera;
  for (Frame& frame : frames_) {
    const auto moved = by_name.find(frame.name);
    if (moved == by_name.end()) continue;
    frame.camera.cam_from_world_rotation = moved->second->cam_from_world_rotation;
    frame.camera.cam_from_world_translation = moved->second->cam_from_world_translation;
  }
}

StreamedFrames KeptFrames::frames() const {
  StreamedFrames result;
  SceneViews& scene = result.scene;
  scene.root = "the stream";
  scene.form = "stream";
  std::vector<const Frame*> photographs;
  for (const Frame& frame : frames_) {
    if (!frame.photograph.empty()) photographs.push_back(&frame);
    if (!frame.depth.empty()) {
      scene.depths.push_back({frame.depth, frame.depth_unit, lens_of(frame.camera), frame.camera, {}});
    }
  }
  std::vector<std::size_t> by_name(photographs.size());
  std::iota(by_name.begin(), by_name.end(), std::size_t{0});
  std::sort(by_name.begin(), by_name.end(),
            [&](std::size_t a, std::size_t b) { return photographs[a]->name < photographs[b]->name; });
  result.offered.resize(photographs.size());
  for (std::size_t rank = 0; rank < by_name.size(); ++rank) {
    const Frame& frame = *photographs[by_name[rank]];
    SceneView& view = scene.views.emplace_back();
    view.name = frame.name;
    view.image = frame.photograph;
    view.lens = lens_of(frame.camera);
    view.camera = frame.camera;
    result.offered[by_name[rank]] = rank;
  }
  return result;
}

}  // namespace lumatlas
