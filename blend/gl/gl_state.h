// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: saves and restores the GL state that drawing changes, in a context that another library may own.
#pragma once

#include <epoxy/gl.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lumatlas {

// Textures are bound to this unit while they are made, so that the shaders keep theirs.
inline constexpr GLuint kSpareUnit = 15;

// Returns whether a position can set its own depth in the current context, so that hidden fragments are discarded
// before they are shaded: in desktop OpenGL, and in OpenGL ES with EXT_clip_control. Otherwise the surface's shader
// writes gl_FragDepth.
[[nodiscard]] bool has_clip_control();
// Calls glClipControl, which has another name in OpenGL ES. The context must have it.
void set_clip_control(GLenum origin, GLenum depth);

// Takes note of the current context's state, sets what drawing and copying here expect, and puts everything back at the
// end of its life. What OpenGL has by number for several viewports is kept for the first one only.
class GlStateGuard {
 public:
  GlStateGuard();
  ~GlStateGuard();
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  struct Switch {
    GLenum name;
    GLboolean on;
  };
  struct Value {
    GLenum name;
    GLint value;
  };
  struct Unit {
    GLuint number;
    GLint flat, layered, sampler;  // textures of two dimensions, arrays of them
  };
  struct IndexedBuffer {
    GLint buffer;
    GLint64 start, size;
  };
  struct StencilFace {
    GLenum face;
    GLint function, reference, mask, write_mask, fail, depth_fail, pass;
  };
  using ColorMask = std::array<GLboolean, 4>;

  void note_draw_buffers();
  void note_units();
  void note_uniform_buffer();
  void set_defaults() const;
  void restore_bindings() const;

  bool desktop_, clip_control_;
  std::vector<Switch> switches_;
  std::vector<Value> pixel_stores_;
  std::vector<Unit> units_;
  std::vector<GLboolean> blends_;        // one per draw buffer
  std::vector<ColorMask> color_masks_;   // likewise
  std::array<StencilFace, 2> stencils_;  // front, back
  GLboolean depth_mask_ = GL_TRUE;
  GLint depth_function_ = 0, clip_origin_ = 0, clip_depth_ = 0, active_texture_ = 0;
  std::array<GLint, 2> polygon_mode_{};
  std::array<GLfloat, 2> depth_range_{};
  std::array<GLint, 4> viewport_{};
  GLint program_ = 0, vertex_array_ = 0, array_buffer_ = 0, copy_buffer_ = 0, pack_buffer_ = 0, unpack_buffer_ = 0;
  GLint uniform_buffer_ = 0, draw_framebuffer_ = 0, read_framebuffer_ = 0;
  std::array<IndexedBuffer, 2> indexed_buffers_;  // of the shaders' uniform blocks
};

}  // namespace lumatlas
