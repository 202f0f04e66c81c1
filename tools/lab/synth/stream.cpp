// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/stream.h"

#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <iomanip>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "mesh/base/errors.h"
#include "tools/lab/synth/random.h"
#include "tools/lab/synth/scan.h"

namespace lumatlas::synth {
namespace {

constexpr double kStepsPerUnit = 5000;  // of TUM depth files
constexpr double kHalfPixel = 0.5;      // TUM counts from the middle of the first pixel

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw InputError(path.string() + ": cannot be written");
}

void add_big_endian(std::string& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes += static_cast<char>((value >> static_cast<unsigned>(shift)) & 255U);
}

void add_png_chunk(std::string& png, std::string_view type, const std::string& data) {
  add_big_endian(png, static_cast<std::uint32_t>(data.size()));
  const std::string checked = std::string(type) + data;
  png += checked;
  const auto* first = reinterpret_cast<const Bytef*>(checked.data());
  add_big_endian(png, static_cast<std::uint32_t>(crc32(0, first, static_cast<uInt>(checked.size()))));
}

std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string result(size, '\0');
  compress2(reinterpret_cast<Bytef*>(result.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
            static_cast<uLong>(bytes.size()), Z_BEST_SPEED);
  result.resize(size);
  return result;
}

// A PNG of one channel of 16 bits.
std::string depth_png(const DepthImage& image) {
  std::string rows;
  for (std::uint32_t y = 0; y < image.camera.height; ++y) {
    rows += '\0';  // the row is not filtered
    for (std::uint32_t x = 0; x < image.camera.width; ++x) {
      const double steps = std::round(kStepsPerUnit * image.depth[std::size_t{y} * image.camera.width + x]);
      const auto value = static_cast<std::uint32_t>(std::clamp(steps, 0.0, 65535.0));
      rows += static_cast<char>(value >> 8U);
      rows += static_cast<char>(value & 255U);
    }
  }
  std::string header;
  add_big_endian(header, image.camera.width);
  add_big_endian(header, image.camera.height);
  header += std::string("\x10\0\0\0\0", 5);  // 16 bits, grey
  std::string png("\x89PNG\r\n\x1a\n", 8);
  add_png_chunk(png, "IHDR", header);
  add_png_chunk(png, "IDAT", deflated(rows));
  add_png_chunk(png, "IEND", {});
  return png;
}

std::string pose_line(const Camera& camera) {
  const glm::dvec3 center = camera.center();
  const glm::dquat q = glm::quat_cast(glm::transpose(camera.cam_from_world_rotation));
  std::ostringstream line;
  line << std::setprecision(12);
  for (const double value : {center.x, center.y, center.z, q.x, q.y, q.z, q.w}) line << ' ' << value;
  return line.str() + '\n';
}

}  // namespace

void write_stream(const std::filesystem::path& folder, std::span<const StreamFrame> frames, const Tracer& tracer,
                  double rate, std::uint64_t seed) {
  std::error_code error;
  for (const char* name : {"rgb", "depth"}) {
    std::filesystem::create_directories(folder / name, error);
    if (error) throw InputError((folder / name).string() + ": cannot be created: " + error.message());
  }
  std::string rgb, depth, poses;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string name = frames[i].photograph.filename().string();
    std::ostringstream time;
    time << std::fixed << std::setprecision(6) << static_cast<double>(i) / rate;
    rgb += time.str() + " rgb/" + name + '\n';
    depth += time.str() + " depth/" + name + '\n';
    poses += time.str() + pose_line(frames[i].written);
  }
  tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t i) {
    const std::filesystem::path name = frames[i].photograph.filename();
    std::error_code failure;
    std::filesystem::copy_file(frames[i].photograph, folder / "rgb" / name, failure);
    if (failure) throw InputError((folder / "rgb" / name).string() + ": cannot be written: " + failure.message());
    write_bytes(folder / "depth" / name, depth_png(depth_image(tracer, frames[i].true_camera, hashed(seed, 5, i))));
  });
  write_bytes(folder / "rgb.txt", rgb);
  write_bytes(folder / "depth.txt", depth);
  write_bytes(folder / "groundtruth.txt", poses);
  if (frames.empty()) return;
  const Camera& lens = frames.front().written;
  std::ostringstream camera;
  camera << std::setprecision(12) << lens.fx << ' ' << lens.fy << ' ' << lens.cx - kHalfPixel << ' '
         << lens.cy - kHalfPixel << '\n';
  write_bytes(folder / "camera.txt", camera.str());
}

}  // namespace lumatlas::synth
