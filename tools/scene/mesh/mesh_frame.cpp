// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/mesh/mesh_frame.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/base/number_text.h"
#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr Requirement mesh_frame_requires{"mesh frame"};
constexpr double kMostShift = 1e12;

bool is_signed_permutation(const glm::dmat3& axes) {
  for (int i = 0; i < 3; ++i) {
    int in_column = 0, in_row = 0;
    for (int j = 0; j < 3; ++j) {
      const double entry = axes[i][j];
      if (entry != 0 && entry != 1 && entry != -1) return false;
      in_column += entry != 0 ? 1 : 0;
      in_row += axes[j][i] != 0 ? 1 : 0;
    }
    if (in_column != 1 || in_row != 1) return false;
  }
  return true;
}

// The parts between commas of "(a, b, c)", in small letters, without spaces.
std::vector<std::string> parts_of_triple(std::string_view text) {
  std::string plain;
  for (const char c : text) {
    if (std::isspace(static_cast<unsigned char>(c)) == 0) {
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  if (plain.size() >= 2 && plain.front() == '(' && plain.back() == ')') plain = plain.substr(1, plain.size() - 2);
  std::vector<std::string> parts(1);
  for (const char c : plain) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  for (std::string& part : parts) {
    if (part.size() > 1 && part.front() == '+' && part[1] != '-') part.erase(0, 1);
  }
  return parts;
}

[[noreturn]] void refuse_axes(std::string_view text, const std::string& why) {
  throw std::invalid_argument(std::string(text) + " " + why +
                              ": give the poses' x, y and z in terms of the mesh's, such as x,-z,y");
}

[[noreturn]] void refuse_shift(std::string_view text, const std::string& why) {
  throw std::invalid_argument(std::string(text) + " " + why +
                              ": give what is added to x, y and z, such as -500000,-4500000,0");
}

}  // namespace

void check(const MeshFrame& frame) {
  mesh_frame_requires(std::isfinite(frame.scale) && frame.scale > 0, "scale", frame.scale, "finite and above 0");
  if (!is_signed_permutation(frame.axes)) {
    throw std::invalid_argument("mesh frame: axes must have one 1 or -1 in each row and column, and else 0");
  }
  for (int i = 0; i < 3; ++i) {
    mesh_frame_requires(std::abs(frame.shift[i]) <= kMostShift, "shift", frame.shift[i], "within 1e12 of 0");
  }
}

MeshFrame combined(const MeshFrame& first, const MeshFrame& second) {
  return {second.axes * first.axes, second.scale * first.scale,
          second.scale * (second.axes * first.shift) + second.shift};
}

void move_to_frame_of_poses(TriangleSoup& soup, const MeshFrame& frame) {
  check(frame);
  if (frame == MeshFrame{}) return;
  for (glm::dvec3& position : soup.positions) position = frame.scale * (frame.axes * position) + frame.shift;
  if (glm::determinant(frame.axes) > 0) return;
  for (glm::uvec3& face : soup.faces) std::swap(face.y, face.z);
}

glm::dmat3 parse_mesh_axes(std::string_view text) {
  const std::vector<std::string> parts = parts_of_triple(text);
  if (parts.size() != 3) refuse_axes(text, "does not name three axes");
  glm::dmat3 axes(0.0);
  std::array<bool, 3> named{};
  for (int row = 0; row < 3; ++row) {
    const std::string& part = parts[static_cast<std::size_t>(row)];
    const bool negative = part.starts_with('-');
    const std::string letter = part.substr(negative ? 1 : 0);
    if (letter != "x" && letter != "y" && letter != "z") refuse_axes(text, "names an axis that is not x, y or z");
    const int column = letter.front() - 'x';
    if (std::exchange(named[static_cast<std::size_t>(column)], true)) refuse_axes(text, "names " + letter + " twice");
    axes[column][row] = negative ? -1 : 1;
  }
  return axes;
}

std::string mesh_axes_text(const glm::dmat3& axes) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (axes[column][row] == 0) continue;
      text += text.empty() ? "" : ",";
      text += axes[column][row] < 0 ? "-" : "";
      text += "xyz"[column];
    }
  }
  return text;
}

glm::dvec3 parse_mesh_shift(std::string_view text) {
  const std::vector<std::string> parts = parts_of_triple(text);
  if (parts.size() != 3) refuse_shift(text, "is not three numbers");
  glm::dvec3 shift(0);
  for (int i = 0; i < 3; ++i) {
    const std::string& part = parts[static_cast<std::size_t>(i)];
    const char* const end = part.data() + part.size();
    const auto [stop, error] = std::from_chars(part.data(), end, shift[i]);
    if (error != std::errc() || stop != end) refuse_shift(text, "is not three numbers");
    if (!(std::abs(shift[i]) <= kMostShift)) refuse_shift(text, "is not within 1e12 of 0");
  }
  return shift;
}

std::string mesh_frame_options(const MeshFrame& frame) {
  std::vector<std::string> options;
  const MeshFrame none;
  if (frame.scale != none.scale || frame == none) options.push_back("--mesh-scale " + number_text(frame.scale));
  if (frame.axes != none.axes) options.push_back("--mesh-axes " + mesh_axes_text(frame.axes));
  if (frame.shift != none.shift) {
    options.push_back("--mesh-shift " + number_text(frame.shift.x) + "," + number_text(frame.shift.y) + "," +
                      number_text(frame.shift.z));
  }
  std::string text;
  for (const std::string& option : options) text += (text.empty() ? "" : " ") + option;
  return text;
}

nlohmann::json mesh_frame_json(const MeshFrame& frame) {
  return {{"mesh_scale", frame.scale},
          {"mesh_axes", mesh_axes_text(frame.axes)},
          {"mesh_shift", {frame.shift.x, frame.shift.y, frame.shift.z}}};
}

}  // namespace lumatlas
