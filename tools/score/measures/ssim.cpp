// SPDX-License-Identifier: GPL-3.0-or-later
// Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to structural similarity", 2004.
//
// Windows over a mask: equations 14 to 16 of the paper take any weights that sum to 1. So a window that reaches beyond
// the pixels that count keeps its Gaussian weights on those that do, divided by their sum. This is normalized
// convolution (Knutsson and Westin, "Normalized and differential convolution", 1993). Gao et al., "Monocular dynamic
// view synthesis: a reality check", 2022, mask SSIM the same way. Windows that lie wholly inside would leave thin parts
// and rims without a value, and SSIM would then speak of fewer pixels than PSNR.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tools/score/measures/counted_pixels.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

namespace {

constexpr int kRadius = 5;  // an 11x11 window: scikit-image's, sigma 1.5 cut off at 3.5 sigma
constexpr std::size_t kTaps = 2 * kRadius + 1;
constexpr double kC1 = (0.01 * 255) * (0.01 * 255);
constexpr double kC2 = (0.03 * 255) * (0.03 * 255);
using Kernel = std::array<double, kTaps>;

Kernel gaussian_kernel() {
  constexpr double kSigma = 1.5;
  Kernel kernel{};
  for (std::size_t tap = 0; tap < kTaps; ++tap) {
    const double x = static_cast<double>(tap) - kRadius;
    kernel[tap] = std::exp(-0.5 * x * x / (kSigma * kSigma));
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

// 0 where a pixel does not count.
std::vector<double> luma(const Photograph& image, const CountedPixels& counted) {
  std::vector<double> values(counted.size(), 0.0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, values.size(), 65536), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint8_t* const rgb = &image.rgb[3 * i];
      if (counted[i] != 0) values[i] = 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
    }
  });
  return values;
}

// The window sums that SSIM needs along one row. It takes both variances only as their sum, so four fields do, and the
// sum of the weights of pixels that count.
struct RowFields {
  explicit RowFields(std::size_t width) : x(width), y(width), squares(width), product(width), weight(width) {}
  [[nodiscard]] std::array<std::vector<double>*, 5> all() { return {&x, &y, &squares, &product, &weight}; }
  std::vector<double> x, y, squares, product, weight;
};

class SsimRows {
 public:
  // Keeps a reference to `counted`.
  SsimRows(const Photograph& a, const Photograph& b, const CountedPixels& counted)
      : width_(a.width),
        height_(a.height),
        counted_(counted),
        a_(luma(a, counted)),
        b_(luma(b, counted)),
        kernel_(gaussian_kernel()) {}

  // Sum of SSIM over the row's pixels that count. `columns` holds width + 2 kRadius values, for reuse.
  [[nodiscard]] double sum(std::size_t row, RowFields& columns) const {
    const std::uint8_t* const counted = &counted_[row * width_];
    filter_columns(row, columns);
    for (std::vector<double>* const field : columns.all()) reflect_ends(*field);
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
    for (std::vector<double>* const field : columns.all()) std::fill(field->begin(), field->end(), 0.0);
    for (std::size_t tap = 0; tap < kTaps; ++tap) {
      const std::size_t source = reflected(static_cast<std::int64_t>(row + tap) - kRadius, height_);
      add_row(source * width_, kernel_[tap], columns);
    }
  }

  void add_row(std::size_t first, double weight, RowFields& columns) const {
    const double* const a = &a_[first];
    const double* const b = &b_[first];
    const std::uint8_t* const counted = &counted_[first];
    double* const x = &columns.x[kRadius];
    double* const y = &columns.y[kRadius];
    double* const squares = &columns.squares[kRadius];
    double* const product = &columns.product[kRadius];
    double* const weights = &columns.weight[kRadius];
    for (std::size_t i = 0; i < width_; ++i) {
      x[i] += weight * a[i];
      y[i] += weight * b[i];
      squares[i] += weight * (a[i] * a[i] + b[i] * b[i]);
      product[i] += weight * (a[i] * b[i]);
      weights[i] += weight * counted[i];
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

  // The pixel must count: the window of another one may be empty, which gives NaN.
  [[nodiscard]] double ssim_at(const RowFields& columns, std::size_t column) const {
    const double weight = window(columns.weight, column);
    const double mean_x = window(columns.x, column) / weight;
    const double mean_y = window(columns.y, column) / weight;
    const double means = mean_x * mean_x + mean_y * mean_y;
    const double variances = window(columns.squares, column) / weight - means;
    const double covariance = window(columns.product, column) / weight - mean_x * mean_y;
    return (2 * mean_x * mean_y + kC1) * (2 * covariance + kC2) / ((means + kC1) * (variances + kC2));
  }

  std::size_t width_, height_;
  const CountedPixels& counted_;
  std::vector<double> a_, b_;
  Kernel kernel_;
};

}  // namespace

double ssim(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  const auto pixels = std::accumulate(counted.begin(), counted.end(), std::size_t{0});
  if (pixels == 0) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const SsimRows rows(rendering, photograph, counted);
  std::vector<double> row_sums(photograph.height, 0.0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, photograph.height, 16), [&](const auto& range) {
    RowFields columns(rows.padded_width());
    for (std::size_t row = range.begin(); row < range.end(); ++row) {
      const std::uint8_t* const counted_row = &counted[row * photograph.width];
      if (std::any_of(counted_row, counted_row + photograph.width, [](std::uint8_t c) { return c != 0; })) {
        row_sums[row] = rows.sum(row, columns);
      }
    }
  });
  return std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / static_cast<double>(pixels);
}

}  // namespace lumatlas
