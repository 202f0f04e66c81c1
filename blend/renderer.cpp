// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Erat et al. 2019, sections 3.1 and 3.4.
#include "blend/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "blend/exposure.h"
#include "blend/gl/egl_context.h"
#include "blend/gl/gl_objects.h"
#include "blend/gl/gl_state.h"
#include "blend/gl/mesh_objects.h"
#include "blend/gl/photograph_array.h"
#include "blend/gl/picture_parts.h"
#include "blend/gl/picture_targets.h"
#include "blend/gl/shader_program.h"
#include "blend/gl/side_thread.h"
#include "blend/gl/snapshot_upload.h"
#include "blend/sampling/supersampling.h"
#include "blend/tables/drawn_zones.h"
#include "blend/tables/ranked_references.h"
#include "blend/tables/snapshot_preparation.h"
#include "blend/tables/snapshot_tables.h"
#include "blend/tables/view_table.h"
#include "blend/tables/zone_mesh.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// Mirrors the block Picture of shaders/picture.glsl, std140.
struct PictureBlock {
  glm::vec4 cam_from_world[3];
  glm::vec4 intrinsics, clip_from_cam, center, exposure, weights;
  glm::ivec4 departures, sampling, tiles, samples;
};
static_assert(sizeof(PictureBlock) == 12 * sizeof(glm::vec4));

// In the stencil: 1 + which of kCellsOfShader is for the face, and which pixels are means of samples.
constexpr GLint kSampled = 4;
static_assert(kCellsOfShader.size() < kSampled);

// Limits of RendererOptions::part_px. With the most samples a part's texture is then within 16384 pixels a side.
constexpr std::uint32_t kLeastPart = 64, kMostPart = 4000;

template <typename T>
GlTexture table_of(const GlTableFormat& format, const std::vector<T>& entries, const char* what) {
  return make_table(format, std::as_bytes(std::span<const T>(entries)), what);
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

// Image x right and y down from the top left corner to clip coordinates, where y is up.
glm::vec4 clip_from_cam(const Camera& camera) {
  return glm::dvec4(2 * camera.fx / camera.width, -2 * camera.fy / camera.height, 2 * camera.cx / camera.width - 1,
                    1 - 2 * camera.cy / camera.height);
}

PixelDiagnosis unpacked(const std::uint32_t* packed) {
  const auto share = [](std::uint32_t bits) { return static_cast<float>(bits & 0xFFFFu) / 65535.0f; };
  return {packed[0], ViewSlot{packed[1]}, {share(packed[2]), share(packed[2] >> 16), share(packed[3])}};
}

// Returns where the copied pixels of a part are in the framebuffer that it was drawn into, and in the whole picture.
ReadPlace place_of(const PicturePart& part, std::uint32_t whole_width) {
  const auto& [drawn, copied] = part;
  return {copied.left - drawn.left,
          drawn.top + drawn.height - copied.top - copied.height,
          copied.width,
          copied.height,
          copied.left,
          copied.top,
          whole_width};
}

// Copies four values of each pixel of a drawn part into a whole image.
template <typename T>
void read_part(const GlFramebuffer& framebuffer, GLenum attachment, GLenum format, GLenum type, const PicturePart& part,
               std::uint32_t whole_width, std::vector<T>& image) {
  read_values(framebuffer, attachment, format, type, place_of(part, whole_width), 4 * sizeof(T),
              reinterpret_cast<std::byte*>(image.data()));
}

void check_steps(const RendererOptions& steps) {
  if (steps.part_px >= kLeastPart && steps.part_px <= kMostPart) return;
  throw std::invalid_argument("renderer: part_px is " + std::to_string(steps.part_px) + ", must be in [" +
                              std::to_string(kLeastPart) + ", " + std::to_string(kMostPart) + "]");
}

[[noreturn]] void throw_not_loaded() {
  throw std::invalid_argument("renderer: no snapshot is loaded, load() must come first");
}

void check_depth(const HostDepth& depth) {
  if (std::isfinite(depth.at_infinity) && std::isfinite(depth.per_reciprocal) && depth.per_reciprocal != 0) return;
  throw std::invalid_argument("renderer: the host's depth is " + number_text(depth.at_infinity) + " + " +
                              number_text(depth.per_reciprocal) + " / z, must be finite and depend on z");
}

void bind_texture(TextureUnit unit, GLenum target, const GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.get());
  glActiveTexture(GL_TEXTURE0 + kSpareUnit);
}

}  // namespace

HostDepth HostDepth::between(double nearest, double farthest) {
  if (!(nearest > 0 && nearest < farthest && std::isfinite(farthest))) {
    throw std::invalid_argument("host depth: it is between " + number_text(nearest) + " and " + number_text(farthest) +
                                ", must be finite, above 0 and ascending");
  }
  const double at_infinity = farthest / (farthest - nearest);
  return {at_infinity, -at_infinity * nearest};
}

HostDepth HostDepth::reversed(double nearest) {
  if (!(nearest > 0 && std::isfinite(nearest))) {
    throw std::invalid_argument("host depth: the nearest is " + number_text(nearest) + ", must be finite and above 0");
  }
  return {0, nearest};
}

std::uint64_t array_bytes(const Snapshot& snapshot) {
  check(snapshot);
  return array_shape(snapshot).bytes();
}

// A framebuffer of another program, and where the picture's lower left corner comes to in it.
struct HostTarget {
  GLuint framebuffer;
  int left, bottom;
  std::optional<HostDepth> depth;
};

// Leftovers of a former snapshot, and of the preparation of the one that replaced it.
struct LeftOver {
  SnapshotPreparation::Rest preparation;
  std::shared_ptr<const SnapshotTables> tables;
  std::shared_ptr<const DrawnZones> zones;
  std::shared_ptr<const ZoneReferences> lists;
  std::vector<RankedReference> ranked;
};

// Memory of textures that are not drawn from any more. The driver may use it until another picture has been drawn.
struct RetiredMemory {
  std::shared_ptr<ArrayTextures> textures;
  bool is_drawn_over = false;  // the picture after these is begun
};

