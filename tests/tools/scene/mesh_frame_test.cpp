// SPDX-License-Identifier: GPL-3.0-or-later
// Frames of mesh files: their text, what they do to a mesh, and how finely a file can say where a vertex is.
#include "tools/scene/mesh/mesh_frame.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tools/scene/mesh/mesh_coordinate_step.h"

namespace lumatlas {
namespace {

// The corner of a box whose three faces look outwards, away from (1, 1, 1).
TriangleSoup box_corner() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}}, {}, {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}}};
}

glm::dvec3 face_normal(const TriangleSoup& soup, std::size_t face) {
  const glm::uvec3& f = soup.faces[face];
  return glm::cross(soup.positions[f.y] - soup.positions[f.x], soup.positions[f.z] - soup.positions[f.x]);
}

TEST_CASE("axes are read as people and the diagnosis write them, and printed shortly") {
  const glm::dmat3 z_up = parse_mesh_axes("x,-z,y");
  CHECK(z_up * glm::dvec3(1, 2, 3) == glm::dvec3(1, -3, 2));
  for (const char* const other : {"(x, -z, y)", " X, -Z , +Y ", "x,-z,y"}) CHECK(parse_mesh_axes(other) == z_up);
  CHECK(parse_mesh_axes("x,y,z") == glm::dmat3(1.0));
  for (const std::string text : {"x,y,z", "x,-z,y", "-y,-x,-z", "z,x,y"}) {
    CHECK(mesh_axes_text(parse_mesh_axes(text)) == text);
  }
}

TEST_CASE("axes that are none are refused, and the sentence says why") {
  const std::string advice = ": give the poses' x, y and z in terms of the mesh's, such as x,-z,y";
  CHECK_THROWS_WITH(parse_mesh_axes("x,y"), "x,y does not name three axes" + advice);
  CHECK_THROWS_WITH(parse_mesh_axes("xyz"), "xyz does not name three axes" + advice);
  CHECK_THROWS_WITH(parse_mesh_axes("x,y,x"), "x,y,x names x twice" + advice);
  CHECK_THROWS_WITH(parse_mesh_axes("x,-y,-y"), "x,-y,-y names y twice" + advice);
  for (const std::string text : {"x,y,w", "x,y,", "x,y,--z", "x,y,+-z", "1,0,0", "x,y,2z"}) {
    CHECK_THROWS_WITH(parse_mesh_axes(text), text + " names an axis that is not x, y or z" + advice);
  }
}

TEST_CASE("shifts are three numbers in double precision") {
  CHECK(parse_mesh_shift("-500000.001,-4500000.25,1e2") == glm::dvec3(-500000.001, -4500000.25, 100));
  CHECK(parse_mesh_shift("(1, +2, -3)") == glm::dvec3(1, 2, -3));
  const std::string advice = ": give what is added to x, y and z, such as -500000,-4500000,0";
  for (const std::string text : {"1,2", "1,2,3,4", "1,2,x", "", "1,2,3m", "1;2;3", "1,2,++3"}) {
    CHECK_THROWS_WITH(parse_mesh_shift(text), text + " is not three numbers" + advice);
  }
  for (const std::string text : {"nan,0,0", "0,inf,0", "0,0,-2e12"}) {
    CHECK_THROWS_WITH(parse_mesh_shift(text), text + " is not within 1e12 of 0" + advice);
  }
}

TEST_CASE("a frame scales, exchanges axes and then shifts, to the last digit of a map's coordinates") {
  TriangleSoup soup{{{362000125, 40500, -5762000250}}, {}, {}};
  move_to_frame_of_poses(soup, {parse_mesh_axes("x,-z,y"), 0.001, {-362000, -5762000, -40}});
  CHECK(glm::distance(soup.positions[0], glm::dvec3(0.125, 0.25, 0.5)) < 1e-8);
}

