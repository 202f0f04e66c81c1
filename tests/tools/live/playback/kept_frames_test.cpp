// SPDX-License-Identifier: GPL-3.0-or-later
// KeptFrames, and the model that is made of its frames.
#include "tools/live/playback/kept_frames.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/live/room_stream.h"
#include "tools/live/playback/finished_model.h"
#include "tools/meshing/depth/scene_depth.h"

namespace lumatlas {
namespace {

constexpr double kUnit = 1.0 / 5000;

FrameMessage room_message(std::size_t number) {
  FrameMessage message;
  message.name = room_view(number) + ".png";
  message.camera = room_camera(number);
  message.photograph = encode_image(pattern_photograph(message.camera, number), {});
  message.depth_unit = kUnit;
  for (const float depth : room_depth(message.camera).depth) {
    message.depth.push_back(static_cast<std::uint16_t>(depth / kUnit + 0.5));
  }
  return message;
}

StageProgress unheard() {
  return [](const std::string& /*stage*/, std::size_t /*steps*/) { return [](std::size_t /*done*/) {}; };
}

TEST_CASE("kept frames are read back as they were sent, with the poses that they were moved to") {
  const TemporaryFolder folder;
  {
    KeptFrames kept(folder.path(), 1 << 30);
    for (const std::size_t number : {2, 1}) kept.keep(room_message(number));
    kept.move({{room_view(1) + ".png", room_camera(3)}, {"another.png", room_camera(4)}});
    const StreamedFrames frames = kept.frames();
    REQUIRE(frames.scene.views.size() == 2);
    CHECK(frames.scene.views[0].name == room_view(1) + ".png");
    CHECK(frames.offered == std::vector<std::size_t>{1, 0});  // in the order in which they came
    CHECK(frames.scene.views[0].camera.center() == room_camera(3).center());
    CHECK(load_photograph(frames.scene.views[1]).rgb == pattern_photograph(room_camera(2), 2).rgb);
    REQUIRE(frames.scene.depths.size() == 2);
    CHECK(frames.scene.depths[1].camera.center() == room_camera(3).center());
    const DepthImage read = read_depth(frames.scene.depths[0]), sent = room_depth(room_camera(2));
    REQUIRE(read.depth.size() == sent.depth.size());
    double sum = 0, off = 0;
    for (std::size_t i = 0; i < read.depth.size(); ++i) {
      if (read.depth[i] == 0) continue;  // seen aslant, see read_depth()
      sum += 1;
      off = std::max(off, std::abs(double{read.depth[i]} - sent.depth[i]));
    }
    CHECK(sum > 0.8 * static_cast<double>(read.depth.size()));
    CHECK(off < kUnit);
  }
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("kept frames stay within their bytes, evenly over the stream") {
  const TemporaryFolder folder;
  const FrameMessage message = room_message(0);
  KeptFrames once(folder.path(), 1 << 30);
  once.keep(message);
  const std::uint64_t of_one = once.bytes();
  KeptFrames kept(folder.path(), 5 * of_one + of_one / 2);
  for (std::size_t number = 0; number < 20; ++number) {
    FrameMessage next = message;
    next.name = std::to_string(10 + number);
    kept.keep(next);
    CHECK(kept.bytes() <= 5 * of_one + of_one / 2);
  }
  const StreamedFrames frames = kept.frames();
  std::vector<std::string> names;
  for (const SceneView& view : frames.scene.views) names.push_back(view.name);
  CHECK(names == std::vector<std::string>{"10", "14", "18", "22", "26"});
}

TEST_CASE("a model is made anew of kept frames, and frames that cannot be read are named") {
  const TemporaryFolder folder;
  KeptFrames kept(folder.path(), 1 << 30);
  for (std::size_t number = 0; number < 8; ++number) kept.keep(room_message(number));
  BuildOptions options;
  options.max_views = 5;
  options.refine = RefineMode::none;
  options.texture_px.reset();
  options.completion.far_sphere = false;
  const FinishedModel finished = finished_model(kept.frames(), options, unheard(), {});
  CHECK(finished.voxel > 0);
  CHECK_NOTHROW(check(finished.result.snapshot));
  CHECK(finished.result.planned.size() == 8);
  std::size_t stored = 0;
  for (const auto& view : finished.result.snapshot.views) stored += view != nullptr;
  CHECK(stored > 2);
  CHECK(stored <= 5);
  BuildOptions with_stereo = options;
  with_stereo.completion.surface = true;
  CHECK_THROWS_AS(finished_model(kept.frames(), with_stereo, unheard(), {}), std::invalid_argument);
  StreamedFrames none = kept.frames();
  for (SceneDepth& depth : none.scene.depths) depth.file = folder.path() / "missing.tif";
  CHECK_THROWS_WITH(finished_model(none, options, unheard(), {}), Catch::Contains("no depth image can be read"));
}

}  // namespace
}  // namespace lumatlas
