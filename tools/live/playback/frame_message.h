// SPDX-License-Identifier: GPL-3.0-or-later
// The messages by which another program sends a stream of frames. tools/live/README.md describes each byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"
#include "tools/live/live_model.h"

namespace lumatlas {

// A frame: a photograph, a depth image, or both, from one pose.
struct FrameMessage {
  std::string name;
  Camera camera;
  std::vector<std::uint8_t> photograph;  // a PNG or JPEG file; empty: none
  std::vector<std::uint16_t> depth;      // row by row, 0: not measured; empty: none
  double depth_unit = 0;                 // scene units that a stored 1 is
};

struct MovesMessage {
  std::vector<MovedView> views;
};

// A piece of surface, see LiveModel::replace_piece().
struct PieceMessage {
  std::uint32_t id = 0;
  TriangleSoup surface;  // in the stream's own coordinates
};

struct EndMessage {};

using LiveMessage = std::variant<FrameMessage, MovesMessage, PieceMessage, EndMessage>;

// Puts messages together from bytes as they come. It holds at most one message, of 64 MiB.
class MessageReader {
 public:
  // Adds bytes of the stream.
  void add(std::span<const std::uint8_t> bytes);
  // Returns the next whole message; none if more bytes are needed. Throws InputError, a sentence that says which
  // message and what about it, where the bytes are no messages; nothing can be read after that.
  [[nodiscard]] std::optional<LiveMessage> next();
  // Returns whether bytes were added that next() has not returned: a part of a message, once it returns none.
  [[nodiscard]] bool has_more() const { return read_ < bytes_.size(); }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t read_ = 0;  // of these
  std::size_t messages_ = 0;
  bool greeted_ = false;
  std::optional<Camera> lens_;
};

}  // namespace lumatlas
