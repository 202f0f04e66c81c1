// SPDX-License-Identifier: GPL-3.0-or-later
// Greg Turk, "The PLY Polygon File Format", 1994; type names with sizes (int32, float64) as later writers use them.
#include "mesh/readers/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"

namespace lumatlas {

namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{{"char", PlyType::Int8},
                                                                       {"int8", PlyType::Int8},
                                                                       {"uchar", PlyType::Uint8},
                                                                       {"uint8", PlyType::Uint8},
                                                                       {"short", PlyType::Int16},
                                                                       {"int16", PlyType::Int16},
                                                                       {"ushort", PlyType::Uint16},
                                                                       {"uint16", PlyType::Uint16},
                                                                       {"int", PlyType::Int32},
                                                                       {"int32", PlyType::Int32},
                                                                       {"uint", PlyType::Uint32},
                                                                       {"uint32", PlyType::Uint32},
                                                                       {"float", PlyType::Float32},
                                                                       {"float32", PlyType::Float32},
                                                                       {"double", PlyType::Float64},
                                                                       {"float64", PlyType::Float64}}};

constexpr std::array<std::pair<std::string_view, PlyEncoding>, 3> kEncodings{
    {{"ascii", PlyEncoding::Ascii},
     {"binary_little_endian", PlyEncoding::BinaryLittleEndian},
     {"binary_big_endian", PlyEncoding::BinaryBigEndian}}};

// The value under `name`, or nothing.
template <typename Table>
auto look_up(const Table& table, std::string_view name) -> std::optional<decltype(table[0].second)> {
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& row) { return row.first == name; });
  return found == table.end() ? std::nullopt : std::optional(found->second);
}

class HeaderParser {
 public:
  HeaderParser(std::string_view contents, const std::string& path) : contents_(contents), path_(path) {}

  PlyHeader parse() {
    parse_first_line();
    while (parse_line()) {
    }
    if (!has_format_) fail("the line 'format ...' is missing");
    header_.body = contents_.size() - rest_.size();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(path_ + ": PLY header line " + std::to_string(line_number_) + ": " + reason);
  }

  void parse_first_line() {
    if (!contents_.starts_with("ply\n") && !contents_.starts_with("ply\r")) {
      throw InputError(path_ + ": not a PLY file, its first line is not 'ply'");
    }
    if (contents_[3] == '\r' && !contents_.starts_with("ply\r\n")) header_.line_feed = '\r';
    rest_ = contents_;
    (void)take_line(rest_, header_.line_feed);
  }

  // False after the last line.
  bool parse_line() {
    ++line_number_;
    if (rest_.empty()) fail("the file ends before 'end_header'; it is cut off");
    line_ = take_line(rest_, header_.line_feed);
    const std::string_view keyword = take_field(line_);
    if (keyword == "end_header") return false;
    if (keyword == "comment" || keyword == "obj_info" || keyword.empty()) return true;
    if (keyword == "format") {
      parse_format();
    } else if (keyword == "element") {
      parse_element();
    } else if (keyword == "property") {
      parse_property();
    } else {
      fail(in_quotes(keyword) + " is not a keyword of a PLY header");
    }
    return true;
  }

  void parse_format() {
    const std::string_view name = take_field(line_);
    const auto encoding = look_up(kEncodings, name);
    if (!encoding) fail("the format " + in_quotes(name) + " is not ascii, binary_little_endian or binary_big_endian");
    const std::string_view version = take_field(line_);
    if (version != "1.0") fail("the version " + in_quotes(version) + " is not 1.0");
    header_.encoding = *encoding;
    has_format_ = true;
  }

  void parse_element() {
    const std::string_view name = take_field(line_);
    const std::string_view count_field = take_field(line_);
    const auto count = parse_integer(count_field);
    if (name.empty() || !count || *count < 0) {
      fail("'element' needs a name and a count, not " + in_quotes(name) + " and " + in_quotes(count_field));
    }
    for (const PlyElement& element : header_.elements) {
      if (element.name == name) fail("the element " + in_quotes(name) + " was declared before");
    }
    header_.elements.push_back({std::string(name), static_cast<std::uint64_t>(*count), {}});
  }

  PlyType parse_type() {
    const std::string_view name = take_field(line_);
    const auto type = look_up(kTypes, name);
    if (!type) fail("the type " + in_quotes(name) + " is not one of PLY's");
    return *type;
  }

  void parse_property() {
    if (header_.elements.empty()) fail("a property comes before any element");
    PlyProperty property;
    std::string_view after_keyword = line_;
    if (take_field(after_keyword) == "list") {
      line_ = after_keyword;
      property.is_list = true;
      property.count_type = parse_type();
      if (property.count_type >= PlyType::Float32) fail("a list is counted in floating point");
    }
    property.type = parse_type();
    const std::string_view name = take_field(line_);
    if (name.empty()) fail("a property has no name");
    property.name = name;
    for (const PlyProperty& other : header_.elements.back().properties) {
      if (other.name == name) fail("the property " + in_quotes(name) + " was declared before");
    }
    header_.elements.back().properties.push_back(std::move(property));
  }

  std::string_view contents_;
  const std::string& path_;
  std::string_view rest_;  // the rest of the contents
  std::string_view line_;  // the rest of the line
  std::size_t line_number_ = 1;
  bool has_format_ = false;
  PlyHeader header_;
};

// With every list empty. A number in ASCII takes a digit and a separator.
std::uint64_t least_record_bytes(const PlyElement& element, PlyEncoding encoding) {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : element.properties) {
    const PlyType first = property.is_list ? property.count_type : property.type;
    bytes += encoding == PlyEncoding::Ascii ? 2 : byte_count(first);
  }
  return bytes;
}

}  // namespace

std::size_t byte_count(PlyType type) {
  constexpr std::array<std::size_t, 8> kBytes{1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

PlyHeader parse_ply_header(std::string_view contents, const std::string& path) {
  return HeaderParser(contents, path).parse();
}

void check_counts(const PlyHeader& header, std::size_t contents_bytes, const std::string& path) {
  const std::uint64_t body_bytes = contents_bytes - header.body;
  // The last number of an ASCII file needs no separator.
  const std::uint64_t holds_bytes = body_bytes + (header.encoding == PlyEncoding::Ascii ? 1 : 0);
  std::uint64_t needed = 0;
  for (const PlyElement& element : header.elements) {
    const std::uint64_t record = least_record_bytes(element, header.encoding);
    if (record > 0 && element.count > (holds_bytes - needed) / record) {
      throw InputError(path + ": its header claims " + std::to_string(element.count) + " records of " +
                       in_quotes(element.name) + ", too many for the " + std::to_string(body_bytes) +
                       " bytes that follow; the file is cut off or damaged");
    }
    needed += record * element.count;
  }
}

}  // namespace lumatlas
