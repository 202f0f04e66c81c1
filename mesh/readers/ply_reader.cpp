// SPDX-License-Identifier: GPL-3.0-or-later
// A reader of our own, because what is packaged for Debian either trusts the counts in the header and aborts on bad
// input or comes with a whole mesh library, and because positions must stay in double precision.
#include "mesh/readers/ply_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/readers/ply_header.h"
#include "mesh/readers/polygons.h"

namespace lumatlas {

namespace {

// The position of a reader in the body, for its messages.
class Record {
 public:
  explicit Record(const std::string& path) : path_(path) {}

  void begin(const PlyElement& element, std::uint64_t index) {
    element_ = &element;
    index_ = index;
  }

  [[noreturn]] void fail(const std::string& reason) const {
    const bool is_ours = element_->name == "vertex" || element_->name == "face";
    const std::string name = is_ours ? element_->name : in_quotes(element_->name);
    throw InputError(path_ + ": " + name + " " + std::to_string(index_) + " " + reason);
  }
  [[noreturn]] void fail_missing(const std::string& how) const {
    fail("of " + std::to_string(element_->count) + " is " + how + "; the file is cut off or damaged");
  }

 private:
  const std::string& path_;
  const PlyElement* element_ = nullptr;
  std::uint64_t index_ = 0;
};

// The two kinds of body have the same interface: per record begin_record(), one value() or skip() for each number, then
// end_record(). check_room() refuses a count of values that the rest of the record or file cannot hold.
class BinaryBody {
 public:
  BinaryBody(std::string_view bytes, std::endian endian, const std::string& path)
      : at_(bytes.data()), end_(bytes.data() + bytes.size()), swaps_(endian != std::endian::native), record_(path) {}

  void begin_record(const PlyElement& element, std::uint64_t index) { record_.begin(element, index); }
  [[nodiscard]] const Record& record() const { return record_; }

  double value(PlyType type) {
    if (left() < byte_count(type)) record_.fail_missing("not complete");
    switch (type) {
      case PlyType::Int8:
        return load<std::int8_t>();
      case PlyType::Uint8:
        return load<std::uint8_t>();
      case PlyType::Int16:
        return load<std::int16_t>();
      case PlyType::Uint16:
        return load<std::uint16_t>();
      case PlyType::Int32:
        return load<std::int32_t>();
      case PlyType::Uint32:
        return load<std::uint32_t>();
      case PlyType::Float32:
        return static_cast<double>(load<float>());
      case PlyType::Float64:
        break;
    }
    return load<double>();
  }

  void check_room(std::uint64_t count, PlyType type) const {
    if (count > left() / byte_count(type)) record_.fail_missing("not complete");
  }

  void skip(std::uint64_t count, PlyType type) {
    check_room(count, type);
    at_ += count * byte_count(type);
  }

  void end_record() {}

  [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
  [[nodiscard]] std::string_view rest() const { return {at_, left()}; }

 private:
  template <typename Value>
  Value load() {
    std::array<char, sizeof(Value)> bytes;
    std::memcpy(bytes.data(), at_, sizeof(Value));
    at_ += sizeof(Value);
    if (swaps_) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Value>(bytes);
  }

  const char* at_;
  const char* end_;
  bool swaps_;
  Record record_;
};

// A record is a line; empty lines are skipped.
class AsciiBody {
 public:
  AsciiBody(std::string_view text, char line_feed, const std::string& path)
      : text_(text), line_feed_(line_feed), record_(path) {}

  void begin_record(const PlyElement& element, std::uint64_t index) {
    record_.begin(element, index);
    do {
      if (text_.empty()) record_.fail_missing("missing");
      line_ = take_line(text_, line_feed_);
      field_ = take_field(line_);
    } while (field_.empty());
  }
  [[nodiscard]] const Record& record() const { return record_; }

  double value(PlyType type) {
    if (field_.empty()) record_.fail("has too few values on its line");
    const auto number = parse_number(field_);
    if (!number) record_.fail("has the value " + in_quotes(field_) + ", which is not a number");
    if (type < PlyType::Float32 && *number != std::trunc(*number)) {
      record_.fail("has the value " + in_quotes(field_) + ", which is not a whole number");
    }
    field_ = take_field(line_);
    return *number;
  }

