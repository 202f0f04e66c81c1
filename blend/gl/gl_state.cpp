// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/gl_state.h"

#include <initializer_list>

#include "blend/gl/gl_objects.h"
#include "blend/gl/shader_program.h"

namespace lumatlas {

namespace {

// All off while something is drawn here, but where the renderer turns one on.
constexpr std::array<GLenum, 9> kSwitches{
    GL_CULL_FACE,          GL_SCISSOR_TEST, GL_POLYGON_OFFSET_FILL, GL_SAMPLE_COVERAGE, GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_RASTERIZER_DISCARD, GL_DITHER,       GL_STENCIL_TEST,        GL_DEPTH_TEST};
constexpr std::array<GLenum, 5> kDesktopSwitches{GL_FRAMEBUFFER_SRGB, GL_COLOR_LOGIC_OP, GL_PRIMITIVE_RESTART,
                                                 GL_SAMPLE_MASK, GL_DEPTH_CLAMP};

struct PixelStore {
  GLenum name;
  GLint ours;
};
constexpr std::array<PixelStore, 10> kPixelStores{{{GL_PACK_ALIGNMENT, 1},
                                                   {GL_PACK_ROW_LENGTH, 0},
                                                   {GL_PACK_SKIP_ROWS, 0},
                                                   {GL_PACK_SKIP_PIXELS, 0},
                                                   {GL_UNPACK_ALIGNMENT, 1},
                                                   {GL_UNPACK_ROW_LENGTH, 0},
                                                   {GL_UNPACK_IMAGE_HEIGHT, 0},
                                                   {GL_UNPACK_SKIP_ROWS, 0},
                                                   {GL_UNPACK_SKIP_PIXELS, 0},
                                                   {GL_UNPACK_SKIP_IMAGES, 0}}};
constexpr std::array<PixelStore, 2> kDesktopPixelStores{{{GL_PACK_SWAP_BYTES, 0}, {GL_UNPACK_SWAP_BYTES, 0}}};

GLint number(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

void set(GLenum name, GLboolean on) {
  if (on) {
    glEnable(name);
  } else {
    glDisable(name);
  }
}

GLuint name_of(GLint binding) {
  return static_cast<GLuint>(binding);
}

GLenum enum_of(GLint value) {
  return static_cast<GLenum>(value);
}

}  // namespace

bool has_clip_control() {
  return epoxy_is_desktop_gl() || epoxy_has_gl_extension("GL_EXT_clip_control");
}

void set_clip_control(GLenum origin, GLenum depth) {
  if (epoxy_is_desktop_gl()) {
    glClipControl(origin, depth);
  } else {
    glClipControlEXT(origin, depth);
  }
}

GlStateGuard::GlStateGuard() : desktop_(epoxy_is_desktop_gl()), clip_control_(has_clip_control()) {
  for (const GLenum name : kSwitches) switches_.push_back({name, glIsEnabled(name)});
  for (const PixelStore& store : kPixelStores) pixel_stores_.push_back({store.name, number(store.name)});
  glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  depth_function_ = number(GL_DEPTH_FUNC);
  glGetFloatv(GL_DEPTH_RANGE, depth_range_.data());
  glGetIntegerv(GL_VIEWPORT, viewport_.data());
  stencils_[0] = {GL_FRONT,
                  number(GL_STENCIL_FUNC),
                  number(GL_STENCIL_REF),
                  number(GL_STENCIL_VALUE_MASK),
                  number(GL_STENCIL_WRITEMASK),
                  number(GL_STENCIL_FAIL),
                  number(GL_STENCIL_PASS_DEPTH_FAIL),
                  number(GL_STENCIL_PASS_DEPTH_PASS)};
  stencils_[1] = {GL_BACK,
                  number(GL_STENCIL_BACK_FUNC),
                  number(GL_STENCIL_BACK_REF),
                  number(GL_STENCIL_BACK_VALUE_MASK),
                  number(GL_STENCIL_BACK_WRITEMASK),
                  number(GL_STENCIL_BACK_FAIL),
                  number(GL_STENCIL_BACK_PASS_DEPTH_FAIL),
                  number(GL_STENCIL_BACK_PASS_DEPTH_PASS)};
  program_ = number(GL_CURRENT_PROGRAM);
  vertex_array_ = number(GL_VERTEX_ARRAY_BINDING);
  array_buffer_ = number(GL_ARRAY_BUFFER_BINDING);
  copy_buffer_ = number(GL_COPY_WRITE_BUFFER_BINDING);
  pack_buffer_ = number(GL_PIXEL_PACK_BUFFER_BINDING);
  unpack_buffer_ = number(GL_PIXEL_UNPACK_BUFFER_BINDING);
  draw_framebuffer_ = number(GL_DRAW_FRAMEBUFFER_BINDING);
  read_framebuffer_ = number(GL_READ_FRAMEBUFFER_BINDING);
  if (desktop_) {
    for (const GLenum name : kDesktopSwitches) switches_.push_back({name, glIsEnabled(name)});
    for (const PixelStore& store : kDesktopPixelStores) pixel_stores_.push_back({store.name, number(store.name)});
    glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
  }
  if (clip_control_) {
    clip_origin_ = number(GL_CLIP_ORIGIN);
    clip_depth_ = number(GL_CLIP_DEPTH_MODE);
  }
  note_draw_buffers();
  note_uniform_buffer();
  note_units();
  set_defaults();
}

void GlStateGuard::note_draw_buffers() {
  const auto buffers = desktop_ ? static_cast<std::size_t>(number(GL_MAX_DRAW_BUFFERS)) : 1;
  color_masks_.resize(buffers);
  if (!desktop_) {  // OpenGL ES 3.0 has one for all
    blends_.push_back(glIsEnabled(GL_BLEND));
    glGetBooleanv(GL_COLOR_WRITEMASK, color_masks_[0].data());
    return;
  }
  for (std::size_t i = 0; i < buffers; ++i) {
    blends_.push_back(glIsEnabledi(GL_BLEND, static_cast<GLuint>(i)));
    glGetBooleani_v(GL_COLOR_WRITEMASK, static_cast<GLuint>(i), color_masks_[i].data());
  }
}

void GlStateGuard::note_uniform_buffer() {
  uniform_buffer_ = number(GL_UNIFORM_BUFFER_BINDING);
  for (std::size_t i = 0; i < indexed_buffers_.size(); ++i) {
    IndexedBuffer& indexed = indexed_buffers_.at(i);
    glGetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, kBlockBindings.at(i), &indexed.buffer);
    glGetInteger64i_v(GL_UNIFORM_BUFFER_START, kBlockBindings.at(i), &indexed.start);
    glGetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, kBlockBindings.at(i), &indexed.size);
  }
}

