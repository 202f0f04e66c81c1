// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/colmap/colmap.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

using test::Bytes;
using test::write_file;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::array<double, 4> kUpright{1, 0, 0, 0};
constexpr std::array<double, 3> kOrigin{0, 0, 0};

// Returns the parser's complaint about the input; fails the test if there is none.
template <typename Parse>
std::string parse_complaint(Parse parse) {
  try {
    (void)parse();
  } catch (const InputError& error) {
    return error.what();
  }
  FAIL("the input was taken");
  return {};
}
std::string cameras_complaint(const Bytes& file) {
  return parse_complaint([&] { return parse_cameras_binary(file.span(), "cameras.bin"); });
}
std::string images_complaint(const Bytes& file) {
  return parse_complaint([&] { return parse_images_binary(file.span(), "images.bin"); });
}
std::string cameras_complaint(const std::string& file) {
  return parse_complaint([&] { return parse_cameras_text(file, "cameras.txt"); });
}
std::string images_complaint(const std::string& file) {
  return parse_complaint([&] { return parse_images_text(file, "images.txt"); });
}

Bytes count(std::uint64_t records) {
  return Bytes().u64(records);
}

Bytes one_camera(std::int32_t model, std::uint64_t width, std::uint64_t height,
                 std::initializer_list<double> parameters) {
  return count(1).camera(7, model, width, height, parameters);
}

Bytes one_image(std::array<double, 4> q, std::array<double, 3> t, std::string_view name) {
  return count(1).image(3, q, t, 1, name);
}

TEST_CASE("binary cameras are read with their models and parameters") {
  const Bytes file = count(2).camera(9, 1, 640, 480, {500, 510, 320, 240}).camera(2, 2, 100, 50, {80, 50, 25, -0.1});
  const std::vector<ColmapCamera> cameras = parse_cameras_binary(file.span(), "cameras.bin");
  REQUIRE(cameras.size() == 2);
  CHECK(cameras[0].id == 9);
  CHECK(cameras[0].lens.model == LensModel::kPinhole);
  CHECK(cameras[0].lens.width == 640);
  CHECK(cameras[0].lens.height == 480);
  CHECK(cameras[0].lens.focal_length() == glm::dvec2(500, 510));
  CHECK(cameras[0].lens.principal_point() == glm::dvec2(320, 240));
  CHECK(cameras[1].lens.model == LensModel::kSimpleRadial);
  CHECK(cameras[1].lens.focal_length() == glm::dvec2(80, 80));
  CHECK(cameras[1].lens.parameters[3] == -0.1);
}

TEST_CASE("text cameras say the same as binary ones") {
  const Bytes binary = count(2).camera(9, 1, 640, 480, {500, 510, 320, 240}).camera(2, 2, 100, 50, {80, 50, 25, -0.1});
  const std::string text =
      "# a comment\n\n9 PINHOLE 640 480 500 510.0 3.2e2 240\r\n  2\tSIMPLE_RADIAL  100 50 80 50 25 -0.1";
  const auto a = parse_cameras_binary(binary.span(), "cameras.bin");
  const auto b = parse_cameras_text(text, "cameras.txt");
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].id == b[i].id);
    CHECK(a[i].lens == b[i].lens);
  }
}

TEST_CASE("images are read with unit quaternions, whatever their length was, and their points skipped") {
  const Bytes file = count(2)
                         .image(3, {2, 0, 0, 2}, {1, 2, 3}, 9, "a.jpg", 1000)
                         .image(4, {1e200, 1e200, 0, 0}, {4, 5, 6}, 2, "folder/b c.jpg");
  const std::vector<ColmapImage> images = parse_images_binary(file.span(), "images.bin");
  REQUIRE(images.size() == 2);
  CHECK(images[0].id == 3);
  CHECK(images[0].camera_id == 9);
  CHECK(images[0].name == "a.jpg");
  CHECK(images[0].cam_from_world_rotation.w == Approx(std::sqrt(0.5)));
  CHECK(images[0].cam_from_world_rotation.z == Approx(std::sqrt(0.5)));
  CHECK(images[0].cam_from_world_translation == glm::dvec3(1, 2, 3));
  CHECK(images[1].name == "folder/b c.jpg");
  CHECK(images[1].cam_from_world_rotation.x == Approx(std::sqrt(0.5)));
}

