// SPDX-License-Identifier: GPL-3.0-or-later
// A reader of our own, because tinyobjloader reads what is no number as 0, rounds decimals to a neighbour of the
// nearest double, and passes on negative indices that point before the first vertex.
#include "mesh/readers/obj_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/readers/polygons.h"

namespace lumatlas {

namespace {

constexpr std::string_view kSeparators = " \t\r\v\f\n\\";  // a statement may go on after a backslash and a line feed

// Statements that change nothing about triangles: texture, normals, groups, materials, how it is drawn, points, lines.
constexpr std::array<std::string_view, 23> kSkipped{
    "vt",     "vn",         "vp",        "g",     "o",     "s",     "mg",       "usemtl",
    "mtllib", "usemap",     "maplib",    "p",     "l",     "bevel", "c_interp", "d_interp",
    "lod",    "shadow_obj", "trace_obj", "ctech", "stech", "vc",    "vw"};
// Statements of surfaces that are made of something else than polygons.
constexpr std::array<std::string_view, 19> kFreeForm{"cstype", "deg",  "bmat", "step", "surf", "curv", "curv2",
                                                     "parm",   "trim", "hole", "scrv", "sp",   "con",  "end",
                                                     "bzp",    "bsp",  "cdc",  "cdp",  "res"};

template <typename Words>
bool is_one_of(std::string_view word, const Words& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

class ObjParser {
 public:
  ObjParser(std::string_view contents, const std::string& path) : rest_(contents), path_(path) {}

  TriangleSoup parse() {
    while (!rest_.empty()) {
      line_ = take_line(rest_);
      line_number_ += 1;
      const std::string_view keyword = take_field(line_, kSeparators);
      if (keyword == "v") {
        parse_vertex();
      } else if (keyword == "f" || keyword == "fo") {  // fo: as version 2.11 has faces
        parse_face();
      } else {
        skip_statement(keyword);
      }
    }
    check_forward_reference();
    if (soup_.positions.empty()) throw InputError(path_ + ": has no vertices");
    if (soup_.faces.empty()) throw no_faces(path_);
    take_colors();
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

  void skip_statement(std::string_view keyword) {
    if (keyword.empty() || keyword.starts_with('#')) return;
    if (keyword == "call" || keyword == "csh") {
      fail("begins with " + in_quotes(keyword) +
           ", which takes in another file, which this program does not read: write one file");
    }
    if (is_one_of(keyword, kFreeForm)) {
      fail("begins with " + in_quotes(keyword) +
           ", a free-form surface, which this program does not read: convert it to triangles");
    }
    if (!is_one_of(keyword, kSkipped) && !follows_skipped_) {
      fail("begins with " + in_quotes(keyword) + ", which is no word of OBJ");
    }
    // A line that ends with a backslash goes on, or names a material or a folder that does.
    follows_skipped_ = ends_with_backslash(line_);
  }

  void begin_statement() {
    follows_skipped_ = false;
    continues_ = ends_with_backslash(line_);
  }

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
    std::array<double, 8> values{};
    std::size_t count = 0;
    for (std::string_view next = field(); !next.empty() && !next.starts_with('#'); next = field()) {
      if (count == values.size()) fail("a vertex has more than 8 numbers");
      const auto number = parse_number(next);
      if (!number) fail("a vertex has the value " + in_quotes(next) + ", which is not a number");
      values[count++] = *number;
    }
    check_count(count);
    if (soup_.positions.size() == std::numeric_limits<std::uint32_t>::max()) fail("more than 4294967295 vertices");
    soup_.positions.emplace_back(values[0], values[1], values[2]);
    if (count == 4 || count == 8) check_weight(values[3]);
    if (count >= 6) append_color({values.begin() + (count == 8 ? 4 : 3), values.begin() + count});
    end_statement();
  }

  // The count of a vertex's numbers tells what they are, and must be the same all over the file. Only a weight of 1 may
  // be left out.
  void check_count(std::size_t count) {
    if (count < 3 || count == 5) fail("a vertex has " + std::to_string(count) + " numbers; 3, 4, 6, 7 or 8 are known");
    if (soup_.positions.empty()) numbers_ = count;
    const bool same = count == numbers_ || (count <= 4 && numbers_ <= 4);
    if (same) return;
    fail("a vertex has " + std::to_string(count) + " numbers, the first has " + std::to_string(numbers_) +
         ": give all the same");
  }

  void check_weight(double weight) const {
    if (weight == 1) return;
    fail("a vertex has the weight " + number_text(weight) + ", must be 1: write x y z divided by it");
  }

  // Takes three or four numbers. Which of four are the colour is known at the end of the file.
  void append_color(std::span<const double> numbers) {
    glm::u8vec4& color = colors_.emplace_back(0);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!(numbers[i] >= 0 && numbers[i] <= 1)) fail("a vertex has a colour outside of [0, 1]");
      color[static_cast<int>(i)] = static_cast<std::uint8_t>(numbers[i] * 255 + 0.5);
    }
    first_is_1_ = first_is_1_ && numbers.front() == 1;
    last_is_1_ = last_is_1_ && numbers.back() == 1;
  }

  // Seven numbers are x y z w r g b, whose weight is 1, or x y z r g b a.
  void take_colors() {
    const bool weighted = numbers_ == 7 && first_is_1_;
    const bool same = std::all_of(colors_.begin(), colors_.end(),
                                  [](const glm::u8vec4& c) { return c.x == c.y && c.y == c.z && c.z == c.w; });
    if (weighted && last_is_1_ && !same) {
      throw InputError(path_ +
                       ": its vertices have 7 numbers, of which the fourth and the last are 1 everywhere: this may be "
                       "x y z w r g b or x y z r g b a; write x y z r g b");
    }
    for (const glm::u8vec4& c : colors_) {
      soup_.colors.push_back(weighted ? glm::u8vec3(c.y, c.z, c.w) : glm::u8vec3(c.x, c.y, c.z));
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

  std::string_view rest_;  // the rest of the contents
  std::string_view line_;  // the rest of the line
  const std::string& path_;
  std::size_t line_number_ = 0;  // line at which the statement begins
  std::size_t lines_continued_ = 0;
  bool continues_ = false;
  bool follows_skipped_ = false;  // the line before may be the beginning of this one, and was skipped
  std::optional<ForwardReference> furthest_;
  std::size_t numbers_ = 0;          // numbers of the first vertex
  std::vector<glm::u8vec4> colors_;  // one per position, or empty: what follows the position, and a weight before alpha
  bool first_is_1_ = true, last_is_1_ = true;  // true as long as these numbers are 1 everywhere
  std::vector<std::uint32_t> corners_;
  Polygons polygons_;
  TriangleSoup soup_;
};

}  // namespace

TriangleSoup parse_obj(std::string_view contents, const std::string& path) {
  return ObjParser(contents, path).parse();
}

}  // namespace lumatlas
