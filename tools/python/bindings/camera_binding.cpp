// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <glm/vec3.hpp>
#include <sstream>
#include <stdexcept>

#include "tools/picture/paths/camera_path.h"
#include "tools/python/bindings/bindings.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Matrix = py::array_t<double, py::array::c_style | py::array::forcecast>;

Matrix matrix_of(const Camera& camera) {
  Matrix result({4, 4});
  auto at = result.mutable_unchecked<2>();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) at(row, column) = camera.cam_from_world_rotation[column][row];
    at(row, 3) = camera.cam_from_world_translation[row];
    at(3, row) = 0;
  }
  at(3, 3) = 1;
  return result;
}

void place(Camera& camera, const Matrix& matrix) {
  if (matrix.ndim() != 2 || matrix.shape(0) < 3 || matrix.shape(0) > 4 || matrix.shape(1) != 4) {
    throw std::invalid_argument("camera: cam_from_world must be an array of 4 x 4 or 3 x 4 numbers");
  }
  const auto at = matrix.unchecked<2>();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) camera.cam_from_world_rotation[column][row] = at(row, column);
    camera.cam_from_world_translation[row] = at(row, 3);
  }
}

Camera make_camera(std::uint32_t width, std::uint32_t height, double fx, std::optional<double> fy,
                   std::optional<double> cx, std::optional<double> cy, const std::optional<Matrix>& cam_from_world) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = fx;
  camera.fy = fy.value_or(fx);
  camera.cx = cx.value_or(width / 2.0);
  camera.cy = cy.value_or(height / 2.0);
  if (cam_from_world) place(camera, *cam_from_world);
  check(camera);
  return camera;
}

using Triple = std::array<double, 3>;

glm::dvec3 vector_of(const Triple& triple) {
  return {triple[0], triple[1], triple[2]};
}

Camera camera_looking_at(const Triple& position, const Triple& target, const Triple& up, std::uint32_t width,
                         std::uint32_t height, double fov_deg) {
  const glm::dvec3 place = vector_of(position);
  return camera_at({place, look_at(place, vector_of(target), vector_of(up)), fov_deg}, width, height);
}

Triple center_of(const Camera& camera) {
  const glm::dvec3 center = camera.center();
  return {center.x, center.y, center.z};
}

std::string text_of(const Camera& camera) {
  std::ostringstream text;
  text << "<lumatlas.Camera " << camera.width << "x" << camera.height << ", focal length " << camera.fx << " pixels>";
  return text.str();
}

}  // namespace

Camera in_scene(Camera camera, const glm::dvec3& offset) {
  camera.cam_from_world_translation -= camera.cam_from_world_rotation * offset;
  return camera;
}

Camera in_model(Camera camera, const glm::dvec3& offset) {
  camera.cam_from_world_translation += camera.cam_from_world_rotation * offset;
  return camera;
}

void bind_camera(py::module_& module) {
  py::class_<Camera>(module, "Camera",
                     "A pinhole camera: x right, y down, z forward; the top left corner of the picture is (0, 0)")
      .def(py::init(&make_camera), py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy") = py::none(),
           py::arg("cx") = py::none(), py::arg("cy") = py::none(), py::arg("cam_from_world") = py::none(),
           "Sizes and focal lengths in pixels; a principal point that is not given is the middle")
      .def_static("looking_at", &camera_looking_at, py::arg("position"), py::arg("target"), py::arg("up"),
                  py::arg("width"), py::arg("height"), py::arg("fov_deg") = 70.0,
                  "A camera at a position that looks at a target; the field of view is horizontal")
      .def("scaled_to", &Camera::scaled_to, py::arg("width"), py::arg("height"), "The same view at another resolution")
      .def_readonly("width", &Camera::width)
      .def_readonly("height", &Camera::height)
      .def_readonly("fx", &Camera::fx)
      .def_readonly("fy", &Camera::fy)
      .def_readonly("cx", &Camera::cx)
      .def_readonly("cy", &Camera::cy)
      .def_property_readonly("center", &center_of, "Where the camera stands, in the scene's coordinates")
      .def_property_readonly("cam_from_world", &matrix_of, "4 x 4, from the scene's coordinates")
      .def("__repr__", &text_of);
}

}  // namespace lumatlas::python
