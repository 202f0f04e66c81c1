// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photogrammetry/opensfm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/json_poses.h"
#include "tools/scene/forms/fields/unknown_keys.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr auto kOpenSfmKeys =
    std::to_array<std::string_view>({"cameras", "shots", "rig_cameras", "rig_instances", "reference_lla", "pano_shots",
                                     // of no concern
                                     "points", "biases"});

constexpr auto kOpenSfmShotKeys = std::to_array<std::string_view>(
    {"camera", "rotation", "translation",
     // of no concern
     "orientation", "capture_time", "gps_dop", "gps_position", "compass", "accelerometer", "gravity_down", "opk_angles",
     "opk_accuracy", "skey", "sequence_key", "vertices", "faces", "scale", "covariance", "merge_cc"});

constexpr auto kOpenSfmRigKeys = std::to_array<std::string_view>({"rotation", "translation", "rig_camera_ids"});

constexpr std::string_view kOpenSfmLensKeys = "projection_type width height focal_prior k1_prior k2_prior";

struct OpenSfmProjection {
  std::string_view name;
  std::string_view keys;  // with blanks between them; those of focal lengths must be there
};

constexpr std::array kOpenSfmProjections{
    OpenSfmProjection{"perspective", "focal k1 k2"},
    OpenSfmProjection{"simple_radial", "focal_x focal_y c_x c_y k1"},
    OpenSfmProjection{"radial", "focal_x focal_y c_x c_y k1 k2"},
    OpenSfmProjection{"brown", "focal_x focal_y c_x c_y k1 k2 k3 p1 p2"},
    OpenSfmProjection{"fisheye", "focal k1 k2"},
    OpenSfmProjection{"fisheye_opencv", "focal_x focal_y c_x c_y k1 k2 k3 k4"},
    OpenSfmProjection{"fisheye62", "focal_x focal_y c_x c_y k1 k2 k3 k4 k5 k6 p1 p2"},
    OpenSfmProjection{"fisheye624", "focal_x focal_y c_x c_y k1 k2 k3 k4 k5 k6 p1 p2 s0 s1 s2 s3"},
    OpenSfmProjection{"dual", "focal k1 k2 transition"},
    OpenSfmProjection{"spherical", ""},
    OpenSfmProjection{"equirectangular", ""},
};

// The advice for a lens that is not read.
constexpr const char* kOpenSfmUndistort = ": undistort the photographs (`opensfm undistort`) and read undistorted/";

const OpenSfmProjection& projection_of(const JsonPlace& camera) {
  if (!camera.has("projection_type")) return kOpenSfmProjections.front();
  const std::string name = camera.at("projection_type").text();
  const auto found = std::find_if(kOpenSfmProjections.begin(), kOpenSfmProjections.end(),
                                  [&](const OpenSfmProjection& projection) { return projection.name == name; });
  if (found == kOpenSfmProjections.end()) {
    camera.at("projection_type").refuse("is " + in_quotes(name) + ", which is not read" + kOpenSfmUndistort);
  }
  return *found;
}

std::vector<std::string_view> keys_of(const OpenSfmProjection& projection) {
  std::vector<std::string_view> keys;
  for (std::string_view list : {projection.keys, kOpenSfmLensKeys}) {
    for (std::string_view key = take_field(list); !key.empty(); key = take_field(list)) keys.push_back(key);
  }
  return keys;
}

// One of `cameras`.
class OpenSfmLens {
 public:
  // `size_of_photograph` is called where the file does not say the size.
  OpenSfmLens(const JsonPlace& camera, const std::function<ImageSize()>& size_of_photograph)
      : camera_(camera), projection_(projection_of(camera)) {
    const bool has_size = number("width") != 0 && number("height") != 0;
    const ImageSize size =
        has_size ? ImageSize{pixels_in(camera.at("width")), pixels_in(camera.at("height"))} : size_of_photograph();
    brown_.width = size.width;
    brown_.height = size.height;
  }

  [[nodiscard]] CameraModel read() {
    const std::string_view name = projection_.name;
    if (projection_.keys.empty()) return panorama_at(camera_, brown_.width, brown_.height);
    read_pinhole();
    if (name == "fisheye62" || name == "fisheye624") return polynomial_fisheye();
    if (name == "dual" ? is_dual_fisheye() : name.starts_with("fisheye")) {
      return lens_at(camera_, LensModel::kOpenCvFisheye, brown_,
                     {number("k1"), number("k2"), number("k3"), number("k4")});
    }
    brown_.k1 = number("k1");
    brown_.k2 = number("k2");
    brown_.k3 = number("k3");
    brown_.p1 = number("p1");
    brown_.p2 = number("p2");
    return lens_at(camera_, brown_);
  }

 private:
  [[nodiscard]] double number(std::string_view key) const { return camera_.has(key) ? number_in(camera_.at(key)) : 0; }

