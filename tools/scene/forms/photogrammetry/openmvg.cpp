// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photogrammetry/openmvg.h"

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/json_poses.h"
#include "tools/scene/forms/fields/unknown_keys.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr auto kOpenMvgKeys =
    std::to_array<std::string_view>({"sfm_data_version", "root_path", "views", "intrinsics", "extrinsics",
                                     // of no concern
                                     "structure", "control_points"});

constexpr auto kOpenMvgViewKeys =
    std::to_array<std::string_view>({"local_path", "filename", "id_pose", "id_intrinsic",
                                     // of no concern: the lens says the size, and priors are what poses were found from
                                     "width", "height", "id_view", "use_pose_center_prior", "center_weight", "center",
                                     "use_pose_rotation_prior", "rotation_weight", "rotation"});

constexpr auto kOpenMvgPoseKeys = std::to_array<std::string_view>({"rotation", "center"});

struct OpenMvgLens {
  std::string_view name;
  std::string_view key;  // the coefficients' key
  std::size_t count;     // how many there are
};

constexpr std::array kOpenMvgLenses{
    OpenMvgLens{"pinhole", "", 0},
    OpenMvgLens{"pinhole_radial_k1", "disto_k1", 1},
    OpenMvgLens{"pinhole_radial_k3", "disto_k3", 3},
    OpenMvgLens{"pinhole_brown_t2", "disto_t2", 5},
    OpenMvgLens{"fisheye", "fisheye", 4},
};

// The base class's members, which cereal writes on their own for some lenses.
JsonPlace openmvg_base(const JsonPlace& data) {
  return data.has("value0") ? data.at("value0") : data;
}

CameraModel openmvg_lens(const std::string& name, const JsonPlace& data, UnknownKeys& unknown) {
  const JsonPlace base = openmvg_base(data);
  const std::uint32_t width = pixels_in(base.at("width")), height = pixels_in(base.at("height"));
  if (name == "spherical") {
    unknown.look_at_lens(data, std::to_array<std::string_view>({"width", "height", "value0"}));
    return panorama_at(data, width, height);
  }
  const auto lens = std::find_if(kOpenMvgLenses.begin(), kOpenMvgLenses.end(),
                                 [&](const OpenMvgLens& known) { return known.name == name; });
  if (lens == kOpenMvgLenses.end()) {
    data.refuse(
        "is a lens of the kind " + in_quotes(name) +
        ", which is not read: undistort the photographs (openMVG_main_ExportUndistortedImages), or use pinhole, "
        "pinhole_radial_k1, pinhole_radial_k3, pinhole_brown_t2, fisheye or spherical");
  }
  unknown.look_at_lens(data, std::to_array<std::string_view>(
                                 {"width", "height", "value0", "focal_length", "principal_point", lens->key}));
  const std::vector<double> center = numbers_in(data.at("principal_point"), 2);
  const double focal_length = number_in(data.at("focal_length"));
  BrownLens brown{width, height, focal_length, focal_length, center[0], center[1]};
  std::vector<double> k = lens->count == 0 ? std::vector<double>{} : numbers_in(data.at(lens->key), lens->count);
  k.resize(5);
  if (name == "fisheye") return lens_at(data, LensModel::kOpenCvFisheye, brown, {k[0], k[1], k[2], k[3]});
  brown.k1 = k[0];
  brown.k2 = k[1];
  brown.k3 = k[2];
  brown.p1 = k[3];
  brown.p2 = k[4];
  return lens_at(data, brown);
}

RigidPose openmvg_pose(const JsonPlace& extrinsic) {
  const std::vector<JsonPlace> rows = extrinsic.at("rotation").elements();
  if (rows.size() != 3) extrinsic.at("rotation").refuse("must have 3 rows");
  RigidPose pose;
  for (int row = 0; row < 3; ++row) {
    const std::vector<double> values = numbers_in(rows[static_cast<std::size_t>(row)], 3);
    for (int column = 0; column < 3; ++column) pose.rotation[column][row] = values[static_cast<std::size_t>(column)];
  }
  const std::vector<double> center = numbers_in(extrinsic.at("center"), 3);
  pose.center = {center[0], center[1], center[2]};
  return pose;
}

// Resolves what cereal writes once and refers to by a number afterwards. The number's highest bit says that it is new.
class CerealObjects {
 public:
  // The data of an object {"ptr_wrapper": {"id", "data"}}.
  JsonPlace data_of(const JsonPlace& object) {
    const JsonPlace wrapper = object.at("ptr_wrapper");
    return remembered(objects_, wrapper, "id", "data");
  }
  // The type of an object {"polymorphic_id", "polymorphic_name"}.
  std::string type_of(const JsonPlace& object) {
    return remembered(types_, object, "polymorphic_id", "polymorphic_name").text();
  }

 private:
  using Known = std::map<std::size_t, JsonPlace>;

  static JsonPlace remembered(Known& known, const JsonPlace& owner, const char* id_key, const char* value_key) {
    constexpr std::size_t kNew = 0x80000000, kMost = 0xffffffff;
    const std::size_t id = owner.at(id_key).count(0, kMost) & ~kNew;
    if (owner.has(value_key)) return known.insert_or_assign(id, owner.at(value_key)).first->second;
    const auto found = known.find(id);
    if (found == known.end()) {
      owner.refuse("has no \"" + std::string(value_key) + "\", and its " + id_key + " is that of nothing before it");
    }
    return found->second;
  }

