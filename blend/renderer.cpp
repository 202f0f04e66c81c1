// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Erat et al. 2019, sections 3.1 and 3.4.
#include "blend/renderer.h"

#include <epoxy/gl.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "blend/cell_shares.h"
#include "blend/cubic_kernel.h"
#include "blend/exposure.h"
#include "blend/geometric_weight.h"
#include "blend/gl_objects.h"
#include "blend/photograph_array.h"
#include "blend/shaders.h"
#include "blend/supersampling.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// Mirrors View in shaders/blend.frag, std430.
struct ViewBlock {
  glm::vec4 cam_from_world[3];
  glm::vec4 intrinsics;
  glm::vec4 center;
  glm::vec4 gain;
  glm::vec4 size;
  glm::uvec4 tiles;
};
static_assert(sizeof(ViewBlock) == 8 * sizeof(glm::vec4));

// The nearest surface drawn, as a share of the mesh's box, which stray faces may make far larger than the scene. Depth
// is reversed and a float, so its relative precision is the same however small this is.
constexpr double kNearShare = 1e-8;

void require_limit(std::uint64_t needed, GLenum name, const char* what, const char* advice) {
  const GLint most = gl_limit(name);
  if (needed > static_cast<std::uint64_t>(most)) {
    throw GlError("the model needs " + std::to_string(needed) + " " + what + ", this driver takes " +
                  std::to_string(most) + ": " + advice);
  }
}

std::array<glm::vec4, 3> rows_of_pose(const Camera& camera) {
  std::array<glm::vec4, 3> rows;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      rows[static_cast<std::size_t>(row)][column] = static_cast<float>(camera.cam_from_world_rotation[column][row]);
    }
    rows[static_cast<std::size_t>(row)].w = static_cast<float>(camera.cam_from_world_translation[row]);
  }
  return rows;
}

glm::vec4 intrinsics_of(const Camera& camera) {
  return glm::vec4(glm::dvec4(camera.fx, camera.fy, camera.cx, camera.cy));
}

std::vector<ViewBlock> view_blocks(const Snapshot& snapshot, const PhotographArray& photographs) {
  std::vector<ViewBlock> blocks(snapshot.views.size());
  for (std::size_t slot = 0; slot < blocks.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const StoredView& view = *snapshot.views[slot];
    const std::array<glm::vec4, 3> rows = rows_of_pose(view.camera);
    std::copy(rows.begin(), rows.end(), blocks[slot].cam_from_world);
    blocks[slot].intrinsics = intrinsics_of(view.camera);
    blocks[slot].center = glm::vec4(glm::dvec4(view.camera.center(), 0));
    blocks[slot].gain = glm::vec4(glm::dvec4(snapshot.gains[slot], 0));
    const auto number = static_cast<std::uint32_t>(slot);
    blocks[slot].size = glm::vec4(view.camera.width, view.camera.height, photographs.depth_scale(number), 0);
    blocks[slot].tiles = glm::uvec4(photographs.first_tile(number), photographs.columns_of(view), 0, 0);
  }
  return blocks;
}

// What the first pass leaves for the second, and the picture.
struct Targets {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  GlTexture face, depth, fallback, shares, z_buffer, picture;
  GlTexture samples, sampled;  // sums over a pixel; stencil, 1 where samples are taken; made when first asked for
  GlFramebuffer surface_pass, blend_pass, sample_pass;
};

Targets make_targets(std::uint32_t width, std::uint32_t height) {
  require_picture_size(width, height);
  const auto w = static_cast<GLsizei>(width);
  const auto h = static_cast<GLsizei>(height);
  Targets targets;
  targets.width = width;
  targets.height = height;
  targets.face = make_texture_2d(GL_R32UI, w, h);
  targets.depth = make_texture_2d(GL_R32F, w, h);
  targets.fallback = make_texture_2d(GL_RGBA16F, w, h);
  targets.shares = make_texture_2d(GL_RGBA16, w, h);
  targets.z_buffer = make_texture_2d(GL_DEPTH_COMPONENT32F, w, h);
  targets.picture = make_texture_2d(GL_RGBA8, w, h);
  targets.surface_pass =
      make_framebuffer({&targets.face, &targets.depth, &targets.fallback, &targets.shares}, &targets.z_buffer);
  targets.blend_pass = make_framebuffer({&targets.picture}, nullptr);
  return targets;
}

