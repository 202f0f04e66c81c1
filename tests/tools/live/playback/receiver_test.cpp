// SPDX-License-Identifier: GPL-3.0-or-later
// receive_stream(), with clients that go, stall and send nonsense.
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <thread>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/live/playback/stream_client.h"
#include "tests/tools/live/room_stream.h"
#include "tools/live/playback/playback.h"

namespace lumatlas {
namespace {

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
