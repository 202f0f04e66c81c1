// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photogrammetry/meshroom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <glm/glm.hpp>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/json_poses.h"
#include "tools/scene/forms/fields/unknown_keys.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr auto kMeshroomKeys = std::to_array<std::string_view>({"version", "views", "intrinsics", "poses", "rigs",
                                                                // of no concern
                                                                "featuresFolders", "matchesFolders", "structure",
                                                                "controlPoints", "surveyPoints", "constraints2d"});

constexpr auto kMeshroomViewKeys = std::to_array<std::string_view>(
    {"poseId", "intrinsicId", "path", "rigId", "subPoseId", "isPoseIndependant",
     // of no concern: the lens says the size
     "viewId", "frameId", "resectionId", "width", "height", "metadata", "ancestors", "ancestorImages"});

constexpr auto kMeshroomPoseKeys =
    std::to_array<std::string_view>({"transform", "valid", "rotationOnly", "locked", "removable"});

constexpr auto kMeshroomLensKeys = std::to_array<std::string_view>(
    {"width", "height", "type", "pxFocalLength", "focalLength", "sensorWidth", "pixelRatio", "principalPoint",
     "distortionParams", "distortionType", "undistortionParams", "undistortionType", "undistortionOffset",
     // of no concern: what the lens was before, and what is held in a bundle adjustment
     "intrinsicId", "serialNumber", "sensorHeight", "initializationMode", "pxInitialFocalLength", "initialFocalLength",
     "pixelRatioLock", "pixelRatioLocked", "offsetLocked", "scaleLocked", "distortionLocked",
     "distortionInitializationMode", "locked"});

constexpr const char* kMeshroomUndistort =
    "undistort the photographs (Meshroom's node PrepareDenseScene or ExportImages), or use pinhole, radial1, radial3, "
    "brown, fisheye4, fisheye1 or equirectangular";

// The file's version: major, minor, revision.
using MeshroomVersion = std::array<int, 3>;
constexpr MeshroomVersion kTwoFocalLengths{1, 2, 0}, kPrincipalPointFromMiddle{1, 2, 1}, kMillimetres{1, 2, 2},
    kPixelRatioOfPixels{1, 2, 5}, kLastFocalLengthOfX{1, 2, 8}, kFocalLengthOfY{1, 2, 11}, kNewestMeshroom{1, 2, 14};

MeshroomVersion meshroom_version(const JsonPlace& file) {
  const JsonPlace place = file.at("version");
  const std::vector<double> numbers = numbers_in(place, 3);
  MeshroomVersion version{};
  for (std::size_t i = 0; i < version.size(); ++i) {
    if (!(numbers[i] >= 0 && numbers[i] <= 1e6)) place.refuse("must be three numbers from 0 to 1000000");
    version[i] = static_cast<int>(numbers[i]);
  }
  if (version[0] != 1) place.refuse("begins with " + std::to_string(version[0]) + ", but only version 1 is known");
  return version;
}

// Returns true if a list is empty. AliceVision writes an empty list as an empty text.
bool is_empty_list(const JsonPlace& place) {
  return is_empty_text(place) || (place.value().is_array() && place.value().empty());
}

// One of `intrinsics`.
class MeshroomLens {
 public:
  MeshroomLens(const JsonPlace& intrinsic, const MeshroomVersion& version)
      : intrinsic_(intrinsic),
        version_(version),
        brown_{pixels_in(intrinsic.at("width")), pixels_in(intrinsic.at("height"))} {}

  [[nodiscard]] CameraModel read() {
    refuse_undistortion();
    read_focal_lengths();
    const std::vector<double> point = numbers_in(intrinsic_.at("principalPoint"), 2);
    const double from_middle = version_ < kPrincipalPointFromMiddle ? 0 : 0.5;
    brown_.cx = from_middle * brown_.width + point[0];
    brown_.cy = from_middle * brown_.height + point[1];
    const std::string name = distortion();
    if (name == "equirectangular") return panorama();
    if (name == "fisheye1") return fov();
    if (name == "fisheye4" || name == "fisheye") {
      const std::vector<double> k = coefficients(4);
      return lens_at(intrinsic_, LensModel::kOpenCvFisheye, brown_, {k[0], k[1], k[2], k[3]});
    }
    return brown(name);
  }