struct Renderer::State {
  State() = default;
  ~State() {
    if (upload) upload->preparation().cancel();  // another thread may wait in prepare()
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  RendererOptions steps;
  PassListener listener;
  UploadListener upload_listener;
  bool in_software = false;   // the driver draws so
  bool clip_control = false;  // see has_clip_control()
  ShaderPrograms programs;
  GlVertexArray no_vertices;
  GlBuffer picture_block;
  std::vector<MeshObjects> batches;  // of `zones`, or where that is null of `former_zones`
  GlTexture zone_table, cell_table;
  GlTable reference_lists{kPairs, kReferencesName};
  GlTable views{kVectors, kViewsName};
  GlBuffer views_block;  // the same, of kBlockTexels, where they fit
  PhotographArray photographs;
  std::shared_ptr<const SnapshotTables> tables;    // null before load()
  std::shared_ptr<const DrawnZones> zones;         // of the mesh; null: it is made with the next picture
  std::shared_ptr<const DrawnZones> former_zones;  // of `batches`, where `zones` is null
  std::shared_ptr<const ZoneReferences> lists;
  std::vector<RankedReference> ranked;  // the references of `lists` in the order that is drawn
  FallbackColors loaded_colors;         // of all batches
  RunsOfShaders seen_runs;              // by the camera of the part that is drawn
  double focal_length = 0;              // of that camera
  bool loaded = false;
  std::uint64_t meshes = 0;  // that were loaded
  SideThread side;
  std::vector<RetiredMemory> retired;
  std::shared_ptr<SnapshotUpload> upload;
  BlendOptions upload_options;  // of the pictures that the next snapshot is for
  bool upload_joins_cells = true;
  PartTargets targets;
  WholeTarget whole;

  // Tells the listener, if there is one, of a pass.
  void tell(const char* pass) const;
  void tell_upload(UploadStep step) const;
  void take_tables(const Snapshot& snapshot);
  void load_references();
  [[nodiscard]] std::uint64_t bytes_allocated_here() const;
  void retire_array();
  void free_retired();
  void free_all_retired();
  void drop_upload();
  void take_upload();
  void rank(const Camera& camera, const BlendOptions& options);
  // The number of levels, finest first, that are sampled cubically.
  [[nodiscard]] std::uint32_t sampled_cubic(const BlendOptions& options) const;
  void renew_colors();
  void load_zones(double width);
  void take_batches(const DrawnZones* former, const DrawnZones& next, std::optional<MeshObjects> added);
  void describe(const Camera& camera, const glm::dvec3& exposure, const BlendOptions& options) const;
  void store_views(std::vector<glm::vec4> table);
  [[nodiscard]] bool continues_outlines(const BlendOptions& options) const;
  [[nodiscard]] bool views_in_block() const { return views_block.get() != 0; }
  [[nodiscard]] bool make_next_program();
  void bind_tables() const;
  void draw_surface(const SurfaceTargets& target, std::uint32_t across);
  void draw_faces(bool marks);
  void draw_screen(GLuint program, const GlTexture& surfaces) const;
  void draw_blend(const ColorTargets& target, const BlendOptions& options, Output output);
  void mark_sampled(const ColorTargets& target);
  void copy_colors(ColorTargets& target, Output output);
  void draw_samples(ColorTargets& target, const BlendOptions& options, Output output);
  void continue_outlines(const BlendOptions& options);
  void soften_edges(ColorTargets& target, Output output, bool are_marked);
  void draw_part(ColorTargets& target, const BlendOptions& options, Output output);
  void copy_part(const PicturePart& part) const;
  void present_part(const PicturePart& part, const HostTarget& host);
  [[nodiscard]] ProgramKey blend_key(Pass pass, std::uint32_t most_cells, const BlendOptions& options,
                                     Output output) const;
  [[nodiscard]] std::vector<ProgramKey> picture_keys(const BlendOptions& options, double edge_deviation) const;
  [[nodiscard]] std::vector<PicturePart> parts() const { return parts_of(whole.width, whole.height, steps.part_px); }
  // Draws the surface of each part of the picture, and calls `draw_rest` for what else there is to draw of it.
  template <typename DrawRest>
  void draw_parts(const Camera& camera, const BlendOptions& options, const DrawRest& draw_rest);
  void draw_picture(const Camera& camera, const BlendOptions& options);
  [[nodiscard]] std::vector<float> draw_floats(const Camera& camera, const BlendOptions& options, Output output);
  [[nodiscard]] Rendering read_back() const;
};

void Renderer::State::tell(const char* pass) const {
  if (listener) listener(pass);
}

void Renderer::State::tell_upload(UploadStep step) const {
  if (upload_listener) upload_listener(step);
}

// Takes those of a snapshot, and what of the mesh on the GPU depends on them. The mesh stays where the surface does.
void Renderer::State::take_tables(const Snapshot& snapshot) {
  const SameTables same = same_tables(tables.get(), snapshot);
  tables = tables_after(tables.get(), snapshot);
  if (!stays(zones.get(), same)) {
    if (zones) former_zones = std::exchange(zones, nullptr);
    return;  // all is made when it is drawn
  }
  if (!same.references || !same.deviation) load_references();
}

// Brings the loaded mesh's colours up to date.
void Renderer::State::renew_colors() {
  if (loaded_colors == tables->vertex_colors) return;
  for (std::size_t i = 0; i < batches.size(); ++i) {
    const std::vector<glm::u8vec3> copies = copied_colors(tables->vertex_colors, zones->batches[i]);
    const auto bytes = std::as_bytes(std::span<const glm::u8vec3>(copies));
    glBindBuffer(GL_COPY_WRITE_BUFFER, batches[i].colors.get());
    glBufferSubData(GL_COPY_WRITE_BUFFER, 0, static_cast<GLsizeiptr>(bytes.size()), bytes.data());
  }
  check_gl("renewing the mesh's colours");
  loaded_colors = tables->vertex_colors;
}

// Keeps the batches that are in both, and appends the one that is not.
void Renderer::State::take_batches(const DrawnZones* former, const DrawnZones& next, std::optional<MeshObjects> added) {
  std::vector<MeshObjects> kept;
  for (std::size_t i = 0; former != nullptr && i < former->batches.size() && kept.size() < next.batches.size(); ++i) {
    if (former->batches[i].number == next.batches[kept.size()].number) kept.push_back(std::move(batches[i]));
  }
  if (added) kept.push_back(std::move(*added));
  batches = std::move(kept);
}

void Renderer::State::load_references() {
  const std::shared_ptr<const DrawnZones> of_zones = std::exchange(zones, nullptr);  // until all is there
  former_zones = of_zones;
  lists = lists_of(*tables, *of_zones);
  zone_table = table_of(kRecords, lists->zones, kZonesName);
  cell_table = table_of(kRecords, lists->cells, kCellsName);
  ranked = unranked(*lists);
  zones = of_zones;
}

// Orders the references for a picture, if pixels may stop early, and copies them to the GPU.
void Renderer::State::rank(const Camera& camera, const BlendOptions& options) {
  if (steps.skip_losers) rank_references(*lists, zones->balls, camera, tables->stored_centers, options, ranked);
  reference_lists.store(std::as_bytes(std::span<const RankedReference>(ranked)));
  tell("ranking");
}

// Mesh and zones for a width as in BlendOptions.
void Renderer::State::load_zones(double width) {
  if (zones && zones->border_width == width) {
    renew_colors();
    return;
  }
  if (zones) former_zones = std::exchange(zones, nullptr);
  MadeZones made = make_zones(*tables, width, steps.join_cells, former_zones.get());
  std::optional<MeshObjects> added;
  if (made.mesh) {
    made.mesh->colors = copied_colors(tables->vertex_colors, made.zones->batches.back());
    added = make_mesh_objects(*made.mesh);
    ++meshes;
  }
  take_batches(former_zones.get(), *made.zones, std::move(added));
  former_zones = nullptr;
  zones = std::move(made.zones);
  renew_colors();
  load_references();
}

std::uint32_t Renderer::State::sampled_cubic(const BlendOptions& options) const {
  return tables && options.sampling == BlendOptions::Sampling::cubic ? tables->cubic_levels : 0;
}

// For all passes of a part of a picture, which is shown in that exposure.
void Renderer::State::describe(const Camera& camera, const glm::dvec3& exposure, const BlendOptions& options) const {
  PictureBlock block{};
  const std::array<glm::vec4, 3> rows = rows_of_pose(camera);
  std::copy(rows.begin(), rows.end(), block.cam_from_world);
  block.intrinsics = glm::dvec4(camera.fx, camera.fy, camera.cx, camera.cy);
  block.clip_from_cam = clip_from_cam(camera);
  block.center = glm::dvec4(camera.center(), camera.height);
  block.exposure = glm::dvec4(exposure, tables->near_depth);
  block.weights = glm::dvec4(options.lambda, 1 + options.occlusion_tolerance, options.frame_fade, tables->before_far);
  block.departures = {options.position == BlendOptions::Position::printed, options.rims, options.fade_last,
                      options.consistent};
  const ArrayShape& shape = photographs.shape();
  block.sampling = {static_cast<int>(sampled_cubic(options)), static_cast<int>(shape.levels), options.prefilter,
                    steps.skip_losers};
  const ArrayContents& contents = photographs.contents();
  block.tiles = glm::ivec4(glm::ivec2(contents.tile_size), contents.gutter, shape.columns);
  block.samples = {static_cast<int>(shape.rows), static_cast<int>(options.supersample),
                   options.antialias == BlendOptions::Antialias::all, options.soften};
  glBindBuffer(GL_UNIFORM_BUFFER, picture_block.get());
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof(block), &block);
  glBindBufferBase(GL_UNIFORM_BUFFER, kPictureBinding, picture_block.get());
}