void add_samples(Targets& targets) {
  const auto w = static_cast<GLsizei>(targets.width);
  const auto h = static_cast<GLsizei>(targets.height);
  targets.samples = make_texture_2d(GL_RGBA32F, w, h);
  targets.sampled = make_texture_2d(GL_STENCIL_INDEX8, w, h);
  targets.sample_pass = make_framebuffer({&targets.samples}, nullptr, &targets.sampled);
}

// As GLSL reads a float, whatever the host's locale writes.
std::string constant(double value) {
  return number_text(value, 6);
}

std::string with_definitions(std::string_view source) {
  std::string text(source);
  text.insert(text.find('\n') + 1,
              "#define MAX_BLENDED_VIEWS " + std::to_string(kMaxBlendedViews) + "\n#define SHARP_FOOTPRINT " +
                  constant(kSharpFootprint) + "\n#define LEAST_PENALTY " + constant(kLeastPenalty) +
                  "\n#define SILHOUETTE_BEND " + constant(kSilhouetteBend) + "\n#define RIM_NEAR_COSINE " +
                  constant(std::cos(glm::radians(kRimNearDegrees))) + "\n#define RIM_FAR_COSINE " +
                  constant(std::cos(glm::radians(kRimFarDegrees))) + "\n");
  return text;
}

// Programs that only some pictures need: the usual one pays nothing. `names` are defined: variants of a pass.
void make_once(GlProgram& program, const std::string& pass, std::string_view fragment_source,
               std::initializer_list<std::string> names = {}) {
  if (program.get() != 0) return;
  std::string text = with_definitions(fragment_source);
  std::string title = pass;
  for (const std::string& name : names) {
    text.insert(text.find('\n') + 1, "#define " + name + "\n");
    title += ", " + name;
  }
  program = make_program(title, k_screen_vert, text);
}

// All values of a texture, from the picture's first row, which is the framebuffer's last. In strips, for GL counts the
// bytes of each in 31 bits.
template <typename T>
std::vector<T> values_of(const GlTexture& texture, GLenum format, GLenum type, const Targets& targets,
                         std::size_t values_per_pixel) {
  constexpr std::size_t kStripBytes = 1 << 26;
  const std::size_t row = values_per_pixel * targets.width;
  const std::size_t strip_rows = std::max<std::size_t>(1, kStripBytes / (row * sizeof(T)));
  std::vector<T> values(row * targets.height);
  std::vector<T> strip;
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  for (std::size_t first = 0; first < targets.height; first += strip_rows) {
    const std::size_t rows = std::min(strip_rows, targets.height - first);
    strip.resize(row * rows);
    glGetTextureSubImage(texture.get(), 0, 0, static_cast<GLint>(first), 0, static_cast<GLsizei>(targets.width),
                         static_cast<GLsizei>(rows), 1, format, type, static_cast<GLsizei>(strip.size() * sizeof(T)),
                         strip.data());
    for (std::size_t y = 0; y < rows; ++y) {
      std::copy_n(&strip[row * y], row, &values[row * (targets.height - 1 - first - y)]);
    }
  }
  check_gl("reading the picture");
  return values;
}

PixelDiagnosis unpacked(const std::uint32_t* packed) {
  const auto share = [](std::uint32_t bits) { return static_cast<float>(bits & 0xFFFFu) / 65535.0f; };
  return {packed[0], packed[1], {share(packed[2]), share(packed[2] >> 16), share(packed[3])}};
}