// Samplers of the caller's would decide how our textures are read.
void GlStateGuard::note_units() {
  active_texture_ = number(GL_ACTIVE_TEXTURE);
  for (GLuint i = 0; i <= static_cast<GLuint>(kLastUnit) + 1; ++i) {
    const GLuint unit = i <= static_cast<GLuint>(kLastUnit) ? i : kSpareUnit;
    glActiveTexture(GL_TEXTURE0 + unit);
    units_.push_back(
        {unit, number(GL_TEXTURE_BINDING_2D), number(GL_TEXTURE_BINDING_2D_ARRAY), number(GL_SAMPLER_BINDING)});
    glBindSampler(unit, 0);
  }
}

void GlStateGuard::set_defaults() const {
  glActiveTexture(GL_TEXTURE0 + kSpareUnit);
  for (const Switch& state : switches_) glDisable(state.name);
  glDisable(GL_BLEND);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthRangef(0, 1);
  glStencilMask(0xFF);
  for (const PixelStore& store : kPixelStores) glPixelStorei(store.name, store.ours);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  if (clip_control_) set_clip_control(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  if (!desktop_) return;
  for (const PixelStore& store : kDesktopPixelStores) glPixelStorei(store.name, store.ours);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void GlStateGuard::restore_bindings() const {
  for (const Unit& unit : units_) {
    glActiveTexture(GL_TEXTURE0 + unit.number);
    glBindTexture(GL_TEXTURE_2D, name_of(unit.flat));
    glBindTexture(GL_TEXTURE_2D_ARRAY, name_of(unit.layered));
    glBindSampler(unit.number, name_of(unit.sampler));
  }
  glActiveTexture(enum_of(active_texture_));
  for (std::size_t i = 0; i < indexed_buffers_.size(); ++i) {
    const auto& [buffer, start, size] = indexed_buffers_.at(i);
    if (buffer != 0 && size > 0) {
      glBindBufferRange(GL_UNIFORM_BUFFER, kBlockBindings.at(i), name_of(buffer), static_cast<GLintptr>(start),
                        static_cast<GLsizeiptr>(size));
    } else {
      glBindBufferBase(GL_UNIFORM_BUFFER, kBlockBindings.at(i), name_of(buffer));
    }
  }
  glBindBuffer(GL_UNIFORM_BUFFER, name_of(uniform_buffer_));
  glBindVertexArray(name_of(vertex_array_));
  glBindBuffer(GL_ARRAY_BUFFER, name_of(array_buffer_));
  glBindBuffer(GL_COPY_WRITE_BUFFER, name_of(copy_buffer_));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, name_of(pack_buffer_));
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, name_of(unpack_buffer_));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, name_of(draw_framebuffer_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, name_of(read_framebuffer_));
  glUseProgram(name_of(program_));
}

GlStateGuard::~GlStateGuard() {
  restore_bindings();
  for (const Switch& state : switches_) set(state.name, state.on);
  for (const Value& store : pixel_stores_) glPixelStorei(store.name, store.value);
  for (std::size_t i = 0; i < color_masks_.size(); ++i) {
    const ColorMask& mask = color_masks_[i];
    if (desktop_) {
      const auto buffer = static_cast<GLuint>(i);
      glColorMaski(buffer, mask[0], mask[1], mask[2], mask[3]);
      if (blends_[i]) glEnablei(GL_BLEND, buffer);
    } else {
      glColorMask(mask[0], mask[1], mask[2], mask[3]);
      set(GL_BLEND, blends_[i]);
    }
  }
  for (const StencilFace& stencil : stencils_) {
    glStencilFuncSeparate(stencil.face, enum_of(stencil.function), stencil.reference,
                          static_cast<GLuint>(stencil.mask));
    glStencilOpSeparate(stencil.face, enum_of(stencil.fail), enum_of(stencil.depth_fail), enum_of(stencil.pass));
    glStencilMaskSeparate(stencil.face, static_cast<GLuint>(stencil.write_mask));
  }
  glDepthMask(depth_mask_);
  glDepthFunc(enum_of(depth_function_));
  glDepthRangef(depth_range_[0], depth_range_[1]);
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  if (clip_control_) set_clip_control(enum_of(clip_origin_), enum_of(clip_depth_));
  if (!desktop_) return;
  glPolygonMode(GL_FRONT_AND_BACK, enum_of(polygon_mode_[0]));
}

}  // namespace lumatlas
