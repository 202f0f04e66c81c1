// SPDX-License-Identifier: GPL-3.0-or-later
// Agisoft Metashape user manual, appendix "Camera models".
#include "tools/scene/forms/photogrammetry/metashape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// world = scale * rotation * chunk + translation
struct Similarity {
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
  double scale = 1;
};

// The position of an element in the file, for sentences.
struct XmlPlace {
  const fs::path& path;
  std::string where;

  [[noreturn]] void refuse(const std::string& reason) const {
    throw InputError(path.string() + ": " + where + ": " + reason);
  }
};

// pugixml would read them as the C locale has it, and what is no number as 0.
std::vector<double> numbers(const pugi::xml_node& node, std::size_t count, const XmlPlace& place) {
  std::string_view text = node.text().get();
  std::vector<double> values;
  while (true) {
    const std::string_view field = take_field(text, " \t\r\v\f\n");
    if (field.empty()) break;
    const std::optional<double> value = parse_number(field);
    if (!value || !std::isfinite(*value)) {
      place.refuse("its " + std::string(node.name()) + " has the value " + in_quotes(field) +
                   ", which is not a finite number");
    }
    values.push_back(*value);
  }
  if (values.size() != count) {
    place.refuse("its " + std::string(node.name()) + " has " + std::to_string(values.size()) + " values, must have " +
                 std::to_string(count));
  }
  return values;
}

std::string_view trimmed_text(const pugi::xml_node& node) {
  std::string_view text = node.text().get();
  return take_field(text, " \t\r\v\f\n");
}

double number_or_0(const pugi::xml_node& parent, const char* name, const XmlPlace& place) {
  const pugi::xml_node node = parent.child(name);
  return node ? numbers(node, 1, place)[0] : 0;
}

std::uint32_t size_in(const pugi::xml_node& resolution, const char* name, const XmlPlace& place) {
  const std::string_view text = resolution.attribute(name).value();
  const std::optional<long long> value = parse_integer(text);
  if (!value || *value < 1 || *value > 65536) {
    place.refuse("its " + std::string(name) + " is " + in_quotes(text) + ", must be a whole number in [1, 65536]");
  }
  return static_cast<std::uint32_t>(*value);
}

// Returns the adjusted calibration if there are others.
pugi::xml_node calibration_of(const pugi::xml_node& sensor) {
  const pugi::xml_node adjusted = sensor.find_child_by_attribute("calibration", "class", "adjusted");
  return adjusted ? adjusted : sensor.child("calibration");
}

// Everything that a calibration may hold; of these, the last ones are no coefficients.
constexpr std::array kCalibrationNames{"f",  "cx", "cy", "b1", "b2",         "k1",   "k2",         "k3", "k4",
                                       "p1", "p2", "p3", "p4", "resolution", "date", "covariance", "fx"};

void refuse_unread_calibration(const pugi::xml_node& calibration, const XmlPlace& place) {
  for (const pugi::xml_node& node : calibration.children()) {
    const std::string_view name = node.name();
    const bool known = std::any_of(kCalibrationNames.begin(), kCalibrationNames.end(),
                                   [&](const char* other) { return name == other; });
    if (known || node.type() != pugi::node_element) continue;
    const std::optional<double> value = parse_number(trimmed_text(node));
    if (value == 0.0) continue;
    place.refuse("its calibration has " + in_quotes(name) +
                 ", which this program does not read: export undistorted photographs and their cameras");
  }
}

CameraModel panorama_of_sensor(const pugi::xml_node& sensor, const XmlPlace& place) {
  const pugi::xml_node resolution = sensor.child("resolution");
  CameraModel lens{LensModel::kEquirectangular, size_in(resolution, "width", place),
                   size_in(resolution, "height", place)};
  lens.parameters = {static_cast<double>(lens.width), static_cast<double>(lens.height)};
  return lens;
}