// A uniform that the driver has optimised away has location -1, which GL ignores.
GLint location(const GlProgram& program, const char* name) {
  return glGetUniformLocation(program.get(), name);
}

void set_pose(const GlProgram& program, const Camera& camera) {
  const std::array<glm::vec4, 3> rows = rows_of_pose(camera);
  glProgramUniform4fv(program.get(), location(program, "cam_from_world"), 3, &rows[0].x);
}

// The mesh with a vertex for each zone that it is a corner of, because its shares are in the order of the zone's
// cells.
struct ZoneMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::u8vec3> colors;
  std::vector<glm::u16vec4> shares;  // 65535 is 1
  std::vector<glm::uvec3> faces;     // in the mesh's order
};

ZoneMesh zone_mesh(const Mesh& mesh, const std::vector<glm::u8vec3>& colors, const CellShares& shares) {
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  ZoneMesh copy;
  std::vector<std::uint32_t> zone;  // of each copied vertex
  std::vector<std::uint32_t> newest(mesh.positions.size(), kNone);
  std::vector<std::uint32_t> older;  // the next copy of the same vertex
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    glm::uvec3& corners = copy.faces.emplace_back();
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.faces[face][corner];
      std::uint32_t found = newest[vertex];
      while (found != kNone && zone[found] != shares.zone_of_face[face]) found = older[found];
      if (found == kNone) {
        found = static_cast<std::uint32_t>(zone.size());
        zone.push_back(shares.zone_of_face[face]);
        older.push_back(std::exchange(newest[vertex], found));
        copy.positions.push_back(mesh.positions[vertex]);
        copy.colors.push_back(colors[vertex]);
        const glm::vec4& of_cells = shares.corners[face][static_cast<std::size_t>(corner)];
        copy.shares.emplace_back(glm::round(of_cells * 65535.0F));
      }
      corners[corner] = found;
    }
  }
  return copy;
}

}  // namespace

std::uint64_t array_bytes(const Snapshot& snapshot) {
  check(snapshot);
  return array_shape(snapshot).bytes();
}

struct Renderer::State {
  RendererOptions steps;
  GlProgram surface_program = make_program("surface", k_surface_vert, k_surface_frag);
  GlProgram blend_program = make_program("blend", k_screen_vert, with_definitions(k_blend_frag));
  // Made when they are first asked for.
  GlProgram linear_program, diagnosis_program, sampled_program, sample_program, mean_program, linear_mean_program;
  GlVertexArray no_vertices;
  GlVertexArray mesh;
  GlBuffer positions, colors, shares, faces, cell_of_face, zone_of_face, zones, offsets, slots, views, cell_seen;
  PhotographArray photographs;
  GLsizei index_count = 0;
  double near_depth = 0;
  NearbyExposure nearby_exposure;
  // What share_cells() needs again for another width, and order_references() for another camera.
  std::shared_ptr<const Surface> surface;
  std::vector<glm::u8vec3> vertex_colors;
  ReferenceTable references;
  std::uint32_t cubic_levels = 0;
  std::vector<glm::dvec3> centers;     // of the stored views' cameras, by slot
  std::optional<double> border_width;  // that mesh and zones are loaded for
  bool loaded = false;
  Targets targets;

  void load_shares(double width);
  void order_references(const glm::dvec3& center, const BlendOptions& blend);
  void load_mesh(const ZoneMesh& copy);
  void load_tables(const Snapshot& snapshot);
  void draw_surface(const Camera& camera) const;
  void draw_blend(const GlProgram& program, const GlFramebuffer& target, const Camera& camera,
                  const BlendOptions& options) const;
  void draw_screen(const GlProgram& program) const;
  void mark_sampled(const Camera& camera, const BlendOptions& options);
  void draw_samples(const Camera& camera, const BlendOptions& options);
  void draw_means(const GlProgram& program, const GlFramebuffer& target) const;
  [[nodiscard]] Rendering read_back() const;
};

