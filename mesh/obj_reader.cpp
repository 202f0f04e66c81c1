// SPDX-License-Identifier: GPL-3.0-or-later
// A reader of our own, because tinyobjloader reads what is no number as 0, rounds decimals to a neighbour of the
// nearest double, and passes on negative indices that point before the first vertex.
#include "mesh/obj_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/polygons.h"

namespace lumatlas {

namespace {

constexpr std::string_view kSeparators = " \t\r\v\f\n\\";  // a statement may go on after a backslash and a line feed

class ObjParser {
 public:
  ObjParser(std::string_view contents, const std::string& path) : rest_(contents), path_(path) {}

  TriangleSoup parse() {
    while (!rest_.empty()) {
      line_ = take_line(rest_);
      line_number_ += 1;
      const std::string_view keyword = take_field(line_);
      if (keyword == "v") {
        parse_vertex();
      } else if (keyword == "f") {
        parse_face();
      }
    }
    check_forward_reference();
    if (soup_.positions.empty()) throw InputError(path_ + ": has no vertices");
    if (soup_.faces.empty()) throw no_faces(path_);
    polygons_.triangulate(soup_);
    return std::move(soup_);
  }

 private:
  // A face may refer to a vertex that is defined further down.
  struct ForwardReference {
    long long index;  // from 1
    std::size_t line;
  };

  [[noreturn]] void fail_at(std::size_t line, const std::string& reason) const {
    throw InputError(path_ + ": line " + std::to_string(line) + ": " + reason);
  }
  [[noreturn]] void fail(const std::string& reason) const { fail_at(line_number_, reason); }

  // The next field of the statement, over the ends of lines that a backslash continues.
  std::string_view field() {
    while (true) {
      const std::string_view next = take_field(line_, kSeparators);
      if (!next.empty() || !continues_) return next;
      take_continuation();
    }
  }

  void begin_statement() { continues_ = ends_with_backslash(line_); }

  void take_continuation() {
    line_ = take_line(rest_);
    ++lines_continued_;
    continues_ = ends_with_backslash(line_);
  }

  void end_statement() {
    line_number_ += lines_continued_;
    lines_continued_ = 0;
  }

  static bool ends_with_backslash(std::string_view line) {
    const std::size_t last = line.find_last_not_of(" \t\r");
    return last != std::string_view::npos && line[last] == '\\';
  }

  void parse_vertex() {
    begin_statement();
    std::array<double, 7> values{};
    std::size_t count = 0;
    for (std::string_view next = field(); !next.empty() && !next.starts_with('#'); next = field()) {
      if (count == values.size()) fail("a vertex has more than 7 values");
      const auto number = parse_number(next);
      if (!number) fail("a vertex has the value " + in_quotes(next) + ", which is not a number");
      values[count++] = *number;
    }
    if (count < 3 || count == 5) fail("a vertex has " + std::to_string(count) + " values; 3, 4, 6 or 7 are known");
    if (soup_.positions.size() == std::numeric_limits<std::uint32_t>::max()) fail("more than 4294967295 vertices");
    soup_.positions.emplace_back(values[0], values[1], values[2]);
    append_color(count >= 6 ? &values[count - 3] : nullptr);
    end_statement();
  }

  void append_color(const double* rgb) {
    if (soup_.positions.size() > 1 && (rgb != nullptr) == soup_.colors.empty()) {
      fail("some vertices have colours and others do not; give them to all or to none");
    }
    if (!rgb) return;
    glm::u8vec3& color = soup_.colors.emplace_back();
    for (int i = 0; i < 3; ++i) {
      if (!(rgb[i] >= 0 && rgb[i] <= 1)) fail("a vertex has a colour outside of [0, 1]");
      color[i] = static_cast<std::uint8_t>(rgb[i] * 255 + 0.5);
    }
  }

  void parse_face() {
    begin_statement();
    corners_.clear();
    for (std::string_view next = field(); !next.empty() && !next.starts_with('#'); next = field()) {
      corners_.push_back(parse_corner(next));
    }
    if (corners_.empty()) fail("a face has no corners");
    polygons_.append(corners_, soup_.faces);
    end_statement();
  }

  // "7", "7/1", "7//3" or "7/1/3"; counted from 1, or backwards from the last vertex so far with -1.
  std::uint32_t parse_corner(std::string_view corner) {
    const auto index = parse_integer(corner.substr(0, corner.find('/')));
    if (!index) fail("a face has the corner " + in_quotes(corner) + ", which does not begin with a vertex number");
    const auto count = static_cast<long long>(soup_.positions.size());
    const bool is_known = *index != 0 && *index >= -count;
    if (!is_known || *index > std::numeric_limits<std::uint32_t>::max()) fail(unknown_vertex(*index));
    if (*index > count && (!furthest_ || *index > furthest_->index)) furthest_ = {*index, line_number_};
    return static_cast<std::uint32_t>(*index > 0 ? *index - 1 : count + *index);
  }

  std::string unknown_vertex(long long index) const {
    return "a face refers to vertex " + std::to_string(index) + ", but there are " +
           std::to_string(soup_.positions.size()) + " vertices, counted from 1";
  }

  void check_forward_reference() const {
    if (furthest_ && furthest_->index > static_cast<long long>(soup_.positions.size())) {
      fail_at(furthest_->line, unknown_vertex(furthest_->index));
    }
  }

  std::string_view rest_;  // of the contents
  std::string_view line_;  // what is left of it
  const std::string& path_;
  std::size_t line_number_ = 0;  // where the statement begins
  std::size_t lines_continued_ = 0;
  bool continues_ = false;
  std::optional<ForwardReference> furthest_;
  std::vector<std::uint32_t> corners_;
  Polygons polygons_;
  TriangleSoup soup_;
};

}  // namespace

TriangleSoup parse_obj(std::string_view contents, const std::string& path) {
  return ObjParser(contents, path).parse();
}

}  // namespace lumatlas
