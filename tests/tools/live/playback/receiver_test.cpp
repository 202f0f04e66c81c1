// SPDX-License-Identifier: GPL-3.0-or-later
// receive_stream(), with clients that go, stall and send nonsense.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <thread>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/live/playback/stream_client.h"
#include "tests/tools/live/room_stream.h"
#include "tools/live/playback/frame_socket.h"
#include "tools/live/playback/playback.h"

namespace lumatlas {
namespace {

// What receive_stream() takes, without what takes long at a stream's end; it keeps the warnings.
struct Receiving {
  FrameSocket socket{0};
  PlaybackOptions options;
  PlaybackCallbacks callbacks;
  std::vector<std::string> warnings;
  std::atomic<std::size_t> warned = 0;

  Receiving() {
    options.live = room_live_options();
    options.measure_deviation = false;
    options.finish = false;
    callbacks.warned = [this](const std::string& sentence) {
      warnings.push_back(sentence);
      ++warned;
    };
  }
  void wait_for_warnings(std::size_t count) const {
    while (warned < count) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
};

TEST_CASE("a stream survives clients that go, stall and send nonsense, and is a whole model at the end") {
  FrameSocket socket(0);
  PlaybackOptions options;
  options.live = room_live_options();
  options.live.waiting_views = 30;
  options.live.waiting_depths = 30;
  options.measure_deviation = false;
  const TemporaryFolder scratch;
  options.scratch_folder = scratch.path();
  std::vector<std::string> warnings;
  std::atomic<std::size_t> frames = 0, warned = 0;
  PlaybackCallbacks callbacks;
  callbacks.warned = [&](const std::string& sentence) {
    warnings.push_back(sentence);
    ++warned;
  };
  const auto wait_for_warnings = [&](std::size_t count) {
    while (warned < count) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  std::thread clients([&] {
    {
      const StreamClient client(socket.port());
      client.send_all(room_opening());
      for (std::size_t number = 0; number < 5; ++number) client.send_all(room_frame(number));
      StreamBytes half = room_frame(5);
      half.resize(half.size() / 2);
      client.send_all(half);
    }  // dies in the middle of a frame
    wait_for_warnings(1);
    {
      const StreamClient client(socket.port());
      client.send_all({'G', 'E', 'T', ' ', '/', ' ', 'H', 'T', 'T', 'P'});
      wait_for_warnings(2);
    }
    {
      const StreamClient client(socket.port());
      client.send_all(room_opening());
      client.send_all(room_frame(0));  // which came before
      wait_for_warnings(3);
    }
    const StreamClient client(socket.port());
    client.send_all(room_opening());
    for (std::size_t number = 5; number < 10; ++number) client.send_all(room_frame(number));
    std::this_thread::sleep_for(std::chrono::milliseconds(120));  // stalls for longer than the receiver waits at once
    client.send_all(moves_bytes({{room_view(5) + ".png", room_camera(5)}}));
    client.send_all(message_bytes('E', {}));
    while (frames == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  const Playback playback = receive_stream(socket, options, callbacks);
  frames = playback.record.frames;
  clients.join();
  CHECK(playback.record.frames == 10);
  CHECK_FALSE(playback.record.ended_early);
  CHECK(playback.record.live.failed == 0);
  CHECK(playback.record.live.stored > 5);
  CHECK_NOTHROW(check(playback.result.snapshot));
  CHECK(playback.record.finish.done);
  CHECK(playback.result.planned.size() == 10);
  CHECK(std::filesystem::is_empty(scratch.path()));
  REQUIRE(warnings.size() == 3);
  CHECK_THAT(warnings[0], Catch::Contains("gone without an end"));
  CHECK_THAT(warnings[1], Catch::Contains("greeting is not LUMLIVE1"));
  CHECK_THAT(warnings[2], Catch::Contains("came before"));
}

TEST_CASE("a stream of photographs and pieces of surface is made anew on those, and refuses depths") {
  FrameSocket socket(0);
  PlaybackOptions options;
  options.live = room_live_options();
  options.live.waiting_views = 30;
  options.measure_deviation = false;
  const TemporaryFolder scratch;
  options.scratch_folder = scratch.path();
  std::vector<std::string> warnings;
  std::atomic<std::size_t> warned = 0;
  PlaybackCallbacks callbacks;
  callbacks.warned = [&](const std::string& sentence) {
    warnings.push_back(sentence);
    ++warned;
  };
  std::size_t depths_of_finish = 1;
  callbacks.finishing = [&](std::size_t depths, std::size_t /*photographs*/) { depths_of_finish = depths; };
  std::thread clients([&] {
    {
      const StreamClient client(socket.port());
      client.send_all(room_opening());
      client.send_all(piece_bytes<float>(3, {}));  // removes what is not there
      for (std::uint32_t octant = 0; octant < 8; ++octant)
        client.send_all(piece_bytes<double>(octant, room_piece(octant)));
      for (std::size_t number = 0; number < 5; ++number) client.send_all(room_photograph(number));
      TriangleSoup bad = room_piece(2);
      bad.faces.back().x = 1'000'000;
      client.send_all(piece_bytes<float>(2, bad));
      while (warned < 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    {
      const StreamClient client(socket.port());
      client.send_all(room_opening());
      client.send_all(room_frame(5));  // has depths
      while (warned < 2) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const StreamClient client(socket.port());
    client.send_all(room_opening());
    for (std::size_t number = 6; number < 10; ++number) client.send_all(room_photograph(number));
    client.send_all(piece_bytes<float>(7, room_piece(7)));  // again
    client.send_all(message_bytes('E', {}));
  });
  const Playback playback = receive_stream(socket, options, callbacks);
  clients.join();
  REQUIRE(warnings.size() == 2);
  CHECK_THAT(warnings[0], Catch::Contains("a triangle of a vertex that is not there"));
  CHECK_THAT(warnings[1], Catch::Contains("has depths, and the surface of this stream is made of pieces"));
  CHECK(playback.record.frames == 9);
  CHECK(playback.record.live.pieces_given == 9);
  CHECK(playback.record.live.stored > 5);
  CHECK(playback.record.finish.done);
  CHECK(playback.record.finish.voxel == 0);
  CHECK(depths_of_finish == 0);
  CHECK(playback.result.planned.size() == 9);
  CHECK_NOTHROW(check(playback.result.snapshot));
  // The saved surface is the room, where the stream's coordinates have it.
  const Surface& surface = *playback.result.snapshot.surface;
  Camera camera = room_camera(4);
  camera.cam_from_world_translation += camera.cam_from_world_rotation * surface.offset;
  const VisibilityBuffer seen = make_ray_visibility(surface.mesh)->trace(camera);
  const VisibilityBuffer room = make_ray_visibility(room_surface()->mesh)->trace(room_camera(4));
  std::size_t near = 0;
  for (std::size_t pixel = 0; pixel < seen.depth.size(); ++pixel)
    near += std::abs(seen.depth[pixel] - room.depth[pixel]) < 0.01F;
  CHECK(near > seen.depth.size() * 98 / 100);
  CHECK(std::filesystem::is_empty(scratch.path()));
}

TEST_CASE("a stream whose kept frames have no depths is saved as it was shown") {
  FrameSocket socket(0);
  PlaybackOptions options;
  options.live = room_live_options();
  options.live.waiting_views = 30;
  options.live.waiting_depths = 30;
  options.measure_deviation = false;
  options.kept_bytes = 1;  // of the frames the first one is kept, a photograph alone
  std::thread clients([&] {
    const StreamClient client(socket.port());
    client.send_all(room_opening());
    for (std::size_t number = 0; number < 10; ++number) {
      client.send_all(number % 2 == 0 ? room_photograph(number) : room_frame(number));
    }
    client.send_all(message_bytes('E', {}));
  });
  const Playback playback = receive_stream(socket, options, {});
  clients.join();
  CHECK_FALSE(playback.record.finish.done);
  CHECK(playback.record.finish.why_not == "no depth image of the stream is kept");
  CHECK(playback.record.live.stored > 1);
  CHECK_NOTHROW(check(playback.result.snapshot));
  const auto& views = playback.result.snapshot.views;
  CHECK(std::count_if(views.begin(), views.end(), [](const auto& view) { return view != nullptr; }) > 1);
}

TEST_CASE("a stream warns of a piece that makes no surface, and its origin is near its first triangle") {
  Receiving receiving;
  std::thread clients([&] {
    const StreamClient client(receiving.socket.port());
    client.send_all(room_opening());
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      TriangleSoup piece = room_piece(octant);
      piece.positions.insert(piece.positions.begin(), glm::dvec3(5e8));  // no face refers to it
      for (glm::uvec3& face : piece.faces) face += 1U;
      client.send_all(piece_bytes<double>(octant, piece));
    }
    for (std::size_t number = 0; number < 5; ++number) client.send_all(room_photograph(number));
    const TriangleSoup vast{{{0, 0, 0}, {20'000, 0, 0}, {0, 20'000, 0}}, {}, {{0, 1, 2}}};
    client.send_all(piece_bytes<double>(8, vast));
    receiving.wait_for_warnings(1);
    client.send_all(piece_bytes<double>(8, {}));
    client.send_all(message_bytes('E', {}));
  });
  const Playback playback = receive_stream(receiving.socket, receiving.options, receiving.callbacks);
  clients.join();
  REQUIRE(receiving.warnings.size() == 1);
  CHECK_THAT(receiving.warnings.front(),
             Catch::Contains("the surface stays as it was: the pieces of surface are too large for cells"));
  CHECK(playback.record.live.surface_failure.empty());
  CHECK(playback.record.live.stored > 0);
  const Surface& surface = *playback.result.snapshot.surface;
  CHECK(surface.mesh.faces.size() == room_surface()->mesh.faces.size());
  CHECK(glm::length(surface.offset) < 10);
}

TEST_CASE("a stream that has depths refuses pieces of surface, and goes on") {
  Receiving receiving;
  std::thread clients([&] {
    {
      const StreamClient client(receiving.socket.port());
      client.send_all(room_opening());
      client.send_all(room_frame(0));
      client.send_all(piece_bytes<double>(0, room_piece(0)));
      receiving.wait_for_warnings(1);
    }
    const StreamClient client(receiving.socket.port());
    client.send_all(room_opening());
    client.send_all(room_frame(1));
    client.send_all(message_bytes('E', {}));
  });
  const Playback playback = receive_stream(receiving.socket, receiving.options, receiving.callbacks);
  clients.join();
  REQUIRE(receiving.warnings.size() == 1);
  CHECK_THAT(receiving.warnings.front(), Catch::Contains("comes after frames with depths"));
  CHECK(playback.record.frames == 2);
  CHECK(playback.record.live.stored > 0);
}

TEST_CASE("a stream that ends before a frame came makes no model, and a port is one program's") {
  FrameSocket socket(0);
  PlaybackCallbacks callbacks;
  callbacks.ended = [] { return true; };
  PlaybackOptions options;
  CHECK_THROWS_WITH(receive_stream(socket, options, callbacks), Catch::Contains("no frame arrived"));
  CHECK_THROWS_WITH(FrameSocket(socket.port()), Catch::Contains("cannot be listened at"));
}

}  // namespace
}  // namespace lumatlas
