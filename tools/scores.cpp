// SPDX-License-Identifier: GPL-3.0-or-later
// Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to structural similarity", 2004.
#include "tools/scores.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace lumatlas {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_size(const char* what, std::size_t size, std::size_t expected) {
  if (size != expected) {
    throw std::invalid_argument(std::string("scores: ") + what + " has " + std::to_string(size) +
                                " entries, must have " + std::to_string(expected));
  }
}

void check_pictures(const Photograph& rendering, const Photograph& photograph) {
  if (rendering.width != photograph.width || rendering.height != photograph.height) {
    throw std::invalid_argument("scores: the rendering is " + std::to_string(rendering.width) + "x" +
                                std::to_string(rendering.height) + ", must be " + std::to_string(photograph.width) +
                                "x" + std::to_string(photograph.height) + " as the photograph");
  }
  const std::size_t pixels = std::size_t{photograph.width} * photograph.height;
  if (pixels == 0) {
    throw std::invalid_argument("scores: the pictures have no pixels, must have at least one");
  }
  check_size("the rendering's rgb", rendering.rgb.size(), 3 * pixels);
  check_size("the photograph's rgb", photograph.rgb.size(), 3 * pixels);
  if (!photograph.valid.empty()) {
    check_size("the photograph's valid", photograph.valid.size(), pixels);
  }
}

// One entry per pixel, 1 where it counts.
using Counted = std::vector<std::uint8_t>;

Counted counted_pixels(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  check_pictures(rendering, photograph);
  const std::size_t pixels = std::size_t{photograph.width} * photograph.height;
  if (!mask.empty()) {
    check_size("the mask", mask.size(), pixels);
  }
  Counted counted(pixels, 1);
  for (std::size_t i = 0; i < pixels; ++i) {
    const bool masked = mask.empty() || mask[i] != 0;
    const bool inside = photograph.valid.empty() || photograph.valid[i] != 0;
    counted[i] = masked && inside ? 1 : 0;
  }
  return counted;
}

// ---- PSNR and exposure -------------------------------------------------------------------------------------------

using LevelTable = std::array<std::uint8_t, 256>;  // what becomes of each 8-bit level

// All that the square error of any level table depends on: a gain treats equal levels equally, so the pictures need to
// be read only once. Whole numbers: exact in any order of summation.
struct LevelSums {
  std::array<std::int64_t, 256> count{};      // of values in the rendering, by level
  std::array<std::int64_t, 256> photo_sum{};  // of the photograph's values there
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

LevelSums level_sums(const Photograph& rendering, const Photograph& photograph, const Counted& counted) {
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

double linear_from_srgb(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
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

// ---- SSIM --------------------------------------------------------------------------------------------------------

constexpr int kRadius = 5;  // an 11x11 window: scikit-image's, sigma 1.5 cut off at 3.5 sigma
constexpr std::size_t kTaps = 2 * kRadius + 1;
constexpr double kC1 = (0.01 * 255) * (0.01 * 255);
constexpr double kC2 = (0.03 * 255) * (0.03 * 255);
using Kernel = std::array<double, kTaps>;

Kernel gaussian_kernel() {
  constexpr double kSigma = 1.5;
  Kernel kernel{};
  for (int i = -kRadius; i <= kRadius; ++i) {
    kernel[static_cast<std::size_t>(i + kRadius)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  }
  const double sum = std::accumulate(kernel.begin(), kernel.end(), 0.0);
  for (double& weight : kernel) {
    weight /= sum;
  }
  return kernel;
}

// Index into [0, size) for one that may lie beyond either end: reflected, the edge repeated (d c b a | a b c d | d c b
// a).
std::size_t reflected(std::int64_t index, std::size_t size) {
  const auto period = static_cast<std::int64_t>(2 * size);
  const std::int64_t folded = ((index % period) + period) % period;
  return static_cast<std::size_t>(std::min(folded, period - 1 - folded));
}

std::vector<double> luma(const Photograph& image) {
  std::vector<double> values(std::size_t{image.width} * image.height);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, values.size(), 65536), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint8_t* const rgb = &image.rgb[3 * i];
      values[i] = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
    }
  });
  return values;
}

