// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/playback/frame_message.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "tools/scene/forms/capture.h"

namespace lumatlas {

namespace {

constexpr std::string_view kGreeting = "LUMLIVE1";
constexpr std::size_t kHeaderBytes = 8;  // type, three zeros, length
constexpr std::size_t kMostPayload = std::size_t{64} << 20U;
constexpr std::size_t kMostName = 1024;
constexpr std::uint32_t kMostSide = 16384;  // pixels
constexpr double kFarthest = 1e9;           // scene units; a globe has less than 1e7 metres
constexpr double kSquare = 0.01;            // by which axes may miss length 1 and right angles

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are sent");

// Takes one field after the other from a payload.
class Fields {
 public:
  explicit Fields(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <typename Number>
  Number number() {
    Number value;
    const std::span<const std::uint8_t> from = take(sizeof value);
    std::memcpy(&value, from.data(), sizeof value);
    return value;
  }
  std::span<const std::uint8_t> take(std::size_t count) {
    if (count > bytes_.size() - at_) throw InputError("is shorter than its fields");
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }
  std::string name() {
    const auto length = number<std::uint32_t>();
    if (length == 0 || length > kMostName) throw InputError("has a name of " + std::to_string(length) + " bytes");
    const std::span<const std::uint8_t> bytes = take(length);
    std::string text(bytes.begin(), bytes.end());
    try {
      (void)nlohmann::json(text).dump();  // models are JSON
    } catch (const nlohmann::json::type_error&) {
      throw InputError("has a name that is not UTF-8");
    }
    if (!inner_path(text))
      throw InputError("has a name that cannot be the name of a file in a folder: " + in_quotes(text));
    return text;
  }
  // Sets rotation and translation, by rows: three of the rotation, each with its number of the translation behind it.
  void pose(Camera& camera) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) camera.cam_from_world_rotation[column][row] = number<double>();
      camera.cam_from_world_translation[row] = number<double>();
    }
    glm::dmat3& rotation = camera.cam_from_world_rotation;
    require_rotation(rotation);
    rotation = glm::mat3_cast(glm::normalize(glm::quat_cast(rotation)));
    check_camera(camera);
    if (!(glm::length(camera.center()) < kFarthest)) throw InputError("has a pose that is too far from the origin");
  }
  void end() const {
    if (at_ != bytes_.size()) throw InputError("is longer than its fields");
  }

  static void check_camera(const Camera& camera) {
    try {
      check(camera);
    } catch (const std::invalid_argument& error) {
      throw InputError(std::string("has an impossible camera: ") + error.what());
    }
  }