TEST_CASE("text images say the same as binary ones, blanks in names included") {
  const Bytes binary = count(3)
                           .image(3, {2, 0, 0, 2}, {1, 2, 3}, 9, "a.jpg", 1)
                           .image(4, kUpright, {4, -5, 6}, 2, "folder/b c.jpg")
                           .image(5, kUpright, kOrigin, 2, "#.png");
  const std::string text =
      "# Image list\n3 2 0 0 2 1 2 3 9 a.jpg\n0 2.5 -1\n4 1 0 0 0 4 -5e0 6 2 folder/b c.jpg\n\n"
      "5 1 0 0 0 0 0 0 2 #.png";
  const auto a = parse_images_binary(binary.span(), "images.bin");
  const auto b = parse_images_text(text, "images.txt");
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].id == b[i].id);
    CHECK(a[i].camera_id == b[i].camera_id);
    CHECK(a[i].name == b[i].name);
    CHECK(a[i].cam_from_world_rotation == b[i].cam_from_world_rotation);
    CHECK(a[i].cam_from_world_translation == b[i].cam_from_world_translation);
  }
}

TEST_CASE("a damaged cameras.bin gets an exact sentence") {
  CHECK(cameras_complaint(Bytes()) ==
        "cameras.bin: is 0 bytes long, too short for the number of cameras that it must begin with");
  CHECK(cameras_complaint(Bytes().u32(1)) ==
        "cameras.bin: is 4 bytes long, too short for the number of cameras that it must begin with");
  CHECK(cameras_complaint(count(~std::uint64_t{0}).camera(1, 1, 640, 480, {500, 500, 320, 240})) ==
        "cameras.bin: claims 18446744073709551615 cameras, but the 56 bytes after that number hold at most 1: the file "
        "is cut off or damaged");
  CHECK(cameras_complaint(one_camera(1, 640, 480, {500, 500, 320})) ==
        "cameras.bin: the camera at index 0: the file ends inside it, at byte 56: it is cut off");
  CHECK(cameras_complaint(one_camera(1, 640, 480, {500, 500, 320, 240}).text("tail")) ==
        "cameras.bin: 4 bytes follow the 1 cameras that it claims: the file is damaged");
  CHECK(cameras_complaint(one_camera(18, 640, 480, {500, 500, 320, 240})) ==
        "cameras.bin: the camera at index 0: its lens model is 18, must be one of COLMAP's, in [0, 17]");
  CHECK(cameras_complaint(one_camera(-1, 640, 480, {500, 500, 320, 240})) ==
        "cameras.bin: the camera at index 0: its lens model is -1, must be one of COLMAP's, in [0, 17]");
  CHECK(cameras_complaint(one_camera(1, 0, 480, {500, 500, 320, 240})) ==
        "cameras.bin: the camera at index 0: width is 0, must be in [1, 65536]");
  CHECK(cameras_complaint(one_camera(1, 640, static_cast<std::uint64_t>(-480), {500, 500, 320, 240})) ==
        "cameras.bin: the camera at index 0: height is -480, must be in [1, 65536]");
  CHECK(cameras_complaint(one_camera(1, 1ull << 40, 480, {500, 500, 320, 240})) ==
        "cameras.bin: the camera at index 0: width is 1099511627776, must be in [1, 65536]");
}

