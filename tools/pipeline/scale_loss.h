// SPDX-License-Identifier: GPL-3.0-or-later
// What a store loses when its photographs are downscaled, measured in pictures: parts of its own photographs are drawn,
// each as if the store did not hold that photograph, before and after.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/egl_context.h"
#include "blend/renderer.h"

namespace lumatlas {

class ScaleLoss {
 public:
  // Draws from all the views of `full` with its own OpenGL context. Throws GlError where there is none, or where it has
  // no room for them.
  explicit ScaleLoss(const Snapshot& full);

  // Whether any part shows enough surface that other views show too.
  [[nodiscard]] bool can_tell() const { return !parts_.empty(); }

  // By how much the PSNR of `reduced`, dB, falls short of that of `full`, in the mean over the parts; below 0: it is
  // better. Pixels count that views of the store are blended for and that the photograph's own mask trusts. `reduced`
  // has the slots, surface and references of `full`. Throws std::logic_error unless can_tell(), and GlError as above.
  [[nodiscard]] double of(const Snapshot& reduced);

 private:
  // A part of a photograph: its camera sees just that.
  struct Part {
    std::uint32_t slot;
    Camera camera;
    std::vector<std::uint8_t> rgb;     // of the photograph
    std::vector<std::uint8_t> counts;  // by pixel, 1: the photograph is to be believed there
    double psnr = 0;                   // of the full store
  };
  [[nodiscard]] static Part part_of(const StoredView& view, std::uint32_t slot, std::size_t index);
  [[nodiscard]] double psnr(const Snapshot& snapshot, const Part& part, std::size_t& pixels);

  EglContext context_;
  Renderer renderer_;
  std::vector<Part> parts_;
};

}  // namespace lumatlas