// Mesh and zones for a width as in BlendOptions.
void Renderer::State::load_shares(double width) {
  if (border_width == width) return;
  border_width.reset();
  CellShares cell_shares = share_cells(*surface, width * surface->cells.size);
  if (steps.join_cells && width > 0) cell_shares = joined(std::move(cell_shares), first_of_same_references(references));
  zone_of_face = make_buffer(cell_shares.zone_of_face);
  zones = make_buffer(cell_shares.zones);
  load_mesh(zone_mesh(surface->mesh, vertex_colors, cell_shares));
  border_width = width;
}

void Renderer::State::load_mesh(const ZoneMesh& copy) {
  positions = make_buffer(copy.positions);
  colors = make_buffer(copy.colors);
  shares = make_buffer(copy.shares);
  faces = make_buffer(copy.faces);
  index_count = static_cast<GLsizei>(3 * copy.faces.size());
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  mesh = GlVertexArray(name);
  glVertexArrayVertexBuffer(name, 0, positions.get(), 0, sizeof(glm::vec3));
  glVertexArrayVertexBuffer(name, 1, colors.get(), 0, sizeof(glm::u8vec3));
  glVertexArrayVertexBuffer(name, 2, shares.get(), 0, sizeof(glm::u16vec4));
  glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribFormat(name, 1, 3, GL_UNSIGNED_BYTE, GL_TRUE, 0);
  glVertexArrayAttribFormat(name, 2, 4, GL_UNSIGNED_SHORT, GL_TRUE, 0);
  for (const GLuint attribute : {0u, 1u, 2u}) {
    glVertexArrayAttribBinding(name, attribute, attribute);
    glEnableVertexArrayAttrib(name, attribute);
  }
  glVertexArrayElementBuffer(name, faces.get());
  check_gl("loading the mesh");
}

void Renderer::State::load_tables(const Snapshot& snapshot) {
  const std::vector<std::uint32_t>& face_cells = snapshot.surface->cells.cell_of_face;
  const char* const advice = "decimate the mesh or lower --references";
  require_limit(sizeof(std::uint32_t) * face_cells.size(), GL_MAX_SHADER_STORAGE_BLOCK_SIZE, "bytes for its faces",
                advice);
  require_limit(sizeof(std::uint32_t) * snapshot.references.views.size(), GL_MAX_SHADER_STORAGE_BLOCK_SIZE,
                "bytes for its references", advice);
  cell_of_face = make_buffer(face_cells);
  offsets = make_buffer(snapshot.references.offsets);
  slots = make_buffer(snapshot.references.views);
  views = make_buffer(view_blocks(snapshot, photographs));
  cell_seen = make_buffer(std::vector<std::uint32_t>(snapshot.cell_seen.begin(), snapshot.cell_seen.end()));
}

// By their weights at the middle of each cell.
void Renderer::State::order_references(const glm::dvec3& center, const BlendOptions& blend) {
  std::vector<std::uint32_t> views_of_cells(references.views.size());
  tbb::parallel_for(std::size_t{0}, surface->cells.cells.size(), [&](std::size_t cell) {
    const std::size_t begin = references.offsets[cell];
    const std::size_t count = references.offsets[cell + 1] - begin;
    std::vector<std::pair<double, std::uint32_t>> ranked;
    ranked.reserve(count);
    for (const std::uint32_t slot : references.of_cell(cell)) {
      ranked.emplace_back(-geometric_weight(surface->cells.cells[cell].centroid, center, centers[slot], blend), slot);
    }
    std::sort(ranked.begin(), ranked.end());
    for (std::size_t i = 0; i < count; ++i) views_of_cells[begin + i] = ranked[i].second;
  });
  slots = make_buffer(views_of_cells);
}