 private:
  // `type`, else what a newer file has beside it.
  [[nodiscard]] std::string distortion() const {
    const std::string type = intrinsic_.at("type").text();
    return type == "pinhole" && intrinsic_.has("distortionType") ? intrinsic_.at("distortionType").text() : type;
  }

  // AliceVision has an undistortion of its own kind for film plates, beside the distortion.
  void refuse_undistortion() const {
    for (const char* const key : {"undistortionParams", "undistortionOffset"}) {
      if (!intrinsic_.has(key) || is_empty_list(intrinsic_.at(key))) continue;
      const std::vector<JsonPlace> values = intrinsic_.at(key).elements();
      if (std::all_of(values.begin(), values.end(), [](const JsonPlace& value) { return number_in(value) == 0; })) {
        continue;
      }
      intrinsic_.at(key).refuse(std::string("is not read: ") + kMeshroomUndistort);
    }
  }

  void read_focal_lengths() {
    if (version_ < kTwoFocalLengths) {
      brown_.fx = brown_.fy = number_in(intrinsic_.at("pxFocalLength"));
    } else if (version_ < kMillimetres) {
      const std::vector<double> pixels = numbers_in(intrinsic_.at("pxFocalLength"), 2);
      brown_.fx = pixels[0];
      brown_.fy = pixels[1];
    } else {
      read_millimetres();
    }
  }

  [[nodiscard]] double positive_or(const char* key, double otherwise) const {
    if (!intrinsic_.has(key)) return otherwise;
    const double value = number_in(intrinsic_.at(key));
    if (!(value > 0)) intrinsic_.at(key).refuse("is " + number_text(value) + ", must be positive");
    return value;
  }

  void read_millimetres() {
    constexpr double kFilmWidth = 36;  // AliceVision's default
    const double pixels =
        number_in(intrinsic_.at("focalLength")) / positive_or("sensorWidth", kFilmWidth) * brown_.width;
    const double ratio = positive_or("pixelRatio", 1);
    brown_.fx = brown_.fy = pixels;
    if (version_ < kPixelRatioOfPixels) {
      brown_.fy = pixels / ratio;
    } else if (version_ <= kLastFocalLengthOfX) {
      brown_.fy = pixels * ratio;
    } else if (version_ >= kFocalLengthOfY) {
      brown_.fx = pixels / ratio;
    } else if (ratio != 1) {
      intrinsic_.at("pixelRatio")
          .refuse("is " + number_text(ratio) +
                  ", which versions 1.2.9 and 1.2.10 are read without: open and save the project "
                  "in a newer Meshroom");
    }
  }

  // All 0 where the list is empty or missing.
  [[nodiscard]] std::vector<double> coefficients(std::size_t count) const {
    if (!intrinsic_.has("distortionParams")) return std::vector<double>(count);
    const JsonPlace place = intrinsic_.at("distortionParams");
    return is_empty_list(place) ? std::vector<double>(count) : numbers_in(place, count);
  }

  [[nodiscard]] CameraModel brown(const std::string& name) {
    const bool none = name == "pinhole" || name == "none", k1 = name == "radial1" || name == "radialk1";
    const bool k3 = name == "radial3" || name == "radialk3";
    if (!none && !k1 && !k3 && name != "brown") {
      intrinsic_.refuse("is a lens of the kind " + in_quotes(name) + ", which is not read: " + kMeshroomUndistort);
    }
    std::vector<double> k = coefficients(none ? 0 : k1 ? 1 : k3 ? 3 : 5);
    k.resize(5);
    brown_.k1 = k[0];
    brown_.k2 = k[1];
    brown_.k3 = k[2];
    brown_.p1 = k[3];
    brown_.p2 = k[4];
    return lens_at(intrinsic_, brown_);
  }

  // The formula is even in omega, but AliceVision does not bend the point where omega is negative.
  [[nodiscard]] CameraModel fov() const {
    const double omega = coefficients(1)[0];
    if (omega < 0) {
      intrinsic_.at("distortionParams").refuse("begins with " + number_text(omega) + ", must not be negative");
    }
    return lens_at(intrinsic_, LensModel::kFov, brown_, {omega});
  }

