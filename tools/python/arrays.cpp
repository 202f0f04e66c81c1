// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/python/arrays.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "mesh/base/number_text.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

// "an array of float32, (4, 3)".
std::string text_of_array(const py::array& array) {
  std::string text = "an array of " + py::str(array.dtype()).cast<std::string>() + ", (";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i == 0 ? "" : ", ") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

std::string text_of_value(const py::handle& given) {
  if (py::isinstance<py::array>(given)) return text_of_array(py::reinterpret_borrow<py::array>(given));
  return "a value of type " + py::type::of(given).attr("__name__").cast<std::string>();
}

[[noreturn]] void refuse(const std::string& argument, const py::handle& given, const std::string& wanted) {
  throw std::invalid_argument(argument + ": is " + text_of_value(given) + ", must be " + wanted);
}

// The array of a NumPy array, or of what NumPy makes one of.
py::array array_from(const std::string& argument, const py::handle& given, const std::string& wanted) {
  py::array array = py::array::ensure(given);
  if (!array) {
    PyErr_Clear();
    refuse(argument, given, wanted);
  }
  return array;
}

std::string size_text(const Camera& camera) {
  return "(" + std::to_string(camera.height) + ", " + std::to_string(camera.width);
}

bool has_size_of(const py::array& array, const Camera& camera) {
  return array.ndim() >= 2 && array.shape(0) == py::ssize_t{camera.height} &&
         array.shape(1) == py::ssize_t{camera.width};
}

// A photograph that repeats one pixel takes no memory in Python and gigabytes here.
void check_pixels(const std::string& argument, const Camera& camera) {
  constexpr std::uint64_t kMostPhotographPixels = std::uint64_t{1} << 30;  // 3.2 GB of colours
  const std::uint64_t pixels = std::uint64_t{camera.width} * camera.height;
  if (pixels <= kMostPhotographPixels) return;
  throw std::invalid_argument(argument + ": its camera has " + std::to_string(pixels) + " pixels, must have at most " +
                              std::to_string(kMostPhotographPixels));
}

bool is_rows_of_three(const py::array& array) {
  return array.ndim() == 2 && array.shape(1) == 3;
}

}  // namespace

Photograph photograph_of(const std::string& argument, const py::handle& given, const Camera& camera) {
  const std::string wanted = "an array of uint8, " + size_text(camera) + ", 3), as its camera";
  const py::array array = array_from(argument, given, wanted);
  if (array.ndim() != 3 || array.shape(2) != 3 || !has_size_of(array, camera) ||
      !array.dtype().equal(py::dtype::of<std::uint8_t>())) {
    refuse(argument, array, wanted);
  }
  check_pixels(argument, camera);
  const py::array_t<std::uint8_t, py::array::c_style> pixels(array);
  return {camera.width, camera.height, {pixels.data(), pixels.data() + pixels.size()}, {}};
}

Photograph mask_picture(const std::string& argument, const py::handle& given, const Camera& camera) {
  const std::string wanted = "an array of bool or uint8, " + size_text(camera) + "), as its camera";
  const py::array array = array_from(argument, given, wanted);
  const bool known = array.dtype().equal(py::dtype::of<std::uint8_t>()) || array.dtype().equal(py::dtype::of<bool>());
  if (array.ndim() != 2 || !has_size_of(array, camera) || !known) refuse(argument, array, wanted);
  const py::array_t<bool, py::array::c_style | py::array::forcecast> used(array);
  Photograph picture{camera.width, camera.height, {}, {}};
  picture.rgb.reserve(3 * static_cast<std::size_t>(used.size()));
  for (py::ssize_t i = 0; i < used.size(); ++i) picture.rgb.insert(picture.rgb.end(), 3, used.data()[i] ? 255 : 0);
  return picture;
}

std::vector<glm::dvec3> points_of(const std::string& argument, const py::handle& given) {
  const std::string wanted = "an array of numbers, (n, 3)";
  const py::array array = array_from(argument, given, wanted);
  const char kind = array.dtype().kind();
  if (!is_rows_of_three(array) || (kind != 'f' && kind != 'i' && kind != 'u')) refuse(argument, array, wanted);
  if (array.shape(0) == 0) throw std::invalid_argument(argument + ": is empty, must hold at least one point");
  const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(array);
  const auto at = numbers.unchecked<2>();
  std::vector<glm::dvec3> points;
  points.reserve(static_cast<std::size_t>(at.shape(0)));
  for (py::ssize_t row = 0; row < at.shape(0); ++row) {
    for (py::ssize_t column = 0; column < 3; ++column) {
      if (std::isfinite(at(row, column))) continue;
      throw std::invalid_argument(argument + "[" + std::to_string(row) + ", " + std::to_string(column) + "]: is " +
                                  py::str(py::float_(at(row, column))).cast<std::string>() + ", must be finite");
    }
    points.emplace_back(at(row, 0), at(row, 1), at(row, 2));
  }
  return points;
}

std::vector<glm::uvec3> triangles_of(const std::string& argument, const py::handle& given, std::size_t vertices) {
  const std::string wanted = "an array of whole numbers, (n, 3)";
  const py::array array = array_from(argument, given, wanted);
  const char kind = array.dtype().kind();
  if (!is_rows_of_three(array) || (kind != 'i' && kind != 'u')) refuse(argument, array, wanted);
  if (array.shape(0) == 0) throw std::invalid_argument(argument + ": is empty, must hold at least one face");
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> numbers(array);
  const auto at = numbers.unchecked<2>();
  const auto end = static_cast<std::int64_t>(std::min<std::size_t>(vertices, std::numeric_limits<std::int32_t>::max()));
  std::vector<glm::uvec3> faces;
  faces.reserve(static_cast<std::size_t>(at.shape(0)));
  for (py::ssize_t row = 0; row < at.shape(0); ++row) {
    for (py::ssize_t column = 0; column < 3; ++column) {
      if (at(row, column) >= 0 && at(row, column) < end) continue;
      throw std::invalid_argument(argument + "[" + std::to_string(row) + ", " + std::to_string(column) + "]: is " +
                                  std::to_string(at(row, column)) + ", must be 0 to " + std::to_string(end - 1) +
                                  ", a row of vertices");
    }
    faces.emplace_back(at(row, 0), at(row, 1), at(row, 2));
  }
  return faces;
}

void check_name(const std::string& argument, const std::string& name) {
  const auto refuse_name = [&](const std::string& why) {
    throw std::invalid_argument(argument + ": the name '" + name + "' " + why);
  };
  if (name.empty()) refuse_name("is empty, a photograph needs one");
  if (name.find('\0') != std::string::npos) refuse_name("holds a zero byte, which no file's name can");
  if (name.front() == '/' || name.back() == '/') refuse_name("begins or ends with '/', name a file in a folder");
  for (const std::filesystem::path& part : std::filesystem::path(name)) {
    if (part == "." || part == "..") refuse_name("leads out of its folder, leave out '.' and '..'");
    if (part.native().size() > 240) refuse_name("has a part of more than 240 bytes, which no file's name can");
  }
}

}  // namespace lumatlas::python