CameraModel lens_of_sensor(const pugi::xml_node& sensor, const XmlPlace& place) {
  const pugi::xml_node calibration = calibration_of(sensor);
  if (sensor.attribute("type").value() == std::string_view("spherical")) return panorama_of_sensor(sensor, place);
  if (!calibration) place.refuse("has no calibration: export the cameras after aligning them");
  const pugi::xml_node resolution =
      calibration.child("resolution") ? calibration.child("resolution") : sensor.child("resolution");
  if (calibration.child("fx")) place.refuse("is calibrated by fx and fy, as PhotoScan before 1.2 did: export it again");
  const auto value = [&](const char* name) { return number_or_0(calibration, name, place); };
  BrownLens lens{size_in(resolution, "width", place), size_in(resolution, "height", place)};
  lens.fy = value("f");
  lens.fx = lens.fy + value("b1");
  lens.cx = 0.5 * lens.width + value("cx");
  lens.cy = 0.5 * lens.height + value("cy");
  lens.k1 = value("k1");
  lens.k2 = value("k2");
  lens.k3 = value("k3");
  lens.k4 = value("k4");
  lens.p1 = value("p2");  // see the header
  lens.p2 = value("p1");
  lens.p3 = value("p3");
  lens.p4 = value("p4");
  lens.skew = value("b2");
  refuse_unread_calibration(calibration, place);
  std::string_view type = calibration.attribute("type").value();
  if (type.empty()) type = sensor.attribute("type").value();
  if (type != "frame" && type != "fisheye" && type != "equidistant_fisheye") {
    place.refuse("is of the type " + in_quotes(type) + ", must be frame, fisheye or spherical");
  }
  lens.fisheye = type != "frame";
  try {
    return lens_of(lens);
  } catch (const std::invalid_argument& error) {
    place.refuse(std::string("an impossible camera: ") + error.what());
  }
}

Similarity similarity_of(const pugi::xml_node& transform, const XmlPlace& place) {
  Similarity result;
  if (const pugi::xml_node node = transform.child("rotation")) {
    const std::vector<double> r = numbers(node, 9, place);
    for (int i = 0; i < 9; ++i) result.rotation[i % 3][i / 3] = r[static_cast<std::size_t>(i)];
  }
  if (const pugi::xml_node node = transform.child("translation")) {
    const std::vector<double> t = numbers(node, 3, place);
    result.translation = {t[0], t[1], t[2]};
  }
  if (const pugi::xml_node node = transform.child("scale")) result.scale = numbers(node, 1, place)[0];
  if (!(result.scale > 0)) place.refuse("its scale is " + number_text(result.scale) + ", must be positive");
  return result;
}

// The position and rotation of a frame in another frame.
struct RigPose {
  glm::dmat3 rotation{1.0};
  glm::dvec3 center{0.0};

  // The pose of what has the pose `inner` in the coordinates of this.
  [[nodiscard]] RigPose operator*(const RigPose& inner) const {
    return {rotation * inner.rotation, rotation * inner.center + center};
  }
};

RigPose pose_of(const pugi::xml_node& transform, const XmlPlace& place) {
  const std::vector<double> m = numbers(transform, 16, place);
  try {
    check_last_row({m[12], m[13], m[14], m[15]});
  } catch (const std::invalid_argument& error) {
    place.refuse(std::string("its transform: ") + error.what());
  }
  RigPose pose;
  for (int i = 0; i < 9; ++i)
    pose.rotation[i % 3][i / 3] = m[4 * (static_cast<std::size_t>(i) / 3) + static_cast<std::size_t>(i) % 3];
  pose.center = {m[3], m[7], m[11]};
  return pose;
}

