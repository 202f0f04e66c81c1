// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/frame/background.h"

#include <OpenImageIO/imageio.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kWidth = 300, kHeight = 60;
constexpr std::uint32_t kFirstEmpty = 200;  // column
const Background kTransparent{Background::Kind::transparent, {}};

std::size_t at(std::uint32_t x, std::uint32_t y) {
  return std::size_t{y} * kWidth + x;
}

// A grey surface that ends at a column; nothing beyond it.
Rendering half_empty(std::uint8_t grey) {
  Rendering rendering;
  rendering.picture = {kWidth, kHeight, std::vector<std::uint8_t>(3 * kWidth * kHeight, 0), {}};
  rendering.state.assign(kWidth * kHeight, PixelState::empty);
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    for (std::uint32_t x = 0; x < kFirstEmpty; ++x) {
      rendering.state[at(x, y)] = PixelState::textured;
      for (std::size_t channel = 0; channel < 3; ++channel) rendering.picture.rgb[3 * at(x, y) + channel] = grey;
    }
  }
  return rendering;
}

TEST_CASE("coverage is 0 beyond the surface, rises evenly within a hundredth of the picture, and is 1 at its border") {
  const std::vector<float> coverage = soft_coverage(half_empty(128).state, kWidth, kHeight);
  for (const std::uint32_t y : {0u, 30u, kHeight - 1}) {
    CHECK(coverage[at(kFirstEmpty, y)] == 0);
    CHECK(coverage[at(kFirstEmpty - 1, y)] == Approx(0.25));  // 3 pixels are a hundredth of 300
    CHECK(coverage[at(kFirstEmpty - 2, y)] == Approx(0.5));
    CHECK(coverage[at(kFirstEmpty - 3, y)] == Approx(0.75));
    CHECK(coverage[at(kFirstEmpty - 4, y)] == 1);
    CHECK(coverage[at(0, y)] == 1);
  }
  CHECK_THROWS_AS(soft_coverage({}, 2, 2), std::invalid_argument);
}

TEST_CASE("with alpha the surface keeps its colours, and what is transparent has its neighbours'") {
  const Rendering rendering = half_empty(128);
  const SoftPicture soft = with_background(rendering, kTransparent);
  REQUIRE(soft.alpha.size() == rendering.state.size());
  for (std::size_t pixel = 0; pixel < soft.alpha.size(); ++pixel) {
    CHECK(std::abs(int{soft.picture.rgb[3 * pixel]} - 128) <= 1);
    if (rendering.state[pixel] == PixelState::empty) CHECK(soft.alpha[pixel] == 0);
  }
  CHECK(soft.alpha[at(10, 10)] == 255);
  CHECK(soft.alpha[at(kFirstEmpty - 2, 10)] == 128);
}

TEST_CASE("over a colour the surface fades into it in linear light; the blurred background goes on as the surface") {
  const Rendering rendering = half_empty(0);
  const SoftPicture white = with_background(rendering, *background_named("white"));
  CHECK(white.alpha.empty());
  CHECK(white.picture.rgb[3 * at(kFirstEmpty + 5, 7)] == 255);
  CHECK(white.picture.rgb[3 * at(kFirstEmpty - 2, 7)] == 188);  // half of the light
  CHECK(white.picture.rgb[3 * at(5, 7)] == 0);
  const SoftPicture blurred = with_background(half_empty(90), *background_named("blur"));
  CHECK(blurred.alpha.empty());
  CHECK(std::abs(int{blurred.picture.rgb[3 * at(kWidth - 1, 7)]} - 90) <= 1);
}

TEST_CASE("colours that no photograph shows hardly count in the blurred background") {
  Rendering rendering = half_empty(60);
  for (std::uint32_t y = 28; y < 32; ++y) {  // a white scrap
    for (std::uint32_t x = 248; x < 252; ++x) {
      rendering.state[at(x, y)] = PixelState::untextured;
      for (std::size_t channel = 0; channel < 3; ++channel) rendering.picture.rgb[3 * at(x, y) + channel] = 255;
    }
  }
  const auto beside = [&] { return int{with_background(rendering, {}).picture.rgb[3 * at(262, 30)]}; };
  CHECK(beside() < 110);
  for (PixelState& state : rendering.state) {
    if (state == PixelState::untextured) state = PixelState::textured;
  }
  CHECK(beside() > 150);
  // Where nothing else is there, they are the background.
  for (PixelState& state : rendering.state) {
    if (state == PixelState::textured) state = PixelState::unseen;
  }
  CHECK(std::abs(int{with_background(rendering, {}).picture.rgb[3 * at(205, 50)]} - 60) <= 20);
}

TEST_CASE("a picture without anything open stays as it is, one of nothing is transparent black") {
  Rendering rendering = half_empty(77);
  rendering.state.assign(rendering.state.size(), PixelState::untextured);
  for (const char* const name : {"alpha", "blur", "white"}) {
    const SoftPicture soft = with_background(rendering, *background_named(name));
    CHECK(soft.picture.rgb == rendering.picture.rgb);
    CHECK(soft.alpha == (name == std::string("alpha") ? std::vector<std::uint8_t>(rendering.state.size(), 255)
                                                      : std::vector<std::uint8_t>()));
  }
  rendering.state.assign(rendering.state.size(), PixelState::empty);
  const SoftPicture nothing = with_background(rendering, kTransparent);
  CHECK(nothing.alpha == std::vector<std::uint8_t>(rendering.state.size(), 0));
  CHECK(nothing.picture.rgb == std::vector<std::uint8_t>(rendering.picture.rgb.size(), 0));
}

TEST_CASE("in linear light alpha is multiplied into the colours") {
  LinearRendering rendering{kWidth, kHeight, std::vector<float>(3 * kWidth * kHeight, 2.0f), half_empty(1).state};
  const FloatImage image = with_background(rendering, kTransparent);
  CHECK(image.channels == std::vector<std::string>{"R", "G", "B", "A"});
  CHECK(image.values[4 * at(kFirstEmpty - 2, 3)] == Approx(1));
  CHECK(image.values[4 * at(kFirstEmpty - 2, 3) + 3] == Approx(0.5));
  CHECK(image.values[4 * at(kFirstEmpty, 3)] == 0);
  CHECK(with_background(rendering, *background_named("black")).channels.size() == 3);
}

TEST_CASE("a file keeps colours and alpha apart, to the bit") {
  const SoftPicture soft = with_background(half_empty(128), kTransparent);
  const TemporaryFolder folder;
  write_image(folder / "a.png", soft.picture, soft.alpha);
  const auto file = OIIO::ImageInput::open((folder / "a.png").string(), [] {
    static OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    return &config;
  }());
  REQUIRE(file);
  REQUIRE(file->spec().nchannels == 4);
  std::vector<std::uint8_t> rgba(4 * soft.alpha.size());
  REQUIRE(file->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, rgba.data()));
  for (std::size_t pixel = 0; pixel < soft.alpha.size(); ++pixel) {
    CHECK(rgba[4 * pixel] == soft.picture.rgb[3 * pixel]);
    CHECK(rgba[4 * pixel + 3] == soft.alpha[pixel]);
  }
}

TEST_CASE("backgrounds have names, and other names are refused") {
  CHECK(background_named("#10fF80")->color == std::array<std::uint8_t, 3>{16, 255, 128});
  for (const char* const name : {"", "#10ff8", "#10ff8g", "red", "Alpha"}) CHECK_FALSE(background_named(name));
}

}  // namespace
}  // namespace lumatlas