  void check_room(std::uint64_t count, PlyType) const {
    if (count > line_.size() + 1) record_.fail("has too few values on its line");
  }

  void skip(std::uint64_t count, PlyType type) {
    check_room(count, type);
    for (std::uint64_t i = 0; i < count; ++i) (void)value(type);
  }

  void end_record() const {
    if (!field_.empty()) record_.fail("has more values on its line than the header declares");
  }

  [[nodiscard]] std::size_t left() const { return text_.size(); }
  [[nodiscard]] std::string_view rest() const { return text_; }

 private:
  std::string_view text_;
  char line_feed_;
  Record record_;
  std::string_view line_;   // after the field
  std::string_view field_;  // the next one
};

constexpr std::string_view kStrips = "tristrips";

constexpr std::size_t kMissing = std::numeric_limits<std::size_t>::max();

std::size_t property_index(const PlyElement& element, std::string_view name) {
  const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                  [&](const PlyProperty& property) { return property.name == name; });
  return found == element.properties.end() ? kMissing : static_cast<std::size_t>(found - element.properties.begin());
}

using Three = std::array<std::size_t, 3>;  // property indices

bool are_scalars(const PlyElement& element, const Three& three) {
  return std::all_of(three.begin(), three.end(),
                     [&](std::size_t i) { return i != kMissing && !element.properties[i].is_list; });
}

Three position_properties(const PlyElement& vertex, const std::string& path) {
  const Three xyz{property_index(vertex, "x"), property_index(vertex, "y"), property_index(vertex, "z")};
  if (!are_scalars(vertex, xyz)) throw InputError(path + ": its element 'vertex' lacks one of the numbers x, y and z");
  return xyz;
}

std::optional<Three> color_properties(const PlyElement& vertex) {
  for (const std::string prefix : {"", "diffuse_"}) {
    const Three rgb{property_index(vertex, prefix + "red"), property_index(vertex, prefix + "green"),
                    property_index(vertex, prefix + "blue")};
    if (are_scalars(vertex, rgb)) return rgb;
  }
  return {};
}

std::optional<Three> normal_properties(const PlyElement& element) {
  const Three normal{property_index(element, "nx"), property_index(element, "ny"), property_index(element, "nz")};
  if (!are_scalars(element, normal)) return {};
  return normal;
}

std::size_t corner_property(const PlyElement& element, const std::string& path) {
  for (const char* name : {"vertex_indices", "vertex_index"}) {
    const std::size_t index = property_index(element, name);
    if (index != kMissing && element.properties[index].is_list) return index;
  }
  throw InputError(path + ": its element " + in_quotes(element.name) + " has no list vertex_indices");
}

double largest_color(PlyType type) {
  if (type >= PlyType::Float32) return 1;
  return type == PlyType::Uint16 ? 65535 : 255;
}

template <typename Body>
class SoupReader {
 public:
  SoupReader(Body body, const std::string& path) : body_(body), path_(path) {}

  TriangleSoup read(const PlyHeader& header) {
    for (const PlyElement& element : header.elements) {
      if (element.name == "vertex") vertex_count_ = element.count;
    }
    for (const PlyElement& element : header.elements) {
      if (element.name == "vertex") {
        read_vertices(element);
      } else if (element.name == "face") {
        read_faces(element);
      } else if (element.name == kStrips) {
        read_strips(element);
      } else {
        skip(element);
      }
    }
    refuse_rest(header);
    if (soup_.faces.empty()) throw no_faces(path_);  // strips may be too short
    polygons_.triangulate(soup_);
    return std::move(soup_);
  }

  PointSoup read_points(const PlyHeader& header) {
    for (const PlyElement& element : header.elements) {
      if (element.name == "vertex") {
        read_vertices(element);
      } else {
        skip(element);
      }
    }
    refuse_rest(header);
    return {std::move(soup_.positions), std::move(soup_.colors), std::move(normals_)};
  }