TEST_CASE("a lens with impossible parameters gets an exact sentence") {
  CHECK(cameras_complaint(one_camera(1, 640, 480, {500, -500, 320, 240})) ==
        "cameras.bin: the camera at index 0: camera 7 (PINHOLE): fy is -500, must be positive");
  CHECK(cameras_complaint(one_camera(0, 640, 480, {0, 320, 240})) ==
        "cameras.bin: the camera at index 0: camera 7 (SIMPLE_PINHOLE): f is 0, must be positive");
  CHECK(cameras_complaint(one_camera(4, 640, 480, {500, 500, 320, 240, 0, kNan, 0, 0})) ==
        "cameras.bin: the camera at index 0: camera 7 (OPENCV): k2 is nan, must be finite");
  CHECK(cameras_complaint(one_camera(1, 640, 480, {500, 500, kInfinity, 240})) ==
        "cameras.bin: the camera at index 0: camera 7 (PINHOLE): cx is inf, must be finite");
  CHECK(cameras_complaint(one_camera(1, 640, 480, {500, 500, 320, -1e300})) ==
        "cameras.bin: the camera at index 0: camera 7 (PINHOLE): cy is -1e+300, must be in [-1000000, 1000000]");
  CHECK(cameras_complaint(one_camera(7, 640, 480, {500, 500, 320, 240, 4})) ==
        "cameras.bin: the camera at index 0: camera 7 (FOV): omega is 4, must be in (-pi, pi)");
  CHECK(cameras_complaint(one_camera(16, 640, 480, {500, 500, 320, 240, 1.5, 1})) ==
        "cameras.bin: the camera at index 0: camera 7 (EUCM): alpha is 1.5, must be in [0, 1]");
  CHECK(cameras_complaint(one_camera(16, 640, 480, {500, 500, 320, 240, 0.5, 0})) ==
        "cameras.bin: the camera at index 0: camera 7 (EUCM): beta is 0, must be positive");
}

TEST_CASE("a damaged images.bin gets an exact sentence") {
  CHECK(images_complaint(Bytes().text("abc")) ==
        "images.bin: is 3 bytes long, too short for the number of images that it must begin with");
  CHECK(images_complaint(count(1ull << 62)) ==
        "images.bin: claims 4611686018427387904 images, but the 0 bytes after that number hold at most 0: the file is "
        "cut off or damaged");
  const Bytes whole = one_image(kUpright, kOrigin, "long-enough-name.jpg");
  CHECK(images_complaint(whole.cut(whole.size() - 8 - 4)) ==
        "images.bin: the image at index 0: the file ends inside its name: it is cut off");
  CHECK(images_complaint(whole.cut(whole.size() - 3)) ==
        "images.bin: the image at index 0: the file ends inside it, at byte 98: it is cut off");
  CHECK(images_complaint(one_image(kUpright, kOrigin, std::string(5000, 'a'))) ==
        "images.bin: the image at index 0: its name is longer than 4096 bytes: the file is damaged");
  const Bytes points = count(1).u32(3).f64({1, 0, 0, 0, 0, 0, 0}).u32(1).text({"a\0", 2}).u64(1ull << 60).f64({1, 2});
  CHECK(
      images_complaint(points) ==
      "images.bin: the image at index 0: it claims 1152921504606846976 points, but 16 bytes are left, 24 a point: the "
      "file is cut off or damaged");
  CHECK(images_complaint(one_image(kUpright, kOrigin, "a.jpg").u32(0)) ==
        "images.bin: 4 bytes follow the 1 images that it claims: the file is damaged");
}

