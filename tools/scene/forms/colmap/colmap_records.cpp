// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/colmap/colmap_records.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "mesh/base/errors.h"

namespace lumatlas::colmap {
namespace {

constexpr double kFarthest = 1e12;  // beyond, double precision cannot tell neighbouring cameras apart

std::string text_of(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.10g", value);
  return buffer.data();
}

glm::dquat unit(const std::array<double, 4>& q, const FileLocation& place) {
  double largest = 0;
  for (const double component : q) {
    if (!std::isfinite(component)) {
      fail(place, "its rotation quaternion holds " + text_of(component) + ", must be finite");
    }
    largest = std::max(largest, std::abs(component));
  }
  if (largest == 0) {
    fail(place, "its rotation quaternion is 0 0 0 0, must not be zero");
  }
  // Divided first, so that squares neither overflow nor vanish.
  return glm::normalize(glm::dquat(q[0] / largest, q[1] / largest, q[2] / largest, q[3] / largest));
}

void check_translation(const std::array<double, 3>& translation, const FileLocation& place) {
  for (const double component : translation) {
    if (!(std::abs(component) <= kFarthest)) {
      fail(place, "its translation holds " + text_of(component) + ", must be within 1e12 of 0");
    }
  }
}

void check_name(std::string_view name, const FileLocation& place) {
  if (name.empty()) {
    fail(place, "its name is empty, must be that of a photograph");
  }
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::any_of(name.begin(), name.end(), is_control)) {
    fail(place, "its name " + escaped_in_quotes(name) + " holds a control character");
  }
}

// The first record, in the order of the file, whose key an earlier one has; with that one's index.
struct Repetition {
  std::size_t first, second;
};
template <typename Record, typename Key>
std::optional<Repetition> first_repetition(const std::vector<Record>& records, Key key) {
  std::vector<std::size_t> order(records.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return key(records[a]) < key(records[b]); });
  std::optional<Repetition> found;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const bool same = key(records[order[i - 1]]) == key(records[order[i]]);
    if (same && (!found || order[i] < found->second)) {
      found = Repetition{order[i - 1], order[i]};
    }
  }
  return found;
}

[[noreturn]] void fail_repeated(const std::filesystem::path& path, const char* records, const std::string& key,
                                const Repetition& indices) {
  throw InputError(path.string() + ": the " + records + " at index " + std::to_string(indices.first) + " and " +
                   std::to_string(indices.second) + " have the same " + key);
}

}  // namespace

void fail(const FileLocation& place, const std::string& reason) {
  throw InputError(place.path.string() + ": " + place.unit + " " + std::to_string(place.number) + ": " + reason);
}

std::string escaped_in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 100;
  std::string result = "'";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      result += c;
    } else {
      std::array<char, 8> escape{};
      std::snprintf(escape.data(), escape.size(), "\\x%02x", byte);
      result += escape.data();
    }
  }
  return result + (text.size() > kLongest ? "...'" : "'");
}

namespace {

// Passes on the InputError that `check` throws, or, if bad records are kept, stores its sentence in `reason`.
template <typename Check>
void check_or_keep(BadPhotographs bad, std::string& reason, const Check& check) {
  try {
    check();
  } catch (const InputError& error) {
    if (bad == BadPhotographs::refuse) throw;
    reason = error.what();
  }
}

}  // namespace

void check_camera(ColmapCamera& camera, const FileLocation& place, BadPhotographs bad) {
  check_or_keep(bad, camera.bad, [&] {
    try {
      check(camera.lens);
    } catch (const std::invalid_argument& error) {
      fail(place,
           "camera " + std::to_string(camera.id) + " (" + std::string(name(camera.lens.model)) + "): " + error.what());
    }
  });
}

ColmapImage checked_image(std::uint32_t id, const std::array<double, 4>& quaternion,
                          const std::array<double, 3>& translation, std::uint32_t camera_id, std::string_view name,
                          const FileLocation& place, BadPhotographs bad) {
  check_name(name, place);
  ColmapImage image{id, camera_id, std::string(name)};
  check_or_keep(bad, image.bad, [&] {
    check_translation(translation, place);
    image.cam_from_world_rotation = unit(quaternion, place);
    image.cam_from_world_translation = {translation[0], translation[1], translation[2]};
  });
  return image;
}

void check_point(const ColmapPoint& point, const FileLocation& place) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(point.position[axis]) <= kFarthest)) {
      fail(place, "its position holds " + text_of(point.position[axis]) + ", must be within 1e12 of 0");
    }
  }
}

void check_unique(const std::vector<ColmapCamera>& cameras, const std::filesystem::path& path) {
  const auto id = [](const ColmapCamera& camera) { return camera.id; };
  if (const auto repetition = first_repetition(cameras, id)) {
    fail_repeated(path, "cameras", "id " + std::to_string(cameras[repetition->second].id), *repetition);
  }
}

void check_unique(const std::vector<ColmapImage>& images, const std::filesystem::path& path, BadPhotographs bad) {
  const auto id = [](const ColmapImage& image) { return image.id; };
  if (const auto repetition = first_repetition(images, id)) {
    fail_repeated(path, "images", "id " + std::to_string(images[repetition->second].id), *repetition);
  }
  if (bad == BadPhotographs::keep) return;
  const auto name = [](const ColmapImage& image) { return std::string_view(image.name); };
  if (const auto repetition = first_repetition(images, name)) {
    fail_repeated(path, "images", "name " + escaped_in_quotes(images[repetition->second].name), *repetition);
  }
}

}  // namespace lumatlas::colmap
