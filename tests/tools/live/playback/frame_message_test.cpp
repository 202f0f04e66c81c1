// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/frame_message.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <limits>

#include "mesh/base/errors.h"
#include "tests/tools/live/playback/stream_bytes.h"

namespace lumatlas {
namespace {

std::string refusal_of(const StreamBytes& bytes) {
  MessageReader reader;
  reader.add(bytes);
  try {
    while (reader.next()) {
    }
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST_CASE("messages are read as they were written, wherever the bytes are cut") {
  Camera camera = small_lens();
  camera.cam_from_world_rotation = glm::dmat3(0, 1, 0, 0, 0, 1, 1, 0, 0);
  camera.cam_from_world_translation = {1, 2, 3};
  StreamBytes bytes = greeting_bytes();
  append(bytes, lens_bytes(camera));
  append(bytes, frame_bytes("a/first.png", camera, {1, 2, 3}, {0, 5000, 7, 8, 9, 65535}, 0.0002));
  append(bytes, frame_bytes("second.png", camera, {}, {}, 0));
  append(bytes, moves_bytes({{"a/first.png", camera}}));
  append(bytes, message_bytes('E', {}));
  for (const std::size_t step : {std::size_t{1}, std::size_t{7}, bytes.size()}) {
    CAPTURE(step);
    MessageReader reader;
    std::vector<LiveMessage> messages;
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      reader.add(std::span(bytes).subspan(at, std::min(step, bytes.size() - at)));
      while (std::optional<LiveMessage> message = reader.next()) messages.push_back(std::move(*message));
    }
    REQUIRE(messages.size() == 4);
    const auto& first = std::get<FrameMessage>(messages[0]);
    CHECK(first.name == "a/first.png");
    CHECK(first.camera.fx == camera.fx);
    CHECK(glm::distance(first.camera.center(), camera.center()) < 1e-12);
    CHECK(first.photograph == StreamBytes{1, 2, 3});
    CHECK(first.depth == std::vector<std::uint16_t>{0, 5000, 7, 8, 9, 65535});
    CHECK(first.depth_unit == 0.0002);
    CHECK(std::get<FrameMessage>(messages[1]).depth.empty());
    CHECK(std::get<MovesMessage>(messages[2]).views.size() == 1);
    CHECK(std::holds_alternative<EndMessage>(messages[3]));
  }
}

TEST_CASE("pieces of surface are read in both precisions, also before the lens, and refused where they are none") {
  const TriangleSoup piece{{{0.5, 1e6 + 1.0 / 3, -2}, {1, 0, 0}, {0, 1, 0.25}}, {}, {{2, 0, 1}, {1, 2, 0}}};
  StreamBytes bytes = greeting_bytes();
  append(bytes, piece_bytes<double>(7, piece));
  append(bytes, piece_bytes<float>(4294967295U, piece));
  append(bytes, piece_bytes<float>(7, {}));
  MessageReader reader;
  reader.add(bytes);
  const auto fine = std::get<PieceMessage>(reader.next().value());
  CHECK(fine.id == 7);
  CHECK(fine.surface.positions == piece.positions);
  CHECK(fine.surface.faces == piece.faces);
  const auto coarse = std::get<PieceMessage>(reader.next().value());
  CHECK(coarse.id == 4294967295U);
  CHECK(coarse.surface.positions[0] == glm::dvec3(glm::vec3(piece.positions[0])));
  CHECK(std::get<PieceMessage>(reader.next().value()).surface.faces.empty());
  CHECK_FALSE(reader.next());

  const auto refused = [](const StreamBytes& last) {
    StreamBytes all = greeting_bytes();
    append(all, last);
    return refusal_of(all);
  };
  CHECK(refused(message_bytes('S', {1, 2, 3})) == "message 1 is shorter than its fields");
  StreamBytes counts;
  for (const std::uint32_t number : {0U, 4U, 4294967295U}) append_number(counts, number);
  CHECK(refused(message_bytes('S', counts)) == "message 1 is shorter than its fields");
  counts.clear();
  for (const std::uint32_t number : {0U, 8U, 0U, 4294967295U}) append_number(counts, number);
  CHECK(refused(message_bytes('S', counts)) == "message 1 is shorter than its fields");
  counts.clear();
  for (const std::uint32_t number : {0U, 2U, 0U, 0U}) append_number(counts, number);
  CHECK_THAT(refused(message_bytes('S', counts)), Catch::Contains("coordinates of 2 bytes"));
  TriangleSoup bad = piece;
  bad.faces[1].z = 3;
  CHECK_THAT(refused(piece_bytes<double>(0, bad)), Catch::Contains("not there: of 3, number 3"));
  bad.faces[1].z = 4294967295U;
  CHECK_THAT(refused(piece_bytes<double>(0, bad)), Catch::Contains("number 4294967295"));
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 2e9}) {
    bad = piece;
    bad.positions[1].z = wrong;
    CHECK_THAT(refused(piece_bytes<double>(0, bad)), Catch::Contains("too far from the origin"));
    CHECK_THAT(refused(piece_bytes<float>(0, bad)), Catch::Contains("too far from the origin"));
  }
  StreamBytes longer = piece_bytes<float>(0, piece);
  longer[4] += 1;
  longer.push_back(0);
  CHECK(refused(longer) == "message 1 is longer than its fields");
}

TEST_CASE("bytes that are no messages are refused with the message's number and what is wrong with it") {
  const Camera camera = small_lens();
  CHECK(refusal_of({'H', 'T', 'T', 'P'}) == "greeting is not LUMLIVE1");
  const auto refused = [&](const StreamBytes& last) {
    StreamBytes bytes = greeting_bytes();
    append(bytes, lens_bytes(camera));
    append(bytes, last);
    return refusal_of(bytes);
  };
  CHECK(refused(frame_bytes("a", camera, {}, {}, 0)) == "none");
  CHECK(refused(message_bytes('X', {})) == "message 2 is of no known type: 88");
  CHECK(refused(message_bytes('F', {1, 0})) == "message 2 is shorter than its fields");
  CHECK(refused(message_bytes('E', {0})) == "message 2 is longer than its fields");
  CHECK(refused({'F', 0, 0, 0, 0, 0, 0, 255}) == "message 2 has 4278190080 bytes, more than 64 MiB");
  CHECK_THAT(refused(frame_bytes("../a", camera, {}, {}, 0)),
             Catch::Contains("name that cannot be the name of a file"));
  CHECK_THAT(refused(frame_bytes("\xff", camera, {}, {}, 0)), Catch::Contains("not UTF-8"));
  CHECK_THAT(refused(frame_bytes("a", camera, {}, {1, 2, 3, 4, 5, 6}, -1)), Catch::Contains("unit of depths"));
  Camera bad = camera;
  bad.cam_from_world_rotation[0] *= 2;
  CHECK_THAT(refused(frame_bytes("a", bad, {}, {}, 0)), Catch::Contains("no rotation"));
  bad.cam_from_world_rotation[0] *= -0.5;
  CHECK_THAT(refused(frame_bytes("a", bad, {}, {}, 0)), Catch::Contains("mirrored"));
  bad = camera;
  bad.cam_from_world_translation.x = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refused(frame_bytes("a", bad, {}, {}, 0)), Catch::Contains("impossible camera"));
  bad.cam_from_world_translation.x = 2e9;
  CHECK_THAT(refused(moves_bytes({{"a", bad}})), Catch::Contains("too far from the origin"));
  bad = camera;
  bad.width = 0;
  StreamBytes early = greeting_bytes();
  append(early, frame_bytes("a", camera, {}, {}, 0));
  CHECK(refusal_of(early) == "message 1 comes before the lens");
  CHECK_THAT(refused(lens_bytes(bad)), Catch::Contains("impossible camera"));
}

}  // namespace
}  // namespace lumatlas