void Renderer::State::draw_surface(const Camera& camera) const {
  const GLuint target = targets.surface_pass.get();
  const std::array<GLuint, 4> no_face{0xFFFFFFFFu, 0, 0, 0};
  const std::array<GLfloat, 4> zero{};
  glClearNamedFramebufferuiv(target, GL_COLOR, 0, no_face.data());
  glClearNamedFramebufferfv(target, GL_COLOR, 1, zero.data());
  glClearNamedFramebufferfv(target, GL_COLOR, 2, zero.data());
  glClearNamedFramebufferfv(target, GL_COLOR, 3, zero.data());
  glClearNamedFramebufferfv(target, GL_DEPTH, 0, zero.data());
  glBindFramebuffer(GL_FRAMEBUFFER, target);
  glViewport(0, 0, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  const GlProgram& program = surface_program;
  glUseProgram(program.get());
  set_pose(program, camera);
  // Image x right and y down from the top left corner to clip coordinates, where y is up.
  const glm::vec4 clip(glm::dvec4(2 * camera.fx / camera.width, -2 * camera.fy / camera.height,
                                  2 * camera.cx / camera.width - 1, 1 - 2 * camera.cy / camera.height));
  glProgramUniform4fv(program.get(), location(program, "clip_from_cam"), 1, &clip.x);
  glProgramUniform1f(program.get(), location(program, "near_depth"), static_cast<float>(near_depth));
  glBindVertexArray(mesh.get());
  glDrawElements(GL_TRIANGLES, index_count, GL_UNSIGNED_INT, nullptr);
  check_gl("drawing the surface");
}

void Renderer::State::draw_blend(const GlProgram& program, const GlFramebuffer& target, const Camera& camera,
                                 const BlendOptions& options) const {
  const GLuint name = program.get();
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  glDisable(GL_DEPTH_TEST);
  set_pose(program, camera);
  const glm::vec4 intrinsics = intrinsics_of(camera);
  const glm::vec3 center(camera.center());
  const glm::vec3 exposure(picture_exposure(nearby_exposure, camera, options));
  glProgramUniform4fv(name, location(program, "intrinsics"), 1, &intrinsics.x);
  glProgramUniform3fv(name, location(program, "center"), 1, &center.x);
  glProgramUniform3fv(name, location(program, "exposure"), 1, &exposure.x);
  glProgramUniform1f(name, location(program, "samples_across"), static_cast<float>(options.supersample));
  glProgramUniform1f(name, location(program, "height"), static_cast<float>(camera.height));
  glProgramUniform1ui(name, location(program, "blended_views"), options.views);
  glProgramUniform1f(name, location(program, "lambda"), static_cast<float>(options.lambda));
  glProgramUniform1f(name, location(program, "occlusion_tolerance"), static_cast<float>(options.occlusion_tolerance));
  glProgramUniform1i(name, location(program, "printed_position"), options.position == BlendOptions::Position::printed);
  glProgramUniform1i(name, location(program, "rims"), options.rims);
  glProgramUniform1i(name, location(program, "fade_last"), options.fade_last);
  glProgramUniform1i(name, location(program, "consistent"), options.consistent);
  glProgramUniform1i(name, location(program, "skip_losers"), steps.skip_losers);
  glProgramUniform1i(name, location(program, "prefilter"), options.prefilter);
  glProgramUniform1i(name, location(program, "cubic_levels"),
                     options.sampling == BlendOptions::Sampling::cubic ? static_cast<GLint>(cubic_levels) : 0);
  const std::array buffers{cell_of_face.get(), offsets.get(),      slots.get(), views.get(),
                           cell_seen.get(),    zone_of_face.get(), zones.get()};
  glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizei>(buffers.size()), buffers.data());
  photographs.bind(program);
  draw_screen(program);
  check_gl("blending views");
}