  void read_pinhole() {
    const bool one = projection_.keys.starts_with("focal ");
    const double side = std::max(brown_.width, brown_.height);
    brown_.fx = side * number_in(camera_.at(one ? "focal" : "focal_x"));
    brown_.fy = side * number_in(camera_.at(one ? "focal" : "focal_y"));
    brown_.cx = 0.5 * brown_.width + (one ? 0 : side * number("c_x"));
    brown_.cy = 0.5 * brown_.height + (one ? 0 : side * number("c_y"));
  }

  [[nodiscard]] bool is_dual_fisheye() const {
    const double transition = camera_.has("transition") ? number("transition") : 0.5;  // OpenSfM's default
    if (transition != 0 && transition != 1) {
      camera_.refuse("is a dual lens whose transition is " + number_text(transition) +
                     ", between a perspective and a fisheye, which is not read" + kOpenSfmUndistort);
    }
    return transition == 0;
  }

  // OpenSfM's tangential and prism terms are of the point before the radial term moves it, as in THIN_PRISM_FISHEYE,
  // which has four radial coefficients; RAD_TAN_THIN_PRISM_FISHEYE has six, but bends the point that was moved.
  [[nodiscard]] CameraModel polynomial_fisheye() const {
    const auto k = [&](const char* key) { return number(key); };
    if (k("k5") == 0 && k("k6") == 0 && k("s1") == 0 && k("s3") == 0) {
      return lens_at(camera_, LensModel::kThinPrismFisheye, brown_,
                     {k("k1"), k("k2"), k("p1"), k("p2"), k("k3"), k("k4"), k("s0"), k("s2")});
    }
    for (const char* const key : {"p1", "p2", "s0", "s1", "s2", "s3"}) {
      if (k(key) == 0) continue;
      camera_.at(key).refuse("is " + number_text(k(key)) + " of a " + std::string(projection_.name) +
                             ", which is not read together with k5, k6, s1 or s3" + kOpenSfmUndistort);
    }
    return lens_at(camera_, LensModel::kRadTanThinPrismFisheye, brown_,
                   {k("k1"), k("k2"), k("k3"), k("k4"), k("k5"), k("k6")});
  }

  const JsonPlace& camera_;
  const OpenSfmProjection& projection_;
  BrownLens brown_;
};

// The pose that an object with a turn and a translation holds: of a shot, a rig camera or a rig instance.
RigidPose opensfm_pose(const JsonPlace& object) {
  const std::vector<double> r = numbers_in(object.at("rotation"), 3);
  const std::vector<double> t = numbers_in(object.at("translation"), 3);
  const glm::dvec3 turn(r[0], r[1], r[2]);
  const double angle = glm::length(turn);
  RigidPose pose;
  if (angle > 0) pose.rotation = glm::mat3_cast(glm::angleAxis(angle, turn / angle));
  pose.center = -(glm::transpose(pose.rotation) * glm::dvec3(t[0], t[1], t[2]));
  return pose;
}

class OpenSfmReader {
 public:
  OpenSfmReader(const JsonPlace& reconstruction, const fs::path& path, const PhotographLookup& photographs)
      : reconstruction_(reconstruction), path_(path), photographs_(photographs) {}

  Capture read() {
    unknown_.look_at(reconstruction_, kOpenSfmKeys);
    if (reconstruction_.has("rig_instances")) read_rigs();
    for (const auto& shot : reconstruction_.at("shots").members()) read_shot(shot.first, shot.second);
    note_skipped(posed_, without_pose_, "have no pose");
    if (reconstruction_.has("pano_shots")) leave_out_panoramas(reconstruction_.at("pano_shots").members().size());
    finish(posed_, path_, photographs_.bad);
    note_reference();
    unknown_.tell(path_, posed_);
    return std::move(posed_);
  }

 private:
  void read_shot(const std::string& name, const JsonPlace& shot) {
    unknown_.look_at(shot, kOpenSfmShotKeys);
    if (!has_pose(name, shot)) {
      ++without_pose_;
      return;
    }
    add_photograph(posed_, photographs_.bad, name, [&] { return photograph_of(name, shot); });
  }

  void read_rigs() {
    for (const auto& [id, instance] : reconstruction_.at("rig_instances").members()) {
      unknown_.look_at(instance, kOpenSfmRigKeys);
      for (const auto& [shot, camera] : instance.at("rig_camera_ids").members()) {
        rigs_.insert_or_assign(shot, std::pair(instance, camera));
      }
    }
  }

  [[nodiscard]] bool has_pose(const std::string& name, const JsonPlace& shot) const {
    return shot.has("rotation") || rigs_.contains(name);
  }