TEST_CASE("an impossible pose gets an exact sentence") {
  CHECK(images_complaint(one_image({0, 0, 0, 0}, kOrigin, "a.jpg")) ==
        "images.bin: the image at index 0: its rotation quaternion is 0 0 0 0, must not be zero");
  CHECK(images_complaint(one_image({1, kNan, 0, 0}, kOrigin, "a.jpg")) ==
        "images.bin: the image at index 0: its rotation quaternion holds nan, must be finite");
  CHECK(images_complaint(one_image(kUpright, {0, 0, -kInfinity}, "a.jpg")) ==
        "images.bin: the image at index 0: its translation holds -inf, must be within 1e12 of 0");
  CHECK(images_complaint(one_image(kUpright, {0, kNan, 0}, "a.jpg")) ==
        "images.bin: the image at index 0: its translation holds nan, must be within 1e12 of 0");
  CHECK(images_complaint(one_image(kUpright, {2e12, 0, 0}, "a.jpg")) ==
        "images.bin: the image at index 0: its translation holds 2e+12, must be within 1e12 of 0");
}

TEST_CASE("a name that is no place among the photographs gets an exact sentence") {
  CHECK(
      images_complaint(one_image(kUpright, kOrigin, "").text("")) ==
      "images.bin: claims 1 images, but the 73 bytes after that number hold at most 0: the file is cut off or damaged");
  CHECK(images_complaint(count(1).image(3, kUpright, kOrigin, 1, "", 1)) ==
        "images.bin: the image at index 0: its name is empty, must be that of a photograph");
  CHECK(images_complaint(one_image(kUpright, kOrigin, "a\nb.jpg")) ==
        "images.bin: the image at index 0: its name 'a\\x0ab.jpg' holds a control character");
  CHECK(images_complaint(std::string("3 1 0 0 0 0 0 0 1 a\0.jpg\n", 25)) ==
        "images.txt: line 1: its name 'a\\x00.jpg' holds a control character");
  CHECK(parse_images_binary(one_image(kUpright, kOrigin, "a..b/...jpg").span(), "images.bin")[0].name == "a..b/...jpg");
}

TEST_CASE("ids and names that occur twice get an exact sentence") {
  const auto camera = [](Bytes file, std::uint32_t id) { return file.camera(id, 0, 8, 8, {8, 4, 4}); };
  CHECK(cameras_complaint(camera(camera(camera(count(3), 5), 6), 5)) ==
        "cameras.bin: the cameras at index 0 and 2 have the same id 5");
  CHECK(images_complaint(count(2).image(3, kUpright, kOrigin, 1, "a.jpg").image(3, kUpright, kOrigin, 1, "b.jpg")) ==
        "images.bin: the images at index 0 and 1 have the same id 3");
  CHECK(images_complaint(count(2).image(3, kUpright, kOrigin, 1, "a.jpg").image(4, kUpright, kOrigin, 1, "a.jpg")) ==
        "images.bin: the images at index 0 and 1 have the same name 'a.jpg'");
}

TEST_CASE("a damaged cameras.txt gets an exact sentence") {
  CHECK(cameras_complaint("x PINHOLE 640 480 500 500 320 240\n") ==
        "cameras.txt: line 1: camera id is 'x', must be a whole number in [0, 4294967295]");
  CHECK(cameras_complaint("4294967296 PINHOLE 640 480 500 500 320 240\n") ==
        "cameras.txt: line 1: camera id is '4294967296', must be a whole number in [0, 4294967295]");
  CHECK(cameras_complaint("# head\n1 PINWHEEL 640 480 500 500 320 240\n") ==
        "cameras.txt: line 2: lens model is 'PINWHEEL', must be one of COLMAP's, such as PINHOLE or OPENCV");
  CHECK(cameras_complaint("1 PINHOLE -640 480 500 500 320 240\n") ==
        "cameras.txt: line 1: width is '-640', must be a whole number in [1, 65536]");
  CHECK(cameras_complaint("1 PINHOLE 640 48.5 500 500 320 240\n") ==
        "cameras.txt: line 1: height is '48.5', must be a whole number in [1, 65536]");
  CHECK(cameras_complaint("1 PINHOLE 640") == "cameras.txt: line 1: ends before the height");
  CHECK(cameras_complaint("1 PINHOLE 640 480 500 500 320\n") ==
        "cameras.txt: line 1: has 3 parameters, but PINHOLE takes 4 (fx, fy, cx, cy)");
  CHECK(cameras_complaint("1 SIMPLE_PINHOLE 640 480 500 500 320 240\n") ==
        "cameras.txt: line 1: has 4 parameters, but SIMPLE_PINHOLE takes 3 (f, cx, cy)");
  CHECK(cameras_complaint("1 PINHOLE 640 480 500 500 320 24O\n") ==
        "cameras.txt: line 1: parameter is '24O', must be a number");
  CHECK(cameras_complaint("1 PINHOLE 640 480 500 500 nan 240\n") ==
        "cameras.txt: line 1: camera 1 (PINHOLE): cx is nan, must be finite");
  CHECK(cameras_complaint("1 PINHOLE 640 480 500 500 1e999 240\n") ==
        "cameras.txt: line 1: parameter is '1e999', must be a number");
}

