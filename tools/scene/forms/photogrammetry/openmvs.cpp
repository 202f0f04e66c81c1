// SPDX-License-Identifier: GPL-3.0-or-later
// OpenMVS, libs/MVS/Interface.h, versions 1 to 7.
#include "tools/scene/forms/photogrammetry/openmvs.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are in the file");

constexpr std::string_view kMagic = "MVSI";
constexpr std::uint32_t kNewest = 7;
constexpr std::uint32_t kNone = 0xffffffff;

class Archive {
 public:
  Archive(std::span<const std::byte> rest, const fs::path& path) : rest_(rest), path_(path) {}

  [[noreturn]] void refuse(const std::string& reason) const { throw InputError(path_.string() + ": " + reason); }

  template <typename T>
  T take() {
    T value;
    std::memcpy(&value, bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string text() {
    const std::span<const std::byte> taken = bytes(count(1));
    return {reinterpret_cast<const char*>(taken.data()), taken.size()};
  }
  // Reads the count of a list whose entries have at least `least_bytes` bytes.
  std::uint64_t count(std::uint64_t least_bytes) {
    const auto entries = take<std::uint64_t>();
    if (entries > rest_.size() / least_bytes) ends();
    return entries;
  }
  std::span<const std::byte> bytes(std::uint64_t size) {
    if (size > rest_.size()) ends();
    const std::span<const std::byte> taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }
  glm::dvec3 point() {
    glm::dvec3 result;
    for (int axis = 0; axis < 3; ++axis) result[axis] = take<double>();
    return result;
  }
  glm::dmat3 matrix() {  // rows one after the other
    glm::dmat3 result;
    for (int i = 0; i < 9; ++i) result[i % 3][i / 3] = take<double>();
    return result;
  }

 private:
  [[noreturn]] void ends() const { refuse("ends before its platforms and images do: it is damaged or was cut off"); }

  std::span<const std::byte> rest_;
  const fs::path& path_;
};

// cam = R (X - C)
struct Pose {
  glm::dmat3 R{1.0};
  glm::dvec3 C{0.0};
};

struct PlatformCamera {
  std::uint32_t width = 0, height = 0;  // 0: K is by the longer side of the photograph
  glm::dmat3 K{1.0};
  Pose in_platform;
};

struct Platform {
  std::vector<PlatformCamera> cameras;
  std::vector<Pose> poses;
};

struct Image {
  std::string name, mask;  // files
  std::uint32_t platform = kNone, camera = kNone, pose = kNone;
};

Pose take_pose(Archive& archive) {
  Pose pose;
  pose.R = archive.matrix();
  pose.C = archive.point();
  return pose;
}

PlatformCamera take_camera(Archive& archive, std::uint32_t version) {
  PlatformCamera camera;
  (void)archive.text();                   // name
  if (version > 3) (void)archive.text();  // the band's name
  if (version > 0) {
    camera.width = archive.take<std::uint32_t>();
    camera.height = archive.take<std::uint32_t>();
  }
  camera.K = archive.matrix();
  camera.in_platform = take_pose(archive);
  return camera;
}

Platform take_platform(Archive& archive, std::uint32_t version) {
  constexpr std::uint64_t kPoseBytes = 12 * sizeof(double), kLeastCamera = 8 + 21 * sizeof(double);
  Platform platform;
  (void)archive.text();  // name
  for (std::uint64_t left = archive.count(kLeastCamera); left > 0; --left) {
    platform.cameras.push_back(take_camera(archive, version));
  }
  for (std::uint64_t left = archive.count(kPoseBytes); left > 0; --left) platform.poses.push_back(take_pose(archive));
  return platform;
}

Image take_image(Archive& archive, std::uint32_t version) {
  Image image;
  image.name = archive.text();
  if (version > 4) image.mask = archive.text();
  image.platform = archive.take<std::uint32_t>();
  image.camera = archive.take<std::uint32_t>();
  image.pose = archive.take<std::uint32_t>();
  if (version > 2) (void)archive.take<std::uint32_t>();  // its number elsewhere
  if (version > 6) {
    constexpr std::uint64_t kDepths = 3 * sizeof(float), kScore = 6 * sizeof(float);
    (void)archive.bytes(kDepths);
    (void)archive.bytes(kScore * archive.count(kScore));
  }
  return image;
}

CameraModel lens_in(const PlatformCamera& camera, const PosedPhotograph& photograph,
                    const PhotographLookup& photographs) {
  constexpr double kHalfPixel = 0.5;  // from the middle of the first pixel to its corner
  const bool has_size = camera.width > 0 && camera.height > 0;
  const ImageSize size = has_size ? ImageSize{camera.width, camera.height} : photographs.size_of(photograph);
  const double pixels = has_size ? 1 : std::max(size.width, size.height);
  const glm::dmat3& K = camera.K;
  if (K[0][1] != 0 || K[0][2] != 0 || K[1][2] != 0 || K[2][2] != 1) {
    throw std::invalid_argument("its K is no upper triangle that ends in 1");
  }
  BrownLens lens{size.width,
                 size.height,
                 K[0][0] * pixels,
                 K[1][1] * pixels,
                 K[2][0] * pixels + kHalfPixel,
                 K[2][1] * pixels + kHalfPixel};
  lens.skew = K[1][0] * pixels;
  return lens_of(lens);
}

// An element of a list, or what refuse() says that `what` is.
template <typename Element, typename Refuse>
const Element& element(const std::vector<Element>& list, std::uint32_t index, const char* what, const Refuse& refuse) {
  if (index >= list.size()) refuse("has " + std::string(what) + " " + std::to_string(index) + ", which is not there");
  return list[index];
}

PosedPhotograph photograph_of(const Image& image, const std::vector<Platform>& platforms, const fs::path& path,
                              std::uint64_t index, const PhotographLookup& photographs) {
  const auto refuse = [&](const std::string& reason) {
    throw InputError(path.string() + ": image " + std::to_string(index) + " (" + in_quotes(image.name) +
                     "): " + reason);
  };
  const Platform& platform = element(platforms, image.platform, "platform", refuse);
  const PlatformCamera& camera = element(platform.cameras, image.camera, "camera", refuse);
  const Pose& pose = element(platform.poses, image.pose, "pose", refuse);
  PosedPhotograph photograph = photographs.find(image.name);
  const glm::dvec3 center = glm::transpose(pose.R) * camera.in_platform.C + pose.C;
  const std::string broken =
      set_pose(photograph, glm::transpose(camera.in_platform.R * pose.R), center, CameraAxes::right_down_forward);
  if (!broken.empty()) refuse("its pose " + broken);
  try {
    photograph.lens = lens_in(camera, photograph, photographs);
  } catch (const std::invalid_argument& error) {
    refuse(std::string("an impossible camera: ") + error.what());
  }
  return photograph;
}

}  // namespace

Capture parse_openmvs(std::span<const std::byte> file, const fs::path& path, const PhotographLookup& photographs) {
  Archive archive(file, path);
  const std::span<const std::byte> magic = archive.bytes(kMagic.size());
  if (std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0) archive.refuse("does not begin with MVSI");
  const auto version = archive.take<std::uint32_t>();
  if (version > kNewest) {
    archive.refuse("is of version " + std::to_string(version) + ", but versions up to " + std::to_string(kNewest) +
                   " are known");
  }
  (void)archive.take<std::uint32_t>();  // reserved
  std::vector<Platform> platforms;
  for (std::uint64_t left = archive.count(24); left > 0; --left) platforms.push_back(take_platform(archive, version));
  const std::uint64_t count = archive.count(20);
  Capture posed;
  std::size_t without_pose = 0, masks = 0;
  for (std::uint64_t index = 0; index < count; ++index) {
    const Image image = take_image(archive, version);
    if (!image.mask.empty()) ++masks;
    if (image.pose == kNone) {
      ++without_pose;
      continue;
    }
    add_photograph(posed, photographs.bad, image.name,
                   [&] { return photograph_of(image, platforms, path, index, photographs); });
  }
  note_skipped(posed, without_pose, "have no pose");
  finish(posed, path, photographs.bad);
  if (masks > 0) {
    posed.notes.push_back(std::to_string(masks) +
                          " of its images name a mask, which is not read: masks are taken from "
                          "masks/ or --masks");
  }
  return posed;
}

std::optional<fs::path> find_openmvs(const fs::path& scene) {
  for (const fs::path& file : files_ending_in(scene, ".mvs")) {
    if (first_bytes(file).starts_with(kMagic)) return file;
  }
  return std::nullopt;
}

Capture read_openmvs(const CaptureRequest& request) {
  const fs::path path = find_openmvs(request.scene).value();
  const std::string file = read_whole_file(path);
  PhotographLookup lookup = photographs_of(request);
  // OpenMVS names photographs from its working folder on, or wholly: the file's name is what is left of it here.
  lookup.find = [find = lookup.find](std::string_view name) {
    const fs::path whole(name);
    return find(name_without(whole.is_absolute() ? whole.filename() : whole, "images"));
  };
  return parse_openmvs(std::as_bytes(std::span(file)), path, lookup);
}

}  // namespace lumatlas
