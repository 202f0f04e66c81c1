// SPDX-License-Identifier: GPL-3.0-or-later
// A stream that is read from a pipe or file.
#include "tools/live/playback/frame_input.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/live/playback/stream_client.h"
#include "tests/tools/live/room_stream.h"
#include "tools/live/playback/playback.h"

namespace lumatlas {
namespace {

// A file of these bytes, open for reading.
class OpenedBytes {
 public:
  explicit OpenedBytes(const StreamBytes& bytes) {
    const std::filesystem::path file = folder_.path() / "stream";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    descriptor_ = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    REQUIRE(descriptor_ >= 0);
  }
  ~OpenedBytes() { close(descriptor_); }
  OpenedBytes(const OpenedBytes&) = delete;
  OpenedBytes& operator=(const OpenedBytes&) = delete;
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  TemporaryFolder folder_;
  int descriptor_ = -1;
};

struct Read {
  Playback playback;
  std::vector<std::string> warnings;
};

Read read_stream(int descriptor) {
  Read read;
  PlaybackOptions options;
  options.live = room_live_options();
  options.live.waiting_views = options.live.waiting_depths = 30;
  options.measure_deviation = false;
  options.finish = false;
  PlaybackCallbacks callbacks;
  callbacks.warned = [&read](const std::string& sentence) { read.warnings.push_back(sentence); };
  FrameInput input(descriptor);
  read.playback = receive_stream(input, options, callbacks);
  return read;
}

StreamBytes stream_of(std::size_t frames) {
  StreamBytes bytes = room_opening();
  for (std::size_t number = 0; number < frames; ++number) append(bytes, room_frame(number));
  return bytes;
}

void check_stored(const Playback& playback, std::size_t frames) {
  CHECK(playback.record.frames == frames);
  CHECK_FALSE(playback.record.ended_early);
  CHECK(playback.record.live.failed == 0);
  CHECK(playback.record.live.stored > 1);
  CHECK_NOTHROW(check(playback.result.snapshot));
}

TEST_CASE("a stream in a file ends with the file, with or without an end message") {
  StreamBytes bytes = stream_of(6);
  if (GENERATE(false, true)) append(bytes, message_bytes('E', {}));
  const Read read = read_stream(OpenedBytes(bytes).descriptor());
  CHECK(read.warnings.empty());
  check_stored(read.playback, 6);
}

TEST_CASE("a stream comes through a pipe as it is written, and what follows its end message is not read") {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  std::thread writer([&] {
    StreamBytes bytes = stream_of(6);
    append(bytes, message_bytes('E', {}));
    append(bytes, room_frame(6));
    append_text(bytes, "this is no message, and long enough to be read as the head of one");
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t written = write(ends[1], bytes.data() + at, std::min<std::size_t>(bytes.size() - at, 10'000));
      if (written <= 0) break;
      at += static_cast<std::size_t>(written);
    }
  });
  const Read read = read_stream(ends[0]);  // its other end is still open
  writer.join();
  close(ends[0]);
  close(ends[1]);
  CHECK(read.warnings.empty());
  check_stored(read.playback, 6);
}

TEST_CASE("a stream that is cut off in a message keeps the frames before, and says so") {
  StreamBytes bytes = stream_of(6);
  bytes.resize(bytes.size() - 1);
  const Read read = read_stream(OpenedBytes(bytes).descriptor());
  REQUIRE(read.warnings.size() == 1);
  CHECK(read.warnings.front() == "the input ends in the middle of a message; what came before stays");
  check_stored(read.playback, 5);
}

TEST_CASE("nonsense in a file ends the stream with a warning, and frames before it stay") {
  StreamBytes bytes = stream_of(5);
  append_text(bytes, "this is no message, and long enough to be read as the head of one");
  append(bytes, room_frame(5));
  const Read read = read_stream(OpenedBytes(bytes).descriptor());
  REQUIRE(read.warnings.size() == 1);
  CHECK_THAT(read.warnings.front(), Catch::StartsWith("the input's message") &&
                                        Catch::EndsWith("no more of it is taken, what came before stays"));
  check_stored(read.playback, 5);
}

TEST_CASE("an input without a frame makes no model, and one that cannot be read is refused") {
  CHECK_THROWS_WITH(read_stream(OpenedBytes({}).descriptor()), "no frame arrived, so no model was saved");
  CHECK_THROWS_WITH(read_stream(OpenedBytes(StreamBytes(1000, 'x')).descriptor()),
                    "no frame arrived, so no model was saved");
  const TemporaryFolder folder;
  const int directory = open(folder.path().c_str(), O_RDONLY | O_CLOEXEC);
  CHECK_THROWS_WITH(read_stream(directory), Catch::StartsWith("the input cannot be read: "));
  close(directory);
}

}  // namespace
}  // namespace lumatlas
