// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/scores.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/images/srgb.h"
#include "mesh/base/number_text.h"
#include "tools/score/measures/counted_pixels.h"

namespace lumatlas {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using LevelTable = std::array<std::uint8_t, 256>;  // new value of each 8-bit level

// All that the square error of any level table depends on: a gain treats equal levels equally, so the pictures need to
// be read only once. Whole numbers: exact in any order of summation.
struct LevelSums {
  std::array<std::int64_t, 256> count{};      // values in the rendering, one per level
  std::array<std::int64_t, 256> photo_sum{};  // sum of the photograph's values there
  std::int64_t photo_squares = 0;

  void add(std::uint8_t rendered, std::uint8_t photographed) {
    ++count[rendered];
    photo_sum[rendered] += photographed;
    photo_squares += int{photographed} * photographed;
  }
  [[nodiscard]] LevelSums operator+(const LevelSums& other) const {
    LevelSums sum = *this;
    for (std::size_t level = 0; level < 256; ++level) {
      sum.count[level] += other.count[level];
      sum.photo_sum[level] += other.photo_sum[level];
    }
    sum.photo_squares += other.photo_squares;
    return sum;
  }
  [[nodiscard]] std::int64_t values() const { return std::accumulate(count.begin(), count.end(), std::int64_t{0}); }
  [[nodiscard]] std::int64_t square_error(const LevelTable& table) const {
    std::int64_t error = photo_squares;
    for (std::size_t level = 0; level < 256; ++level) {
      const std::int64_t value = table[level];
      error += value * value * count[level] - 2 * value * photo_sum[level];
    }
    return error;
  }
};

LevelSums level_sums(const Photograph& rendering, const Photograph& photograph, const CountedPixels& counted) {
  constexpr std::size_t kGrain = 65536;
  const auto add_range = [&](const tbb::blocked_range<std::size_t>& range, LevelSums sums) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      for (std::size_t value = 3 * i; counted[i] != 0 && value < 3 * i + 3; ++value) {
        sums.add(rendering.rgb[value], photograph.rgb[value]);
      }
    }
    return sums;
  };
  return tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, counted.size(), kGrain), LevelSums{}, add_range,
                              [](const LevelSums& a, const LevelSums& b) { return a + b; });
}

double psnr_of(const LevelSums& sums, const LevelTable& table) {
  const std::int64_t values = sums.values();
  if (values == 0) {
    return kNaN;
  }
  const std::int64_t error = sums.square_error(table);
  return error == 0 ? kInfinity
                    : 10 * std::log10(255.0 * 255.0 * static_cast<double>(values) / static_cast<double>(error));
}

struct SrgbLevels {
  std::array<double, 256> linear{};  // linear light of each level
  std::array<double, 256> edge{};    // linear light from which on a level is rounded to; edge[0] is 0
};

const SrgbLevels& srgb_levels() {
  static const SrgbLevels levels = [] {
    SrgbLevels made;
    for (std::size_t level = 0; level < 256; ++level) {
      made.linear[level] = linear_from_srgb(static_cast<double>(level) / 255);
      made.edge[level] = level == 0 ? 0 : linear_from_srgb((static_cast<double>(level) - 0.5) / 255);
    }
    return made;
  }();
  return levels;
}

LevelTable gain_table(double gain) {
  const SrgbLevels& levels = srgb_levels();
  LevelTable table{};
  for (std::size_t level = 0; level < 256; ++level) {
    const double light = gain * levels.linear[level];
    const auto above = std::upper_bound(levels.edge.begin(), levels.edge.end(), light);
    table[level] = static_cast<std::uint8_t>(above - levels.edge.begin() - 1);
  }
  return table;
}

// A gain at which a level of the rendering moves up to the next output level.
struct GainStep {
  double gain;
  std::uint8_t level;
};

std::vector<GainStep> gain_steps(const LevelSums& sums) {
  const SrgbLevels& levels = srgb_levels();
  std::vector<GainStep> steps;
  for (std::size_t level = 1; level < 256; ++level) {
    for (std::size_t output = 1; sums.count[level] != 0 && output < 256; ++output) {
      const double gain = levels.edge[output] / levels.linear[level];
      if (gain > 1 / kLargestGain && gain < kLargestGain) {
        steps.push_back({gain, static_cast<std::uint8_t>(level)});
      }
    }
  }
  std::sort(steps.begin(), steps.end(), [](const GainStep& a, const GainStep& b) {
    return a.gain != b.gain ? a.gain < b.gain : a.level < b.level;
  });
  return steps;
}

struct GainRange {
  double low = 1 / kLargestGain;
  double high = kLargestGain;
};

// Narrower than this, a range is rounding: two steps at the same gain.
constexpr double kNarrowestRange = 1e-9;