 private:
  // Refuses data that the header does not declare, which would otherwise be lost silently, faces for example. Only
  // empty lines, and zeros as some programs pad binary files with, are allowed.
  void refuse_rest(const PlyHeader& header) const {
    const std::string_view rest = body_.rest();
    if (rest.find_first_not_of(std::string_view(" \t\r\n\0", 5)) == std::string_view::npos) return;
    constexpr std::size_t kMostNamed = 3;  // a header may declare any number of elements
    std::string declared;
    for (const PlyElement& element : std::span(header.elements).first(std::min(kMostNamed, header.elements.size()))) {
      declared += (declared.empty() ? "" : " and ") + std::to_string(element.count) + " of " + in_quotes(element.name);
    }
    if (header.elements.size() > kMostNamed) declared += " and more";
    throw InputError(path_ + ": " + std::to_string(rest.size()) +
                     " bytes follow after all records that its header declares, " + declared +
                     "; the header is wrong or the file damaged");
  }

  void read_vertices(const PlyElement& element) {
    const Three xyz = position_properties(element, path_);
    const std::optional<Three> rgb = color_properties(element), normal = normal_properties(element);
    soup_.positions.reserve(element.count);  // check_counts() made sure that the file holds them
    if (rgb) soup_.colors.reserve(element.count);
    std::vector<double> values(element.properties.size());
    for (std::uint64_t index = 0; index < element.count; ++index) {
      body_.begin_record(element, index);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = scalar(element.properties[i]);
      body_.end_record();
      soup_.positions.emplace_back(values[xyz[0]], values[xyz[1]], values[xyz[2]]);
      if (normal) normals_.emplace_back(values[(*normal)[0]], values[(*normal)[1]], values[(*normal)[2]]);
      if (!rgb) continue;
      glm::u8vec3& color = soup_.colors.emplace_back();
      for (int i = 0; i < 3; ++i) {
        const std::size_t property = (*rgb)[static_cast<std::size_t>(i)];
        color[i] = color_byte(element.properties[property], values[property]);
      }
    }
  }

  void read_faces(const PlyElement& element) {
    const std::size_t corners = corner_property(element, path_);
    const PlyProperty& list = element.properties[corners];
    const std::uint64_t triangle_bytes = byte_count(list.count_type) + 3 * byte_count(list.type);
    soup_.faces.reserve(std::min<std::uint64_t>(element.count, body_.left() / triangle_bytes));
    for (std::uint64_t index = 0; index < element.count; ++index) {
      body_.begin_record(element, index);
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        if (i == corners) {
          read_corners(list);
        } else {
          (void)scalar(element.properties[i]);
        }
      }
      body_.end_record();
    }
  }

  void read_corners(const PlyProperty& list) {
    const std::uint64_t count = item_count(list);
    if (count == 0) body_.record().fail("has no corners");
    body_.check_room(count, list.type);
    corners_.clear();
    for (std::uint64_t i = 0; i < count; ++i) corners_.push_back(vertex(body_.value(list.type), ""));
    polygons_.append(corners_, soup_.faces);
  }

  void read_strips(const PlyElement& element) {
    const std::size_t corners = corner_property(element, path_);
    for (std::uint64_t index = 0; index < element.count; ++index) {
      body_.begin_record(element, index);
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        if (i == corners) {
          read_strip_list(element.properties[i]);
        } else {
          (void)scalar(element.properties[i]);
        }
      }
      body_.end_record();
    }
  }

