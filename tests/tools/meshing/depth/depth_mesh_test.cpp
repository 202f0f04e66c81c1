// SPDX-License-Identifier: GPL-3.0-or-later
// Depth images of a room whose surface is known, in each form that holds them, and the mesh that is made of them.
#include "tools/meshing/depth/depth_mesh.h"

#include <OpenImageIO/imageio.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/camera/camera.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/meshing/length_text.h"
#include "tools/meshing/scene_mesh.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;
using glm::dvec3;
using test::write_file;

// A hollow box with a ball in its middle.
const dvec3 kHalfBox(2, 1.8, 1.4);
constexpr double kBall = 0.5;

// > 0 in the free space.
double distance_to_surface(const dvec3& p) {
  const dvec3 wall = kHalfBox - glm::abs(p);
  return std::min({glm::length(p) - kBall, wall.x, wall.y, wall.z});
}

dvec3 towards_free_space(const dvec3& p) {
  constexpr double kStep = 1e-5;
  dvec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    dvec3 step(0.0);
    step[axis] = kStep;
    gradient[axis] = distance_to_surface(p + step) - distance_to_surface(p - step);
  }
  return gradient;
}

// How far along the ray, in its lengths, the first surface is.
double first_hit(const dvec3& from, const dvec3& ray) {
  double nearest = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    const double wall = ray[axis] > 0 ? kHalfBox[axis] : -kHalfBox[axis];
    if (ray[axis] != 0) nearest = std::min(nearest, (wall - from[axis]) / ray[axis]);
  }
  const double a = glm::dot(ray, ray), half = glm::dot(from, ray);
  const double root = half * half - a * (glm::dot(from, from) - kBall * kBall);
  if (root > 0 && -half - std::sqrt(root) > 0) nearest = std::min(nearest, (-half - std::sqrt(root)) / a);
  return nearest;
}

struct Lens {
  std::uint32_t width, height;
  double fx, fy, cx, cy;  // (0, 0) is the corner
};
constexpr Lens kPhotograph{112, 84, 56, 57, 55, 43};
constexpr Lens kSmaller{56, 42, 28, 28.5, 27.5, 21.5};  // the same view
constexpr Lens kOther{80, 60, 42, 42, 41, 29};          // another one

struct Pose {
  dvec3 center;
  glm::dmat3 world_from_cam;  // columns: right, down, forward
};

std::vector<Pose> poses() {
  std::vector<Pose> result;
  for (int i = 0; i < 20; ++i) {
    const double angle = 0.7 * i, pitch = 0.5 * std::sin(1.3 * i);
    const dvec3 center(1.15 * std::cos(angle), 1.05 * std::sin(angle), 0.6 * std::cos(2.1 * i));
    const double heading = angle + (i % 2 == 0 ? 3.1415926 : 0.4);
    const dvec3 forward =
        i % 2 == 0 ? -glm::normalize(center)
                   : dvec3(std::cos(heading) * std::cos(pitch), std::sin(heading) * std::cos(pitch), std::sin(pitch));
    const dvec3 right = glm::normalize(glm::cross(forward, dvec3(0, 0, 1)));
    result.push_back({center, glm::dmat3(right, glm::cross(forward, right), forward)});
  }
  return result;
}

std::vector<std::uint16_t> depths(const Pose& pose, const Lens& lens, double unit) {
  std::vector<std::uint16_t> values;
  for (std::uint32_t y = 0; y < lens.height; ++y) {
    for (std::uint32_t x = 0; x < lens.width; ++x) {
      const dvec3 ray = pose.world_from_cam * dvec3((x + 0.5 - lens.cx) / lens.fx, (y + 0.5 - lens.cy) / lens.fy, 1);
      values.push_back(static_cast<std::uint16_t>(std::lround(first_hit(pose.center, ray) / unit)));
    }
  }
  for (std::uint32_t x = 0; x < lens.width; ++x) values[x] = 0;  // a row that was not measured
  return values;
}

