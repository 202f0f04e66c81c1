// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/scores.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "tools/score/report/error_picture.h"

namespace lumatlas {
namespace {

using Mask = std::vector<std::uint8_t>;
const Mask kEverywhere;

template <typename Value>
Photograph picture(int width, int height, Value value) {
  Photograph image;
  image.width = static_cast<std::uint32_t>(width);
  image.height = static_cast<std::uint32_t>(height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        image.rgb.push_back(static_cast<std::uint8_t>(std::clamp(value(x, y, c), 0, 255)));
      }
    }
  }
  return image;
}

// The formulas of ssim_reference.py beside this file.
int pattern_value(int x, int y, int c) {
  return (7 * x + 13 * y + 29 * c + x * y / 5 + 40 * ((x / 8 + y / 8) % 2)) % 256;
}

Photograph pattern(int width, int height) {
  return picture(width, height, pattern_value);
}

Photograph disturbed_pattern(int width, int height, int strength) {
  return picture(width, height, [strength](int x, int y, int c) {
    return pattern_value(x, y, c) + (31 * x + 17 * y + 11 * c + x * x / 3) % (2 * strength + 1) - strength;
  });
}

Photograph grey(int width, int height, int level) {
  return picture(width, height, [level](int, int, int) { return level; });
}

Mask striped_mask(int width, int height) {
  Mask mask;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      mask.push_back((x + 2 * y) % 7 < 4 ? 255 : 0);
    }
  }
  return mask;
}

Mask left_half(int width, int height) {
  Mask mask;
  for (int i = 0; i < width * height; ++i) {
    mask.push_back(i % width < width / 2 ? 1 : 0);
  }
  return mask;
}

double psnr_after(const Photograph& rendering, const Photograph& photograph, double gain) {
  return psnr(apply_gain(rendering, gain), photograph, kEverywhere);
}

TEST_CASE("PSNR and SSIM are those of scikit-image, and over a mask those of normalised windows") {
  struct Reference {
    int width, height, strength;
    double psnr, ssim, ssim_masked;
  };
  // Printed by: /usr/bin/python3 tests/tools/score/ssim_reference.py (scikit-image 0.19.3, SciPy 1.10.1)
  const std::vector<Reference> table = {
      {64, 48, 11, 31.827763281, 0.996280663288, 0.995966830084},
      {33, 57, 60, 17.870299133, 0.786425161072, 0.771610152804},
      {160, 90, 3, 42.150502004, 0.999803451648, 0.999771594781},
      {11, 11, 100, 13.733380377, 0.432082791361, 0.392626809406},
  };
  for (const Reference& expected : table) {
    CAPTURE(expected.width, expected.height);
    const Photograph photograph = pattern(expected.width, expected.height);
    const Photograph rendering = disturbed_pattern(expected.width, expected.height, expected.strength);
    // Both sides work in double precision; the table is printed to 9 and 12 digits.
    CHECK(psnr(rendering, photograph, kEverywhere) == Approx(expected.psnr).margin(1e-8));
    CHECK(ssim(rendering, photograph, kEverywhere) == Approx(expected.ssim).margin(1e-9));
    const Mask mask = striped_mask(expected.width, expected.height);
    CHECK(ssim(rendering, photograph, mask) == Approx(expected.ssim_masked).margin(1e-9));
  }
}

TEST_CASE("identical pictures score infinity and 1 and need no gain") {
  const Photograph photograph = pattern(40, 30);
  const RegionScores scores = score_region(photograph, photograph, kEverywhere, kEverywhere);
  CHECK(scores.raw.psnr == std::numeric_limits<double>::infinity());
  CHECK(scores.raw.ssim == Approx(1).margin(1e-12));
  CHECK(scores.fitted.psnr == std::numeric_limits<double>::infinity());
  CHECK(scores.gain == 1);
  CHECK(scores.pixels == 1200);
}

TEST_CASE("a constant offset has the PSNR that its definition gives") {
  CHECK(psnr(grey(9, 7, 110), grey(9, 7, 100), kEverywhere) == Approx(20 * std::log10(25.5)).margin(1e-12));
  CHECK(psnr(grey(1, 1, 0), grey(1, 1, 255), kEverywhere) == Approx(0).margin(1e-12));
}

TEST_CASE("SSIM and PSNR do not change when the two pictures are exchanged") {
  const Photograph a = pattern(31, 29);
  const Photograph b = disturbed_pattern(31, 29, 50);
  CHECK(ssim(a, b, kEverywhere) == Approx(ssim(b, a, kEverywhere)).margin(1e-13));
  CHECK(psnr(a, b, kEverywhere) == psnr(b, a, kEverywhere));
}

