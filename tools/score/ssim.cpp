// SPDX-License-Identifier: GPL-3.0-or-later
// Wang, Bovik, Sheikh, Simoncelli, "Image quality assessment: from error visibility to structural similarity", 2004.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "tools/score/counted_pixels.h"
#include "tools/score/scores.h"

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

}  // namespace

double ssim(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  const auto pixels = std::accumulate(counted.begin(), counted.end(), std::size_t{0});
  if (pixels == 0) {
    return std::numeric_limits<double>::quiet_NaN();
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

}  // namespace lumatlas