template <typename Value>
void write_grey(const fs::path& path, std::uint32_t width, std::uint32_t height, const std::vector<Value>& values) {
  fs::create_directories(path.parent_path());
  const auto output = OIIO::ImageOutput::create(path.string());
  REQUIRE(output);
  const OIIO::TypeDesc type = sizeof(Value) == 2 ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8;
  REQUIRE(output->open(path.string(), OIIO::ImageSpec(static_cast<int>(width), static_cast<int>(height), 1, type)));
  REQUIRE(output->write_image(type, values.data()));
  REQUIRE(output->close());
}

void write_depth(const fs::path& path, const Pose& pose, const Lens& lens, double unit) {
  write_grey(path, lens.width, lens.height, depths(pose, lens, unit));
}

void write_photograph(const fs::path& path) {
  fs::create_directories(path.parent_path());
  const std::size_t bytes = std::size_t{3} * kPhotograph.width * kPhotograph.height;
  write_image(path, Photograph{kPhotograph.width, kPhotograph.height, std::vector<std::uint8_t>(bytes, 90), {}});
}

std::string text(double value) {
  std::ostringstream out;
  out << std::setprecision(17) << value;
  return out.str();
}

std::string name_of(std::size_t i) {
  return std::to_string(100 + i);
}

// World from camera by rows, of a camera whose second and third axes are turned for OpenGL's.
std::array<std::array<double, 4>, 3> rows(const Pose& pose, bool opengl) {
  std::array<std::array<double, 4>, 3> result{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      result[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          (opengl && column > 0 ? -1 : 1) * pose.world_from_cam[column][row];
    }
    result[static_cast<std::size_t>(row)][3] = pose.center[row];
  }
  return result;
}

std::string intrinsic(const Lens& lens) {  // the middle of the first pixel is at (0, 0)
  return text(lens.fx) + " 0 " + text(lens.cx - 0.5) + " 0\n0 " + text(lens.fy) + " " + text(lens.cy - 0.5) +
         " 0\n0 0 1 0\n0 0 0 1\n";
}

void write_tum(const fs::path& scene) {
  std::string rgb, depth, trajectory;
  for (std::size_t i = 0; i < poses().size(); ++i) {
    const Pose pose = poses()[i];
    const double time = 100 + static_cast<double>(i);
    const glm::dquat q = glm::quat_cast(pose.world_from_cam);
    write_photograph(scene / "rgb" / (name_of(i) + ".png"));
    write_depth(scene / "depth" / (name_of(i) + ".png"), pose, kPhotograph, 1.0 / 5000);
    rgb += text(time - 0.004) + " rgb/" + name_of(i) + ".png\n";
    depth += text(time + 0.008) + " depth/" + name_of(i) + ".png\n";
    trajectory += text(time);
    for (const double v : {pose.center.x, pose.center.y, pose.center.z, q.x, q.y, q.z, q.w}) {
      trajectory += ' ';
      trajectory += text(v);
    }
    trajectory += "\n";
  }
  depth += "9 depth/none.png\n";
  write_file(scene / "rgb.txt", rgb);
  write_file(scene / "depth.txt", depth);
  write_file(scene / "groundtruth.txt", trajectory);
  write_file(scene / "camera.txt", text(kPhotograph.fx) + " " + text(kPhotograph.fy) + " " +
                                       text(kPhotograph.cx - 0.5) + " " + text(kPhotograph.cy - 0.5));
}

void write_scannet(const fs::path& scene) {
  for (std::size_t i = 0; i < poses().size(); ++i) {
    write_photograph(scene / "color" / (name_of(i) + ".png"));
    write_depth(scene / "depth" / (name_of(i) + ".png"), poses()[i], kOther, 0.001);
    std::string pose;
    for (const auto& row : rows(poses()[i], false)) {
      for (const double value : row) pose += text(value) + " ";
    }
    write_file(scene / "pose" / (name_of(i) + ".txt"), pose + "0 0 0 1");
  }
  write_file(scene / "intrinsic/intrinsic_color.txt", intrinsic(kPhotograph));
  write_file(scene / "intrinsic/intrinsic_depth.txt", intrinsic(kOther));
}