// Copies the views' numbers to the GPU: to a uniform block, which shaders read faster than a texture, if they fit.
void Renderer::State::store_views(std::vector<glm::vec4> table) {
  if (table.size() > kBlockTexels) {
    views_block = {};
    views.store(std::as_bytes(std::span<const glm::vec4>(table)));
    return;
  }
  table.resize(kBlockTexels);
  views_block = make_buffer(table);
  views = GlTable(kVectors, kViewsName);
}

void Renderer::State::bind_tables() const {
  if (views_in_block()) {
    glBindBufferBase(GL_UNIFORM_BUFFER, kViewsBinding, views_block.get());
  } else {
    bind_texture(TextureUnit::views, GL_TEXTURE_2D, views.texture());
  }
  bind_texture(TextureUnit::photographs, GL_TEXTURE_2D_ARRAY, photographs.photographs());
  bind_texture(TextureUnit::raw_texels, GL_TEXTURE_2D_ARRAY, photographs.raw_texels());
  bind_texture(TextureUnit::depths, GL_TEXTURE_2D_ARRAY, photographs.depths());
  bind_texture(TextureUnit::zones, GL_TEXTURE_2D, zone_table);
  bind_texture(TextureUnit::cells, GL_TEXTURE_2D, cell_table);
  bind_texture(TextureUnit::references, GL_TEXTURE_2D, reference_lists.texture());
  bind_texture(TextureUnit::tile_slots, GL_TEXTURE_2D, photographs.tile_slots());
}

