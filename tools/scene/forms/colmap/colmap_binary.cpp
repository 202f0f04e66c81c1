// SPDX-License-Identifier: GPL-3.0-or-later
// COLMAP's binary files, little-endian without padding:
//
//   cameras.bin: u64 count; each u32 id, i32 model, u64 width, u64 height, f64 parameters[as the model has]
//   images.bin:  u64 count; each u32 id, f64 quaternion[4] (w first), f64 translation[3], u32 camera, name and a 0
//                byte, u64 point count, each point f64 x, f64 y, u64 point id
//   points3D.bin: u64 count; each u64 id, f64 position[3], u8 rgb[3], f64 error,
//                u64 track length, each entry u32 image, u32 index of the 2D point in it
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "mesh/base/errors.h"
#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/forms/colmap/colmap_records.h"

namespace lumatlas {
namespace {

using colmap::fail;
using colmap::FileLocation;

static_assert(std::endian::native == std::endian::little, "COLMAP's files are read as they lie in memory");

constexpr std::size_t kLongestName = 4096;  // bytes; what Linux accepts as a path
constexpr std::size_t kPointBytes = 24;

class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> file) : file_(file) {}

  [[nodiscard]] std::size_t remaining() const { return file_.size() - position_; }

  template <typename T>
  T read(const FileLocation& place) {
    if (remaining() < sizeof(T)) {
      fail(place, "the file ends inside it, at byte " + std::to_string(file_.size()) + ": it is cut off");
    }
    T value;
    std::memcpy(&value, file_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }

  std::string_view read_name(const FileLocation& place) {
    const auto* const begin = reinterpret_cast<const char*>(file_.data()) + position_;
    const std::string_view window(begin, std::min(remaining(), kLongestName + 1));
    const std::size_t length = window.find('\0');
    if (length == std::string_view::npos) {
      fail(place, window.size() > kLongestName ? "its name is longer than 4096 bytes: the file is damaged"
                                               : "the file ends inside its name: it is cut off");
    }
    position_ += length + 1;
    return window.substr(0, length);
  }

  void skip_points(const FileLocation& place) {
    const auto count = read<std::uint64_t>(place);
    if (count > remaining() / kPointBytes) {
      fail(place, "it claims " + std::to_string(count) + " points, but " + std::to_string(remaining()) +
                      " bytes are left, " + std::to_string(kPointBytes) + " a point: the file is cut off or damaged");
    }
    position_ += count * kPointBytes;
  }

 private:
  std::span<const std::byte> file_;
  std::size_t position_ = 0;
};

// The number of records that a file begins with, once it is clear that it can hold them.
std::size_t read_count(Cursor& cursor, const std::filesystem::path& path, const char* records,
                       std::size_t smallest_record) {
  if (cursor.remaining() < sizeof(std::uint64_t)) {
    throw InputError(path.string() + ": is " + std::to_string(cursor.remaining()) + " bytes long, too short for the " +
                     "number of " + records + " that it must begin with");
  }
  const auto count = cursor.read<std::uint64_t>({path, "byte", 0});
  if (count > cursor.remaining() / smallest_record) {
    throw InputError(path.string() + ": claims " + std::to_string(count) + " " + records + ", but the " +
                     std::to_string(cursor.remaining()) + " bytes after that number hold at most " +
                     std::to_string(cursor.remaining() / smallest_record) + ": the file is cut off or damaged");
  }
  return count;
}

void require_end(const Cursor& cursor, const std::filesystem::path& path, std::size_t count, const char* records) {
  if (cursor.remaining() > 0) {
    throw InputError(path.string() + ": " + std::to_string(cursor.remaining()) + " bytes follow the " +
                     std::to_string(count) + " " + records + " that it claims: the file is damaged");
  }
}

std::uint32_t read_size(Cursor& cursor, const char* what, const FileLocation& place) {
  const auto size = cursor.read<std::int64_t>(place);  // COLMAP's type has no sign, but a negative one says more
  if (size < 1 || size > 65536) {
    fail(place, std::string(what) + " is " + std::to_string(size) + ", must be in [1, 65536]");
  }
  return static_cast<std::uint32_t>(size);
}

ColmapCamera read_camera(Cursor& cursor, const FileLocation& place, BadPhotographs bad) {
  ColmapCamera camera;
  camera.id = cursor.read<std::uint32_t>(place);
  const auto id = cursor.read<std::int32_t>(place);
  const std::optional<LensModel> model = lens_model(id);
  if (!model) {
    fail(place, "its lens model is " + std::to_string(id) + ", must be one of COLMAP's, in [0, 17]");
  }
  camera.lens.model = *model;
  camera.lens.width = read_size(cursor, "width", place);
  camera.lens.height = read_size(cursor, "height", place);
  for (std::size_t i = 0; i < parameter_count(*model); ++i) {
    camera.lens.parameters[i] = cursor.read<double>(place);
  }
  colmap::check_camera(camera, place, bad);
  return camera;
}

template <std::size_t N>
std::array<double, N> read_doubles(Cursor& cursor, const FileLocation& place) {
  std::array<double, N> values;
  for (double& value : values) {
    value = cursor.read<double>(place);
  }
  return values;
}

ColmapImage read_image(Cursor& cursor, const FileLocation& place, BadPhotographs bad) {
  const auto id = cursor.read<std::uint32_t>(place);
  const auto quaternion = read_doubles<4>(cursor, place);
  const auto translation = read_doubles<3>(cursor, place);
  const auto camera_id = cursor.read<std::uint32_t>(place);
  const std::string_view name = cursor.read_name(place);
  cursor.skip_points(place);
  return colmap::checked_image(id, quaternion, translation, camera_id, name, place, bad);
}

ColmapPoint read_point(Cursor& cursor, const FileLocation& place) {
  constexpr std::size_t kEntryBytes = 8;
  (void)cursor.read<std::uint64_t>(place);
  const auto position = read_doubles<3>(cursor, place);
  ColmapPoint point{{position[0], position[1], position[2]}, {}, {}};
  for (int channel = 0; channel < 3; ++channel) point.color[channel] = cursor.read<std::uint8_t>(place);
  (void)cursor.read<double>(place);
  const auto length = cursor.read<std::uint64_t>(place);
  if (length > cursor.remaining() / kEntryBytes) {
    fail(place, "it claims to be seen by " + std::to_string(length) + " images, but " +
                    std::to_string(cursor.remaining()) + " bytes are left, " + std::to_string(kEntryBytes) +
                    " an image: the file is cut off or damaged");
  }
  point.images.reserve(length);
  for (std::uint64_t i = 0; i < length; ++i) {
    point.images.push_back(cursor.read<std::uint32_t>(place));
    (void)cursor.read<std::uint32_t>(place);
  }
  colmap::check_point(point, place);
  return point;
}

// All records of a file. `records` and `record` are what they are called, and one of them where it stands; one takes at
// least `smallest` bytes.
template <typename Read>
auto read_records(std::span<const std::byte> file, const std::filesystem::path& path, const char* records,
                  const char* record, std::size_t smallest, const Read& read) {
  Cursor cursor(file);
  const std::size_t count = read_count(cursor, path, records, smallest);
  std::vector<decltype(read(cursor, {path, record, 0}))> all;
  all.reserve(count);
  for (std::size_t i = 0; i < count; ++i) all.push_back(read(cursor, {path, record, i}));
  require_end(cursor, path, count, records);
  return all;
}

}  // namespace

