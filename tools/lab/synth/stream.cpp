// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/stream.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <iomanip>
#include <sstream>
#include <system_error>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "tools/lab/synth/random.h"
#include "tools/lab/synth/scan.h"

namespace lumatlas::synth {
namespace {

constexpr double kStepsPerUnit = 5000;  // of TUM depth files
constexpr double kHalfPixel = 0.5;      // TUM counts from the middle of the first pixel

template <typename Bytes>
void write_bytes(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw InputError(path.string() + ": cannot be written");
}

std::vector<std::uint8_t> depth_png(const DepthImage& image) {
  GreyImage steps{image.camera.width, image.camera.height, {}};
  for (const float depth : image.depth) {
    steps.values.push_back(static_cast<std::uint16_t>(std::clamp(std::round(kStepsPerUnit * depth), 0.0, 65535.0)));
  }
  return encode_grey_image(steps);
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
