// SPDX-License-Identifier: GPL-3.0-or-later
// receive_stream() under attack: clients that die at any byte, send any byte, or hold the connection.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <exception>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"
#include "tests/tools/live/playback/stream_client.h"
#include "tools/live/playback/frame_socket.h"
#include "tools/live/playback/playback.h"

namespace lumatlas {
namespace {

// Receives on the test's thread while `attack` runs on another one.
class Attacked {
 public:
  explicit Attacked(std::chrono::milliseconds most_silence = std::chrono::seconds(60)) : socket_(0, most_silence) {
    options_.live = room_live_options();
    options_.measure_deviation = false;
    options_.finish = false;
    callbacks_.warned = [this](const std::string& /*sentence*/) { ++warned_; };
  }

  template <typename Attack>
  Playback by(const Attack& attack) {
    std::thread attacker([&] { attack(); });
    Playback playback;
    std::string failure;
    try {
      playback = receive_stream(socket_, options_, callbacks_);
    } catch (const std::exception& error) {
      failure = error.what();
    }
    stopped_ = true;
    attacker.join();
    CAPTURE(failure);
    REQUIRE(failure.empty());
    return playback;
  }

  // Sends all, closes, and waits until the receiver has noticed.
  void attack_with(const StreamBytes& bytes) {
    if (stopped_) return;
    const std::size_t before = warned_;
    std::make_unique<StreamClient>(socket_.port())->send_all(bytes);
    wait_for_warnings(before + 1);
  }
  void wait_for_warnings(std::size_t count) const {
    while (warned_ < count && !stopped_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  // Sends frames of the room and the end.
  void end_well(std::size_t frames) {
    if (stopped_) return;
    const StreamClient client(socket_.port());
    client.send_all(room_opening());
    for (std::size_t number = 0; number < frames; ++number) client.send_all(room_frame(number));
    client.send_all(message_bytes('E', {}));
  }

  [[nodiscard]] std::uint16_t port() const { return socket_.port(); }
  [[nodiscard]] std::size_t warned() const { return warned_; }

 private:
  FrameSocket socket_;
  PlaybackOptions options_;
  PlaybackCallbacks callbacks_;
  std::atomic<std::size_t> warned_ = 0;
  std::atomic<bool> stopped_ = false;
};

void check_whole(const Playback& playback) {
  CHECK_FALSE(playback.record.ended_early);
  CHECK(playback.record.live.stored > 0);
  CHECK_NOTHROW(check(playback.result.snapshot));
}

TEST_CASE("a stream that is cut at 200 places by chance keeps each whole frame before the cut") {
  Attacked receiver;
  std::mt19937 chance(1);
  std::size_t whole_frames = 0;
  const Playback playback = receiver.by([&] {
    for (std::size_t attempt = 0; attempt < 200; ++attempt) {
      StreamBytes bytes = room_opening();
      std::vector<std::size_t> ends;
      for (std::size_t frame = 0; frame < 2; ++frame) {
        append(bytes, room_frame((2 * attempt + frame) % 30,
                                 "cut " + std::to_string(attempt) + " " + std::to_string(frame) + ".png"));
        ends.push_back(bytes.size());
      }
      bytes.resize(std::uniform_int_distribution<std::size_t>(0, bytes.size())(chance));
      for (const std::size_t end : ends) whole_frames += end <= bytes.size() ? 1 : 0;
      receiver.attack_with(bytes);
    }
    receiver.end_well(10);
  });
  CHECK(whole_frames > 50);
  CHECK(playback.record.frames == whole_frames + 10);
  CHECK(playback.record.live.failed == 0);
  CHECK(receiver.warned() == 200);
  check_whole(playback);
}

TEST_CASE("a stream with a wrong byte at any place loses no frame of others") {
  Attacked receiver;
  std::mt19937 chance(2);
  const Playback playback = receiver.by([&] {
    for (std::size_t attempt = 0; attempt < 200; ++attempt) {
      StreamBytes bytes = room_opening();
      // The first half of the attempts has its wrong byte near the beginning, where the lens and the pose are.
      append(bytes, room_frame(attempt % 30, "wrong " + std::to_string(attempt) + ".png"));
      const std::size_t last = attempt < 100 ? 200 : bytes.size() - 1;
      const std::size_t place = std::uniform_int_distribution<std::size_t>(0, last)(chance);
      bytes[place] = static_cast<std::uint8_t>(bytes[place] + std::uniform_int_distribution<int>(1, 255)(chance));
      receiver.attack_with(bytes);
    }
    receiver.end_well(10);
  });
  CHECK(playback.record.frames >= 10);
  CHECK(receiver.warned() == 200);
  check_whole(playback);
}

TEST_CASE("garbage, impossible numbers and lengths without end are refused, and the next client goes on") {
  Attacked receiver;
  const auto opened = [](const StreamBytes& message) {
    StreamBytes bytes = room_opening();
    append(bytes, message);
    return bytes;
  };
  std::vector<StreamBytes> attacks;
  std::mt19937 chance(3);
  StreamBytes noise(100'000);
  for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(chance());
  attacks.push_back(noise);
  attacks.push_back(opened(noise));
  attacks.push_back(opened(StreamBytes(100'000, 0)));
  attacks.push_back(opened({'F', 0, 0, 0, 255, 255, 255, 255}));
  attacks.push_back(opened({'M', 0, 0, 0, 255, 255, 255, 3}));  // just below 64 MiB, which never come
  attacks.push_back(opened(message_bytes('M', {255, 255, 255, 255})));
  attacks.push_back(opened(message_bytes('F', {255, 255, 255, 127})));
  attacks.push_back(opened(message_bytes('L', {})));
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e308}) {
    Camera camera = room_camera(0);
    camera.cam_from_world_translation.y = wrong;
    attacks.push_back(opened(frame_bytes("pose.png", camera, {}, {}, 0)));
    attacks.push_back(opened(moves_bytes({{"pose.png", camera}})));
    camera = room_camera(0);
    camera.cam_from_world_rotation[1][2] = wrong;
    attacks.push_back(opened(frame_bytes("turn.png", camera, {}, {}, 0)));
    camera = room_camera(0);
    camera.fx = wrong;
    attacks.push_back(opened(lens_bytes(camera)));
  }
  attacks.push_back(opened(message_bytes('S', {})));
  attacks.push_back(opened(message_bytes('S', {1, 0, 0, 0, 4, 0, 0, 0, 255, 255, 255, 255})));
  attacks.push_back(opened(piece_bytes<double>(1, TriangleSoup{{{0, 0, 0}}, {}, {{0, 0, 1}}})));
  attacks.push_back(opened(piece_bytes<float>(1, TriangleSoup{{{0, 1e30, 0}}, {}, {}})));
  Camera huge = room_camera(0);
  huge.width = huge.height = 16384;
  attacks.push_back(opened(lens_bytes(huge)));  // is allowed, and its frames have more than 64 MiB
  const Playback playback = receiver.by([&] {
    for (const StreamBytes& attack : attacks) receiver.attack_with(attack);
    receiver.attack_with(opened(room_frame(11)));  // is a frame, and then its client goes
    receiver.attack_with(opened(room_frame(11)));  // came before
    receiver.end_well(10);
  });
  CHECK(receiver.warned() == attacks.size() + 2);
  CHECK(playback.record.frames == 11);
  check_whole(playback);
}

TEST_CASE("a client that stalls gives way to one that waits, and is heard on while none waits") {
  Attacked receiver(std::chrono::milliseconds(100));
  const Playback playback = receiver.by([&] {
    const StreamClient stalling(receiver.port());
    StreamBytes half = room_opening();
    append(half, room_frame(20));
    stalling.send_all(half);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // longer than it may while another one waits
    stalling.send_all(room_frame(21));
    half = room_frame(22);
    half.resize(half.size() / 2);
    stalling.send_all(half);
    receiver.end_well(10);
  });
  CHECK(receiver.warned() == 1);
  CHECK(playback.record.frames == 12);
  check_whole(playback);
}

}  // namespace
}  // namespace lumatlas
