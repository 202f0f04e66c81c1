// SPDX-License-Identifier: GPL-3.0-or-later
// A small apartment of sharp photographs with exact poses, and the same with other photographs.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "atlas/images/photograph.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas {

inline void write_apartment(const std::filesystem::path& folder, std::uint32_t views, std::uint32_t triangles = 3000) {
  SynthOptions options;
  options.views = views;
  options.width = 96;
  options.height = 72;
  options.samples = 8;
  options.triangles = triangles;
  write_synthetic_scene(options, folder);
}

// An apartment of 16 views of 96 x 72.
inline const std::filesystem::path& sharp_scene() {
  static const TemporaryFolder folder;
  static const bool made = (write_apartment(folder.path(), 16), true);
  REQUIRE(made);
  return folder.path();
}

// A scene with other photographs.
inline void write_changed(const std::filesystem::path& scene, const std::filesystem::path& folder,
                          const std::function<void(Photograph&)>& change) {
  std::filesystem::copy(scene, folder, std::filesystem::copy_options::recursive);
  for (const auto& file : std::filesystem::directory_iterator(folder / "images")) {
    Photograph photograph = read_photograph(file.path());
    change(photograph);
    write_image(file.path(), photograph);
  }
}

// Every value is the mean of its surroundings, five pixels wide.
inline void blur(Photograph& photograph) {
  const Photograph sharp = photograph;
  const auto width = std::ptrdiff_t{sharp.width}, height = std::ptrdiff_t{sharp.height};
  const auto place = [&](std::ptrdiff_t x, std::ptrdiff_t y, std::ptrdiff_t channel) {
    return static_cast<std::size_t>(3 * (y * width + x) + channel);
  };
  for (std::ptrdiff_t y = 0; y < height; ++y) {
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      for (std::ptrdiff_t channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (std::ptrdiff_t dy = -2; dy <= 2; ++dy) {
          for (std::ptrdiff_t dx = -2; dx <= 2; ++dx) {
            const std::ptrdiff_t row = std::clamp<std::ptrdiff_t>(y + dy, 0, height - 1);
            sum += sharp.rgb[place(std::clamp<std::ptrdiff_t>(x + dx, 0, width - 1), row, channel)];
          }
        }
        photograph.rgb[place(x, y, channel)] = static_cast<std::uint8_t>(sum / 25);
      }
    }
  }
}

}  // namespace lumatlas