  // camera from world, by the shot itself or by its rig
  [[nodiscard]] RigidPose pose_of_shot(const std::string& name, const JsonPlace& shot) const {
    if (shot.has("rotation")) return opensfm_pose(shot);
    const auto& [instance, camera] = rigs_.at(name);
    const JsonPlace rig_cameras = reconstruction_.at("rig_cameras");
    const std::string id = id_in(camera);
    if (!rig_cameras.has(id)) camera.refuse("is " + in_quotes(id) + ", which is not in rig_cameras");
    return opensfm_pose(rig_cameras.at(id)) * opensfm_pose(instance);
  }

  PosedPhotograph photograph_of(const std::string& name, const JsonPlace& shot) {
    PosedPhotograph photograph = photographs_.find(name);
    set_pose(photograph, pose_of_shot(name, shot), shot);
    photograph.lens = lens_of_shot(shot.at("camera"), photograph);
    return photograph;
  }

  const CameraModel& lens_of_shot(const JsonPlace& place, const PosedPhotograph& photograph) {
    const std::string id = id_in(place);
    const auto known = lenses_.find(id);
    if (known != lenses_.end()) return known->second;
    const JsonPlace cameras = reconstruction_.at("cameras");
    if (!cameras.has(id)) place.refuse("is " + in_quotes(id) + ", which is not in cameras");
    const JsonPlace camera = cameras.at(id);
    unknown_.look_at_lens(camera, keys_of(projection_of(camera)));
    OpenSfmLens lens(camera, [&] { return photographs_.size_of(photograph); });
    return lenses_.emplace(id, lens.read()).first->second;
  }

  void leave_out_panoramas(std::size_t count) {
    if (count == 0) return;
    posed_.left_out += count;
    posed_.notes.push_back(std::to_string(count) +
                           " panoramas that OpenSfM made of others, in pano_shots, are left out");
  }

  // Without GPS, OpenSfM writes a reference at 0 degrees.
  void note_reference() {
    if (!reconstruction_.has("reference_lla")) return;
    const JsonPlace reference = reconstruction_.at("reference_lla");
    const double latitude = number_in(reference.at("latitude")), longitude = number_in(reference.at("longitude"));
    if (latitude == 0 && longitude == 0) return;
    const double altitude = reference.has("altitude") ? number_in(reference.at("altitude")) : 0;
    if (std::abs(latitude) > 90 || std::abs(longitude) > 180) return;
    posed_.georeference = GeoReference{GeoReference::Frame::east_north_up, latitude, longitude, altitude};
    posed_.notes.push_back("its coordinates are " + text_of(*posed_.georeference) +
                           ", and the mesh is taken to be in them");
  }

  const JsonPlace& reconstruction_;
  const fs::path& path_;
  const PhotographLookup& photographs_;
  std::map<std::string, std::pair<JsonPlace, JsonPlace>> rigs_;  // for each shot: the rig instance, its rig camera's id
  std::map<std::string, CameraModel> lenses_;                    // for cameras that shots have
  UnknownKeys unknown_;
  std::size_t without_pose_ = 0;
  Capture posed_;
};

std::size_t shot_count(const JsonPlace& reconstruction) {
  return reconstruction.at("shots").members().size();
}

void note_other_reconstructions(const std::vector<JsonPlace>& all, std::size_t largest, Capture& posed) {
  if (all.size() < 2) return;
  std::string sizes;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == largest) continue;
    sizes += (sizes.empty() ? "" : ", ") + std::to_string(shot_count(all[i]));
    posed.left_out += shot_count(all[i]);
  }
  posed.notes.push_back("the largest of its " + std::to_string(all.size()) + " reconstructions is read, with " +
                        std::to_string(shot_count(all[largest])) +
                        " shots; the shots of the others are left out: " + sizes);
}

}  // namespace

Capture parse_opensfm(std::string_view text, const fs::path& path, const PhotographLookup& photographs) {
  const nlohmann::json content = parse_json_with_nan(text, path.string());
  if (!content.is_array() || content.empty()) {
    throw InputError(path.string() + ": is no list of reconstructions, as OpenSfM writes them");
  }
  const std::vector<JsonPlace> all = JsonPlace(path.string(), "", content).elements();
  std::size_t largest = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (shot_count(all[i]) > shot_count(all[largest])) largest = i;
  }
  Capture posed = OpenSfmReader(all[largest], path, photographs).read();
  note_other_reconstructions(all, largest, posed);
  return posed;
}

std::optional<fs::path> find_opensfm(const fs::path& scene) {
  std::error_code ignored;
  for (const fs::path& folder : {scene, scene / "opensfm"}) {
    if (fs::exists(folder / "reconstruction.json", ignored)) return folder / "reconstruction.json";
  }
  return std::nullopt;
}

Capture read_opensfm(const CaptureRequest& request) {
  const fs::path path = find_opensfm(request.scene).value();
  return parse_opensfm(read_whole_file(path), path, photographs_of(request));
}

}  // namespace lumatlas
