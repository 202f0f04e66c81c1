// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/shader_program.h"

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "atlas/views/depth_blocks.h"
#include "blend/blend_options.h"
#include "blend/exposure.h"
#include "blend/geometric_weight.h"
#include "blend/gl/gl_state.h"
#include "blend/outlines.h"
#include "blend/sampling/footprint.h"
#include "blend/shaders.h"
#include "blend/soft_edges.h"
#include "blend/tables/view_table.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

constexpr std::array kSamplers{
    "photographs", "depths",     "surfaces", "zones",         "cells",     "references",
    "views",       "tile_slots", "middles",  "middle_colors", "raw_texels"};  // in the order of TextureUnit

std::string definition(std::string_view name, const std::string& value) {
  return "#define " + std::string(name) + " " + value + "\n";
}

// Returns the number as GLSL reads a float, whatever the host's locale writes.
std::string constant(double value) {
  return number_text(value, 7);
}

std::string definitions(const ProgramKey& key) {
  std::string text = shared_definitions();
  if (key.views > 0) text += definition("BLENDED_VIEWS", std::to_string(key.views));
  if (key.cells > 0) text += definition("CELLS", std::to_string(key.cells));
  if (key.pass == Pass::samples) text += "#define SAMPLES\n";
  if (key.output == Output::linear) text += "#define LINEAR\n";
  if (key.output == Output::fetches) text += "#define COUNT_FETCHES\n";
  if (has_clip_control()) text += "#define CLIP_CONTROL\n";
  if (key.views_in_block) text += "#define VIEWS_IN_BLOCK\n";
  if (key.host_depth) text += "#define HOST_DEPTH\n";
  if (key.filtered_taps) text += "#define FILTERED_TAPS\n";
  if (key.raw_texels) text += "#define RAW_TEXELS\n";
  if (!key.cubic) text += "#define LINEAR_SAMPLING\n";
  return text;
}

struct ProgramSource {
  const char* name;
  std::string_view vertex, fragment;
};

ProgramSource source_of(Pass pass) {
  switch (pass) {
    case Pass::surface:
      return {"surface", k_surface_vert, k_surface_frag};
    case Pass::silhouettes:
      return {"silhouettes", k_screen_vert, k_silhouettes_frag};
    case Pass::outline_rows:
      return {"rows of outlines", k_screen_vert, k_outline_rows_frag};
    case Pass::outlines:
      return {"outlines", k_screen_vert, k_outlines_frag};
    case Pass::edges:
      return {"edges", k_screen_vert, k_edges_frag};
    case Pass::edge_rows:
      return {"edge rows", k_screen_vert, k_edge_rows_frag};
    case Pass::soft_edges:
      return {"soft edges", k_screen_vert, k_soft_edges_frag};
    case Pass::diagnose:
      return {"diagnosis", k_screen_vert, k_diagnose_frag};
    case Pass::present:
      return {"presentation", k_screen_vert, k_present_frag};
    case Pass::blend:
    case Pass::samples:
      break;
  }
  return {"blend", k_screen_vert, k_blend_frag};
}

// After the line that says the version, which must come first.
std::string defined(std::string_view source, const std::string& names) {
  std::string text(source);
  text.insert(text.find('\n') + 1, names);
  return text;
}

PendingProgram started(const ProgramKey& key) {
  const ProgramSource source = source_of(key.pass);
  const std::string names = definitions(key);
  return start_program(source.name, defined(source.vertex, names), defined(source.fragment, names));
}

void bind_block(const GlProgram& program, const char* name, GLuint binding) {
  const GLuint block = glGetUniformBlockIndex(program.get(), name);
  if (block != GL_INVALID_INDEX) glUniformBlockBinding(program.get(), block, binding);
}

}  // namespace

std::string shared_definitions() {
  return definition("SHARP_FOOTPRINT", constant(kSharpFootprint)) +
         definition("BLUR_OF_SHIFT", constant(kBlurOfShift)) + definition("SHARP_SHIFT", constant(kSharpShift)) +
         definition("MOST_SHIFT", constant(kMostShift)) + definition("LEAST_PENALTY", constant(kLeastPenalty)) +
         definition("EVEN", constant(kEven)) + definition("EVEN_SLOPE", constant(kEvenSlope)) +
         definition("FADE_PENALTY", constant(kFadePenalty)) + definition("LEAST_FADED", constant(kLeastFaded)) +
         definition("FAR_FRAME_FADE", constant(kFarFrameFade)) + definition("CLIPPED_FROM", constant(kClippedFrom)) +
         definition("SILHOUETTE_BEND", constant(kSilhouetteBend)) + definition("SAME_SURFACE", constant(kSameSurface)) +
         definition("SOFT_EDGE_SINE", constant(std::sin(glm::radians(kSoftEdgeDegrees)))) +
         definition("MOST_EDGE_BLUR", constant(kMostEdgeBlur)) + definition("EDGE_BEND", constant(kEdgeBend)) +
         definition("BLUR_FALL", constant(kBlurFall)) + definition("EDGE_REACH", std::to_string(kEdgeReach)) +
         definition("OUTLINE_OF_SHIFT", constant(kOutlineOfShift)) +
         definition("OUTLINE_REACH", std::to_string(kOutlineReach)) +
         definition("OUTLINE_STEP", constant(kOutlineStep)) +
         definition("RIM_NEAR_COSINE", constant(std::cos(glm::radians(kRimNearDegrees)))) +
         definition("RIM_FAR_COSINE", constant(std::cos(glm::radians(kRimFarDegrees)))) +
         definition("DEPTH_BLOCK_SIDE", std::to_string(kDepthBlockSide)) +
         definition("MOST_DEPTH_SLOPE", constant(kMostDepthSlope)) +
         definition("TABLE_WIDTH", std::to_string(kTableWidth)) +
         definition("VIEW_TEXELS", std::to_string(kViewTexels)) +
         definition("BLOCK_TEXELS", std::to_string(kBlockTexels));
}

GLuint ShaderPrograms::get(const ProgramKey& key) {
  if (const auto found = programs_.find(key); found != programs_.end()) return found->second.get();
  return add(key, started(key));
}

void ShaderPrograms::make(std::span<const ProgramKey> keys) {
  std::map<ProgramKey, PendingProgram> pending;
  for (const ProgramKey& key : keys) {
    if (programs_.count(key) == 0 && pending.count(key) == 0) pending.emplace(key, started(key));
  }
  for (auto& [key, program] : pending) add(key, std::move(program));
}

GLuint ShaderPrograms::add(const ProgramKey& key, PendingProgram pending) {
  GlProgram program = finish_program(std::move(pending));
  bind_block(program, "Picture", kPictureBinding);
  bind_block(program, "Views", kViewsBinding);
  glUseProgram(program.get());
  for (std::size_t unit = 0; unit < kSamplers.size(); ++unit) {
    glUniform1i(glGetUniformLocation(program.get(), kSamplers.at(unit)), static_cast<GLint>(unit));
  }
  glUniform1i(glGetUniformLocation(program.get(), "variances"), static_cast<GLint>(TextureUnit::surfaces));
  glUniform1i(glGetUniformLocation(program.get(), "row_depths"), static_cast<GLint>(TextureUnit::middles));
  for (const char* const name : {"sharp", "shown"}) {
    glUniform1i(glGetUniformLocation(program.get(), name), static_cast<GLint>(TextureUnit::photographs));
  }
  glUseProgram(0);
  return programs_.emplace(key, std::move(program)).first->second.get();
}

}  // namespace lumatlas
