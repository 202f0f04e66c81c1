// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl_visibility.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/gl/gl_objects.h"
#include "blend/shaders.h"
#include "blend/tables/cell_runs.h"

namespace lumatlas {

namespace {

// The depth nearest to the camera that is drawn, as a share of the farthest: nothing that a float can place. Depth is
// reversed and a float, so its relative precision does not depend on this while near / far is far above 1e-38.
constexpr double kNearestShare = 1e-24;

// Planning looks at a view in a few sizes again and again: coarse for counting cells, full for storing it.
constexpr std::size_t kKeptTargets = 4;

// The command of glMultiDrawElementsIndirect. The shader also reads first_index, as an attribute of the instance.
struct DrawCommand {
  GLuint count;
  GLuint instances;
  GLuint first_index;
  GLint base_vertex;
  GLuint base_instance;
};
static_assert(sizeof(DrawCommand) == 5 * sizeof(GLuint));

std::vector<DrawCommand> commands_of(const std::vector<FaceRun>& runs) {
  std::vector<DrawCommand> commands;
  commands.reserve(runs.size());
  for (const FaceRun& run : runs) {
    commands.push_back({3 * run.count, 1, 3 * run.first, 0, static_cast<GLuint>(commands.size())});
  }
  return commands;
}

std::vector<glm::uvec3> in_order(const std::vector<glm::uvec3>& faces, const std::vector<std::uint32_t>& order) {
  std::vector<glm::uvec3> ordered;
  ordered.reserve(order.size());
  for (const std::uint32_t face : order) ordered.push_back(faces[face]);
  return ordered;
}

void require_faces_fit(const Mesh& mesh) {
  if (mesh.faces.empty()) throw std::invalid_argument("GL visibility: the mesh has no faces, must have at least one");
  constexpr std::size_t kMostFaces = std::numeric_limits<GLsizei>::max() / 3;
  if (mesh.faces.size() > kMostFaces) {
    throw GlError("the mesh has " + std::to_string(mesh.faces.size()) + " faces, OpenGL takes " +
                  std::to_string(kMostFaces) + ": decimate the mesh");
  }
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const glm::uvec3& corners = mesh.faces[face];
    const std::uint32_t most = std::max({corners.x, corners.y, corners.z});
    if (most < mesh.positions.size()) continue;
    throw std::invalid_argument("GL visibility: face " + std::to_string(face) + " has the vertex " +
                                std::to_string(most) + ", must be below the number of vertices, " +
                                std::to_string(mesh.positions.size()));
  }
}

double farthest_depth(const Bounds& box, const glm::dvec3& center) {
  return glm::length(glm::max(glm::abs(box.min - center), glm::abs(box.max - center)));
}

// The camera in the shader's terms.
struct ShaderCamera {
  glm::vec3 center;
  glm::mat3 cam_from_world;
  glm::vec4 clip_from_cam;
  float near_depth;

  ShaderCamera(const Camera& camera, const Bounds& box)
      : center(camera.center()),
        cam_from_world(camera.cam_from_world_rotation),
        clip_from_cam(glm::dvec4(2 * camera.fx / camera.width, 2 * camera.fy / camera.height,
                                 2 * camera.cx / camera.width - 1, 2 * camera.cy / camera.height - 1)),
        near_depth(static_cast<float>(kNearestShare * farthest_depth(box, camera.center()))) {}

  [[nodiscard]] bool is_finite() const {
    const glm::vec4 scaled = clip_from_cam * near_depth / static_cast<float>(kNearestShare);
    return std::isfinite(center.x + center.y + center.z) && std::isfinite(scaled.x + scaled.y + scaled.z + scaled.w);
  }
};

struct Targets {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  GlTexture face, depth, z_buffer;
  GlFramebuffer framebuffer;

  Targets(std::uint32_t w, std::uint32_t h) : width(w), height(h) {
    require_picture_size(w, h);
    face = make_texture_2d(GL_R32UI, static_cast<GLsizei>(w), static_cast<GLsizei>(h));
    depth = make_texture_2d(GL_R32F, static_cast<GLsizei>(w), static_cast<GLsizei>(h));
    z_buffer = make_texture_2d(GL_DEPTH_COMPONENT32F, static_cast<GLsizei>(w), static_cast<GLsizei>(h));
    framebuffer = make_framebuffer({&face, &depth}, &z_buffer);
  }
};

// Everything that lives in the context.
class Rasterizer {
 public:
  Rasterizer(const Mesh& mesh, const std::vector<std::uint32_t>& order)
      : program_(make_program("visibility", k_visibility_vert, k_visibility_frag)),
        positions_(make_buffer(mesh.positions)),
        indices_(make_buffer(in_order(mesh.faces, order))) {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    commands_ = GlBuffer(name);
    glCreateVertexArrays(1, &name);
    arrays_ = GlVertexArray(name);
    set_up_arrays();
    set_up_state();
    check_gl("setting up visibility");
  }

  // Faces by their place in the order.
  void trace(std::uint32_t width, std::uint32_t height, const ShaderCamera& camera, const std::vector<FaceRun>& runs,
             VisibilityBuffer& buffer) {
    const Targets& targets = targets_for(width, height);
    clear(targets);
    set_camera(camera);
    draw(commands_of(runs));
    buffer.width = width;
    buffer.height = height;
    buffer.depth.resize(std::size_t{width} * height);
    buffer.face.resize(buffer.depth.size());
    const auto bytes = static_cast<GLsizei>(sizeof(float) * buffer.depth.size());
    glGetTextureImage(targets.face.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, bytes, buffer.face.data());
    glGetTextureImage(targets.depth.get(), 0, GL_RED, GL_FLOAT, bytes, buffer.depth.data());
    check_gl("rasterising the mesh");
  }