// Draws the surface at `across` texels a pixel. For the middles it is drawn everywhere, and the stencil says then which
// shader a pixel is for. For the samples it is drawn only where the stencil says that a pixel is their mean.
void Renderer::State::draw_surface(const SurfaceTargets& target, std::uint32_t across) {
  constexpr std::array<GLuint, 4> kNoSurface{0xFFFFFFFFu, 0, 0, 0};
  glBindFramebuffer(GL_FRAMEBUFFER, target.pass.get());
  glViewport(0, 0, static_cast<GLsizei>(across * targets.width), static_cast<GLsizei>(across * targets.height));
  glClearBufferuiv(GL_COLOR, 0, kNoSurface.data());
  const GLfloat farthest = 0;
  const GLint no_face = 0;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  const bool of_middles = &target == &targets.middles;
  if (of_middles) glClearBufferiv(GL_STENCIL, 0, &no_face);
  glEnable(GL_STENCIL_TEST);
  glStencilOp(GL_KEEP, GL_KEEP, of_middles ? GL_REPLACE : GL_KEEP);
  if (!of_middles) glStencilFunc(GL_EQUAL, kSampled, 0xFF);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  if (clip_control) set_clip_control(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  draw_faces(of_middles);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_DEPTH_TEST);
  check_gl("drawing the surface");
  tell(of_middles ? "surface" : "surface of samples");
}

// Draws the faces that the part's camera may see. With `marks`, they write to the stencil which shader they are for.
void Renderer::State::draw_faces(bool marks) {
  const GLuint program = programs.get({.pass = Pass::surface});
  glUseProgram(program);
  const GLint first_zone = glGetUniformLocation(program, "first_zone");
  std::optional<std::uint32_t> bound;  // batch
  for (std::size_t i = 0; i < seen_runs.size(); ++i) {
    if (marks) glStencilFunc(GL_ALWAYS, static_cast<GLint>(i) + 1, 0xFF);
    for (const auto& [batch, run] : seen_runs.at(i)) {
      if (batch != bound) {
        glBindVertexArray(batches[batch].vertices.get());
        glUniform1ui(first_zone, zones->batches[batch].first_zone);
        bound = batch;
      }
      // OpenGL takes an offset in the buffer as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
      const auto* const offset = reinterpret_cast<const void*>(sizeof(glm::uvec3) * run.first);
      glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * run.count), GL_UNSIGNED_INT, offset);
    }
  }
  glBindVertexArray(0);
}

// One fragment a pixel. `surfaces`: the texture of that name, or of `variances`, in the program.
void Renderer::State::draw_screen(GLuint program, const GlTexture& surfaces) const {
  bind_texture(TextureUnit::surfaces, GL_TEXTURE_2D, surfaces);
  glUseProgram(program);
  glBindVertexArray(no_vertices.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
  glUseProgram(0);  // a program in use outlives its deletion, with its shaders
}

ProgramKey Renderer::State::blend_key(Pass pass, std::uint32_t most_cells, const BlendOptions& options,
                                      Output output) const {
  return {.pass = pass,
          .views = options.views,
          .cells = most_cells,
          .output = output,
          .cubic = sampled_cubic(options) > 0,
          .views_in_block = views_in_block(),
          .filtered_taps = steps.filtered_taps.value_or(!in_software),
          .raw_texels = photographs.raw_texels().get() != 0 && !steps.filtered_taps.value_or(!in_software)};
}

bool Renderer::State::continues_outlines(const BlendOptions& options) const {
  return options.outlines && tables->most_edge_deviation > 0;
}

// Continues the middles' surface past outlines. Pixels that it comes to are for the shader of the most cells, which
// draws all. The target of the samples, which are drawn later, has the surface as it was, in its lower left corner.
void Renderer::State::continue_outlines(const BlendOptions& options) {
  add_soft_edges(targets);
  add_samples(targets, options.supersample);
  const auto width = static_cast<GLint>(targets.width), height = static_cast<GLint>(targets.height);
  glViewport(0, 0, width, height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.middles.pass.get());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.samples.pass.get());
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.edge_rows_pass.get());
  draw_screen(programs.get({.pass = Pass::outline_rows}), targets.middles.surface);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.middles.pass.get());
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, static_cast<GLint>(kCellsOfShader.size()), 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  const GLuint program = programs.get({.pass = Pass::outlines});
  glUseProgram(program);
  glUniform1f(glGetUniformLocation(program, "most_deviation"), static_cast<GLfloat>(tables->most_edge_deviation));
  bind_texture(TextureUnit::middles, GL_TEXTURE_2D, targets.edge_rows);
  draw_screen(program, targets.samples.surface);
  glDisable(GL_STENCIL_TEST);
  check_gl("continuing outlines");
  tell("outlines");
}

// The middles of all pixels, by the surface that is drawn of them. The framebuffer has their stencil.
void Renderer::State::draw_blend(const ColorTargets& target, const BlendOptions& options, Output output) {
  constexpr std::array<GLfloat, 4> kEmpty{};
  glBindFramebuffer(GL_FRAMEBUFFER, target.pass.get());
  glViewport(0, 0, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
  glClearBufferfv(GL_COLOR, 0, kEmpty.data());
  glEnable(GL_STENCIL_TEST);
  glStencilMask(0);  // then it is tested before a pixel is shaded
  for (std::size_t i = 0; i < kCellsOfShader.size(); ++i) {
    const bool may_be_continued = continues_outlines(options) && i + 1 == kCellsOfShader.size();
    if (seen_runs.at(i).empty() && !may_be_continued) continue;
    glStencilFunc(GL_EQUAL, static_cast<GLint>(i) + 1, 0xFF);
    draw_screen(programs.get(blend_key(Pass::blend, kCellsOfShader.at(i), options, output)), targets.middles.surface);
  }
  glStencilMask(0xFF);
  glDisable(GL_STENCIL_TEST);
  check_gl("blending views");
  tell("blend");
}

// Marks in the stencil which pixels are means of samples, as the middles' surface tells, and copies the marks to the
// stencil of the samples' own surface.
void Renderer::State::mark_sampled(const ColorTargets& target) {
  const auto width = static_cast<GLint>(targets.width);
  const auto height = static_cast<GLint>(targets.height);
  const auto across = static_cast<GLint>(targets.samples_across);
  glBindFramebuffer(GL_FRAMEBUFFER, target.pass.get());
  glViewport(0, 0, width, height);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, kSampled, 0xFF);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  draw_screen(programs.get({.pass = Pass::silhouettes}), targets.middles.surface);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_STENCIL_TEST);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.samples.pass.get());
  glBlitFramebuffer(0, 0, width, height, 0, 0, across * width, across * height, GL_STENCIL_BUFFER_BIT, GL_NEAREST);
  check_gl("marking silhouettes");
  tell("silhouettes");
}