TEST_CASE("SSIM has a value for pictures smaller than its window") {
  CHECK(ssim(grey(1, 1, 90), grey(1, 1, 90), kEverywhere) == Approx(1));
  const double tiny = ssim(pattern(3, 2), disturbed_pattern(3, 2, 90), kEverywhere);
  CHECK(tiny < 1);
  CHECK(tiny > -1);
}

TEST_CASE("pixels outside the mask do not count") {
  const Photograph photograph = pattern(40, 20);
  Photograph rendering = photograph;
  for (std::size_t i = 0; i < 800; ++i) {
    if (i % 40 >= 20) {
      rendering.rgb[3 * i] = 0;
    }
  }
  CHECK(psnr(rendering, photograph, left_half(40, 20)) == std::numeric_limits<double>::infinity());
  CHECK(psnr(rendering, photograph, kEverywhere) < 40);
  CHECK(fit_gain(rendering, photograph, left_half(40, 20)) == 1);

  Mask far_left(800, 0);  // further from the damage than the window reaches
  for (std::size_t i = 0; i < 800; ++i) {
    far_left[i] = i % 40 < 15 ? 1 : 0;
  }
  CHECK(ssim(rendering, photograph, far_left) == Approx(1).margin(1e-12));
}

TEST_CASE("pixels outside the lens's image do not count") {
  Photograph photograph = pattern(40, 20);
  photograph.valid = left_half(40, 20);
  Photograph rendering = photograph;
  rendering.rgb[3 * 39] ^= 0x80;
  const RegionScores scores = score_region(rendering, photograph, kEverywhere, kEverywhere);
  CHECK(scores.pixels == 400);
  CHECK(scores.raw.psnr == std::numeric_limits<double>::infinity());
}

// Everything else is as black as undistortion and masks leave it in one picture, and something else in the other.
Photograph with_values(Photograph image, const Mask& counted, std::uint8_t elsewhere) {
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {
    if (counted[i / 3] == 0) image.rgb[i] = elsewhere;
  }
  return image;
}

TEST_CASE("no score depends on what pictures hold where no pixel counts, however near that is") {
  const Photograph whole = pattern(40, 30);
  const Photograph rendering = disturbed_pattern(40, 30, 20);
  for (const Mask& counted : {left_half(40, 30), striped_mask(40, 30)}) {
    const RegionScores masked = score_region(rendering, whole, counted, kEverywhere);
    Photograph black_around = with_values(whole, counted, 0);
    CHECK(ssim(with_values(rendering, counted, 200), black_around, counted) == masked.raw.ssim);
    black_around.valid = counted;  // as a reader tells it
    const RegionScores undistorted = score_region(rendering, black_around, kEverywhere, kEverywhere);
    CHECK(undistorted.raw.ssim == masked.raw.ssim);
    CHECK(undistorted.fitted.ssim == masked.fitted.ssim);
    CHECK(undistorted.raw.psnr == masked.raw.psnr);
    CHECK(error_picture(rendering, black_around, kEverywhere).rgb == error_picture(rendering, whole, counted).rgb);
  }
}

TEST_CASE("a rendering that is right in all pixels that count has an SSIM of 1 beside a black border") {
  const Photograph rendering = pattern(40, 30);
  Photograph photograph = with_values(rendering, left_half(40, 30), 0);
  photograph.valid = left_half(40, 30);
  CHECK(ssim(rendering, photograph, kEverywhere) == Approx(1).margin(1e-12));
}

TEST_CASE("a pixel that counts alone is compared by its luma, because its window has nothing else") {
  Mask one(40 * 30, 0);
  one[15 * 40 + 7] = 1;
  const double c1 = 0.01 * 255 * 0.01 * 255;
  const double same = (2 * 100.0 * 120 + c1) / (100.0 * 100 + 120.0 * 120 + c1);
  CHECK(ssim(grey(40, 30, 100), grey(40, 30, 120), one) == Approx(same).margin(1e-12));
}