// The window sums that SSIM needs along one row. It takes both variances only as their sum, so four fields do.
struct RowFields {
  explicit RowFields(std::size_t width) : x(width), y(width), squares(width), product(width) {}
  std::vector<double> x, y, squares, product;
};

class SsimRows {
 public:
  SsimRows(const Photograph& a, const Photograph& b)
      : width_(a.width), height_(a.height), a_(luma(a)), b_(luma(b)), kernel_(gaussian_kernel()) {}

  // Sum of SSIM over the row's pixels that count. `columns` holds width + 2 kRadius values, for reuse.
  [[nodiscard]] double sum(std::size_t row, const std::uint8_t* counted, RowFields& columns) const {
    filter_columns(row, columns);
    for (std::vector<double>* const field : {&columns.x, &columns.y, &columns.squares, &columns.product}) {
      reflect_ends(*field);
    }
    double total = 0;
    constexpr std::size_t kBlock = 64;
    for (std::size_t first = 0; first < width_; first += kBlock) {
      std::array<double, kBlock> values;
      const std::size_t size = std::min(kBlock, width_ - first);
      for (std::size_t i = 0; i < size; ++i) {
        values[i] = ssim_at(columns, first + i);
      }
      for (std::size_t i = 0; i < size; ++i) {
        total += counted[first + i] != 0 ? values[i] : 0;
      }
    }
    return total;
  }
  [[nodiscard]] std::size_t padded_width() const { return width_ + 2 * kRadius; }

 private:
  void filter_columns(std::size_t row, RowFields& columns) const {
    for (std::vector<double>* const field : {&columns.x, &columns.y, &columns.squares, &columns.product}) {
      std::fill(field->begin(), field->end(), 0.0);
    }
    for (std::size_t tap = 0; tap < kTaps; ++tap) {
      const std::size_t source = reflected(static_cast<std::int64_t>(row + tap) - kRadius, height_);
      add_row(&a_[source * width_], &b_[source * width_], kernel_[tap], columns);
    }
  }

  void add_row(const double* a, const double* b, double weight, RowFields& columns) const {
    double* const x = &columns.x[kRadius];
    double* const y = &columns.y[kRadius];
    double* const squares = &columns.squares[kRadius];
    double* const product = &columns.product[kRadius];
    for (std::size_t i = 0; i < width_; ++i) {
      x[i] += weight * a[i];
      y[i] += weight * b[i];
      squares[i] += weight * (a[i] * a[i] + b[i] * b[i]);
      product[i] += weight * (a[i] * b[i]);
    }
  }

  void reflect_ends(std::vector<double>& field) const {
    for (int i = 1; i <= kRadius; ++i) {
      field[static_cast<std::size_t>(kRadius - i)] = field[kRadius + reflected(-i, width_)];
      const std::size_t beyond = width_ + static_cast<std::size_t>(i) - 1;
      field[kRadius + beyond] = field[kRadius + reflected(static_cast<std::int64_t>(beyond), width_)];
    }
  }

  [[nodiscard]] double window(const std::vector<double>& field, std::size_t column) const {
    double sum = 0;
    for (std::size_t tap = 0; tap < kTaps; ++tap) {
      sum += kernel_[tap] * field[column + tap];
    }
    return sum;
  }

  [[nodiscard]] double ssim_at(const RowFields& columns, std::size_t column) const {
    const double mean_x = window(columns.x, column);
    const double mean_y = window(columns.y, column);
    const double means = mean_x * mean_x + mean_y * mean_y;
    const double variances = window(columns.squares, column) - means;
    const double covariance = window(columns.product, column) - mean_x * mean_y;
    return (2 * mean_x * mean_y + kC1) * (2 * covariance + kC2) / ((means + kC1) * (variances + kC2));
  }