 private:
  void set_up_arrays() const {
    const GLuint name = arrays_.get();
    glVertexArrayVertexBuffer(name, 0, positions_.get(), 0, sizeof(glm::vec3));
    glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayVertexBuffer(name, 1, commands_.get(), 0, sizeof(DrawCommand));
    glVertexArrayAttribIFormat(name, 1, 1, GL_UNSIGNED_INT, offsetof(DrawCommand, first_index));
    glVertexArrayBindingDivisor(name, 1, 1);
    for (const GLuint attribute : {0u, 1u}) {
      glVertexArrayAttribBinding(name, attribute, attribute);
      glEnableVertexArrayAttrib(name, attribute);
    }
    glVertexArrayElementBuffer(name, indices_.get());
    glBindVertexArray(name);
  }

  // For good: the context draws nothing else.
  void set_up_state() const {
    glUseProgram(program_.get());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.get());
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDisable(GL_CULL_FACE);
  }

  // The targets of this size, the most recently used ones first.
  const Targets& targets_for(std::uint32_t width, std::uint32_t height) {
    const auto found = std::find_if(targets_.begin(), targets_.end(), [&](const Targets& targets) {
      return targets.width == width && targets.height == height;
    });
    if (found != targets_.end()) {
      std::rotate(targets_.begin(), found, found + 1);
    } else {
      if (targets_.size() == kKeptTargets) targets_.pop_back();
      targets_.emplace(targets_.begin(), width, height);
    }
    return targets_.front();
  }

  static void clear(const Targets& targets) {
    const GLuint name = targets.framebuffer.get();
    const std::array<GLuint, 4> no_face{FaceId::none, 0, 0, 0};
    const std::array<GLfloat, 4> no_depth{std::numeric_limits<float>::infinity(), 0, 0, 0};
    constexpr GLfloat kFarthest = 0;
    glClearNamedFramebufferuiv(name, GL_COLOR, 0, no_face.data());
    glClearNamedFramebufferfv(name, GL_COLOR, 1, no_depth.data());
    glClearNamedFramebufferfv(name, GL_DEPTH, 0, &kFarthest);
    glBindFramebuffer(GL_FRAMEBUFFER, name);
    glViewport(0, 0, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
  }

  void set_camera(const ShaderCamera& camera) const {
    const auto location = [this](const char* name) { return glGetUniformLocation(program_.get(), name); };
    glUniform3fv(location("center"), 1, &camera.center.x);
    glUniformMatrix3fv(location("cam_from_world"), 1, GL_FALSE, &camera.cam_from_world[0].x);
    glUniform4fv(location("clip_from_cam"), 1, &camera.clip_from_cam.x);
    glUniform1f(location("near_depth"), camera.near_depth);
  }

  void draw(const std::vector<DrawCommand>& commands) const {
    glNamedBufferData(commands_.get(), static_cast<GLsizeiptr>(commands.size() * sizeof(DrawCommand)), commands.data(),
                      GL_STREAM_DRAW);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(commands.size()), 0);
  }

  GlProgram program_;
  GlBuffer positions_, indices_, commands_;
  GlVertexArray arrays_;
  std::vector<Targets> targets_;
};

class GlVisibility final : public Visibility {
 public:
  GlVisibility(const Mesh& mesh, const Cells& cells, const GlVisibilityOptions& options)
      : options_(options),
        runs_(cells, mesh.faces.size()),
        box_(bounds(mesh)),
        context_(EglContext::Options{.debug = options.debug, .stays_current = false}) {
    const CurrentContext current(context_);
    rasterizer_ = std::make_unique<Rasterizer>(mesh, runs_.order());
  }
  ~GlVisibility() override {
    try {
      const CurrentContext current(context_);
      rasterizer_.reset();
    } catch (const GlError&) {
      // A lost context takes its objects with it: deleting their names now could hit another context's.
      static_cast<void>(rasterizer_.release());
    }
  }
  GlVisibility(const GlVisibility&) = delete;
  GlVisibility& operator=(const GlVisibility&) = delete;

  using Visibility::trace;
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override {
    check(camera);
    const ShaderCamera shader_camera(camera, box_);
    std::vector<FaceRun> runs;
    if (shader_camera.is_finite()) runs = runs_to_draw(camera);
    {
      const std::scoped_lock lock(mutex_);
      const CurrentContext current(context_);
      rasterizer_->trace(camera.width, camera.height, shader_camera, runs, buffer);
    }
    for (FaceId& face : buffer.face) {
      if (face != FaceId::none) face = FaceId{runs_.order()[face]};
    }
  }

 private:
  [[nodiscard]] std::vector<FaceRun> runs_to_draw(const Camera& camera) const {
    if (options_.frustum_culling) return runs_.in_view(camera);
    return {{0, static_cast<std::uint32_t>(runs_.order().size())}};
  }

  GlVisibilityOptions options_;
  CellRuns runs_;
  Bounds box_;
  mutable std::mutex mutex_;  // guards the context and its objects
  EglContext context_;
  std::unique_ptr<Rasterizer> rasterizer_;
};

}  // namespace

std::unique_ptr<Visibility> make_gl_visibility(const Mesh& mesh, const Cells& cells,
                                               const GlVisibilityOptions& options) {
  require_faces_fit(mesh);
  return std::make_unique<GlVisibility>(mesh, cells, options);
}

}  // namespace lumatlas
