// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/scale_loss.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "tools/base/interrupt.h"

namespace lumatlas {

namespace {

constexpr std::size_t kMostParts = 24;
constexpr std::uint32_t kPartPx = 192;       // side
constexpr std::uint8_t kLeastTrust = 128;    // of StoredView::trust
constexpr double kLeastShare = 0.2;          // of a part's pixels that must be comparable
constexpr double kLeastSquaredError = 1e-3;  // squared 8-bit levels, so that equal pictures have a PSNR

// The fractional parts of multiples of an irrational number are spread evenly however many they are.
double spread(std::size_t index, double step) {
  double whole = 0;
  return std::modf(0.5 + step * static_cast<double>(index), &whole);
}

Snapshot without_references_to(Snapshot snapshot, std::uint32_t slot) {
  ReferenceTable kept;
  for (std::size_t cell = 0; cell + 1 < snapshot.references.offsets.size(); ++cell) {
    for (const std::uint32_t other : snapshot.references.of_cell(cell)) {
      if (other != slot) kept.views.push_back(other);
    }
    kept.offsets.push_back(static_cast<std::uint32_t>(kept.views.size()));
  }
  snapshot.references = std::move(kept);
  return snapshot;
}

}  // namespace

ScaleLoss::Part ScaleLoss::part_of(const StoredView& view, std::uint32_t slot, std::size_t index) {
  // Reciprocals of the plastic number and of its square, for points of the plane.
  constexpr double kAcross = 0.7548776662466927, kDown = 0.5698402909980532;
  const Camera& whole = view.camera;
  Part part{slot, whole, {}, {}};
  part.camera.width = std::min(kPartPx, whole.width);
  part.camera.height = std::min(kPartPx, whole.height);
  const auto left = static_cast<std::uint32_t>(spread(index, kAcross) * (whole.width - part.camera.width + 1));
  const auto top = static_cast<std::uint32_t>(spread(index, kDown) * (whole.height - part.camera.height + 1));
  part.camera.cx -= left;
  part.camera.cy -= top;
  for (std::uint32_t y = 0; y < part.camera.height; ++y) {
    for (std::uint32_t x = 0; x < part.camera.width; ++x) {
      const std::size_t pixel = std::size_t{top + y} * whole.width + left + x;
      const auto rgb = view.photograph.rgb.begin() + static_cast<std::ptrdiff_t>(3 * pixel);
      part.rgb.insert(part.rgb.end(), rgb, rgb + 3);
      const bool in_lens = view.photograph.valid.empty() || view.photograph.valid[pixel] != 0;
      part.counts.push_back(in_lens && (view.trust.empty() || view.trust[pixel] >= kLeastTrust) ? 1 : 0);
    }
  }
  return part;
}

ScaleLoss::ScaleLoss(const Snapshot& full) {
  std::vector<std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < full.views.size(); ++slot) {
    if (full.views[slot]) slots.push_back(slot);
  }
  const std::size_t count = std::min(slots.size(), kMostParts);
  for (std::size_t i = 0; i < count; ++i) {
    throw_if_interrupted();
    const std::uint32_t slot = slots[i * slots.size() / count];
    Part part = part_of(*full.views[slot], slot, i);
    std::size_t pixels = 0;
    part.psnr = psnr(full, part, pixels);
    if (static_cast<double>(pixels) >= kLeastShare * static_cast<double>(part.counts.size())) {
      parts_.push_back(std::move(part));
    }
  }
}

// Over the pixels that count and that views of the store are blended for; `pixels`: how many.
double ScaleLoss::psnr(const Snapshot& snapshot, const Part& part, std::size_t& pixels) {
  renderer_.load(without_references_to(snapshot, part.slot));
  const Rendering drawn = renderer_.render(part.camera, {});
  double sum = 0;
  pixels = 0;
  for (std::size_t pixel = 0; pixel < part.counts.size(); ++pixel) {
    if (part.counts[pixel] == 0 || drawn.state[pixel] != PixelState::textured) continue;
    ++pixels;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double difference = int{drawn.picture.rgb[3 * pixel + channel]} - int{part.rgb[3 * pixel + channel]};
      sum += difference * difference;
    }
  }
  const double mean = sum / (3 * static_cast<double>(std::max<std::size_t>(pixels, 1)));
  return 10 * std::log10(255.0 * 255.0 / std::max(mean, kLeastSquaredError));
}

double ScaleLoss::of(const Snapshot& reduced) {
  if (parts_.empty()) throw std::logic_error("scale loss: no photograph shows what others show");
  double sum = 0;
  for (const Part& part : parts_) {
    throw_if_interrupted();
    std::size_t pixels = 0;
    sum += part.psnr - psnr(reduced, part, pixels);
  }
  return sum / static_cast<double>(parts_.size());
}

}  // namespace lumatlas