  std::size_t width_, height_;
  std::vector<double> a_, b_;
  Kernel kernel_;
};

double ssim_over(const Photograph& rendering, const Photograph& photograph, const Counted& counted) {
  const auto pixels = std::accumulate(counted.begin(), counted.end(), std::size_t{0});
  if (pixels == 0) {
    return kNaN;
  }
  const SsimRows rows(rendering, photograph);
  std::vector<double> row_sums(photograph.height, 0.0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, photograph.height, 16), [&](const auto& range) {
    RowFields columns(rows.padded_width());
    for (std::size_t row = range.begin(); row < range.end(); ++row) {
      const std::uint8_t* const counted_row = &counted[row * photograph.width];
      if (std::any_of(counted_row, counted_row + photograph.width, [](std::uint8_t c) { return c != 0; })) {
        row_sums[row] = rows.sum(row, counted_row, columns);
      }
    }
  });
  return std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / static_cast<double>(pixels);
}

double share(std::span<const std::uint8_t> textured, const Counted& counted) {
  std::size_t pixels = 0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    pixels += counted[i];
    covered += counted[i] != 0 && !textured.empty() && textured[i] != 0 ? 1 : 0;
  }
  return pixels == 0 ? kNaN : static_cast<double>(covered) / static_cast<double>(pixels);
}

// ---- Means -------------------------------------------------------------------------------------------------------

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
  const Counted counted = counted_pixels(rendering, photograph, mask);
  return psnr_of(level_sums(rendering, photograph, counted), gain_table(1));
}

double ssim(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  return ssim_over(rendering, photograph, counted_pixels(rendering, photograph, mask));
}

double fit_gain(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  const Counted counted = counted_pixels(rendering, photograph, mask);
  return fit_gain_to(level_sums(rendering, photograph, counted));
}

Photograph apply_gain(const Photograph& image, double gain) {
  if (!(std::isfinite(gain) && gain >= 0)) {
    throw std::invalid_argument("scores: gain is " + std::to_string(gain) + ", must be finite and not negative");
  }
  return through_table(image, gain_table(gain));
}

ViewScores score_view(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask,
                      std::span<const std::uint8_t> textured) {
  const Counted counted = counted_pixels(rendering, photograph, mask);
  if (!textured.empty()) {
    check_size("the textured mask", textured.size(), counted.size());
  }
  const LevelSums sums = level_sums(rendering, photograph, counted);
  ViewScores scores;
  scores.pixels = std::accumulate(counted.begin(), counted.end(), std::size_t{0});
  scores.raw = {psnr_of(sums, gain_table(1)), ssim_over(rendering, photograph, counted)};
  scores.gain = fit_gain_to(sums);
  scores.fitted = scores.raw;
  if (scores.gain != 1) {
    const LevelTable table = gain_table(scores.gain);
    scores.fitted = {psnr_of(sums, table), ssim_over(through_table(rendering, table), photograph, counted)};
  }
  scores.textured = share(textured, counted);
  return scores;
}

MethodScores mean_scores(std::span<const ViewScores> views) {
  std::vector<Scores> raw, fitted, aligned;
  double pixels = 0;
  double textured = 0;
  for (const ViewScores& view : views) {
    if (view.pixels == 0) {
      continue;
    }
    raw.push_back(view.raw);
    fitted.push_back(view.fitted);
    if (view.aligned) {
      aligned.push_back(*view.aligned);
    }
    pixels += static_cast<double>(view.pixels);
    textured += view.textured * static_cast<double>(view.pixels);
  }
  MethodScores mean{raw.size(), mean_of(raw), mean_of(fitted), {}, raw.empty() ? kNaN : textured / pixels};
  if (!aligned.empty() && aligned.size() == raw.size()) {
    mean.aligned = mean_of(aligned);
  }
  return mean;
}

}  // namespace lumatlas