TEST_CASE("a view in which nothing counts has no scores and drops out of the means") {
  const Mask nothing(600, 0);
  const RegionScores empty = score_region(pattern(30, 20), grey(30, 20, 7), nothing, kEverywhere);
  CHECK(empty.pixels == 0);
  CHECK(std::isnan(empty.raw.psnr));
  CHECK(std::isnan(empty.fitted.ssim));
  CHECK(std::isnan(empty.textured));
  CHECK(empty.gain == 1);
  const RegionScores some = score_region(pattern(30, 20), disturbed_pattern(30, 20, 9), kEverywhere, kEverywhere);
  const MeanScores mean = mean_scores(std::vector<RegionScores>{empty, some});
  CHECK(mean.views == 1);
  CHECK(mean.raw.psnr == Approx(some.raw.psnr));
  CHECK(std::isnan(mean_scores(std::vector<RegionScores>{empty}).fitted.psnr));
}

TEST_CASE("the exposure gain of a darkened or brightened photograph is found") {
  const Photograph rendering = picture(64, 64, [](int x, int y, int) { return 20 + (x + 64 * y) % 100; });
  for (const double gain : {0.25, 0.5, 0.97, 1.0, 1.31, 2.0, 3.7}) {
    CAPTURE(gain);
    const Photograph photograph = apply_gain(rendering, gain);
    const double fitted = fit_gain(rendering, photograph, kEverywhere);
    // A hundred levels between 20 and 119 leave a gain less than half a level of play at each.
    CHECK(fitted == Approx(gain).epsilon(0.005));
    CHECK(psnr_after(rendering, photograph, fitted) == std::numeric_limits<double>::infinity());
  }
}

TEST_CASE("no gain on a fine grid beats the fitted gain") {
  for (const int strength : {10, 60, 120}) {
    const Photograph photograph = apply_gain(pattern(48, 32), 0.7);
    const Photograph rendering = disturbed_pattern(48, 32, strength);
    const RegionScores scores = score_region(rendering, photograph, kEverywhere, kEverywhere);
    CHECK(scores.fitted.psnr == psnr_after(rendering, photograph, scores.gain));
    for (double gain = 1 / kLargestGain; gain < kLargestGain; gain *= 1.003) {
      REQUIRE(psnr_after(rendering, photograph, gain) <= scores.fitted.psnr);
    }
  }
}

TEST_CASE("fitted PSNR is never below raw, and extreme exposures give a gain within bounds") {
  const std::vector<Photograph> pictures = {grey(20, 20, 0), grey(20, 20, 1), grey(20, 20, 255), pattern(20, 20),
                                            disturbed_pattern(20, 20, 100)};
  for (const Photograph& rendering : pictures) {
    for (const Photograph& photograph : pictures) {
      const RegionScores scores = score_region(rendering, photograph, kEverywhere, kEverywhere);
      CHECK(scores.fitted.psnr >= scores.raw.psnr);
      CHECK(scores.gain >= 1 / kLargestGain);
      CHECK(scores.gain <= kLargestGain);
    }
  }
}

TEST_CASE("a gain acts in linear light and a gain of 1 changes nothing") {
  const Photograph image = pattern(50, 50);
  CHECK(apply_gain(image, 1).rgb == image.rgb);
  // Linear light of sRGB 188 is .503: half of white, so twice 188 saturates and half of 255 is 188.
  CHECK(apply_gain(grey(1, 1, 255), 0.5).rgb[0] == 188);
  CHECK(apply_gain(grey(1, 1, 188), 2).rgb[0] == 255);
  CHECK(apply_gain(grey(1, 1, 200), 0).rgb[0] == 0);
  CHECK_THROWS_WITH(apply_gain(image, -1), "scores: gain is -1, must be finite and not negative");
}

TEST_CASE("the textured share counts masked pixels only") {
  const Photograph photograph = pattern(40, 20);
  Mask textured = left_half(40, 20);
  CHECK(score_region(photograph, photograph, kEverywhere, textured).textured == Approx(0.5));
  CHECK(score_region(photograph, photograph, left_half(40, 20), textured).textured == 1);
  CHECK(score_region(photograph, photograph, kEverywhere, kEverywhere).textured == 0);
}

TEST_CASE("a frame that is mostly empty does not read as textured, however well the mesh is") {
  const Photograph photograph = pattern(40, 20);
  CHECK(score_region(photograph, photograph, left_half(40, 20), left_half(40, 20)).textured == 1);
  const RegionScores frame = score_region(photograph, photograph, {}, left_half(40, 20));
  CHECK(frame.textured == Approx(0.5));
  CHECK(frame.pixels == 800);
  Photograph undistorted = photograph;  // the frame is what the lens shows
  undistorted.valid.assign(800, 255);
  std::fill_n(undistorted.valid.begin(), 400, std::uint8_t{0});
  CHECK(score_region(undistorted, undistorted, {}, left_half(40, 20)).pixels == 400);
  CHECK(score_region(undistorted, undistorted, {}, left_half(40, 20)).textured == Approx(0.5));
}