 private:
  static void require_rotation(const glm::dmat3& rotation) {
    const glm::dmat3 product = rotation * glm::transpose(rotation);
    for (int i = 0; i < 9; ++i) {
      const double expected = i % 4 == 0 ? 1 : 0;
      if (!(std::abs(product[i / 3][i % 3] - expected) < kSquare)) throw InputError("has a pose that is no rotation");
    }
    if (!(glm::determinant(rotation) > 0)) throw InputError("has a pose that is mirrored");
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

Camera lens_from(Fields& fields) {
  Camera lens;
  lens.width = fields.number<std::uint32_t>();
  lens.height = fields.number<std::uint32_t>();
  if (std::max(lens.width, lens.height) > kMostSide) throw InputError("has a camera of too many pixels");
  lens.fx = fields.number<double>();
  lens.fy = fields.number<double>();
  lens.cx = fields.number<double>();
  lens.cy = fields.number<double>();
  Fields::check_camera(lens);
  fields.end();
  return lens;
}

FrameMessage frame_from(Fields& fields, const std::optional<Camera>& lens) {
  if (!lens) throw InputError("comes before the lens");
  FrameMessage frame;
  frame.camera = *lens;
  frame.name = fields.name();
  fields.pose(frame.camera);
  const std::span<const std::uint8_t> photograph = fields.take(fields.number<std::uint32_t>());
  frame.photograph.assign(photograph.begin(), photograph.end());
  frame.depth_unit = fields.number<double>();
  if (frame.depth_unit != 0) {
    if (!(std::isfinite(frame.depth_unit) && frame.depth_unit > 0)) throw InputError("has a unit of depths below 0");
    frame.depth.resize(std::size_t{lens->width} * lens->height);
    const std::span<const std::uint8_t> depth = fields.take(2 * frame.depth.size());
    std::memcpy(frame.depth.data(), depth.data(), depth.size());
  }
  fields.end();
  return frame;
}

MovesMessage moves_from(Fields& fields, const std::optional<Camera>& lens) {
  if (!lens) throw InputError("comes before the lens");
  MovesMessage moves;
  const auto count = fields.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    MovedView view{fields.name(), *lens};
    fields.pose(view.camera);
    moves.views.push_back(std::move(view));
  }
  fields.end();
  return moves;
}

// Takes `count` triples of numbers. The bytes are there before any memory is asked for.
template <typename Number>
std::vector<glm::vec<3, Number>> triples_from(Fields& fields, std::uint32_t count) {
  static_assert(sizeof(glm::vec<3, Number>) == 3 * sizeof(Number));
  const std::span<const std::uint8_t> bytes = fields.take(std::size_t{count} * 3 * sizeof(Number));
  std::vector<glm::vec<3, Number>> triples(count);
  if (count > 0) std::memcpy(triples.data(), bytes.data(), bytes.size());
  return triples;
}

PieceMessage piece_from(Fields& fields) {
  PieceMessage piece;
  piece.id = fields.number<std::uint32_t>();
  const auto bytes = fields.number<std::uint32_t>();
  if (bytes != sizeof(float) && bytes != sizeof(double)) {
    throw InputError("has coordinates of " + std::to_string(bytes) + " bytes, which must be 4 or 8");
  }
  const auto vertices = fields.number<std::uint32_t>();
  if (bytes == sizeof(float)) {
    const std::vector<glm::vec3> positions = triples_from<float>(fields, vertices);
    piece.surface.positions.assign(positions.begin(), positions.end());
  } else {
    piece.surface.positions = triples_from<double>(fields, vertices);
  }
  piece.surface.faces = triples_from<std::uint32_t>(fields, fields.number<std::uint32_t>());
  fields.end();
  for (const glm::dvec3& position : piece.surface.positions) {
    if (!(glm::length(position) < kFarthest)) throw InputError("has a vertex that is too far from the origin");
  }
  for (const glm::uvec3& face : piece.surface.faces) {
    if (std::max({face.x, face.y, face.z}) >= vertices) {
      throw InputError("has a triangle of a vertex that is not there: of " + std::to_string(vertices) + ", number " +
                       std::to_string(std::max({face.x, face.y, face.z})));
    }
  }
  return piece;
}

}  // namespace

void MessageReader::add(std::span<const std::uint8_t> bytes) {
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(read_));
  read_ = 0;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::optional<LiveMessage> MessageReader::next() {
  const auto left = [&] { return std::span<const std::uint8_t>(bytes_).subspan(read_); };
  if (!greeted_) {
    const std::size_t common = std::min(left().size(), kGreeting.size());
    if (!std::equal(left().begin(), left().begin() + static_cast<std::ptrdiff_t>(common), kGreeting.begin())) {
      throw InputError("greeting is not " + std::string(kGreeting));
    }
    if (common < kGreeting.size()) return std::nullopt;
    greeted_ = true;
    read_ += kGreeting.size();
  }
  while (left().size() >= kHeaderBytes) {
    const std::string place = "message " + std::to_string(messages_ + 1) + " ";
    const auto type = static_cast<char>(left()[0]);
    if (std::string_view("LFMSE").find(type) == std::string_view::npos) {
      throw InputError(place + "is of no known type: " + std::to_string(left()[0]));
    }
    std::uint32_t length = 0;
    std::memcpy(&length, left().data() + 4, sizeof length);
    if (length > kMostPayload) throw InputError(place + "has " + std::to_string(length) + " bytes, more than 64 MiB");
    if (left().size() < kHeaderBytes + length) return std::nullopt;
    Fields fields(left().subspan(kHeaderBytes, length));
    read_ += kHeaderBytes + length;
    ++messages_;
    try {
      if (type == 'L') {
        lens_ = lens_from(fields);
        continue;
      }
      if (type == 'F') return frame_from(fields, lens_);
      if (type == 'M') return moves_from(fields, lens_);
      if (type == 'S') return piece_from(fields);
      fields.end();
      return EndMessage{};
    } catch (const InputError& error) {
      throw InputError(place + error.what());
    }
  }
  return std::nullopt;
}

}  // namespace lumatlas