  // Each index makes a triangle with the two before it. Every second one is turned round, so that all have the same
  // outside; a triangle in which a vertex repeats only leads the strip on, and is left out.
  void read_strip_list(const PlyProperty& list) {
    const std::uint64_t count = item_count(list);
    body_.check_room(count, list.type);
    corners_.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      const double corner = body_.value(list.type);
      if (ends_strip(corner, list.type)) {
        corners_.clear();
        continue;
      }
      corners_.push_back(vertex(corner, " at index " + std::to_string(i)));
      const std::size_t size = corners_.size();
      if (size < 3) continue;
      glm::uvec3 face(corners_[size - 3], corners_[size - 2], corners_[size - 1]);
      if (face.x == face.y || face.y == face.z || face.z == face.x) continue;
      if (size % 2 == 0) std::swap(face.x, face.y);
      soup_.faces.push_back(face);
    }
  }

  // Types without sign hold the largest number for -1.
  static bool ends_strip(double corner, PlyType type) {
    return corner == -1 || (type == PlyType::Uint32 && corner == std::numeric_limits<std::uint32_t>::max());
  }

  [[nodiscard]] std::uint32_t vertex(double corner, const std::string& where) const {
    if (!(corner >= 0 && corner < static_cast<double>(vertex_count_)) || corner != std::trunc(corner)) {
      body_.record().fail("refers to vertex " + number_text(corner) + where + ", but there are " +
                          std::to_string(vertex_count_) + " vertices, counted from 0");
    }
    return static_cast<std::uint32_t>(corner);
  }

  void skip(const PlyElement& element) {
    if (element.properties.empty()) return;  // its records are nothing, however many
    for (std::uint64_t index = 0; index < element.count; ++index) {
      body_.begin_record(element, index);
      for (const PlyProperty& property : element.properties) (void)scalar(property);
      body_.end_record();
    }
  }

  // The value of a property; lists are skipped and count as 0.
  double scalar(const PlyProperty& property) {
    if (!property.is_list) return body_.value(property.type);
    body_.skip(item_count(property), property.type);
    return 0;
  }

  std::uint64_t item_count(const PlyProperty& list) {
    const double count = body_.value(list.count_type);
    if (!(count >= 0 && count <= std::numeric_limits<std::uint32_t>::max())) {
      body_.record().fail("has a list " + in_quotes(list.name) + " of " + number_text(count) + " items");
    }
    return static_cast<std::uint64_t>(count);
  }

  [[nodiscard]] std::uint8_t color_byte(const PlyProperty& property, double value) const {
    const double largest = largest_color(property.type);
    if (!(value >= 0 && value <= largest)) {
      body_.record().fail("has " + property.name + " " + number_text(value) + ", which is not in [0, " +
                          number_text(largest) + "]");
    }
    return static_cast<std::uint8_t>(value / largest * 255 + 0.5);
  }

  static std::string number_text(double number) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.10g", number);
    return text.data();
  }

  Body body_;
  const std::string& path_;
  std::uint64_t vertex_count_ = 0;
  std::vector<std::uint32_t> corners_;
  Polygons polygons_;
  TriangleSoup soup_;
  std::vector<glm::vec3> normals_;
};

const PlyElement* element_named(const PlyHeader& header, std::string_view name) {
  for (const PlyElement& element : header.elements) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

void check_has_vertices(const PlyHeader& header, const std::string& path) {
  const PlyElement* const vertex = element_named(header, "vertex");
  if (!vertex || vertex->count == 0) throw InputError(path + ": has no vertices");
  if (vertex->count > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(path + ": has " + std::to_string(vertex->count) + " vertices, more than 4294967295");
  }
}

void check_has_faces(const PlyHeader& header, const std::string& path) {
  const PlyElement *const face = element_named(header, "face"), *const strips = element_named(header, kStrips);
  if ((!face || face->count == 0) && (!strips || strips->count == 0)) throw no_faces(path);
}

// `read` is called with a reader of the body, whatever its encoding is.
template <typename Read>
auto read_body(const PlyHeader& header, std::string_view contents, const std::string& path, const Read& read) {
  check_counts(header, contents.size(), path);
  const std::string_view body = contents.substr(header.body);
  if (header.encoding == PlyEncoding::Ascii) {
    return read(SoupReader<AsciiBody>({body, header.line_feed, path}, path));
  }
  const std::endian endian = header.encoding == PlyEncoding::BinaryBigEndian ? std::endian::big : std::endian::little;
  return read(SoupReader<BinaryBody>({body, endian, path}, path));
}

}  // namespace

TriangleSoup parse_ply(std::string_view contents, const std::string& path) {
  const PlyHeader header = parse_ply_header(contents, path);
  check_has_vertices(header, path);
  check_has_faces(header, path);
  return read_body(header, contents, path, [&](auto reader) { return reader.read(header); });
}

PointSoup parse_ply_points(std::string_view contents, const std::string& path) {
  const PlyHeader header = parse_ply_header(contents, path);
  check_has_vertices(header, path);
  return read_body(header, contents, path, [&](auto reader) { return reader.read_points(header); });
}

}  // namespace lumatlas
