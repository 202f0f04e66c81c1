// SPDX-License-Identifier: GPL-3.0-or-later
// A reader of our own, because those of Debian's libraries stop at damage without a place: CGAL's says only that it
// failed, and Assimp is many formats' worth of code that strangers' files would reach.
#include "mesh/readers/stl_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <unordered_map>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/readers/polygons.h"

namespace lumatlas {

namespace {

constexpr std::size_t kHeaderBytes = 84;    // 80 of any text, and the count of triangles
constexpr std::size_t kTriangleBytes = 50;  // normal, three corners, two bytes that programs use differently

// STL repeats a vertex in each of its triangles.
class Welder {
 public:
  explicit Welder(TriangleSoup& soup) : soup_(soup) {}

  void add_face(const std::array<glm::dvec3, 3>& corners) {
    soup_.faces.push_back(glm::uvec3{vertex(corners[0]), vertex(corners[1]), vertex(corners[2])});  // in this order
  }

 private:
  struct Hash {
    std::size_t operator()(const glm::dvec3& p) const {
      const std::hash<double> hash;
      return (hash(p.x) * 31 + hash(p.y)) * 31 + hash(p.z);
    }
  };

  // One that is not a number equals nothing and stays alone: among the others, many of them would share a place.
  std::uint32_t vertex(const glm::dvec3& position) {
    const auto next = static_cast<std::uint32_t>(soup_.positions.size());
    const bool is_number = position == position;
    if (is_number) {
      const auto [found, is_new] = vertices_.emplace(position, next);
      if (!is_new) return found->second;
    }
    soup_.positions.push_back(position);
    return next;
  }

  TriangleSoup& soup_;
  std::unordered_map<glm::dvec3, std::uint32_t, Hash> vertices_;
};

std::uint32_t count_of(std::string_view contents) {
  std::uint32_t count = 0;
  std::memcpy(&count, contents.data() + kHeaderBytes - sizeof count, sizeof count);
  return count;
}

bool is_binary(std::string_view contents) {
  return contents.size() >= kHeaderBytes &&
         (contents.size() - kHeaderBytes) == std::uint64_t{count_of(contents)} * kTriangleBytes;
}

TriangleSoup parse_binary(std::string_view contents) {
  TriangleSoup soup;
  Welder welder(soup);
  for (std::size_t at = kHeaderBytes; at < contents.size(); at += kTriangleBytes) {
    std::array<glm::vec3, 4> rows;  // the normal first
    std::memcpy(rows.data(), contents.data() + at, sizeof rows);
    welder.add_face({glm::dvec3(rows[1]), glm::dvec3(rows[2]), glm::dvec3(rows[3])});
  }
  return soup;
}

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

// The words of STL are written in lower or upper case.
std::string lower_case(std::string_view word) {
  std::string result(word);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

// Returns whether the contents begin with "solid", after blanks and empty lines.
bool begins_as_ascii(std::string_view contents) {
  if (contents.starts_with(kByteOrderMark)) contents.remove_prefix(kByteOrderMark.size());
  constexpr std::string_view kBlanks = " \t\r\n";
  contents.remove_prefix(std::min(contents.find_first_not_of(kBlanks), contents.size()));
  return lower_case(contents.substr(0, contents.find_first_of(kBlanks))) == "solid";
}

class AsciiParser {
 public:
  AsciiParser(std::string_view contents, const std::string& path) : rest_(contents), path_(path) {}

  TriangleSoup parse() {
    TriangleSoup soup;
    Welder welder(soup);
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    while (!rest_.empty()) {
      std::string_view line = take_line(rest_);
      ++line_number_;
      const std::string keyword = lower_case(take_field(line));
      if (keyword == "vertex") {
        if (corners_ == 3) fail("a triangle has a fourth vertex");
        loop_[corners_++] = position(line);
      } else if (keyword == "endloop" || keyword == "endfacet") {
        if (keyword == "endfacet" && corners_ == 0) continue;
        if (corners_ != 3) fail("a triangle has " + std::to_string(corners_) + " vertices, must have 3");
        welder.add_face(loop_);
        corners_ = 0;
      } else if (!is_skipped(keyword)) {
        fail("begins with " + in_quotes(keyword) + ", which is no word of STL");
      }
    }
    if (corners_ != 0) fail("ends within a triangle");
    return soup;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(path_ + ": line " + std::to_string(line_number_) + ": " + reason);
  }

  static bool is_skipped(std::string_view keyword) {
    return keyword.empty() || keyword == "solid" || keyword == "facet" || keyword == "outer" || keyword == "endsolid" ||
           keyword == "color";
  }

  [[nodiscard]] glm::dvec3 position(std::string_view line) const {
    glm::dvec3 result(0);
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view field = take_field(line);
      const std::optional<double> number = parse_number(field);
      if (!number) fail("a vertex has the value " + in_quotes(field) + ", which is not a number");
      result[axis] = *number;
    }
    if (!take_field(line).empty()) fail("a vertex has more than 3 numbers");
    return result;
  }

  std::string_view rest_;
  const std::string& path_;
  std::size_t line_number_ = 0;
  std::array<glm::dvec3, 3> loop_{};
  std::size_t corners_ = 0;
};

std::string neither(std::string_view contents) {
  std::string reason = ": is neither ASCII STL, which begins with \"solid\", nor binary STL";
  if (contents.size() < kHeaderBytes) return reason + ", which has at least 84 bytes";
  return reason + ": for its " + std::to_string(count_of(contents)) + " triangles it would have " +
         std::to_string(kHeaderBytes + std::uint64_t{count_of(contents)} * kTriangleBytes) + " bytes, but it has " +
         std::to_string(contents.size());
}

}  // namespace

TriangleSoup parse_stl(std::string_view contents, const std::string& path) {
  TriangleSoup soup;
  if (is_binary(contents)) {
    soup = parse_binary(contents);
  } else if (begins_as_ascii(contents) && contents.find('\0') == std::string_view::npos) {
    soup = AsciiParser(contents, path).parse();
  } else {
    throw InputError(path + neither(contents));
  }
  if (soup.faces.empty()) throw no_faces(path);
  return soup;
}

}  // namespace lumatlas
