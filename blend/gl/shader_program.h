// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: the programs that pictures are drawn with, made from the files in shaders/ when first asked for.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

enum class Pass : std::uint8_t {
  surface,       // the visible surface
  silhouettes,   // which pixels get samples
  outline_rows,  // the least depths along rows
  outlines,      // surfaces, continued past their outlines
  blend,         // colours at the middles of pixels
  samples,       // means over samples
  edges,         // the variances of the blur at depth edges
  edge_rows,     // their spread along rows
  soft_edges,    // their spread along columns, and the blurred picture
  diagnose,
  present,  // into the caller's framebuffer
};

enum class Output : std::uint8_t {
  srgb,     // 8 bits a channel
  linear,   // linear light
  fetches,  // how many texels were fetched
};

// The settings that are compiled in. Passes that do not use one have 0 or false there.
struct ProgramKey {
  Pass pass;
  std::uint32_t views = 0;  // K
  std::uint32_t cells = 0;  // cells that fade in a zone: 1, 2 or 4
  Output output = Output::srgb;
  bool cubic = false;           // some level of the photographs is sampled so
  bool views_in_block = false;  // the views are in a uniform block in place of a texture
  bool filtered_taps = false;   // texels of photographs are fetched in pairs
  bool raw_texels = false;      // the shader decodes colours of photographs, see ArrayTextures::raw_texels
  bool host_depth = false;      // the depths of the caller's framebuffer are written

  // clang-tidy 14 takes the 0 in a defaulted comparison for a pointer.
  [[nodiscard]] auto operator<=>(const ProgramKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

// The texture units of the shaders' samplers, named as there.
enum class TextureUnit : std::uint8_t {
  photographs,
  depths,
  surfaces,
  zones,
  cells,
  references,
  views,
  tile_slots,
  middles,
  middle_colors,
  raw_texels
};
inline constexpr auto kLastUnit = TextureUnit::raw_texels;

// `#define` lines of the numbers that the shaders have in common with C++, the same for every pass.
[[nodiscard]] std::string shared_definitions();

// The uniform blocks of shaders/picture.glsl and shaders/tables.glsl.
inline constexpr GLuint kPictureBinding = 0, kViewsBinding = 1;
inline constexpr std::array kBlockBindings{kPictureBinding, kViewsBinding};

class ShaderPrograms {
 public:
  // Throws GlError with the compiler's log.
  [[nodiscard]] GLuint get(const ProgramKey& key);
  [[nodiscard]] bool has(const ProgramKey& key) const { return programs_.contains(key); }
  // Makes all that are not there yet, at the same time where the driver compiles on several threads. Throws as get().
  void make(std::span<const ProgramKey> keys);
  // Returns how many there are.
  [[nodiscard]] std::size_t count() const { return programs_.size(); }

 private:
  GLuint add(const ProgramKey& key, PendingProgram pending);

  std::map<ProgramKey, GlProgram> programs_;
};

}  // namespace lumatlas