// Copies the part's picture to where a pass can read it that changes it.
void Renderer::State::copy_colors(ColorTargets& target, Output output) {
  add_copy(targets, target, output == Output::srgb ? GL_RGBA8 : GL_RGBA32F);
  const auto width = static_cast<GLint>(targets.width), height = static_cast<GLint>(targets.height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.pass.get());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.copy_pass.get());
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

// Means over samples in place of the middles' colours, whose states stay, where the middles' surface says so.
void Renderer::State::draw_samples(ColorTargets& target, const BlendOptions& options, Output output) {
  add_samples(targets, options.supersample);
  mark_sampled(target);
  draw_surface(targets.samples, options.supersample);
  copy_colors(target, output);
  bind_texture(TextureUnit::middles, GL_TEXTURE_2D, targets.middles.surface);
  bind_texture(TextureUnit::middle_colors, GL_TEXTURE_2D, target.copy);
  glBindFramebuffer(GL_FRAMEBUFFER, target.pass.get());
  glViewport(0, 0, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, kSampled, 0xFF);
  glStencilMask(0);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  draw_screen(programs.get(blend_key(Pass::samples, kCellsOfShader.back(), options, output)), targets.samples.surface);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glStencilMask(0xFF);
  glDisable(GL_STENCIL_TEST);
  check_gl("drawing means over samples");
  tell("samples");
}

// Blurs the part's picture across depth edges, as the middles' surface tells. `are_marked`: the stencil has them all.
void Renderer::State::soften_edges(ColorTargets& target, Output output, bool are_marked) {
  if (!(tables->most_edge_deviation > 0)) return;
  add_soft_edges(targets);
  const auto width = static_cast<GLsizei>(targets.width);
  const auto height = static_cast<GLsizei>(targets.height);
  constexpr std::array<GLuint, 4> kNoEdge{};
  glViewport(0, 0, width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.edges_pass.get());
  glClearBufferuiv(GL_COLOR, 0, kNoEdge.data());
  const GLuint edges = programs.get({.pass = Pass::edges});
  glUseProgram(edges);
  glUniform1f(glGetUniformLocation(edges, "most_deviation"), static_cast<GLfloat>(tables->most_edge_deviation));
  if (are_marked) {
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_EQUAL, kSampled, 0xFF);
    glStencilMask(0);
  }
  draw_screen(edges, targets.middles.surface);
  glStencilMask(0xFF);
  glDisable(GL_STENCIL_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.edge_rows_pass.get());
  glClearBufferuiv(GL_COLOR, 0, kNoEdge.data());
  draw_screen(programs.get({.pass = Pass::edge_rows}), targets.edges);
  copy_colors(target, output);
  glBindFramebuffer(GL_FRAMEBUFFER, target.pass.get());
  bind_texture(TextureUnit::photographs, GL_TEXTURE_2D, target.copy);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
  draw_screen(programs.get({.pass = Pass::soft_edges, .output = output}), targets.edge_rows);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  check_gl("softening edges");
  tell("soft edges");
}

// All of a part but its surface.
void Renderer::State::draw_part(ColorTargets& target, const BlendOptions& options, Output output) {
  draw_blend(target, options, output);
  if (options.supersample > 1) draw_samples(target, options, output);
  if (!options.soft_edges || output == Output::fetches) return;
  soften_edges(target, output, options.supersample > 1 && focal_length * kEdgeBend > kSilhouetteBend);
}

// Copies a drawn part into the whole picture.
void Renderer::State::copy_part(const PicturePart& part) const {
  const ReadPlace from = place_of(part, whole.width);
  const auto x = static_cast<GLint>(from.x), y = static_cast<GLint>(from.y);
  const auto width = static_cast<GLint>(from.width), height = static_cast<GLint>(from.height);
  const auto left = static_cast<GLint>(from.left);
  const auto bottom = static_cast<GLint>(whole.height - from.top - from.height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.colors.pass.get());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, whole.pass.get());
  glBlitFramebuffer(x, y, x + width, y + height, left, bottom, left + width, bottom + height, GL_COLOR_BUFFER_BIT,
                    GL_NEAREST);
  check_gl("copying a part of the picture");
}

// Copies a drawn part into the framebuffer of another program.
void Renderer::State::present_part(const PicturePart& part, const HostTarget& host) {
  const ReadPlace from = place_of(part, whole.width);
  const int left = host.left + static_cast<int>(from.left);
  const int bottom = host.bottom + static_cast<int>(whole.height - from.top - from.height);
  const GLuint program = programs.get({.pass = Pass::present, .host_depth = host.depth.has_value()});
  glUseProgram(program);
  glUniform2i(glGetUniformLocation(program, "corner"), left - static_cast<int>(from.x),
              bottom - static_cast<int>(from.y));
  glBindFramebuffer(GL_FRAMEBUFFER, host.framebuffer);
  glViewport(left, bottom, static_cast<GLsizei>(from.width), static_cast<GLsizei>(from.height));
  if (host.depth) {
    glUniform2f(glGetUniformLocation(program, "host_depth"), static_cast<GLfloat>(host.depth->at_infinity),
                static_cast<GLfloat>(host.depth->per_reciprocal));
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(host.depth->per_reciprocal < 0 ? GL_LEQUAL : GL_GEQUAL);
  }
  bind_texture(TextureUnit::photographs, GL_TEXTURE_2D, targets.colors.picture);
  draw_screen(program, targets.middles.surface);
  glDisable(GL_DEPTH_TEST);
  check_gl("drawing into the caller's framebuffer");
}

