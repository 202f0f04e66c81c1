// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the programs that pictures are drawn with, made from the files in shaders/ when first asked for.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

enum class Pass : std::uint8_t {
  surface,      // what is visible
  silhouettes,  // which pixels get samples
  blend,        // of the middles of pixels
  samples,      // of the means over samples
  diagnose,
  present,  // into the caller's framebuffer
};

// What is compiled in. The passes that do not ask for it have 0 and false.
struct ProgramKey {
  Pass pass;
  std::uint32_t views = 0;  // K
  std::uint32_t cells = 0;  // of a zone: 1, 2 or 4
  bool linear = false;      // linear light in place of sRGB
  bool cubic = false;       // some level of the photographs is sampled so

  // clang-tidy 14 takes the 0 in a defaulted comparison for a pointer.
  [[nodiscard]] auto operator<=>(const ProgramKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

// Where the shaders' samplers are bound, by the names that they have there.
enum class TextureUnit : std::uint8_t { photographs, depths, surfaces, zones, cells, references, views, tile_slots };

// `#define` lines of the numbers that the shaders have in common with C++, the same for every pass.
[[nodiscard]] std::string shared_definitions();

// Whether a position can say how deep it lies, so that what is behind is left out before it is shaded. Desktop OpenGL
// has it; what OpenGL ES writes instead is gl_FragDepth.
[[nodiscard]] bool has_clip_control();

inline constexpr GLuint kPictureBinding = 0;  // of the uniform block of shaders/picture.glsl

class ShaderPrograms {
 public:
  // Throws GlError with the compiler's log.
  [[nodiscard]] GLuint get(const ProgramKey& key);

 private:
  std::map<ProgramKey, GlProgram> programs_;
};

}  // namespace lumatlas