void write_polycam(const fs::path& scene) {
  for (std::size_t i = 0; i < poses().size(); ++i) {
    write_photograph(scene / "keyframes/images" / (name_of(i) + ".jpg"));
    write_depth(scene / "keyframes/depth" / (name_of(i) + ".png"), poses()[i], kSmaller, 0.001);
    std::string json = "{\"fx\": " + text(kPhotograph.fx) + ", \"fy\": " + text(kPhotograph.fy) +
                       ", \"cx\": " + text(kPhotograph.cx) + ", \"cy\": " + text(kPhotograph.cy) +
                       ", \"width\": " + std::to_string(kPhotograph.width) +
                       ", \"height\": " + std::to_string(kPhotograph.height);
    const auto matrix = rows(poses()[i], true);
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 4; ++column) {
        json += ", \"t_" + std::to_string(row) + std::to_string(column) + "\": " + text(matrix[row][column]);
      }
    }
    write_file(scene / "keyframes/cameras" / (name_of(i) + ".json"), json + "}");
  }
}

// `unit` is what the file says, the images are in steps of 0.0005 units.
void write_transforms(const fs::path& scene, double unit = 0.0005) {
  std::string frames;
  for (std::size_t i = 0; i < poses().size(); ++i) {
    write_photograph(scene / "images" / (name_of(i) + ".png"));
    write_depth(scene / "depth" / (name_of(i) + ".png"), poses()[i], kSmaller, 0.0005);
    if (i > 0) frames += ',';
    std::ostringstream frame;
    frame << R"({"file_path": "images/)" << name_of(i) << R"(.png", "depth_file_path": "depth/)" << name_of(i)
          << R"(.png", "transform_matrix": [)" << std::setprecision(17);
    for (const auto& row : rows(poses()[i], true)) {
      frame << '[' << row[0] << ',' << row[1] << ',' << row[2] << ',' << row[3] << "],";
    }
    frames += frame.str();
    frames += "[0,0,0,1]]}";
  }
  write_file(scene / "transforms.json",
             "{\"depth_unit_scale_factor\": " + text(unit) + ", \"fl_x\": " + text(kPhotograph.fx) +
                 ", \"fl_y\": " + text(kPhotograph.fy) + ", \"cx\": " + text(kPhotograph.cx) +
                 ", \"cy\": " + text(kPhotograph.cy) + ", \"frames\": [" + frames + "]}");
}

const StageProgress kSilent = [](const std::string&, std::size_t) { return [](std::size_t) {}; };

SceneMesh meshed(const fs::path& scene, const SceneMeshOptions& options = {}) {
  return mesh_from_scene(scene, options, kSilent);
}

void check_is_room(const SceneMesh& made) {
  REQUIRE(made.depth);
  CHECK(made.depth->images == poses().size());
  CHECK(made.depth->confirmed > 0.95);
  CHECK(made.trust.points_on_surface > 0.95);
  CHECK(made.trust.pixels_covered > 0.9);
  CHECK(made.warnings.empty());
  std::vector<double> distances;
  for (const dvec3& p : made.surface.positions) {
    distances.push_back(std::abs(distance_to_surface(p)) / made.depth->voxel);
  }
  CAPTURE(made.depth->voxel, percentile(distances, 0.5), percentile(distances, 0.95));
  CHECK(percentile(distances, 0.5) < 0.1);
  CHECK(percentile(distances, 0.95) < 0.5);
  double area = 0, outward = 0;
  for (const glm::uvec3& face : made.surface.faces) {
    const dvec3 a = made.surface.positions[face[0]], b = made.surface.positions[face[1]],
                c = made.surface.positions[face[2]];
    const dvec3 twice_area = glm::cross(b - a, c - a);
    area += glm::length(twice_area);
    if (glm::dot(twice_area, towards_free_space((a + b + c) / 3.0)) > 0) outward += glm::length(twice_area);
  }
  CHECK(outward > 0.99 * area);
}

