// SPDX-License-Identifier: GPL-3.0-or-later
// COLMAP's text files. Blank lines and lines that begin with '#' are skipped, except that the line after an image's own
// is that of its 2D points, blank if there are none; scripts that leave blank lines out leave these out too:
//
//   cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS...
//   images.txt:  IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME
//                X Y POINT3D_ID  X Y POINT3D_ID  ...
//   points3D.txt: POINT3D_ID X Y Z R G B ERROR  IMAGE_ID POINT2D_INDEX  IMAGE_ID POINT2D_INDEX  ...
#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <utility>

#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/forms/colmap/colmap_records.h"

namespace lumatlas {
namespace {

using colmap::escaped_in_quotes;
using colmap::fail;
using colmap::FileLocation;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && is_blank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

class Lines {
 public:
  // Editors of Windows begin a file with a mark of its byte order.
  explicit Lines(std::string_view file) : rest_(file) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
  }

  // The next line, without blanks at its ends; false after the last.
  bool next(std::string_view& line) {
    if (rest_.empty()) {
      return false;
    }
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line = trimmed(rest_.substr(0, end));
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++number_;
    return true;
  }

  // The next line that is neither blank nor a comment.
  bool next_record(std::string_view& line) {
    while (next(line)) {
      if (!line.empty() && line.front() != '#') {
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] std::uint64_t number() const { return number_; }  // the last line's, from 1

 private:
  std::string_view rest_;
  std::uint64_t number_ = 0;
};

template <typename T>
bool parse(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

// The words of a line, one after the other.
class Fields {
 public:
  Fields(std::string_view line, const FileLocation& place) : rest_(line), place_(place) {}

  [[nodiscard]] const FileLocation& place() const { return place_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

  std::string_view word(const char* what) {
    const std::string_view text = text_of(what);
    const auto* const end = std::find_if(text.begin(), text.end(), is_blank);
    const auto length = static_cast<std::size_t>(end - text.begin());
    rest_ = trimmed(text.substr(length));
    return text.substr(0, length);
  }

  // All that is left: a name may hold blanks.
  std::string_view rest(const char* what) {
    const std::string_view text = text_of(what);
    rest_ = {};
    return text;
  }

  std::uint32_t id(const char* what) { return whole(what, 0, 4294967295, "[0, 4294967295]"); }

  std::uint32_t size(const char* what) { return whole(what, 1, 65536, "[1, 65536]"); }

  std::uint8_t color(const char* what) { return static_cast<std::uint8_t>(whole(what, 0, 255, "[0, 255]")); }

  double number(const char* what) {
    const std::string_view text = word(what);
    double value = 0;
    if (!parse(text, value)) {
      fail(place_, std::string(what) + " is " + escaped_in_quotes(text) + ", must be a number");
    }
    return value;
  }

 private:
  std::string_view text_of(const char* what) const {
    if (rest_.empty()) {
      fail(place_, std::string("ends before the ") + what);
    }
    return rest_;
  }

  std::uint32_t whole(const char* what, std::uint32_t least, std::uint32_t most, const char* range) {
    const std::string_view text = word(what);
    std::uint32_t value = 0;
    if (!parse(text, value) || value < least || value > most) {
      fail(place_, std::string(what) + " is " + escaped_in_quotes(text) + ", must be a whole number in " + range);
    }
    return value;
  }

  std::string_view rest_;
  const FileLocation& place_;
};

void read_parameters(Fields& fields, CameraModel& lens) {
  const std::size_t expected = parameter_count(lens.model);
  std::size_t given = 0;
  for (; !fields.at_end(); ++given) {
    const double value = fields.number("parameter");
    if (given < expected) {
      lens.parameters[given] = value;
    }
  }
  if (given != expected) {
    fail(fields.place(), "has " + std::to_string(given) + " parameters, but " + std::string(name(lens.model)) +
                             " takes " + std::to_string(expected) + " (" + std::string(parameter_names(lens.model)) +
                             ")");
  }
}

ColmapCamera read_camera(std::string_view line, const FileLocation& place, BadPhotographs bad) {
  Fields fields(line, place);
  ColmapCamera camera;
  camera.id = fields.id("camera id");
  const std::string_view model_name = fields.word("lens model");
  const std::optional<LensModel> model = lens_model(model_name);
  if (!model) {
    fail(place,
         "lens model is " + escaped_in_quotes(model_name) + ", must be one of COLMAP's, such as PINHOLE or OPENCV");
  }
  camera.lens.model = *model;
  camera.lens.width = fields.size("width");
  camera.lens.height = fields.size("height");
  read_parameters(fields, camera.lens);
  colmap::check_camera(camera, place, bad);
  return camera;
}

ColmapImage read_image(std::string_view line, const FileLocation& place, BadPhotographs bad) {
  Fields fields(line, place);
  const std::uint32_t id = fields.id("image id");
  std::array<double, 4> quaternion;
  for (double& component : quaternion) {
    component = fields.number("rotation quaternion");
  }
  std::array<double, 3> translation;
  for (double& component : translation) {
    component = fields.number("translation");
  }
  const std::uint32_t camera_id = fields.id("camera id");
  return colmap::checked_image(id, quaternion, translation, camera_id, fields.rest("name"), place, bad);
}

ColmapPoint read_point(std::string_view line, const FileLocation& place) {
  Fields fields(line, place);
  ColmapPoint point;
  (void)fields.word("point id");
  for (int axis = 0; axis < 3; ++axis) point.position[axis] = fields.number("position");
  for (int channel = 0; channel < 3; ++channel) point.color[channel] = fields.color("colour");
  (void)fields.number("error");
  while (!fields.at_end()) {
    point.images.push_back(fields.id("image id"));
    (void)fields.word("index of a 2D point");
  }
  colmap::check_point(point, place);
  return point;
}

constexpr std::array<bool, 256> characters_of_numbers() {
  std::array<bool, 256> table{};
  for (const char c : std::string_view("0123456789+-.eEnaifNAIF \t\r")) {
    table[static_cast<unsigned char>(c)] = true;
  }
  return table;
}

// Returns true if the line has only characters of numbers. The name of a photograph has others too, such as its ending.
bool holds_numbers(std::string_view line) {
  static constexpr std::array<bool, 256> kOfNumbers = characters_of_numbers();
  return std::all_of(line.begin(), line.end(), [](char c) { return kOfNumbers[static_cast<unsigned char>(c)]; });
}

void check_points(std::string_view line, const FileLocation& place) {
  if (line.starts_with('#')) return;
  std::size_t words = 0;
  bool in_word = false;
  for (const char c : line) {
    words += in_word || is_blank(c) ? 0 : 1;
    in_word = !is_blank(c);
  }
  if (words % 3 != 0) {
    fail(place, "holds " + std::to_string(words) +
                    " numbers, must hold X, Y and point id of each 2D point of the "
                    "image in the line before, or be blank");
  }
}

}  // namespace

std::vector<ColmapCamera> parse_cameras_text(std::string_view file, const std::filesystem::path& path,
                                             BadPhotographs bad) {
  Lines lines(file);
  std::vector<ColmapCamera> cameras;
  for (std::string_view line; lines.next_record(line);) {
    cameras.push_back(read_camera(line, {path, "line", lines.number()}, bad));
  }
  colmap::check_unique(cameras, path);
  return cameras;
}

std::vector<ColmapPoint> parse_points_text(std::string_view file, const std::filesystem::path& path) {
  Lines lines(file);
  std::vector<ColmapPoint> points;
  for (std::string_view line; lines.next_record(line);) {
    points.push_back(read_point(line, {path, "line", lines.number()}));
  }
  return points;
}

std::vector<ColmapImage> parse_images_text(std::string_view file, const std::filesystem::path& path,
                                           BadPhotographs bad) {
  Lines lines(file);
  std::vector<ColmapImage> images;
  std::string_view line;
  for (bool is_image = lines.next_record(line); is_image;) {
    images.push_back(read_image(line, {path, "line", lines.number()}, bad));
    if (!lines.next(line)) break;
    is_image = !line.empty() && line.front() != '#' && !holds_numbers(line);
    if (is_image) continue;
    check_points(line, {path, "line", lines.number()});
    is_image = lines.next_record(line);
  }
  colmap::check_unique(images, path, bad);
  return images;
}

}  // namespace lumatlas