// One fragment a pixel, with what earlier passes left.
void Renderer::State::draw_screen(const GlProgram& program) const {
  const std::array textures{targets.face.get(), targets.depth.get(), targets.fallback.get(), targets.shares.get(),
                            targets.samples.get()};
  glBindTextures(2, static_cast<GLsizei>(textures.size()), textures.data());
  glUseProgram(program.get());
  glBindVertexArray(no_vertices.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glUseProgram(0);  // a program in use outlives its deletion, with its shaders
}

// In the stencil of what samples are added up in, the pixels that are to have some, by the surface that `camera` sees.
void Renderer::State::mark_sampled(const Camera& camera, const BlendOptions& options) {
  make_once(sampled_program, "sampled", k_sampled_frag);
  const GLint unmarked = 0;
  glClearNamedFramebufferiv(targets.sample_pass.get(), GL_STENCIL, 0, &unmarked);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.sample_pass.get());
  glProgramUniform1i(sampled_program.get(), location(sampled_program, "everywhere"),
                     options.antialias == BlendOptions::Antialias::all);
  glProgramUniform1f(sampled_program.get(), location(sampled_program, "focal_length"), static_cast<float>(camera.fx));
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, 1, 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  draw_screen(sampled_program);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_STENCIL_TEST);
  check_gl("marking sampled pixels");
}

// The sums over the samples of each pixel that has any, of colour and of how many see the surface. The surface of the
// pixels' middles must be drawn; afterwards another one is.
void Renderer::State::draw_samples(const Camera& camera, const BlendOptions& options) {
  if (targets.samples.get() == 0) add_samples(targets);
  make_once(sample_program, "blend", k_blend_frag, {"SAMPLE"});
  const std::array<GLfloat, 4> zero{};
  glClearNamedFramebufferfv(targets.sample_pass.get(), GL_COLOR, 0, zero.data());
  mark_sampled(camera, options);
  glStencilFunc(GL_EQUAL, 1, 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glBlendFunc(GL_ONE, GL_ONE);
  for (const Camera& sample : sample_cameras(camera, options.supersample)) {
    draw_surface(sample);
    glEnable(GL_BLEND);
    glEnable(GL_STENCIL_TEST);
    draw_blend(sample_program, targets.sample_pass, sample, options);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_BLEND);
  }
}

// In place of the middles' colours, whose states stay.
void Renderer::State::draw_means(const GlProgram& program, const GlFramebuffer& target) const {
  glBindFramebuffer(GL_FRAMEBUFFER, target.get());
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  draw_screen(program);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  check_gl("drawing means");
}

Rendering Renderer::State::read_back() const {
  const std::size_t width = targets.width;
  const std::size_t height = targets.height;
  std::vector<std::uint8_t> rgba(4 * width * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(targets.picture.get(), 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(rgba.size()),
                    rgba.data());
  check_gl("reading the picture");
  Rendering rendering;
  rendering.picture.width = targets.width;
  rendering.picture.height = targets.height;
  rendering.picture.rgb.resize(3 * width * height);
  rendering.state.resize(width * height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint8_t* from = &rgba[4 * ((height - 1 - y) * width + x)];
      const std::size_t pixel = y * width + x;
      std::copy_n(from, 3, &rendering.picture.rgb[3 * pixel]);
      rendering.state[pixel] = static_cast<PixelState>(from[3]);
    }
  }
  return rendering;
}

Renderer::Renderer(const EglContext& /*current*/, const RendererOptions& steps) : state_(std::make_unique<State>()) {
  state_->steps = steps;
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  state_->no_vertices = GlVertexArray(name);
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

void Renderer::take_steps(const RendererOptions& steps) {
  // The model's own order, once another one has taken its place.
  if (state_->steps.order_references && !steps.order_references) state_->slots = make_buffer(state_->references.views);
  if (state_->steps.join_cells != steps.join_cells) state_->border_width.reset();
  state_->steps = steps;
}

void Renderer::load(const Snapshot& snapshot) {
  check(snapshot);
  state_->loaded = false;
  state_->surface = snapshot.surface;
  state_->vertex_colors = snapshot.vertex_colors;
  state_->references = snapshot.references;
  state_->cubic_levels = cubic_levels(snapshot.tiles.options);
  state_->centers.assign(snapshot.views.size(), glm::dvec3(0));
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) state_->centers[slot] = snapshot.views[slot]->camera.center();
  }
  state_->border_width.reset();
  const Bounds box = bounds(snapshot.surface->mesh);
  state_->near_depth = kNearShare * glm::length(box.max - box.min);
  state_->photographs.load(snapshot);
  state_->load_tables(snapshot);
  state_->nearby_exposure = NearbyExposure(snapshot);
  state_->loaded = true;
}