TEST_CASE("depth images of each form make the surface that they were taken of, facing outwards") {
  const TemporaryFolder folder;
  write_tum(folder / "tum");
  write_scannet(folder / "scannet");
  write_polycam(folder / "polycam");
  write_transforms(folder / "transforms");
  for (const char* const form : {"tum", "scannet", "polycam", "transforms"}) {
    CAPTURE(form);
    check_is_room(meshed(folder / form));
    const SceneViews views = read_scene_views(folder / form, dvec3(0));
    CHECK(views.depths.size() == poses().size());
    REQUIRE(!views.notes.empty());
    CHECK_THAT(views.notes.back(), Catch::StartsWith("20 depth images, of which `lumatlas mesh` makes a mesh: "));
  }
  CHECK_THAT(read_scene_views(folder / "tum", dvec3(0)).notes.back(), Catch::Contains("1 more have no pose within 20"));
}

TEST_CASE("a mesh of depth images is the same for any number of threads, and has no more faces than asked for") {
  const TemporaryFolder folder;
  write_polycam(folder.path());
  SceneMeshOptions options;
  options.most_faces = 20'000;
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return meshed(folder.path(), options);
  };
  const SceneMesh one = run(1), two = run(2);
  CHECK((one.surface.positions == two.surface.positions));
  CHECK((one.surface.faces == two.surface.faces));
  CHECK(one.surface.faces.size() <= 20'000);
  CHECK(one.depth->fused_faces > 20'000);
}

TEST_CASE("depths of low confidence are left out, and a picture of confidence that does not fit is named") {
  const TemporaryFolder folder;
  write_polycam(folder.path());
  // Everywhere a wall half a unit in front of the camera, in the middle of the room.
  for (std::size_t i = 0; i < poses().size(); ++i) {
    const fs::path depth = folder / ("keyframes/depth/" + name_of(i) + ".png");
    const fs::path confidence = folder / ("keyframes/confidence/" + name_of(i) + ".png");
    const std::vector<std::uint16_t> true_depths = read_grey_image(depth).values;
    std::vector<std::uint16_t> depths = true_depths;
    std::vector<std::uint8_t> levels(depths.size(), 127);
    for (std::size_t pixel = 0; pixel < depths.size(); pixel += 3) {
      depths[pixel] = 500;
      levels[pixel] = 0;
    }
    fs::create_directories(confidence.parent_path());
    write_grey(depth, kSmaller.width, kSmaller.height, depths);
    write_grey(confidence, kSmaller.width, kSmaller.height, levels);
  }
  const auto farthest_off = [&] {
    double most = 0;
    const SceneMesh made = meshed(folder.path());
    for (const dvec3& p : made.surface.positions) most = std::max(most, std::abs(distance_to_surface(p)));
    return most / made.depth->voxel;
  };
  CHECK(farthest_off() < 3);
  const fs::path file = folder / ("keyframes/confidence/" + name_of(0) + ".png");
  write_grey(file, 5, 4, std::vector<std::uint8_t>(20, 127));
  CHECK_THROWS_WITH(meshed(folder.path()),
                    file.string() + ": is 5x4 pixels, must have the size of its depth image, 56x42");
}

TEST_CASE("what a mesh is made of is told before any work is done, and what is thrown then is thrown on") {
  const TemporaryFolder folder;
  write_polycam(folder.path());
  std::size_t stages = 0;
  const StageProgress count = [&](const std::string&, std::size_t) {
    ++stages;
    return [](std::size_t) {};
  };
  const auto refuse = [](MeshSource source) {
    throw std::runtime_error(source == MeshSource::depth_images ? "of depth images" : "of points");
  };
  CHECK_THROWS_WITH(mesh_from_scene(folder.path(), {}, count, refuse), "of depth images");
  SceneMeshOptions options;
  options.points = folder.with_file("points.ply", "ply\n");
  CHECK_THROWS_WITH(mesh_from_scene(folder.path(), options, count, refuse), "of points");
  CHECK(stages == 0);
}

TEST_CASE("a length is told in four significant digits, whatever its size") {
  CHECK(length_text(0.00001234567) == "1.235e-05");
  CHECK(length_text(0.0123456) == "0.01235");
  CHECK(length_text(12.5) == "12.5");
}

TEST_CASE("a voxel that is asked for is taken") {
  const TemporaryFolder folder;
  write_transforms(folder.path());
  SceneMeshOptions options;
  options.voxel = 0.1;
  const SceneMesh made = meshed(folder.path(), options);
  CHECK(made.depth->voxel == 0.1);
  CHECK(made.depth->truncation == Approx(0.4));
  CHECK(made.surface.faces.size() < 30'000);
}

TEST_CASE("a depth image that cannot be used is named, with what is wrong with it") {
  const TemporaryFolder folder;
  write_polycam(folder.path());
  const auto complaint = [&](const SceneMeshOptions& options = {}) {
    try {
      (void)meshed(folder.path(), options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  const fs::path file = folder / "keyframes/depth/103.png";
  write_grey(file, 56, 56, std::vector<std::uint16_t>(56 * 56, 1000));
  CHECK(complaint() == file.string() + ": is 56x56 pixels, which is not the shape of what its camera takes, 112x84");
  write_grey(file, 56, 42, std::vector<std::uint8_t>(56 * 42, 100));
  CHECK(complaint() == file.string() +
                           ": has 1 channel of 8 bits, must have one of 16 bits: numbers are kept in a grey PNG of 16 "
                           "bits");
  write_file(file, "rubbish");
  CHECK_THAT(complaint(), Catch::StartsWith(file.string() + ": is no JPEG, PNG"));
  write_depth(file, poses()[3], kSmaller, 0.001);
  CHECK(complaint() == "taken");
  SceneMeshOptions options;
  options.voxel = 1e-4;
  CHECK_THAT(complaint(options),
             Catch::StartsWith("--voxel: voxels of 0.0001 would take ") && Catch::Contains("at most 256 MiB"));
  options = {};
  options.depth_unit = 0.0;
  CHECK_THROWS_WITH(meshed(folder.path(), options), Catch::StartsWith("depth_unit: 0, must be in"));
  for (const auto& entry : fs::directory_iterator(folder / "keyframes/depth")) {
    write_grey(entry.path(), 56, 42, std::vector<std::uint16_t>(56 * 42, 0));
  }
  CHECK_THAT(complaint(), Catch::Contains("has measured anything, all of their pixels are 0"));
  // A measured depth that cannot be used is not called 0.
  std::vector<std::uint16_t> alone(56 * 42, 0);
  alone[1000] = 1500;
  for (const auto& entry : fs::directory_iterator(folder / "keyframes/depth")) {
    write_grey(entry.path(), 56, 42, alone);
  }
  CHECK_THAT(complaint(), Catch::Contains("shows a surface: 20 of their pixels are above 0, but none has a measured "
                                          "neighbour beside it"));
}

TEST_CASE("a depth image that transforms.json names and that is not there is named") {
  const TemporaryFolder folder;
  write_transforms(folder.path());
  fs::remove(folder / "depth/104.png");
  CHECK_THROWS_WITH(meshed(folder.path()), (folder / "depth/104.png").string() + ": no such file");
}

TEST_CASE("a unit that cannot be is refused, unless it was asked for") {
  const TemporaryFolder folder;
  const auto complaint = [&](double unit) {
    write_transforms(folder.path(), unit);
    try {
      (void)meshed(folder.path());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("taken");
  };
  CHECK_THAT(complaint(0.5), Catch::Contains("its depth images see surfaces ") &&
                                 Catch::Contains("is a step of 100.png 0.5 units of the poses? --depth-unit"));
  CHECK_THAT(complaint(5e-7), Catch::Contains("of the depths in the view of another depth image are confirmed by it"));
  CHECK_THAT(complaint(-1), Catch::Contains("depth_unit_scale_factor: is -1, must be in [1e-9, 1e9]"));
  SceneMeshOptions options;
  options.depth_unit = 0.0005;
  write_transforms(folder.path(), 0.5);
  check_is_room(meshed(folder.path(), options));
}

}  // namespace
}  // namespace lumatlas
