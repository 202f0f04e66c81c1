// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/paths/path_file.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

namespace {

using nlohmann::json;

constexpr double kMostNumber = 1e12;  // coordinates and times: sums and squares of them are safe
constexpr double kLeastGap = 1e-9;    // between times, of the larger of 1 and the time
constexpr double kLeastFov = 0.01;    // degrees
constexpr double kMostFov = 179;      // degrees

class PathReader {
 public:
  PathReader(const std::filesystem::path& file, const PathDefaults& defaults) : file_(file), defaults_(defaults) {}

  [[nodiscard]] std::vector<KeyFrame> keys() const {
    const json content = read_json(file_);
    if (!content.is_object() || !content.contains("keys") || !content["keys"].is_array() || content["keys"].empty()) {
      refuse("must be an object with \"keys\", an array of at least one key frame");
    }
    refuse_others(content, {"keys"}, "it");
    std::vector<KeyFrame> keys;
    for (const json& entry : content["keys"]) {
      keys.push_back(key(entry, keys.size()));
      if (keys.size() > 1) require_later(keys[keys.size() - 2].time, keys.back().time, keys.size() - 1);
    }
    return keys;
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { throw InputError(file_.string() + ": " + why); }
  [[nodiscard]] static std::string name_of(std::size_t index) { return "key frame " + std::to_string(index); }

  // A misspelt field would else be ignored.
  void refuse_others(const json& object, const std::set<std::string>& known, const std::string& where) const {
    for (const auto& [name, value] : object.items()) {
      if (!known.contains(name)) refuse(where + " has the unknown field " + json(name).dump(-1, ' ', true));
    }
  }

  void require_later(double before, double time, std::size_t index) const {
    if (!(time - before >= kLeastGap * std::max(1.0, std::abs(time)))) {
      refuse(name_of(index) + " must be later than the one before it");
    }
  }

  [[nodiscard]] static bool is_number(const json& value) {
    return value.is_number() && std::abs(value.get<double>()) <= kMostNumber;
  }

  [[nodiscard]] double number(const json& object, const char* name, const std::string& where) const {
    const json& value = object[name];
    if (!is_number(value)) refuse(where + ": \"" + name + "\" must be a number, at most 1e12");
    return value.get<double>();
  }

  template <int N>
  [[nodiscard]] glm::vec<N, double> numbers(const json& object, const char* name, const std::string& where) const {
    const json& value = object[name];
    if (!value.is_array() || value.size() != N || !std::all_of(value.begin(), value.end(), is_number)) {
      refuse(where + ": \"" + name + "\" must be an array of " + std::to_string(N) + " numbers, at most 1e12");
    }
    glm::vec<N, double> vector(0);
    for (int i = 0; i < N; ++i) vector[i] = value[static_cast<std::size_t>(i)].get<double>();
    return vector;
  }

  [[nodiscard]] glm::dquat turn(const json& entry, const glm::dvec3& position, const std::string& where) const {
    if (entry.contains("look_at") == entry.contains("rotation")) {
      refuse(where + " must have either \"look_at\" or \"rotation\"");
    }
    if (entry.contains("rotation")) {
      if (entry.contains("up")) refuse(where + " has \"up\", which goes with \"look_at\" alone");
      const glm::dvec4 wxyz = numbers<4>(entry, "rotation", where);
      if (!(std::abs(glm::length(wxyz) - 1) < 1e-3)) {
        refuse(where + ": \"rotation\" must be a unit quaternion, w x y z");
      }
      return glm::normalize(glm::dquat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]));
    }
    const glm::dvec3 up = entry.contains("up") ? numbers<3>(entry, "up", where) : defaults_.up;
    const glm::dvec3 target = numbers<3>(entry, "look_at", where) - defaults_.offset;
    if (target == position) refuse(where + ": \"look_at\" must differ from \"position\"");
    if (up == glm::dvec3(0)) refuse(where + ": \"up\" must not be zero");
    return look_at(position, target, up);
  }

  [[nodiscard]] KeyFrame key(const json& entry, std::size_t index) const {
    const std::string where = name_of(index);
    if (!entry.is_object() || !entry.contains("position")) refuse(where + " must be an object with a \"position\"");
    refuse_others(entry, {"time", "position", "look_at", "up", "rotation", "fov"}, where);
    KeyFrame key;
    key.time = entry.contains("time") ? number(entry, "time", where) : static_cast<double>(index);
    key.vantage.position = numbers<3>(entry, "position", where) - defaults_.offset;
    key.vantage.cam_from_world = turn(entry, key.vantage.position, where);
    key.vantage.fov_deg = entry.contains("fov") ? number(entry, "fov", where) : defaults_.fov_deg;
    if (!(key.vantage.fov_deg >= kLeastFov && key.vantage.fov_deg <= kMostFov)) {
      refuse(where + ": \"fov\" must be in [0.01, 179] degrees");
    }
    return key;
  }

  const std::filesystem::path& file_;
  const PathDefaults& defaults_;
};

}  // namespace

std::vector<KeyFrame> read_path(const std::filesystem::path& file, const PathDefaults& defaults) {
  return PathReader(file, defaults).keys();
}

}  // namespace lumatlas
