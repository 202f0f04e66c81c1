// SPDX-License-Identifier: GPL-3.0-or-later
// The bytes of a stream as a client writes them: tools/live/README.md.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "tools/live/live_model.h"

namespace lumatlas {

using StreamBytes = std::vector<std::uint8_t>;

template <typename Number>
void append_number(StreamBytes& bytes, Number value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

inline void append(StreamBytes& bytes, const StreamBytes& more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

inline void append_text(StreamBytes& bytes, std::string_view text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

inline void append_pose(StreamBytes& bytes, const std::string& name, const Camera& camera) {
  append_number(bytes, static_cast<std::uint32_t>(name.size()));
  append_text(bytes, name);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) append_number(bytes, camera.cam_from_world_rotation[column][row]);
    append_number(bytes, camera.cam_from_world_translation[row]);
  }
}

[[nodiscard]] inline StreamBytes greeting_bytes() {
  StreamBytes bytes;
  append_text(bytes, "LUMLIVE1");
  return bytes;
}

[[nodiscard]] inline StreamBytes message_bytes(char type, const StreamBytes& payload) {
  StreamBytes bytes{static_cast<std::uint8_t>(type), 0, 0, 0};
  append_number(bytes, static_cast<std::uint32_t>(payload.size()));
  append(bytes, payload);
  return bytes;
}

[[nodiscard]] inline StreamBytes lens_bytes(const Camera& camera) {
  StreamBytes payload;
  append_number(payload, camera.width);
  append_number(payload, camera.height);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) append_number(payload, value);
  return message_bytes('L', payload);
}

[[nodiscard]] inline StreamBytes frame_bytes(const std::string& name, const Camera& camera,
                                             const StreamBytes& photograph, const std::vector<std::uint16_t>& depth,
                                             double unit) {
  StreamBytes payload;
  append_pose(payload, name, camera);
  append_number(payload, static_cast<std::uint32_t>(photograph.size()));
  append(payload, photograph);
  append_number(payload, unit);
  for (const std::uint16_t value : depth) append_number(payload, value);
  return message_bytes('F', payload);
}

[[nodiscard]] inline StreamBytes moves_bytes(const std::vector<MovedView>& views) {
  StreamBytes payload;
  append_number(payload, static_cast<std::uint32_t>(views.size()));
  for (const MovedView& view : views) append_pose(payload, view.name, view.camera);
  return message_bytes('M', payload);
}

// A piece of surface whose coordinates are numbers of this type.
template <typename Number>
[[nodiscard]] StreamBytes piece_bytes(std::uint32_t id, const TriangleSoup& piece) {
  StreamBytes payload;
  append_number(payload, id);
  append_number(payload, static_cast<std::uint32_t>(sizeof(Number)));
  append_number(payload, static_cast<std::uint32_t>(piece.positions.size()));
  for (const glm::dvec3& position : piece.positions) {
    for (int axis = 0; axis < 3; ++axis) append_number(payload, static_cast<Number>(position[axis]));
  }
  append_number(payload, static_cast<std::uint32_t>(piece.faces.size()));
  for (const glm::uvec3& face : piece.faces) {
    for (int corner = 0; corner < 3; ++corner) append_number(payload, face[corner]);
  }
  return message_bytes('S', payload);
}

// Six pixels.
[[nodiscard]] inline Camera small_lens() {
  Camera camera;
  camera.width = 3;
  camera.height = 2;
  camera.fx = camera.fy = 2;
  camera.cx = 1.5;
  camera.cy = 1;
  return camera;
}

}  // namespace lumatlas
