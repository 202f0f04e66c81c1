// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photogrammetry/reality_capture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/forms/fields/text_rows.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr double kFilmWidth = 36;  // millimetres
constexpr auto kReadColumns =
    std::to_array<std::string_view>({"name", "x", "y", "alt", "heading", "pitch", "roll", "f", "px", "py", "k1", "k2",
                                     "k3", "k4", "t1", "t2", "px_norm", "py_norm"});
constexpr auto kNeededColumns =
    std::to_array<std::string_view>({"name", "x", "y", "alt", "heading", "pitch", "roll", "f"});

// Names that other programs give to columns of this form.
struct OtherName {
  std::string_view name, usual;
};
constexpr std::array kOtherNames{OtherName{"z", "alt"}, OtherName{"yaw", "heading"}, OtherName{"f_35mm", "f"}};

std::string usual_name(std::string_view name) {
  const auto* const other =
      std::find_if(kOtherNames.begin(), kOtherNames.end(), [&](const OtherName& o) { return o.name == name; });
  return std::string(other == kOtherNames.end() ? name : other->usual);
}

// The line that says the columns. It usually begins with '#', as comments do, of which some may stand before it.
struct Header {
  std::size_t line = 0;  // from 1
  std::vector<std::string> names;
};

std::vector<std::string> column_names(std::string_view line) {
  line.remove_prefix(line.starts_with('#') ? 1 : 0);
  std::vector<std::string> names;
  for (const TextRow& row : rows_of(line, true)) {
    for (const std::string_view name : row.fields) names.push_back(usual_name(name));
  }
  return names;
}

bool has_needed_columns(const std::vector<std::string>& names) {
  return std::all_of(kNeededColumns.begin(), kNeededColumns.end(), [&](std::string_view needed) {
    return std::find(names.begin(), names.end(), needed) != names.end();
  });
}

std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

std::optional<Header> header_in(std::string_view text) {
  text = without_byte_order_mark(text);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    std::vector<std::string> names = column_names(line);
    if (has_needed_columns(names)) return Header{number, std::move(names)};
    const bool is_comment = line.starts_with('#') || line.find_first_not_of(" \t\r") == std::string_view::npos;
    if (!is_comment) return std::nullopt;
  }
  return std::nullopt;
}

class Columns {
 public:
  Columns(std::vector<std::string> names, const fs::path& path) : path_(path), names_(std::move(names)) {}

  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names_.begin());
  }
  [[nodiscard]] double number(const TextRow& row, std::string_view name) const {
    const std::optional<std::size_t> column = find(name);
    if (!column) throw InputError(path_.string() + ": has no column " + std::string(name));
    return number_in(row, *column, path_);
  }
  [[nodiscard]] double number_or_0(const TextRow& row, std::string_view name) const {
    return find(name) ? number(row, name) : 0;
  }
  [[nodiscard]] std::size_t count() const { return names_.size(); }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  const fs::path& path_;
  std::vector<std::string> names_;
};

glm::dmat3 turn(double degrees, const glm::dvec3& axis) {
  return glm::mat3_cast(glm::angleAxis(glm::radians(degrees), axis));
}

glm::dmat3 world_from_camera(const Columns& columns, const TextRow& row) {
  return turn(-columns.number(row, "heading"), {0, 0, 1}) * turn(columns.number(row, "pitch"), {1, 0, 0}) *
         turn(columns.number(row, "roll"), {0, 1, 0});
}

BrownLens lens_in(const Columns& columns, const TextRow& row, const ImageSize& size) {
  const double pixels = std::max(size.width, size.height) / kFilmWidth;  // per millimetre
  BrownLens lens{size.width, size.height};
  lens.fx = lens.fy = columns.number(row, "f") * pixels;
  lens.cx = 0.5 * size.width + columns.number_or_0(row, "px") * pixels;
  lens.cy = 0.5 * size.height + columns.number_or_0(row, "py") * pixels;
  lens.k1 = columns.number_or_0(row, "k1");
  lens.k2 = columns.number_or_0(row, "k2");
  lens.k3 = columns.number_or_0(row, "k3");
  lens.k4 = columns.number_or_0(row, "k4");
  lens.p1 = columns.number_or_0(row, "t1");
  lens.p2 = columns.number_or_0(row, "t2");
  return lens;
}

std::string unread_columns(const Columns& columns) {
  std::string list;
  for (const std::string& name : columns.names()) {
    if (std::find(kReadColumns.begin(), kReadColumns.end(), name) != kReadColumns.end()) continue;
    list += (list.empty() ? "" : ", ") + in_quotes(name);
  }
  return list;
}