template <typename DrawRest>
void Renderer::State::draw_parts(const Camera& camera, const BlendOptions& options, const DrawRest& draw_rest) {
  const glm::dvec3 exposure = picture_exposure(tables->nearby_exposure, camera, options);
  for (const PicturePart& part : parts()) {
    const Camera of_part = camera_of_part(camera, part.drawn);
    describe(of_part, exposure, options);
    seen_runs = zones->in_view(of_part);
    focal_length = camera.fx;
    draw_surface(targets.middles, 1);
    if (continues_outlines(options)) continue_outlines(options);
    draw_rest(part);
  }
}

void Renderer::State::draw_picture(const Camera& camera, const BlendOptions& options) {
  draw_parts(camera, options, [&](const PicturePart& part) {
    draw_part(targets.colors, options, Output::srgb);
    copy_part(part);
  });
}

// Returns the four channels of each pixel as floats.
std::vector<float> Renderer::State::draw_floats(const Camera& camera, const BlendOptions& options, Output output) {
  ColorTargets target = make_float_colors(targets);
  std::vector<float> rgba(std::size_t{4} * whole.width * whole.height);
  draw_parts(camera, options, [&](const PicturePart& part) {
    draw_part(target, options, output);
    read_part(target.pass, GL_COLOR_ATTACHMENT0, GL_RGBA, GL_FLOAT, part, whole.width, rgba);
  });
  return rgba;
}

Rendering Renderer::State::read_back() const {
  std::vector<std::uint8_t> rgba(std::size_t{4} * whole.width * whole.height);
  read_values(whole.pass, GL_COLOR_ATTACHMENT0, GL_RGBA, GL_UNSIGNED_BYTE,
              {0, 0, whole.width, whole.height, 0, 0, whole.width}, 4, reinterpret_cast<std::byte*>(rgba.data()));
  Rendering rendering;
  rendering.picture.width = whole.width;
  rendering.picture.height = whole.height;
  rendering.picture.rgb.resize(rgba.size() / 4 * 3);
  rendering.state.resize(rgba.size() / 4);
  for (std::size_t pixel = 0; pixel < rendering.state.size(); ++pixel) {
    std::copy_n(&rgba[4 * pixel], 3, &rendering.picture.rgb[3 * pixel]);
    rendering.state[pixel] = static_cast<PixelState>(rgba[4 * pixel + 3]);
  }
  return rendering;
}