// The square error changes only at the steps, each time by a term that needs no look at the other levels.
GainRange best_gain_range(const LevelSums& sums) {
  const std::vector<GainStep> steps = gain_steps(sums);
  LevelTable table = gain_table(1 / kLargestGain);
  std::int64_t error = sums.square_error(table);
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  GainRange best;
  GainRange range;
  for (std::size_t i = 0; i <= steps.size(); ++i) {
    range.high = i < steps.size() ? steps[i].gain : kLargestGain;
    if (error < least && range.high > range.low * (1 + kNarrowestRange)) {
      least = error;
      best = range;
    }
    if (i < steps.size()) {
      const std::uint8_t level = steps[i].level;
      error += (2 * std::int64_t{table[level]} + 1) * sums.count[level] - 2 * sums.photo_sum[level];
      ++table[level];
      range.low = range.high;
    }
  }
  return best;
}

// A range that ends at the limit of the search has no middle worth its name: there, just inside its other end.
double gain_within(const GainRange& range) {
  if (range.low <= 1 && 1 < range.high) {
    return 1;
  }
  constexpr double kJustInside = 1 + kNarrowestRange / 2;
  if (range.high == kLargestGain) {
    return range.low * kJustInside;
  }
  if (range.low == 1 / kLargestGain) {
    return range.high / kJustInside;
  }
  return std::sqrt(range.low * range.high);
}

double fit_gain_to(const LevelSums& sums) {
  return gain_within(best_gain_range(sums));
}

Photograph through_table(const Photograph& image, const LevelTable& table) {
  Photograph result = image;
  for (std::uint8_t& value : result.rgb) {
    value = table[value];
  }
  return result;
}

// Returns the share of the counted pixels that are textured.
double textured_share(std::span<const std::uint8_t> textured, const CountedPixels& counted) {
  std::size_t pixels = 0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    pixels += counted[i];
    covered += counted[i] != 0 && !textured.empty() && textured[i] != 0 ? 1 : 0;
  }
  return pixels == 0 ? kNaN : static_cast<double>(covered) / static_cast<double>(pixels);
}

Scores mean_of(const std::vector<Scores>& all) {
  if (all.empty()) {
    return {kNaN, kNaN};
  }
  const bool identical = std::all_of(all.begin(), all.end(), [](const Scores& s) { return s.psnr == kInfinity; });
  Scores mean;
  for (const Scores& scores : all) {
    mean.psnr += std::min(scores.psnr, kPsnrOfIdentical) / static_cast<double>(all.size());
    mean.ssim += scores.ssim / static_cast<double>(all.size());
  }
  if (identical) {
    mean.psnr = kInfinity;
  }
  return mean;
}

}  // namespace

double psnr(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  return psnr_of(level_sums(rendering, photograph, counted), gain_table(1));
}

double fit_gain(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  return fit_gain_to(level_sums(rendering, photograph, counted));
}

Photograph apply_gain(const Photograph& image, double gain) {
  if (!(std::isfinite(gain) && gain >= 0)) {
    throw std::invalid_argument("scores: gain is " + number_text(gain) + ", must be finite and not negative");
  }
  return through_table(image, gain_table(gain));
}

RegionScores score_region(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask,
                          std::span<const std::uint8_t> textured) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  if (!textured.empty()) {
    check_entries("the textured mask", textured.size(), counted.size());
  }
  const LevelSums sums = level_sums(rendering, photograph, counted);
  RegionScores scores;
  scores.pixels = std::accumulate(counted.begin(), counted.end(), std::size_t{0});
  scores.raw = {psnr_of(sums, gain_table(1)), ssim(rendering, photograph, counted)};
  scores.gain = fit_gain_to(sums);
  scores.fitted = scores.raw;
  if (scores.gain != 1) {
    const LevelTable table = gain_table(scores.gain);
    scores.fitted = {psnr_of(sums, table), ssim(through_table(rendering, table), photograph, counted)};
  }
  scores.textured = textured_share(textured, counted);
  return scores;
}

MeanScores mean_scores(std::span<const RegionScores> views) {
  std::vector<Scores> raw, fitted, aligned;
  bool all_aligned = true;
  double pixels = 0;
  double textured = 0;
  for (const RegionScores& view : views) {
    if (view.pixels == 0) {
      continue;
    }
    raw.push_back(view.raw);
    fitted.push_back(view.fitted);
    all_aligned = all_aligned && view.aligned;
    if (view.aligned && view.aligned_pixels > 0) {
      aligned.push_back(*view.aligned);
    }
    pixels += static_cast<double>(view.pixels);
    textured += view.textured * static_cast<double>(view.pixels);
  }
  MeanScores mean{raw.size(), mean_of(raw), mean_of(fitted), {}, raw.empty() ? kNaN : textured / pixels};
  if (!raw.empty() && all_aligned) mean.aligned = mean_of(aligned);
  return mean;
}

MethodScores method_scores(std::span<const ViewScores> views) {
  std::vector<RegionScores> frames, meshes;
  for (const ViewScores& view : views) {
    frames.push_back(view.frame);
    meshes.push_back(view.mesh);
  }
  return {mean_scores(frames), mean_scores(meshes)};
}

}  // namespace lumatlas