// Returns the pose of a sensor in a rig, in the coordinates of the rig's master. A sensor without an offset stands
// where the master does.
RigPose pose_in_rig(const pugi::xml_node& sensor, const XmlPlace& place) {
  RigPose pose;
  if (const pugi::xml_node node = sensor.child("rotation")) {
    const std::vector<double> r = numbers(node, 9, place);
    for (int i = 0; i < 9; ++i) pose.rotation[i % 3][i / 3] = r[static_cast<std::size_t>(i)];
  }
  if (const pugi::xml_node node = sensor.child("location")) {
    const std::vector<double> t = numbers(node, 3, place);
    pose.center = {t[0], t[1], t[2]};
  }
  return pose;
}

class ChunkReader {
 public:
  ChunkReader(const pugi::xml_node& chunk, const fs::path& path, const PhotographLookup& photographs)
      : chunk_(chunk), path_(path), photographs_(photographs) {}

  Capture read() {
    for (const pugi::xml_node& sensor : chunk_.child("sensors").children("sensor")) {
      sensors_.emplace(sensor.attribute("id").value(), sensor);
    }
    if (const pugi::xml_node transform = chunk_.child("transform")) {
      world_from_chunk_ = similarity_of(transform, {path_, "its chunk"});
    }
    for (const pugi::xml_node& component : chunk_.child("components").children("component")) {
      if (!component.child("transform")) continue;
      const std::string id = component.attribute("id").value();
      components_.emplace(id, similarity_of(component.child("transform"), {path_, "component " + in_quotes(id)}));
    }
    collect_cameras(chunk_.child("cameras"));
    for (const pugi::xml_node& group : chunk_.child("cameras").children("group")) collect_cameras(group);
    for (const pugi::xml_node& camera : cameras_) add_camera(camera);
    if (in_rigs_ > 0) {
      posed_.notes.push_back(std::to_string(in_rigs_) +
                             " cameras of rigs are placed by their masters' poses and their sensors' offsets");
    }
    note_skipped(posed_, without_pose_, "are disabled or were not aligned");
    finish(posed_, path_, photographs_.bad);
    const std::string reference = chunk_.child("reference").text().get();
    if (!reference.empty() && !reference.starts_with("LOCAL_CS")) {
      posed_.georeference = GeoReference{GeoReference::Frame::geocentric, 0, 0, 0, reference};
      posed_.notes.emplace_back(
          "the chunk is georeferenced, and the mesh is taken to be in geocentric coordinates: export "
          "both in local ones if they do not meet");
    }
    return std::move(posed_);
  }

 private:
  void collect_cameras(const pugi::xml_node& cameras) {
    for (const pugi::xml_node& camera : cameras.children("camera")) {
      cameras_.push_back(camera);
      cameras_by_id_.emplace(camera.attribute("id").value(), camera);
    }
  }

  // The camera that has the pose of the whole rig; the camera itself if it is in none.
  [[nodiscard]] pugi::xml_node master_of(const pugi::xml_node& camera) const {
    const std::string id = camera.attribute("master_id").value();
    if (id.empty() || camera.child("transform")) return camera;
    const auto found = cameras_by_id_.find(id);
    return found == cameras_by_id_.end() ? camera : found->second;
  }

  void add_camera(const pugi::xml_node& camera) {
    const std::string_view enabled = camera.attribute("enabled").value();
    const pugi::xml_node master = master_of(camera);
    if (enabled == "false" || enabled == "0" || !master.child("transform")) {
      ++without_pose_;
      return;
    }
    if (master != camera) ++in_rigs_;
    add_photograph(posed_, photographs_.bad, camera.attribute("label").value(),
                   [&] { return photograph_of(camera, master); });
  }

  PosedPhotograph photograph_of(const pugi::xml_node& camera, const pugi::xml_node& master) {
    const std::string label = camera.attribute("label").value();
    const XmlPlace place{path_, "camera " + in_quotes(label)};
    RigPose chunk_from_camera = pose_of(master.child("transform"), place);
    if (master != camera) chunk_from_camera = chunk_from_camera * pose_in_rig(sensor_of(camera, place), place);
    PosedPhotograph photograph = find_photograph(label, camera.parent().attribute("label").value());
    const Similarity& world = world_of(master);
    const glm::dvec3 center = world.scale * (world.rotation * chunk_from_camera.center) + world.translation;
    const std::string broken =
        set_pose(photograph, world.rotation * chunk_from_camera.rotation, center, CameraAxes::right_down_forward);
    if (!broken.empty()) place.refuse("its transform " + broken);
    photograph.lens = lens_of_camera(camera, place);
    return photograph;
  }