TEST_CASE("a damaged images.txt gets an exact sentence") {
  CHECK(images_complaint("1 1 0 0 0 0 0 0 1\n") == "images.txt: line 1: ends before the name");
  CHECK(images_complaint("1 1 0 0 zero 0 0 0 1 a.jpg\n") ==
        "images.txt: line 1: rotation quaternion is 'zero', must be a number");
  CHECK(images_complaint("1 1 0 0 0 0 0 0 -1 a.jpg\n") ==
        "images.txt: line 1: camera id is '-1', must be a whole number in [0, 4294967295]");
  CHECK(images_complaint("1 1 0 0 0 0 0 0 1 a.jpg\nrubbish\n") ==
        "images.txt: line 2: image id is 'rubbish', must be a whole number in [0, 4294967295]");
  CHECK(images_complaint("1 1 0 0 0 0 0 0 1 a.jpg\n10 20 -1 30\n") ==
        "images.txt: line 2: holds 4 numbers, must hold X, Y and point id of each 2D point of the image in the line "
        "before, or be blank");
}

TEST_CASE("lines of 2D points may be missing, as scripts that leave blank lines out leave them") {
  const std::string first = "1 1 0 0 0 0 0 0 1 a.jpg\n", second = "2 1 0 0 0 0 0 0 1 b 0.jpg\n";
  for (const std::string& text :
       {first + second, first + "\n" + second + "\n", first + "1 2 -1\n" + second, first + second + "1 2 -1\n",
        first + "# \n" + second, "\xef\xbb\xbf" + first + second}) {
    const std::vector<ColmapImage> images = parse_images_text(text, "images.txt");
    REQUIRE(images.size() == 2);
    CHECK(images[0].name == "a.jpg");
    CHECK(images[1].name == "b 0.jpg");
  }
}

TEST_CASE("a lens or a pose that cannot be is told with its record where bad ones are kept") {
  const auto keep = BadPhotographs::keep;
  const auto cameras = parse_cameras_text("1 PINHOLE 8 8 9 9 4 4\n2 PINHOLE 8 8 -nan(ind) 9 4 4\n", "c.txt", keep);
  REQUIRE(cameras.size() == 2);
  CHECK(cameras[0].bad.empty());
  CHECK(cameras[1].bad == "c.txt: line 2: camera 2 (PINHOLE): fx is -nan, must be finite");
  const Bytes images = count(3)
                           .image(1, kUpright, {0, kInfinity, 0}, 1, "a.jpg")
                           .image(2, {0, 0, 0, 0}, kOrigin, 1, "a.jpg")
                           .image(3, kUpright, kOrigin, 1, "b.jpg");
  const auto read = parse_images_binary(images.span(), "i.bin", keep);
  REQUIRE(read.size() == 3);
  CHECK_THAT(read[0].bad, Catch::Contains("index 0: its translation holds inf"));
  CHECK_THAT(read[1].bad, Catch::Contains("index 1: its rotation quaternion is 0 0 0 0"));
  CHECK(read[2].bad.empty());
}