  // x = cx + fx longitude, y = cy + fy latitude, in radians.
  [[nodiscard]] CameraModel panorama() const {
    constexpr double kMostPixelsOff = 1;  // pixel, at the rims
    const double width = 2 * std::numbers::pi * brown_.fx, height = std::numbers::pi * brown_.fy;
    const std::array errors{width - brown_.width, height - brown_.height, brown_.cx - 0.5 * brown_.width,
                            brown_.cy - 0.5 * brown_.height};
    if (!std::all_of(errors.begin(), errors.end(), [](double error) { return std::abs(error) <= kMostPixelsOff; })) {
      intrinsic_.refuse("is a panorama whose sphere is " + number_text(width) + " by " + number_text(height) +
                        " pixels about (" + number_text(brown_.cx) + ", " + number_text(brown_.cy) +
                        "), must be the whole picture: cut it into pinhole views first");
    }
    (void)coefficients(0);
    return panorama_at(intrinsic_, brown_.width, brown_.height);
  }

  const JsonPlace& intrinsic_;
  const MeshroomVersion& version_;
  BrownLens brown_;
};

// The pose that an object with a rotation by columns and a center holds.
RigidPose meshroom_pose(const JsonPlace& transform) {
  const std::vector<double> r = numbers_in(transform.at("rotation"), 9);
  const std::vector<double> c = numbers_in(transform.at("center"), 3);
  RigidPose pose;
  for (int i = 0; i < 9; ++i) pose.rotation[i / 3][i % 3] = r[static_cast<std::size_t>(i)];
  pose.center = {c[0], c[1], c[2]};
  return pose;
}

class MeshroomReader {
 public:
  MeshroomReader(const JsonPlace& file, const fs::path& path, const PhotographLookup& photographs)
      : file_(file), path_(path), photographs_(photographs), version_(meshroom_version(file)) {}

  Capture read() {
    unknown_.look_at(file_, kMeshroomKeys);
    intrinsics_ = by_id("intrinsics", "intrinsicId");
    poses_ = by_id("poses", "poseId");
    rigs_ = by_id("rigs", "rigId");
    for (const JsonPlace& view : file_.at("views").elements()) read_view(view);
    note_skipped(posed_, skipped_, "have no pose or no lens");
    finish(posed_, path_, photographs_.bad);
    note_version();
    unknown_.tell(path_, posed_);
    return std::move(posed_);
  }

 private:
  using ById = std::map<std::string, JsonPlace>;

  [[nodiscard]] ById by_id(const char* list, const char* key) const {
    ById all;
    if (!file_.has(list) || is_empty_list(file_.at(list))) return all;
    for (const JsonPlace& entry : file_.at(list).elements()) all.insert_or_assign(id_in(entry.at(key)), entry);
    return all;
  }

  // Returns the entry whose id stands under `key` of the view; null if the view has no such key or no entry has the id.
  [[nodiscard]] static const JsonPlace* of_view(const JsonPlace& view, const char* key, const ById& all) {
    if (!view.has(key)) return nullptr;
    const auto found = all.find(id_in(view.at(key)));
    return found == all.end() ? nullptr : &found->second;
  }

  void read_view(const JsonPlace& view) {
    unknown_.look_at(view, kMeshroomViewKeys);
    const JsonPlace* const pose = of_view(view, "poseId", poses_);
    const JsonPlace* const intrinsic = of_view(view, "intrinsicId", intrinsics_);
    if (!pose || !intrinsic || !is_whole(pose->at("pose"))) {
      ++skipped_;
      return;
    }
    const std::string file = view.at("path").text();
    add_photograph(posed_, photographs_.bad, file, [&] {
      PosedPhotograph photograph = photographs_.find(file);
      const JsonPlace transform = pose->at("pose").at("transform");
      const RigidPose own = meshroom_pose(transform);
      set_pose(photograph, is_in_rig(view) ? cam_from_rig(view) * own : own, transform);
      photograph.lens = lens_of_view(id_in(view.at("intrinsicId")), *intrinsic);
      return photograph;
    });
  }