TEST_CASE("faces look outwards as before, whatever the axes") {
  for (const char* const axes : {"x,y,z", "-x,y,z", "x,z,y", "x,-z,y", "-x,-y,-z"}) {
    CAPTURE(axes);
    TriangleSoup soup = box_corner();
    const MeshFrame frame{parse_mesh_axes(axes), 2, {5, 6, 7}};
    move_to_frame_of_poses(soup, frame);
    const glm::dvec3 inside = frame.scale * (frame.axes * glm::dvec3(1)) + frame.shift;
    for (std::size_t face = 0; face < soup.faces.size(); ++face) {
      CHECK(glm::dot(face_normal(soup, face), inside - soup.positions[soup.faces[face].x]) < 0);
    }
  }
}

TEST_CASE("two frames one after the other are their combination") {
  const MeshFrame first{parse_mesh_axes("y,-z,x"), 0.5, {1, 2, 3}}, second{parse_mesh_axes("x,z,-y"), 8, {-4, 0, 9}};
  TriangleSoup one_by_one = box_corner(), at_once = box_corner();
  move_to_frame_of_poses(one_by_one, first);
  move_to_frame_of_poses(one_by_one, second);
  move_to_frame_of_poses(at_once, combined(first, second));
  CHECK(one_by_one.positions == at_once.positions);  // all numbers are sums of powers of two
}

TEST_CASE("a frame is printed as the options that give it") {
  CHECK(mesh_frame_options({}) == "--mesh-scale 1");
  CHECK(mesh_frame_options({.scale = 0.001}) == "--mesh-scale 0.001");
  CHECK(mesh_frame_options({parse_mesh_axes("x,-z,y"), 0.001, {-500000, -4500000.25, 0}}) ==
        "--mesh-scale 0.001 --mesh-axes x,-z,y --mesh-shift -500000,-4500000.25,0");
  const nlohmann::json json = mesh_frame_json({parse_mesh_axes("-x,y,z"), 2, {1, 2, 3}});
  CHECK(json == nlohmann::json::parse(R"({"mesh_scale": 2.0, "mesh_axes": "-x,y,z", "mesh_shift": [1.0, 2.0, 3.0]})"));
}

TEST_CASE("frames that cannot be are refused by name") {
  CHECK_NOTHROW(check(MeshFrame{}));
  CHECK_THROWS_WITH(check(MeshFrame{.scale = 0}), "mesh frame: scale is 0, must be finite and above 0");
  CHECK_THROWS_WITH(check(MeshFrame{.axes = glm::dmat3(2.0)}), Catch::Contains("axes must have one 1 or -1"));
  CHECK_THROWS_WITH(check(MeshFrame{.axes = glm::dmat3(0.0)}), Catch::Contains("axes must have one 1 or -1"));
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(check(MeshFrame{.shift = {0, no_number, 0}}), "mesh frame: shift is nan, must be within 1e12 of 0");
}

// Points that use all digits of their numbers, and what a file of fewer digits makes of them.
template <typename Round>
TriangleSoup rounded_soup(double far, Round round) {
  TriangleSoup soup;
  for (int i = 0; i < 300; ++i) {
    const auto coordinate = [&](double wave, double offset) { return round(offset + 10 * std::sin(wave * (i + 1))); };
    soup.positions.emplace_back(coordinate(1.1, far), coordinate(1.7, 9 * far), coordinate(2.3, 40));
  }
  return soup;
}

TEST_CASE("coarse numbers of a mesh file are found by their digits") {
  const auto exact = [](double c) { return c; };
  const auto as_float = [](double c) { return double{static_cast<float>(c)}; };
  const auto six_digits = [](double c) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.6g", c);
    return std::stod(text);
  };
  CHECK(mesh_coordinate_step(rounded_soup(5e5, exact)) == 0);
  CHECK(mesh_coordinate_step(rounded_soup(5e5, as_float)) == 0.5);
  CHECK(mesh_coordinate_step(rounded_soup(0, as_float)) == Approx(3.8e-6).epsilon(0.01));
  CHECK(mesh_coordinate_step(rounded_soup(5e5, six_digits)) == 10);
  CHECK(mesh_coordinate_step({}) == 0);
}

}  // namespace
}  // namespace lumatlas
