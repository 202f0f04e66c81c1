// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/colmap/colmap_writer.h"

#include <algorithm>
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

CameraModel lens_of(const WrittenView& view) {
  if (!view.lens) {
    const Camera& c = view.camera;
    return {LensModel::kPinhole, c.width, c.height, {c.fx, c.fy, c.cx, c.cy}};
  }
  if (static_cast<std::int32_t>(view.lens->model) >= kColmapModelCount) {
    throw std::invalid_argument(view.name + ": COLMAP has no model of its lens (" +
                                std::string(name(view.lens->model)) + ")");
  }
  return *view.lens;
}

// The distinct lenses, in the order in which they appear, and the id of each image's, from 1.
struct Lenses {
  std::vector<CameraModel> all;
  std::vector<std::uint32_t> ids;
};

Lenses lenses_of(std::span<const WrittenView> images) {
  Lenses lenses;
  std::map<std::array<double, 19>, std::uint32_t> known;
  for (const WrittenView& image : images) {
    const CameraModel lens = lens_of(image);
    std::array<double, 19> key{static_cast<double>(lens.model), static_cast<double>(lens.width),
                               static_cast<double>(lens.height)};
    std::copy(lens.parameters.begin(), lens.parameters.end(), key.begin() + 3);
    const auto [found, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(known.size() + 1));
    if (is_new) lenses.all.push_back(lens);
    lenses.ids.push_back(found->second);
  }
  return lenses;
}

Bytes cameras_file(const std::vector<CameraModel>& lenses) {
  Bytes bytes;
  bytes.put<std::uint64_t>(lenses.size());
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    bytes.put(static_cast<std::uint32_t>(i + 1));
    bytes.put(static_cast<std::int32_t>(lenses[i].model));
    bytes.put(std::uint64_t{lenses[i].width});
    bytes.put(std::uint64_t{lenses[i].height});
    for (std::size_t at = 0; at < parameter_count(lenses[i].model); ++at) bytes.put<double>(lenses[i].parameters[at]);
  }
  return bytes;
}

std::uint32_t id_of(std::span<const WrittenView> images, std::size_t image) {
  return images[image].id != 0 ? images[image].id : static_cast<std::uint32_t>(image + 1);
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

Bytes images_file(std::span<const WrittenView> images, const std::vector<std::uint32_t>& lens_ids,
                  const std::vector<std::vector<Keypoint>>& keypoints) {
  Bytes bytes;
  bytes.put<std::uint64_t>(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    bytes.put(id_of(images, i));
    put_pose(images[i].camera, bytes);
    bytes.put(lens_ids[i]);
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
      points_file.put(id_of(images, seen.image));
      points_file.put(static_cast<std::uint32_t>(keypoints[seen.image].size()));
      keypoints[seen.image].push_back({seen.position, i + 1});
    }
  }
  const Lenses lenses = lenses_of(images);
  cameras_file(lenses.all).write(folder / "cameras.bin");
  images_file(images, lenses.ids, keypoints).write(folder / "images.bin");
  points_file.write(folder / "points3D.bin");
}

}  // namespace lumatlas