  // Returns whether a pose is valid and has a position, not only a rotation.
  [[nodiscard]] bool is_whole(const JsonPlace& pose) {
    unknown_.look_at(pose, kMeshroomPoseKeys);
    return (!pose.has("valid") || flag_in(pose.at("valid"))) &&
           (!pose.has("rotationOnly") || !flag_in(pose.at("rotationOnly")));
  }

  [[nodiscard]] static bool is_in_rig(const JsonPlace& view) {
    return view.has("rigId") && view.has("isPoseIndependant") && !flag_in(view.at("isPoseIndependant"));
  }

  [[nodiscard]] RigidPose cam_from_rig(const JsonPlace& view) const {
    const JsonPlace* const rig = of_view(view, "rigId", rigs_);
    if (!rig) view.at("rigId").refuse("is " + in_quotes(id_in(view.at("rigId"))) + ", which is not in rigs");
    const std::vector<JsonPlace> sub_poses = rig->at("subPoses").elements();
    const double index = number_in(view.at("subPoseId"));
    if (!(index >= 0 && index < static_cast<double>(sub_poses.size())) || index != std::floor(index)) {
      view.at("subPoseId")
          .refuse("is " + number_text(index) + ", but its rig has " + std::to_string(sub_poses.size()) + " subPoses");
    }
    const JsonPlace& sub_pose = sub_poses[static_cast<std::size_t>(index)];
    if (sub_pose.has("status") && sub_pose.at("status").text() == "uninitialized") {
      sub_pose.refuse("is uninitialized, but " + in_quotes(view.at("path").text()) + " is placed by it");
    }
    return meshroom_pose(sub_pose.at("pose"));
  }

  const CameraModel& lens_of_view(const std::string& id, const JsonPlace& intrinsic) {
    const auto known = lenses_.find(id);
    if (known != lenses_.end()) return known->second;
    const CameraModel lens = MeshroomLens(intrinsic, version_).read();
    unknown_.look_at_lens(intrinsic, kMeshroomLensKeys);
    return lenses_.emplace(id, lens).first->second;
  }

  void note_version() {
    if (version_ <= kNewestMeshroom) return;
    std::string text;
    for (const int number : version_) text += (text.empty() ? "" : ".") + std::to_string(number);
    posed_.notes.push_back("it is of version " + text + ", and is read as version 1.2.14, the newest that is known");
  }

  const JsonPlace& file_;
  const fs::path& path_;
  const PhotographLookup& photographs_;
  const MeshroomVersion version_;
  ById intrinsics_, poses_, rigs_;
  std::map<std::string, CameraModel> lenses_;  // for intrinsics that views have
  UnknownKeys unknown_;
  std::size_t skipped_ = 0;
  Capture posed_;
};

bool begins_as_meshroom(const fs::path& file) {
  const std::string head = first_bytes(file);
  const auto has = [&](const char* key) { return head.find(key) != std::string::npos; };
  return has("\"version\"") && (has("\"viewId\"") || has("\"featuresFolders\""));
}

}  // namespace

Capture parse_meshroom(std::string_view text, const fs::path& path, const PhotographLookup& photographs) {
  const nlohmann::json content = parse_json_with_nan(text, path.string());
  const JsonPlace file(path.string(), "", content);
  if (!file.has("version") || !file.has("views")) {
    throw InputError(path.string() + ": has no version and views, as AliceVision writes them");
  }
  return MeshroomReader(file, path, photographs).read();
}

std::optional<fs::path> find_meshroom(const fs::path& scene) {
  if (begins_as_meshroom(scene / "cameras.sfm")) return scene / "cameras.sfm";
  for (const char* const ending : {".sfm", ".json"}) {
    for (const fs::path& file : files_ending_in(scene, ending)) {
      if (begins_as_meshroom(file)) return file;
    }
  }
  return std::nullopt;
}

Capture read_meshroom(const CaptureRequest& request) {
  const fs::path path = find_meshroom(request.scene).value();
  return parse_meshroom(read_whole_file(path), path, photographs_of(request));
}

}  // namespace lumatlas