// Returns true if x and y are degrees of longitude and latitude: the distances between cameras are then less than a
// thousandth of their distance from (0, 0). In metres, all cameras would be in one place.
bool are_degrees(const std::vector<glm::dvec3>& centers) {
  constexpr double kFewKilometres = 0.05, kFarther = 1000, kMostDegrees = 180;
  if (centers.size() < 2) return false;
  glm::dvec3 least = centers.front(), most = centers.front();
  for (const glm::dvec3& center : centers) {
    least = glm::min(least, center);
    most = glm::max(most, center);
  }
  const double wide = std::max(most.x - least.x, most.y - least.y);
  const double far = std::max(std::abs(least.x), std::abs(least.y));
  const bool on_earth = far <= kMostDegrees && std::max(std::abs(most.x), std::abs(most.y)) <= kMostDegrees;
  return on_earth && wide > 0 && wide < kFewKilometres && far > kFarther * wide;
}

// Refuses a principal point in px_norm and py_norm, whose unit is not known, unless it is the middle.
void check_middle(const Columns& columns, const TextRow& row, const fs::path& path) {
  for (const char* const name : {"px_norm", "py_norm"}) {
    const double value = columns.number_or_0(row, name);
    if (value == 0) continue;
    refuse_row(path, row,
               std::string(name) + " is " + number_text(value) +
                   ", in a unit that is not known: export px "
                   "and py in millimetres");
  }
}

PosedPhotograph photograph_in(const Columns& columns, const TextRow& row, const fs::path& path,
                              const PhotographLookup& photographs) {
  try {
    PosedPhotograph photograph = photographs.find(row.fields[columns.find("name").value()]);
    const glm::dvec3 center(columns.number(row, "x"), columns.number(row, "y"), columns.number(row, "alt"));
    const std::string broken =
        set_pose(photograph, world_from_camera(columns, row), center, CameraAxes::right_up_backward);
    if (!broken.empty()) refuse_row(path, row, broken);
    check_middle(columns, row, path);
    photograph.lens = lens_of(lens_in(columns, row, photographs.size_of(photograph)));
    return photograph;
  } catch (const std::invalid_argument& error) {
    refuse_row(path, row, std::string("an impossible camera: ") + error.what());
  }
}

}  // namespace

Capture parse_reality_capture(std::string_view text, const fs::path& path, const PhotographLookup& photographs) {
  std::optional<Header> header = header_in(text);
  if (!header) {
    throw InputError(path.string() +
                     ": has no line with the columns name, x, y, alt, heading, pitch, roll and f before its values");
  }
  const std::size_t header_line = header->line;
  const Columns columns(std::move(header->names), path);
  Capture posed;
  std::vector<glm::dvec3> centers;
  for (const TextRow& row : rows_of(without_byte_order_mark(text), true)) {
    if (row.line <= header_line) continue;
    if (row.fields.size() != columns.count()) {
      refuse_row(path, row,
                 "has " + std::to_string(row.fields.size()) + " values, but line " + std::to_string(header_line) +
                     " names " + std::to_string(columns.count()) + " columns");
    }
    const std::string name(row.fields[columns.find("name").value()]);
    add_photograph(posed, photographs.bad, name, [&] { return photograph_in(columns, row, path, photographs); });
    if (!posed.photographs.back().bad.empty()) continue;
    centers.emplace_back(columns.number(row, "x"), columns.number(row, "y"), columns.number(row, "alt"));
  }
  finish(posed, path, photographs.bad);
  if (are_degrees(centers)) {
    throw InputError(path.string() +
                     ": x and y look like degrees of longitude and latitude beside heights in metres: export cameras "
                     "and mesh in one coordinate system in metres, such as the project's own");
  }
  if (const std::string unread = unread_columns(columns); !unread.empty()) {
    posed.notes.push_back(path.filename().string() + " has columns that are not known and not used: " + unread);
  }
  posed.notes.emplace_back(
      "px and py are taken to be in millimetres on 36 mm of film, as f is, and x, y and alt to be the mesh's "
      "coordinates");
  return posed;
}

std::optional<fs::path> find_reality_capture(const fs::path& scene) {
  for (const fs::path& file : files_ending_in(scene, ".csv")) {
    if (header_in(first_bytes(file))) return file;
  }
  return std::nullopt;
}

Capture read_reality_capture(const CaptureRequest& request) {
  const fs::path path = find_reality_capture(request.scene).value();
  return parse_reality_capture(read_whole_file(path), path, photographs_of(request));
}

}  // namespace lumatlas