  Known objects_, types_;
};

class OpenMvgReader {
 public:
  OpenMvgReader(const JsonPlace& file, const fs::path& path, const PhotographLookup& photographs)
      : file_(file), path_(path), photographs_(photographs) {}

  Capture read() {
    unknown_.look_at(file_, kOpenMvgKeys);
    const auto views = entries("views");
    std::vector<JsonPlace> data;  // ids count through the file, so that all objects are met in its order
    data.reserve(views.size());
    for (const auto& [key, view] : views) data.push_back(objects_.data_of(view));
    for (const auto& [key, intrinsic] : entries("intrinsics")) {
      intrinsics_.insert_or_assign(key, std::pair(objects_.type_of(intrinsic), objects_.data_of(intrinsic)));
    }
    for (const auto& [key, extrinsic] : entries("extrinsics")) extrinsics_.insert_or_assign(key, extrinsic);
    for (const JsonPlace& view : data) read_view(view);
    note_skipped(posed_, skipped_, "have no pose or no lens");
    finish(posed_, path_, photographs_.bad);
    note_panoramas();
    unknown_.tell(path_, posed_);
    return std::move(posed_);
  }

 private:
  // The entries of a map, as cereal writes it; empty where the file has no such map.
  [[nodiscard]] std::vector<std::pair<std::string, JsonPlace>> entries(const char* name) const {
    std::vector<std::pair<std::string, JsonPlace>> all;
    if (!file_.has(name)) return all;
    for (const JsonPlace& entry : file_.at(name).elements())
      all.emplace_back(id_in(entry.at("key")), entry.at("value"));
    return all;
  }

  void read_view(const JsonPlace& view) {
    unknown_.look_at(view, kOpenMvgViewKeys);
    const auto extrinsic = extrinsics_.find(id_in(view.at("id_pose")));
    const auto intrinsic = intrinsics_.find(id_in(view.at("id_intrinsic")));
    if (extrinsic == extrinsics_.end() || intrinsic == intrinsics_.end()) {
      ++skipped_;
      return;
    }
    unknown_.look_at(extrinsic->second, kOpenMvgPoseKeys);
    const std::string file = path_of(view);
    add_photograph(posed_, photographs_.bad, file, [&] {
      PosedPhotograph photograph = photographs_.find(file);
      set_pose(photograph, openmvg_pose(extrinsic->second), extrinsic->second.at("rotation"));
      photograph.lens = lens_of_view(intrinsic->first);
      return photograph;
    });
  }

  // Returns the path that the photograph had on the computer on which OpenMVG ran.
  [[nodiscard]] std::string path_of(const JsonPlace& view) const {
    const std::string name = view.at("filename").text();
    std::string folders;
    for (const auto& [place, key] : {std::pair(&file_, "root_path"), std::pair(&view, "local_path")}) {
      const bool has_one = place->has(key) && !is_empty_text(place->at(key));
      if (has_one) folders += place->at(key).text() + "/";
    }
    return folders + name;
  }

  const CameraModel& lens_of_view(const std::string& id) {
    const auto known = lenses_.find(id);
    if (known != lenses_.end()) return known->second;
    const auto& [name, data] = intrinsics_.at(id);
    return lenses_.emplace(id, openmvg_lens(name, data, unknown_)).first->second;
  }

  void note_panoramas() {
    const bool has_one = std::any_of(lenses_.begin(), lenses_.end(),
                                     [](const auto& lens) { return lens.second.model == LensModel::kEquirectangular; });
    if (!has_one) return;
    posed_.notes.emplace_back(
        "+y of its spherical cameras is taken to point down: what an early OpenMVG found, in which it points up, comes "
        "out mirrored");
  }

  const JsonPlace& file_;
  const fs::path& path_;
  const PhotographLookup& photographs_;
  CerealObjects objects_;
  std::map<std::string, std::pair<std::string, JsonPlace>> intrinsics_;  // type and data
  std::map<std::string, JsonPlace> extrinsics_;
  std::map<std::string, CameraModel> lenses_;  // for intrinsics that views have
  UnknownKeys unknown_;
  std::size_t skipped_ = 0;
  Capture posed_;
};

}  // namespace

Capture parse_openmvg(std::string_view text, const fs::path& path, const PhotographLookup& photographs) {
  const nlohmann::json content = parse_json_with_nan(text, path.string());
  const JsonPlace file(path.string(), "", content);
  if (!file.has("sfm_data_version") || !file.has("views")) {
    throw InputError(path.string() + ": has no sfm_data_version and views, as OpenMVG writes them");
  }
  (void)file.at("sfm_data_version").one_of({"0.1", "0.2", "0.3"});
  return OpenMvgReader(file, path, photographs).read();
}

std::optional<fs::path> find_openmvg(const fs::path& scene) {
  std::error_code ignored;
  if (fs::exists(scene / "sfm_data.json", ignored)) return scene / "sfm_data.json";
  for (const fs::path& file : files_ending_in(scene, ".json")) {
    if (first_bytes(file).find("\"sfm_data_version\"") != std::string::npos) return file;
  }
  return std::nullopt;
}

Capture read_openmvg(const CaptureRequest& request) {
  const fs::path path = find_openmvg(request.scene).value();
  return parse_openmvg(read_whole_file(path), path, photographs_of(request));
}

}  // namespace lumatlas