Renderer::Renderer(const RendererOptions& steps) : state_(std::make_unique<State>()) {
  check_steps(steps);
  const GlStateGuard guard;
  state_->steps = steps;
  state_->in_software = draws_in_software();
  state_->clip_control = has_clip_control();
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  state_->no_vertices = GlVertexArray(name);
  state_->picture_block = make_buffer(std::vector<PictureBlock>(1));
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

RendererWork Renderer::work() const {
  const PhotographArray& photographs = state_->photographs;
  const WholeTarget& whole = state_->whole;
  return {state_->meshes,           photographs.color_bytes(),
          photographs.mask_bytes(), photographs.depth_bytes(),
          state_->programs.count(), state_->targets.bytes + kColorBytes * whole.width * whole.height};
}

void Renderer::set_options(const RendererOptions& steps) {
  check_steps(steps);
  if (state_->steps.join_cells != steps.join_cells) state_->zones = nullptr;
  state_->steps = steps;
}

void Renderer::set_listener(PassListener listener) {
  state_->listener = std::move(listener);
}

void Renderer::set_upload_listener(UploadListener listener) {
  state_->upload_listener = std::move(listener);
}

void Renderer::load(const Snapshot& snapshot) {
  State& state = *state_;
  check_after(state.tables.get(), snapshot);
  const GlStateGuard guard;
  state.drop_upload();
  state.retired.clear();  // at once, before more memory is asked for
  state.loaded = false;
  state.photographs.load(snapshot, state.steps.blocks.value_or(!state.in_software));
  state.take_tables(snapshot);
  state.store_views(view_table(snapshot, state.photographs.contents()));
  state.loaded = true;
}

// Returns the bytes of a next snapshot's objects up to which upload() allocates them.
std::uint64_t Renderer::State::bytes_allocated_here() const {
  constexpr std::uint64_t kFewBytes = 1 << 20;  // software clears them in some tenths of a millisecond
  if (steps.allocate_aside) return *steps.allocate_aside ? 0 : std::numeric_limits<std::uint64_t>::max();
  return in_software ? kFewBytes : std::numeric_limits<std::uint64_t>::max();
}

// Gives the next snapshot up. Its memory, which may be much, is freed beside the thread that draws.
void Renderer::State::drop_upload() {
  if (!upload) return;
  upload->preparation().cancel();
  std::shared_ptr<SnapshotPreparation> preparation = upload->shared_preparation();
  side.free_objects(std::exchange(upload, nullptr));
  side.free_later(std::move(preparation));
}

NextSnapshot Renderer::begin(Snapshot snapshot, const BlendOptions& options) {
  check(options);
  State& state = *state_;
  state.drop_upload();
  const RendererOptions& steps = state.steps;
  const auto preparation = std::make_shared<SnapshotPreparation>(
      std::move(snapshot),
      FormerSnapshot{state.tables, state.zones, state.lists, state.loaded_colors, state.photographs.shared_contents(),
                     state.photographs.unknown_places()},
      PreparationOptions{options.border_width, steps.join_cells, steps.blocks.value_or(!state.in_software),
                         limits_of_driver(), steps.waiting_bytes, std::this_thread::get_id()});
  state.upload = std::make_shared<SnapshotUpload>(preparation, state.side, state.bytes_allocated_here());
  state.upload_options = options;
  state.upload_joins_cells = steps.join_cells;
  return NextSnapshot(preparation);
}

bool Renderer::upload(double milliseconds) {
  State& state = *state_;
  if (!(milliseconds >= 0)) {
    throw std::invalid_argument("renderer: upload() may take " + number_text(milliseconds) + " ms, must be at least 0");
  }
  if (!state.upload) return true;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double, std::milli>(milliseconds);
  if (state.upload->preparation().is_cancelled()) {
    const GlStateGuard guard;
    state.drop_upload();
    return true;
  }
  const GlStateGuard guard;
  try {
    do {
      if (state.upload->allocates_array()) state.free_all_retired();
      const SnapshotUpload::Progress progress = state.upload->step(state.photographs);
      if (progress != SnapshotUpload::Progress::whole) {
        state.tell_upload(state.upload->last_step());
        if (progress == SnapshotUpload::Progress::waits) return false;
      } else if (state.make_next_program()) {
        state.tell_upload({"program", 0});
      } else {
        state.take_upload();
        state.tell_upload({"exchange", 0});
        return true;
      }
    } while (std::chrono::steady_clock::now() < end);
  } catch (...) {
    state.drop_upload();
    throw;
  }
  return false;
}

// Draws the next snapshot from now on, which is on the GPU as a whole. The side thread frees what is left over.
void Renderer::State::take_upload() {
  SnapshotUpload::Objects objects = upload->take();
  if (objects.mesh) make_vertices(*objects.mesh);
  if (objects.textures.photographs.get() != 0) retire_array();
  auto rest = std::make_shared<LeftOver>();
  rest->preparation = upload->preparation().take_rest();
  const FormerSnapshot& former = rest->preparation.former;
  PreparedTables& prepared = rest->preparation.tables;
  // Another picture, or other options, may have replaced the mesh that the next snapshot was to keep a part of.
  const std::shared_ptr<const DrawnZones> shown = std::exchange(zones, nullptr);  // until all is there
  former_zones = nullptr;
  const bool former_stays = shown && shown == former.zones;
  const bool is_whole = objects.mesh && prepared.zones->batches.size() == 1;
  if (objects.mesh) ++meshes;
  if (former_stays || is_whole) {
    // A picture may have renewed the colours of the batches that stay.
    const bool has_colors = is_whole || !objects.colors.empty() || loaded_colors == former.colors;
    take_batches(former_stays ? shown.get() : nullptr, *prepared.zones, std::move(objects.mesh));
    for (std::size_t i = 0; i < objects.positions.size(); ++i) {
      batches[i].positions = std::move(objects.positions[i]);
      make_vertices(batches[i]);
    }
    for (std::size_t i = 0; i < objects.colors.size(); ++i) {
      batches[i].colors = std::move(objects.colors[i]);
      make_vertices(batches[i]);
    }
    zones = upload_joins_cells == steps.join_cells ? prepared.zones : nullptr;
    if (objects.positions.empty()) loaded_colors = has_colors ? prepared.tables->vertex_colors : FallbackColors();
  } else {
    batches.clear();
  }
  rest->tables = std::exchange(tables, prepared.tables);
  if (former_stays && !objects.positions.empty()) {  // a picture may have brought other colours, which stay
    auto with_colors = std::make_shared<SnapshotTables>(*tables);
    with_colors->vertex_colors = loaded_colors;
    tables = std::move(with_colors);
  }
  rest->zones = shown;
  if (objects.zones.get() != 0) {
    zone_table = std::move(objects.zones);
    cell_table = std::move(objects.cells);
  }
  rest->lists = std::exchange(lists, prepared.lists);
  rest->ranked = std::exchange(ranked, std::move(prepared.references));
  reference_lists = std::move(*objects.references);
  views_block = objects.views_block ? std::move(*objects.views_block) : GlBuffer();
  views = objects.views ? std::move(*objects.views) : GlTable(kVectors, kViewsName);
  photographs.take(std::move(objects.textures), std::move(rest->preparation.array.contents),
                   std::move(*objects.tile_entries));
  loaded = true;
  upload = nullptr;
  side.free_later(std::move(rest));
}

// Keeps the memory of the array for the side thread to free, because that takes long. No other array is kept then, so
// that one at most waits for pictures that may not come.
void Renderer::State::retire_array() {
  if (!side.makes_objects()) return;
  free_all_retired();
  retired.push_back({std::make_shared<ArrayTextures>(photographs.memory())});
}

// Frees all that was retired on the side thread, before that thread does what is asked of it from now on.
void Renderer::State::free_all_retired() {
  for (RetiredMemory& memory : retired) side.free_objects(std::move(memory.textures));
  retired.clear();
}

// Frees what was retired before the last picture. Called once a picture.
void Renderer::State::free_retired() {
  for (RetiredMemory& memory : retired) {
    if (std::exchange(memory.is_drawn_over, true)) side.free_objects(std::move(memory.textures));
  }
  std::erase_if(retired, [](const RetiredMemory& memory) { return memory.textures == nullptr; });
}

// Makes what every kind of picture begins with.
void Renderer::prepare(const Camera& camera, const BlendOptions& options) {
  check(camera);
  check(options);
  State& state = *state_;
  if (!state.loaded) throw_not_loaded();
  state.free_retired();
  if (state.whole.width != camera.width || state.whole.height != camera.height) {
    state.whole = {};
    state.whole = make_whole_target(camera.width, camera.height);
  }
  const PartRect part = state.parts().front().drawn;
  if (state.targets.width != part.width || state.targets.height != part.height) {
    state.targets = {};
    state.targets = make_part_targets(part.width, part.height);
  }
  state.load_zones(options.border_width);
  state.rank(camera, options);
  state.bind_tables();
}

void Renderer::draw(const Camera& camera, const BlendOptions& options) {
  const GlStateGuard guard;
  prepare(camera, options);
  state_->draw_picture(camera, options);
}

void Renderer::draw_into(std::uint32_t framebuffer, int left, int bottom, const Camera& camera,
                         const BlendOptions& options, const std::optional<HostDepth>& depth) {
  if (depth) check_depth(*depth);
  const GlStateGuard guard;
  prepare(camera, options);
  State& state = *state_;
  const HostTarget host{framebuffer, left, bottom, depth};
  state.draw_parts(camera, options, [&](const PicturePart& part) {
    state.draw_part(state.targets.colors, options, Output::srgb);
    state.copy_part(part);
    state.present_part(part, host);
  });
}

void Renderer::make_ready(const BlendOptions& options) {
  check(options);
  State& state = *state_;
  if (!state.loaded) throw_not_loaded();
  const GlStateGuard guard;
  std::vector<ProgramKey> keys = state.picture_keys(options, state.tables->most_edge_deviation);
  keys.push_back({.pass = Pass::present});
  keys.push_back({.pass = Pass::present, .host_depth = true});
  state.programs.make(keys);
  state.load_zones(options.border_width);
}

// Returns the keys of all programs that pictures with these options are drawn with, of a model whose softest edges have
// that deviation.
std::vector<ProgramKey> Renderer::State::picture_keys(const BlendOptions& options, double edge_deviation) const {
  std::vector<ProgramKey> keys{{.pass = Pass::surface}};
  for (const std::uint32_t most_cells : kCellsOfShader) {
    keys.push_back(blend_key(Pass::blend, most_cells, options, Output::srgb));
    if (!(options.border_width > 0)) break;  // no cells fade into each other
  }
  if (options.outlines && edge_deviation > 0) {
    for (const Pass pass : {Pass::outline_rows, Pass::outlines}) keys.push_back({.pass = pass});
    if (!(options.border_width > 0))
      keys.push_back(blend_key(Pass::blend, kCellsOfShader.back(), options, Output::srgb));
  }
  if (options.supersample > 1) {
    keys.push_back({.pass = Pass::silhouettes});
    keys.push_back(blend_key(Pass::samples, kCellsOfShader.back(), options, Output::srgb));
  }
  if (options.soft_edges && edge_deviation > 0) {
    for (const Pass pass : {Pass::edges, Pass::edge_rows, Pass::soft_edges}) keys.push_back({.pass = pass});
  }
  return keys;
}

// Compiles one of the programs that the next snapshot needs and the former did not. Returns false if there is none.
bool Renderer::State::make_next_program() {
  const SnapshotTables& next = *upload->preparation().tables().tables;
  const bool cubic = upload_options.sampling == BlendOptions::Sampling::cubic && next.cubic_levels > 0;
  for (ProgramKey key : picture_keys(upload_options, next.most_edge_deviation)) {
    if (key.pass == Pass::blend || key.pass == Pass::samples) {
      key.cubic = cubic;
      key.views_in_block = upload->views_in_block();
    }
    if (programs.has(key)) continue;
    (void)programs.get(key);
    return true;
  }
  return false;
}

std::uint32_t Renderer::picture_texture() const {
  return state_->whole.picture.get();
}

Rendering Renderer::render(const Camera& camera, const BlendOptions& options) {
  const GlStateGuard guard;
  prepare(camera, options);
  state_->draw_picture(camera, options);
  return state_->read_back();
}

LinearRendering Renderer::render_linear(const Camera& camera, const BlendOptions& options) {
  const GlStateGuard guard;
  prepare(camera, options);
  const std::vector<float> rgba = state_->draw_floats(camera, options, Output::linear);
  LinearRendering rendering{camera.width, camera.height, {}, {}};
  rendering.rgb.reserve(rgba.size() / 4 * 3);
  rendering.state.reserve(rgba.size() / 4);
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    rendering.rgb.insert(rendering.rgb.end(), &rgba[i], &rgba[i] + 3);
    rendering.state.push_back(static_cast<PixelState>(std::lround(255 * rgba[i + 3])));
  }
  return rendering;
}