TEST_CASE("a method's frames have means of their own, also of views that see nothing of the mesh") {
  const Photograph photograph = pattern(40, 20);
  const Photograph rendering = disturbed_pattern(40, 20, 30);
  const auto view = [&](const Mask& mesh) {
    return ViewScores{score_region(rendering, photograph, {}, mesh), score_region(rendering, photograph, mesh, mesh)};
  };
  const std::vector<ViewScores> views = {view(left_half(40, 20)), view(Mask(800, 0))};
  const MethodScores means = method_scores(views);
  CHECK(means.mesh.views == 1);
  CHECK(means.mesh.textured == 1);
  CHECK(means.frame.views == 2);
  CHECK(means.frame.textured == Approx(0.25));
  CHECK(means.frame.raw.psnr == Approx(psnr(rendering, photograph, {})));
}

RegionScores view_of(std::size_t pixels, double raw_psnr, double textured) {
  RegionScores view;
  view.pixels = pixels;
  view.aligned_pixels = pixels;
  view.raw = {raw_psnr, 0.5};
  view.fitted = {raw_psnr + 1, 0.6};
  view.textured = textured;
  return view;
}

TEST_CASE("means are over views, the textured share over pixels, aligned only if all views have it") {
  std::vector<RegionScores> views = {view_of(100, 20, 1.0), view_of(300, 30, 0.0)};
  MeanScores mean = mean_scores(views);
  CHECK(mean.raw.psnr == Approx(25));
  CHECK(mean.fitted.psnr == Approx(26));
  CHECK(mean.fitted.ssim == Approx(0.6));
  CHECK(mean.textured == Approx(0.25));
  views[0].aligned = Scores{22, 0.7};
  CHECK_FALSE(mean_scores(views).aligned);
  views[1].aligned = Scores{32, 0.9};
  mean = mean_scores(views);
  REQUIRE(mean.aligned);
  CHECK(mean.aligned->psnr == Approx(27));
  CHECK(mean.aligned->ssim == Approx(0.8));
}

TEST_CASE("a view whose aligned pictures share no pixel leaves the mean of the others") {
  std::vector<RegionScores> views = {view_of(100, 20, 1.0), view_of(300, 30, 0.0)};
  views[0].aligned = Scores{22, 0.7};
  views[1].aligned = Scores{std::nan(""), std::nan("")};
  views[1].aligned_pixels = 0;
  const MeanScores mean = mean_scores(views);
  REQUIRE(mean.aligned);
  CHECK(mean.aligned->psnr == Approx(22));
}

TEST_CASE("one identical view does not make a mean infinite, only all of them do") {
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(mean_scores(std::vector<RegionScores>{view_of(1, infinity, 0), view_of(1, 30, 0)}).raw.psnr == Approx(90));
  CHECK(mean_scores(std::vector<RegionScores>{view_of(1, infinity, 0)}).raw.psnr == infinity);
}

TEST_CASE("scores are the same bits for any number of threads") {
  const Photograph photograph = pattern(301, 203);
  const Photograph rendering = disturbed_pattern(301, 203, 40);
  const RegionScores parallel = score_region(rendering, photograph, kEverywhere, kEverywhere);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const RegionScores serial = score_region(rendering, photograph, kEverywhere, kEverywhere);
  CHECK(parallel.raw.ssim == serial.raw.ssim);
  CHECK(parallel.fitted.ssim == serial.fitted.ssim);
  CHECK(parallel.raw.psnr == serial.raw.psnr);
  CHECK(parallel.gain == serial.gain);
}

TEST_CASE("pictures or masks of different sizes are refused by name") {
  const Photograph photograph = pattern(4, 3);
  CHECK_THROWS_WITH(psnr(pattern(3, 4), photograph, kEverywhere),
                    "scores: the rendering is 3x4, must be 4x3 as the photograph");
  CHECK_THROWS_WITH(ssim(photograph, photograph, Mask(11, 1)), "scores: the mask has 11 entries, must have 12");
  CHECK_THROWS_WITH(score_region(photograph, photograph, kEverywhere, Mask(5, 1)),
                    "scores: the textured mask has 5 entries, must have 12");
  CHECK_THROWS_WITH(fit_gain(Photograph{}, Photograph{}, kEverywhere),
                    "scores: the pictures have no pixels, must have at least one");
  Photograph cut = photograph;
  cut.rgb.pop_back();
  CHECK_THROWS_AS(psnr(cut, photograph, kEverywhere), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