TEST_CASE("a long line of rubbish is quoted only in part") {
  const std::string message = cameras_complaint(std::string(1000000, 'x'));
  CHECK(message.size() < 250);
  CHECK_THAT(message, Catch::Contains("x...', must be"));
}

TEST_CASE("every beginning of a valid file is refused without a crash") {
  const Bytes cameras = one_camera(4, 640, 480, {500, 500, 320, 240, 0.1, 0, 0, 0}).cut(10000);
  for (std::size_t size = 0; size < cameras.size(); ++size) {
    CHECK_THROWS_AS(parse_cameras_binary(cameras.cut(size).span(), "cameras.bin"), InputError);
  }
  const Bytes images = one_image(kUpright, kOrigin, "a.jpg");
  for (std::size_t size = 0; size < images.size(); ++size) {
    CHECK_THROWS_AS(parse_images_binary(images.cut(size).span(), "images.bin"), InputError);
  }
}

const Bytes kCameras = count(1).camera(1, 1, 640, 480, {500, 500, 320, 240});

TEST_CASE("a model is looked for in sparse, in sparse/0 and in the folder itself, binary first") {
  for (const char* const place : {"sparse", "sparse/0", "."}) {
    const TemporaryFolder folder;
    write_file(folder.path() / place / "cameras.bin", kCameras.string());
    write_file(folder.path() / place / "images.bin", one_image(kUpright, kOrigin, "binary.jpg").string());
    write_file(folder.path() / place / "cameras.txt", "rubbish");
    write_file(folder.path() / place / "images.txt", "rubbish");
    CHECK(read_colmap_model(folder.path()).images.at(0).name == "binary.jpg");
  }
  const TemporaryFolder folder;
  write_file(folder.path() / "cameras.txt", "1 PINHOLE 640 480 500 500 320 240\n");
  write_file(folder.path() / "images.txt", "1 1 0 0 0 0 0 0 1 text.jpg\n");
  CHECK(read_colmap_model(folder.path()).images.at(0).name == "text.jpg");
}

TEST_CASE("a model comes sorted, cameras by id and images by name in byte order") {
  const TemporaryFolder folder;
  write_file(folder.path() / "cameras.bin",
             count(2).camera(9, 0, 8, 8, {8, 4, 4}).camera(2, 0, 8, 8, {8, 4, 4}).string());
  write_file(folder.path() / "images.bin", count(3)
                                               .image(1, kUpright, kOrigin, 9, "b.jpg")
                                               .image(2, kUpright, kOrigin, 2, "a.jpg")
                                               .image(3, kUpright, kOrigin, 2, "B.jpg")
                                               .string());
  const ColmapModel model = read_colmap_model(folder.path());
  CHECK(model.cameras.at(0).id == 2);
  CHECK(model.images.at(0).name == "B.jpg");
  CHECK(model.images.at(1).name == "a.jpg");
  CHECK(model.images.at(2).name == "b.jpg");
  CHECK(model.camera_of(model.images.at(2)).id == 9);
}

TEST_CASE("a folder without a whole model gets an exact sentence") {
  const TemporaryFolder folder;
  const std::string scene = folder.path().string();
  const auto message = [&] { return parse_complaint([&] { return read_colmap_model(scene); }); };
  CHECK(message() == scene +
                         ": holds no COLMAP model (cameras.bin and images.bin, or cameras.txt and images.txt, in "
                         "sparse/, sparse/0/ or itself) and no transforms.json or other form of capture");
  write_file(folder.path() / "sparse/cameras.bin", kCameras.string());
  CHECK(message() == scene + "/sparse/images.bin: no such file, but COLMAP's model needs it beside cameras.bin");
  write_file(folder.path() / "sparse/images.bin", count(0).string());
  CHECK(message() == scene + "/sparse/images.bin: holds no image, so there is nothing to see the scene from");
  write_file(folder.path() / "sparse/images.bin", count(1).image(5, kUpright, kOrigin, 4, "a.jpg").string());
  CHECK(message() == scene + "/sparse/images.bin: image 5 ('a.jpg') has camera 4, which is not in cameras.bin");
  CHECK(parse_complaint([&] { return read_colmap_model(scene + "/nowhere"); }) == scene + "/nowhere: no such folder");
}

