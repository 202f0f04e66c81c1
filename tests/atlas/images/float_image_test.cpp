// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/float_image.h"

#include <OpenImageIO/imageio.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <limits>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/images/srgb.h"
#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

TEST_CASE("whole numbers of 16 bits come back from a PNG file as they were") {
  const TemporaryFolder folder;
  const GreyImage image{3, 2, {0, 1, 255, 256, 40000, 65535}};
  const std::vector<std::uint8_t> file = encode_grey_image(image);
  std::ofstream(folder / "depth.png", std::ios::binary)
      .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
  const GreyImage read = read_grey_image(folder / "depth.png");
  CHECK(read.width == 3);
  CHECK(read.height == 2);
  CHECK(read.values == image.values);
  CHECK_THROWS_WITH(encode_grey_image({3, 2, {1, 2, 3, 4, 5}}),
                    "grey image: 5 values for a size of 3x2; each side must be in [1, 65536]");
  CHECK_THROWS_AS(encode_grey_image({}), std::invalid_argument);
}

TEST_CASE("numbers come back from an OpenEXR file as they were, infinity and none included") {
  const TemporaryFolder folder;
  FloatImage image{3, 2, {"Z"}, {0.5f, -1e30f, 1e-30f, 65000.25f, std::numeric_limits<float>::infinity(), NAN}};
  write_float_image(folder / "depth.exr", image);
  const auto reader = OIIO::ImageInput::open((folder / "depth.exr").string());
  REQUIRE(reader);
  CHECK(reader->spec().width == 3);
  CHECK(reader->spec().height == 2);
  CHECK(reader->spec().channelnames == std::vector<std::string>{"Z"});
  std::vector<float> values(6);
  REQUIRE(reader->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, values.data()));
  for (std::size_t i = 0; i < 5; ++i) CHECK(values[i] == image.values[i]);
  CHECK(std::isnan(values[5]));
}

TEST_CASE("colours in an OpenEXR file are read as linear light") {
  const TemporaryFolder folder;
  write_float_image(folder / "colour.exr", {2, 1, {"R", "G", "B"}, {0, 0.25f, 1, 3.5f, 0.5f, 0.001f}});
  const Photograph read = read_photograph(folder / "colour.exr");
  const std::vector<double> light{0, 0.25, 1, 3.5, 0.5, 0.001};
  for (std::size_t i = 0; i < 6; ++i) CHECK(read.rgb[i] == srgb8_from_linear(light[i]));
}

TEST_CASE("images that are not what they say, and places that cannot be written, are refused") {
  const TemporaryFolder folder;
  const FloatImage good{1, 1, {"Y"}, {1}};
  CHECK_THROWS_WITH(write_float_image(folder / "a.png", good), Catch::Contains("does not end in .exr"));
  CHECK_THROWS_AS(write_float_image(folder / "none/a.exr", good), InputError);
  CHECK_THROWS_WITH(write_float_image(folder / "a.exr", {2, 1, {"Y"}, {1}}), "float image: has 1 values, must have 2");
  CHECK_THROWS_WITH(write_float_image(folder / "a.exr", {1, 1, {}, {}}), "float image: it has no channels");
  CHECK_THROWS_WITH(write_float_image(folder / "a.exr", {0, 1, {"Y"}, {}}), Catch::Contains("size is 0x1"));
  CHECK_THROWS_WITH(write_float_image(folder / "a.exr", {1, 1, {"Y", ""}, {1, 2}}),
                    Catch::StartsWith("float image: the name of channel 1 is '', must have"));
  CHECK_THROWS_WITH(write_float_image(folder / "a.exr", {1, 1, {"Y", "Z", "Y"}, {1, 2, 3}}),
                    Catch::StartsWith("float image: the name of channel 2 is 'Y', must have"));
  CHECK_THROWS_AS(write_float_image(folder / "a.exr", {1, 1, {std::string(256, 'Y')}, {1}}), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