// Draws what every kind of picture begins with.
void Renderer::prepare(const Camera& camera, const BlendOptions& options) {
  check(camera);
  check(options);
  if (!state_->loaded) throw std::invalid_argument("renderer: no snapshot is loaded, load() must come first");
  if (state_->targets.width != camera.width || state_->targets.height != camera.height) {
    state_->targets = {};
    state_->targets = make_targets(camera.width, camera.height);
  }
  state_->load_shares(options.border_width);
  if (state_->steps.order_references) state_->order_references(camera.center(), options);
  state_->draw_surface(camera);
}

void Renderer::draw(const Camera& camera, const BlendOptions& options) {
  prepare(camera, options);
  State& state = *state_;
  state.draw_blend(state.blend_program, state.targets.blend_pass, camera, at_middle(options));
  if (options.supersample == 1) return;
  make_once(state.mean_program, "mean", k_mean_frag);
  state.draw_samples(camera, options);
  state.draw_means(state.mean_program, state.targets.blend_pass);
}

Rendering Renderer::render(const Camera& camera, const BlendOptions& options) {
  draw(camera, options);
  return state_->read_back();
}

LinearRendering Renderer::render_linear(const Camera& camera, const BlendOptions& options) {
  prepare(camera, options);
  State& state = *state_;
  make_once(state.linear_program, "blend", k_blend_frag, {"LINEAR"});
  const Targets& targets = state.targets;
  const GlTexture linear =
      make_texture_2d(GL_RGBA32F, static_cast<GLsizei>(camera.width), static_cast<GLsizei>(camera.height));
  const GlFramebuffer linear_pass = make_framebuffer({&linear}, nullptr);
  state.draw_blend(state.linear_program, linear_pass, camera, at_middle(options));
  if (options.supersample > 1) {
    make_once(state.linear_mean_program, "mean", k_mean_frag, {"LINEAR"});
    state.draw_samples(camera, options);
    state.draw_means(state.linear_mean_program, linear_pass);
  }
  const auto rgba = values_of<float>(linear, GL_RGBA, GL_FLOAT, targets, 4);
  LinearRendering rendering{camera.width, camera.height, {}, {}};
  rendering.rgb.reserve(rgba.size() / 4 * 3);
  rendering.state.reserve(rgba.size() / 4);
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    rendering.rgb.insert(rendering.rgb.end(), &rgba[i], &rgba[i] + 3);
    rendering.state.push_back(static_cast<PixelState>(std::lround(255 * rgba[i + 3])));
  }
  return rendering;
}

Diagnosis Renderer::diagnose(const Camera& camera, const BlendOptions& options) {
  prepare(camera, at_middle(options));
  make_once(state_->diagnosis_program, "blend", k_blend_frag, {"DIAGNOSE"});
  const Targets& targets = state_->targets;
  const GlTexture packed =
      make_texture_2d(GL_RGBA32UI, static_cast<GLsizei>(camera.width), static_cast<GLsizei>(camera.height));
  state_->draw_blend(state_->diagnosis_program, make_framebuffer({&targets.picture, &packed}, nullptr), camera,
                     at_middle(options));
  const auto values = values_of<std::uint32_t>(packed, GL_RGBA_INTEGER, GL_UNSIGNED_INT, targets, 4);
  Diagnosis diagnosis{camera.width, camera.height, state_->read_back().state, {}};
  diagnosis.pixels.reserve(values.size() / 4);
  for (std::size_t i = 0; i < values.size(); i += 4) diagnosis.pixels.push_back(unpacked(&values[i]));
  return diagnosis;
}

}  // namespace lumatlas
