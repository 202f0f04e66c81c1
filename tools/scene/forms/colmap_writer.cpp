// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/colmap_writer.h"

#include <array>
#include <bit>
#include <cstring>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <stdexcept>

#include "mesh/base/whole_file.h"

namespace lumatlas {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are written as the machine holds the numbers");

constexpr std::int32_t kPinhole = 1;  // COLMAP's model id: fx, fy, cx, cy

// A file's bytes; put() appends a number as it lies in memory.
class Bytes {
 public:
  template <typename T>
  void put(T value) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    text_.append(raw.data(), raw.size());
  }
  void put_text(const std::string& text) { text_.append(text.c_str(), text.size() + 1); }

  void write(const std::filesystem::path& path) const { write_whole_file(path, text_, Durability::left_to_folder); }

 private:
  std::string text_;
};

using LensKey = std::array<double, 6>;

LensKey lens_key(const Camera& c) {
  return {static_cast<double>(c.width), static_cast<double>(c.height), c.fx, c.fy, c.cx, c.cy};
}

// Id of each distinct lens, from 1, in the order in which they appear.
std::map<LensKey, std::uint32_t> lens_ids(std::span<const WrittenView> images) {
  std::map<LensKey, std::uint32_t> ids;
  for (const WrittenView& image : images)
    ids.try_emplace(lens_key(image.camera), static_cast<std::uint32_t>(ids.size() + 1));
  return ids;
}

Bytes cameras_file(const std::map<LensKey, std::uint32_t>& ids) {
  std::map<std::uint32_t, LensKey> by_id;
  for (const auto& [lens, id] : ids) by_id[id] = lens;
  Bytes bytes;
  bytes.put<std::uint64_t>(by_id.size());
  for (const auto& [id, lens] : by_id) {
    bytes.put<std::uint32_t>(id);
    bytes.put<std::int32_t>(kPinhole);
    bytes.put(static_cast<std::uint64_t>(lens[0]));
    bytes.put(static_cast<std::uint64_t>(lens[1]));
    for (std::size_t i = 2; i < lens.size(); ++i) bytes.put<double>(lens[i]);
  }
  return bytes;
}

struct Keypoint {
  glm::dvec2 position;
  std::uint64_t point_id;
};

void put_pose(const Camera& camera, Bytes& bytes) {
  glm::dquat q = glm::normalize(glm::quat_cast(camera.cam_from_world_rotation));
  if (q.w < 0) q = -q;
  for (const double value : {q.w, q.x, q.y, q.z}) bytes.put<double>(value);
  for (int axis = 0; axis < 3; ++axis) bytes.put<double>(camera.cam_from_world_translation[axis]);
}

Bytes images_file(std::span<const WrittenView> images, const std::map<LensKey, std::uint32_t>& lenses,
                  const std::vector<std::vector<Keypoint>>& keypoints) {
  Bytes bytes;
  bytes.put<std::uint64_t>(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    bytes.put(static_cast<std::uint32_t>(i + 1));
    put_pose(images[i].camera, bytes);
    bytes.put<std::uint32_t>(lenses.at(lens_key(images[i].camera)));
    bytes.put_text(images[i].name);
    bytes.put<std::uint64_t>(keypoints[i].size());
    for (const Keypoint& keypoint : keypoints[i]) {
      bytes.put<double>(keypoint.position.x);
      bytes.put<double>(keypoint.position.y);
      bytes.put<std::uint64_t>(keypoint.point_id);
    }
  }
  return bytes;
}

void put_point(const TrackedPoint& point, std::uint64_t id, Bytes& bytes) {
  bytes.put<std::uint64_t>(id);
  for (int axis = 0; axis < 3; ++axis) bytes.put<double>(point.position[axis]);
  for (int channel = 0; channel < 3; ++channel) bytes.put<std::uint8_t>(point.color[channel]);
  bytes.put<double>(0);  // reprojection error, pixels
  bytes.put<std::uint64_t>(point.track.size());
}

}  // namespace

void write_colmap_model(const std::filesystem::path& folder, std::span<const WrittenView> images,
                        std::span<const TrackedPoint> points) {
  std::vector<std::vector<Keypoint>> keypoints(images.size());
  Bytes points_file;
  points_file.put<std::uint64_t>(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    put_point(points[i], i + 1, points_file);
    for (const PointObservation& seen : points[i].track) {
      if (seen.image >= images.size()) {
        throw std::invalid_argument("point " + std::to_string(i) + ": its track names image " +
                                    std::to_string(seen.image) + ", must be below " + std::to_string(images.size()));
      }
      points_file.put<std::uint32_t>(seen.image + 1);
      points_file.put(static_cast<std::uint32_t>(keypoints[seen.image].size()));
      keypoints[seen.image].push_back({seen.position, i + 1});
    }
  }
  const std::map<LensKey, std::uint32_t> lenses = lens_ids(images);
  cameras_file(lenses).write(folder / "cameras.bin");
  images_file(images, lenses, keypoints).write(folder / "images.bin");
  points_file.write(folder / "points3D.bin");
}

}  // namespace lumatlas
