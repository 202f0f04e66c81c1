// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/kept_depths.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

constexpr double kMostSteps = std::numeric_limits<std::uint16_t>::max();
constexpr unsigned kPayload = 7;  // bits of a byte; the eighth says that another byte follows

bool is_measured(float depth) {
  return std::isfinite(depth) && depth > 0;
}

}  // namespace

RoundedDepth rounded_depth(std::span<const float> depth, double unit) {
  double farthest = 0;
  for (const float value : depth) {
    if (is_measured(value)) farthest = std::max(farthest, double{value});
  }
  RoundedDepth rounded{std::max(unit, farthest / kMostSteps), {}};
  rounded.steps.reserve(depth.size());
  for (const float value : depth) {
    const double steps = is_measured(value) ? std::clamp(std::round(value / rounded.unit), 1.0, kMostSteps) : 0;
    rounded.steps.push_back(static_cast<std::uint16_t>(steps));
  }
  return rounded;
}

std::vector<float> depths_of(const RoundedDepth& rounded) {
  std::vector<float> depth;
  depth.reserve(rounded.steps.size());
  for (const std::uint16_t steps : rounded.steps) depth.push_back(static_cast<float>(rounded.unit * steps));
  return depth;
}

// The unit, the number of pixels, and of each pixel the difference from the one before: small numbers of either sign in
// one byte.
std::vector<std::uint8_t> packed(const RoundedDepth& rounded) {
  const std::uint64_t count = rounded.steps.size();
  std::vector<std::uint8_t> bytes(sizeof rounded.unit + sizeof count);
  std::memcpy(bytes.data(), &rounded.unit, sizeof rounded.unit);
  std::memcpy(bytes.data() + sizeof rounded.unit, &count, sizeof count);
  bytes.reserve(bytes.size() + rounded.steps.size() * 3 / 2);
  int before = 0;
  for (const std::uint16_t steps : rounded.steps) {
    const int difference = steps - std::exchange(before, steps);
    auto rest = static_cast<std::uint32_t>(difference < 0 ? -2 * difference - 1 : 2 * difference);
    for (; rest >> kPayload != 0; rest >>= kPayload) bytes.push_back(static_cast<std::uint8_t>(rest | 1U << kPayload));
    bytes.push_back(static_cast<std::uint8_t>(rest));
  }
  return bytes;
}

RoundedDepth unpacked(std::span<const std::uint8_t> bytes) {
  RoundedDepth rounded;
  std::uint64_t count = 0;
  std::memcpy(&rounded.unit, bytes.data(), sizeof rounded.unit);
  std::memcpy(&count, bytes.data() + sizeof rounded.unit, sizeof count);
  rounded.steps.reserve(count);
  std::size_t at = sizeof rounded.unit + sizeof count;
  int before = 0;
  for (std::uint64_t pixel = 0; pixel < count; ++pixel) {
    std::uint32_t value = 0;
    for (unsigned shift = 0;; shift += kPayload) {
      const std::uint32_t byte = bytes[at++];
      value |= (byte & ((1U << kPayload) - 1)) << shift;
      if (byte >> kPayload == 0) break;
    }
    const int half = static_cast<int>((value + 1) / 2);
    before += value % 2 == 1 ? -half : half;
    rounded.steps.push_back(static_cast<std::uint16_t>(before));
  }
  return rounded;
}

KeptDepths::KeptDepths(std::filesystem::path folder, std::uint64_t memory_bytes, std::uint64_t most_bytes)
    : folder_(std::move(folder)), most_memory_(memory_bytes), most_bytes_(most_bytes) {}

std::optional<std::size_t> KeptDepths::keep(const RoundedDepth& image) {
  std::vector<std::uint8_t> image_bytes = packed(image);
  const std::size_t size = image_bytes.size();
  if (bytes() + size > most_bytes_) return std::nullopt;
  if (memory_bytes_ + size <= most_memory_) {
    memory_bytes_ += size;
    image_bytes.shrink_to_fit();
    places_.push_back({std::move(image_bytes), 0, size});
  } else {
    if (!write(image_bytes)) return std::nullopt;
    places_.push_back({{}, file_bytes_, size});
    file_bytes_ += size;
  }
  return places_.size() - 1;
}

// Writes at the end of the file, which is opened first.
bool KeptDepths::write(std::span<const std::uint8_t> bytes) {
  if (!entry_) {
    try {
      entry_.emplace(TemporaryEntry::Kind::file, folder_, [] { return random_temporary_name(); });
    } catch (const std::system_error&) {
      return false;
    }
    file_.open(entry_->path(), std::ios::binary | std::ios::in | std::ios::out);
  }
  file_.clear();
  file_.seekp(static_cast<std::streamoff>(file_bytes_));
  file_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file_.flush();
  return file_.good();
}

RoundedDepth KeptDepths::image(std::size_t number) {
  const Place& place = places_[number];
  if (!place.bytes.empty()) return unpacked(place.bytes);
  std::vector<std::uint8_t> bytes(place.size);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(place.offset));
  file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file_) throw InputError(folder_.string() + ": a depth image that was kept there cannot be read");
  return unpacked(bytes);
}

}  // namespace lumatlas