std::vector<std::uint32_t> Renderer::count_fetches(const Camera& camera, const BlendOptions& options) {
  const GlStateGuard guard;
  prepare(camera, at_middle(options));
  const std::vector<float> rgba = state_->draw_floats(camera, at_middle(options), Output::fetches);
  std::vector<std::uint32_t> counts;
  counts.reserve(rgba.size() / 4);
  for (std::size_t i = 0; i < rgba.size(); i += 4) counts.push_back(static_cast<std::uint32_t>(std::lround(rgba[i])));
  return counts;
}

Diagnosis Renderer::diagnose(const Camera& camera, const BlendOptions& options) {
  const GlStateGuard guard;
  prepare(camera, at_middle(options));
  State& state = *state_;
  const PartTargets& targets = state.targets;
  const GlTexture packed =
      make_texture_2d(GL_RGBA32UI, static_cast<GLsizei>(targets.width), static_cast<GLsizei>(targets.height));
  const GlFramebuffer pass = make_framebuffer({&targets.colors.picture, &packed}, nullptr);
  const GLuint program =
      state.programs.get({.pass = Pass::diagnose, .views = options.views, .views_in_block = state.views_in_block()});
  constexpr std::array<GLfloat, 4> kEmpty{};
  const std::array<GLuint, 4> kNoDiagnosis{0, ViewSlot::none, 0, 0};
  std::vector<std::uint32_t> values(std::size_t{4} * camera.width * camera.height);
  state.draw_parts(camera, at_middle(options), [&](const PicturePart& part) {
    glBindFramebuffer(GL_FRAMEBUFFER, pass.get());
    glClearBufferfv(GL_COLOR, 0, kEmpty.data());
    glClearBufferuiv(GL_COLOR, 1, kNoDiagnosis.data());
    state.draw_screen(program, targets.middles.surface);
    read_part(pass, GL_COLOR_ATTACHMENT1, GL_RGBA_INTEGER, GL_UNSIGNED_INT, part, camera.width, values);
    state.copy_part(part);
  });
  Diagnosis diagnosis{camera.width, camera.height, state.read_back().state, {}};
  diagnosis.pixels.reserve(values.size() / 4);
  for (std::size_t i = 0; i < values.size(); i += 4) diagnosis.pixels.push_back(unpacked(&values[i]));
  return diagnosis;
}

}  // namespace lumatlas