std::vector<ColmapPoint> parse_points_binary(std::span<const std::byte> file, const std::filesystem::path& path) {
  constexpr std::size_t kSmallestRecord = 8 + 3 * 8 + 3 + 8 + 8;
  return read_records(file, path, "points", "the point at index", kSmallestRecord, read_point);
}

std::vector<ColmapCamera> parse_cameras_binary(std::span<const std::byte> file, const std::filesystem::path& path,
                                               BadPhotographs bad) {
  constexpr std::size_t kSmallestRecord = 4 + 4 + 8 + 8 + 2 * 8;
  const auto read = [bad](Cursor& cursor, const FileLocation& place) { return read_camera(cursor, place, bad); };
  std::vector<ColmapCamera> cameras = read_records(file, path, "cameras", "the camera at index", kSmallestRecord, read);
  colmap::check_unique(cameras, path);
  return cameras;
}

std::vector<ColmapImage> parse_images_binary(std::span<const std::byte> file, const std::filesystem::path& path,
                                             BadPhotographs bad) {
  constexpr std::size_t kSmallestRecord = 4 + 7 * 8 + 4 + 2 + 8;
  const auto read = [bad](Cursor& cursor, const FileLocation& place) { return read_image(cursor, place, bad); };
  std::vector<ColmapImage> images = read_records(file, path, "images", "the image at index", kSmallestRecord, read);
  colmap::check_unique(images, path, bad);
  return images;
}

}  // namespace lumatlas