  // If several photographs have the camera's label, this takes the one in a folder that has the name of the camera's
  // group.
  [[nodiscard]] PosedPhotograph find_photograph(const std::string& label, const std::string& group) const {
    try {
      return photographs_.find(label);
    } catch (const InputError&) {
      if (group.empty()) throw;
      return photographs_.find(group + "/" + label);
    }
  }

  [[nodiscard]] const Similarity& world_of(const pugi::xml_node& camera) const {
    const auto found = components_.find(camera.attribute("component_id").value());
    return found == components_.end() ? world_from_chunk_ : found->second;
  }

  [[nodiscard]] const pugi::xml_node& sensor_of(const pugi::xml_node& camera, const XmlPlace& place) const {
    const std::string id = camera.attribute("sensor_id").value();
    const auto sensor = sensors_.find(id);
    if (sensor == sensors_.end()) place.refuse("is of sensor " + in_quotes(id) + ", which is not in the file");
    return sensor->second;
  }

  const CameraModel& lens_of_camera(const pugi::xml_node& camera, const XmlPlace& place) {
    const pugi::xml_node& sensor = sensor_of(camera, place);
    const std::string id = sensor.attribute("id").value();
    const auto known = lenses_.find(id);
    if (known != lenses_.end()) return known->second;
    return lenses_.emplace(id, lens_of_sensor(sensor, {path_, "sensor " + in_quotes(id)})).first->second;
  }

  const pugi::xml_node chunk_;
  const fs::path& path_;
  const PhotographLookup& photographs_;
  std::map<std::string, pugi::xml_node> sensors_;
  std::map<std::string, CameraModel> lenses_;  // for sensors that cameras have
  std::map<std::string, Similarity> components_;
  std::vector<pugi::xml_node> cameras_;  // in the order of the file
  std::map<std::string, pugi::xml_node> cameras_by_id_;
  Similarity world_from_chunk_;
  std::size_t without_pose_ = 0, in_rigs_ = 0;
  Capture posed_;
};

bool begins_as_metashape(std::string_view text) {
  const std::size_t document = text.find("<document");
  return document != std::string_view::npos && text.find("<chunk", document) != std::string_view::npos;
}

}  // namespace

Capture parse_metashape(std::string_view text, const fs::path& path, const PhotographLookup& photographs) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed) {
    throw InputError(path.string() + ": is no XML from byte " + std::to_string(parsed.offset) +
                     " on: " + short_reason(parsed.description()));
  }
  std::size_t chunks = 0;
  pugi::xml_node first;
  for (const pugi::xml_node& chunk : document.child("document").children("chunk")) {
    if (!chunk.child("cameras")) continue;
    if (++chunks == 1) first = chunk;
  }
  if (chunks == 0) throw InputError(path.string() + ": has no chunk with cameras, as Metashape exports them");
  Capture posed = ChunkReader(first, path, photographs).read();
  if (chunks > 1) posed.notes.push_back("the first of its " + std::to_string(chunks) + " chunks is read");
  return posed;
}

std::optional<fs::path> find_metashape(const fs::path& scene) {
  for (const fs::path& file : files_ending_in(scene, ".xml")) {
    if (begins_as_metashape(first_bytes(file))) return file;
  }
  return std::nullopt;
}

Capture read_metashape(const CaptureRequest& request) {
  const fs::path path = find_metashape(request.scene).value();
  return parse_metashape(read_whole_file(path), path, photographs_of(request));
}

}  // namespace lumatlas