TEST_CASE("a model's file that is a folder is refused") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "cameras.bin");
  write_file(folder.path() / "images.bin", count(0).string());
  CHECK(parse_complaint([&] { return read_colmap_model(folder.path()); }) ==
        (folder.path() / "cameras.bin").string() + ": is not a file");
}

Bytes& point(Bytes& file, std::array<double, 3> p, std::array<std::uint8_t, 3> rgb,
             std::initializer_list<std::uint32_t> images) {
  file.u64(77).f64({p[0], p[1], p[2]});
  for (const std::uint8_t channel : rgb) file.add(channel);
  file.f64({0.5}).u64(images.size());
  for (const std::uint32_t image : images) file.u32(image).u32(9);
  return file;
}

TEST_CASE("binary and text points are read with their colours and tracks") {
  Bytes file = count(2);
  point(file, {1, -2, 3.5}, {10, 20, 255}, {4, 7, 4});
  point(file, {0, 0, 0}, {0, 0, 0}, {});
  const std::string text = "# a comment\n77 1 -2 3.5 10 20 255 0.5 4 9 7 9 4 9\n\n78 0 0 0 0 0 0 -1\n";
  for (const auto& points :
       {parse_points_binary(file.span(), "points3D.bin"), parse_points_text(text, "points3D.txt")}) {
    REQUIRE(points.size() == 2);
    CHECK(points[0].position == glm::dvec3(1, -2, 3.5));
    CHECK(points[0].color == glm::u8vec3(10, 20, 255));
    CHECK(points[0].images == std::vector<std::uint32_t>{4, 7, 4});
    CHECK(points[1].images.empty());
  }
}

TEST_CASE("damaged points get an exact sentence") {
  const auto of_binary = [](const Bytes& file) {
    return parse_complaint([&] { return parse_points_binary(file.span(), "points3D.bin"); });
  };
  const auto of_text = [](const std::string& file) {
    return parse_complaint([&] { return parse_points_text(file, "points3D.txt"); });
  };
  Bytes good = count(1);
  point(good, {1, 2, 3}, {1, 2, 3}, {5});
  for (std::size_t size = 0; size < good.size(); ++size) {
    CHECK_THAT(of_binary(good.cut(size)), Catch::StartsWith("points3D.bin: "));
  }
  Bytes long_track = count(1);
  long_track.u64(1).f64({1, 2, 3}).add(char{1}).add(char{1}).add(char{1}).f64({0}).u64(~std::uint64_t{0});
  CHECK(
      of_binary(long_track) ==
      "points3D.bin: the point at index 0: it claims to be seen by 18446744073709551615 images, but 0 bytes are left, "
      "8 an image: the file is cut off or damaged");
  Bytes far = count(1);
  point(far, {1, kNan, 3}, {1, 2, 3}, {});
  CHECK(of_binary(far) == "points3D.bin: the point at index 0: its position holds nan, must be within 1e12 of 0");
  CHECK(of_binary(Bytes(good).text("x")) ==
        "points3D.bin: 1 bytes follow the 1 points that it claims: the file is damaged");
  CHECK(of_text("1 1 2 3 1 2 256 0\n") == "points3D.txt: line 1: colour is '256', must be a whole number in [0, 255]");
  CHECK(of_text("1 1 2 3 1 2 3 0 5\n") == "points3D.txt: line 1: ends before the index of a 2D point");
  CHECK(of_text("1 1 2 inf 1 2 3 0\n") == "points3D.txt: line 1: its position holds inf, must be within 1e12 of 0");
}

}  // namespace
}  // namespace lumatlas
