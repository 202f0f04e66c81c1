// SPDX-License-Identifier: GPL-3.0-or-later
// Renders new viewpoints from a snapshot of the view store, on the GPU: one pass for the visible surface, one that
// blends the best valid views at each visible pixel (Erat et al. 2019, sections 3.1 and 3.4).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/blend_options.h"
#include "blend/diagnosis.h"
#include "blend/next_snapshot.h"
#include "blend/rendering.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// GL memory, bytes, of the texture arrays of a snapshot's photographs and depths. Needs a current context, whose limits
// they are laid out by, with compressed texels in blocks: see RendererOptions::blocks. Throws std::invalid_argument
// unless the snapshot passes check().
[[nodiscard]] std::uint64_t array_bytes(const Snapshot& snapshot);

// Ways to draw faster. None changes a picture beyond rounding, except where two views weigh the same, and
// `filtered_taps`. bench_render measures the first two.
struct RendererOptions {
  bool skip_losers = true;  // look at no photograph whose weight is too low even if it is valid
  bool join_cells = true;   // neighbours that refer to the same views need not fade into each other
  // Compressed texels stay in blocks on the GPU, from the next load() on. Otherwise, and where a driver of OpenGL ES
  // takes none, they take the bytes of TexelFormat::rgb8. None: unless software draws, which is three times as fast
  // then.
  std::optional<bool> blocks = std::nullopt;
  // The texels that a colour is made of are fetched in pairs by the GPU's own filter: 9 fetches in place of 16, or 1 of
  // 4. GPUs weigh the two of a pair in steps of 1/256, so that colours differ a little: see
  // blend/sampling/cubic_kernel.h. None: unless software draws, for which pairs are slower.
  std::optional<bool> filtered_taps = std::nullopt;
  // Longest side, pixels, of the parts that a picture is drawn in, [64, 4000]. What a part is drawn into takes 40
  // bytes a pixel, and 24 more for each sample of a pixel; the picture as a whole takes 4. Smaller parts take less
  // memory and more commands.
  std::uint32_t part_px = 640;
  // Bytes of texels of a next snapshot from which on prepare() waits for upload(): see begin(). Up to 16 MB of tiles
  // are prepared at once, which may wait in addition.
  std::uint64_t waiting_bytes = 64 << 20;
  // A thread of the renderer's own allocates the memory of a next snapshot's textures and buffers, in a second context
  // that shares objects with the one that draws, if that one is EGL's; otherwise upload() does. None: where software
  // draws, which clears such memory at some GB a second, and more than 1 MB is needed.
  std::optional<bool> allocate_aside = std::nullopt;
};

// Counts of the work that a renderer has done since it was made.
struct RendererWork {
  std::uint64_t meshes = 0;       // made of a surface, or of what is new in it, and copied to the GPU
  std::uint64_t color_bytes = 0;  // photographs, with their validity and their coarser levels, copied to the GPU
  std::uint64_t mask_bytes = 0;   // validity alone, and the coarser levels, which it weighs
  std::uint64_t depth_bytes = 0;  // depths
  std::uint64_t programs = 0;     // compiled
  std::uint64_t targets = 0;      // bytes of what the last picture was drawn into, which are on the GPU now
};

// The numbers in a depth buffer of another program, between 0 and 1, for a depth z in the camera's frame:
// at_infinity + per_reciprocal / z. That is what a projection of that program with the camera's pose gives.
struct HostDepth {
  double at_infinity;
  double per_reciprocal;  // not 0; the nearer surface has the smaller number if it is below 0

  // Returns what OpenGL's usual projection gives: 0 at `nearest`, 1 at `farthest`. Throws std::invalid_argument unless
  // 0 < nearest < farthest.
  [[nodiscard]] static HostDepth between(double nearest, double farthest);
  // Returns 1 at `nearest` and 0 at infinity. Throws std::invalid_argument unless it is above 0.
  [[nodiscard]] static HostDepth reversed(double nearest);
};

// Called after the commands of each pass were given to the driver, with the name of the pass: "surface", "blend",
// "outlines", "silhouettes", "surface of samples", "samples" or "soft edges"; and after references were ranked, with
// "ranking". It may ask the driver for the time, and must leave all other state of the context as it is.
using PassListener = std::function<void(const char* pass)>;

class Renderer {
 public:
  // Draws in the context that is current on the calling thread: OpenGL ES 3.0 or OpenGL 4.5, made by any code. This
  // context must be current for every call, and outlive the renderer. Every call leaves the context's state as it was:
  // bindings, switches, masks, viewport, and how pixels are stored.
  // Throws std::invalid_argument unless the options are in their ranges; so does set_options().
  explicit Renderer(const RendererOptions& steps = {});
  // Waits until memory that is allocated aside is there (RendererOptions::allocate_aside).
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // Copies the snapshot to the GPU in place of an earlier one, and only what has changed. For a view that has moved,
  // its state is copied, some hundred bytes; for another mask, validity, coarser levels and depths, but no photograph
  // unless its texels are compressed. Tiles with the same bytes in the same tile place are not copied again, nor is the
  // mesh of the same surface. Of another surface, only those parts of the mesh are made and copied that have changed or
  // lie beside a change, from the second change on. Vertex colours are made, if the snapshot has not made them, with
  // the next picture. Arrays that have become too small grow by a quarter, which is more than array_bytes() says, and
  // are given back when less than half of them is needed. Cells are joined (RendererOptions) until the store or the
  // surface changes.
  // Throws std::invalid_argument, and changes nothing, unless the snapshot passes check(). Throws GlError, naming the
  // limit, the number and what to do, if the driver's limits (layers, texture size, buffer size) are exceeded, or its
  // free memory, if it reports that. The earlier snapshot is then gone too.
  void load(const Snapshot& snapshot);

  // Begins to take the next snapshot while the former one is drawn, and gives up one that was begun before and is not
  // drawn yet. Call prepare() of the result on another thread, and upload() with each frame. Once the snapshot is
  // drawn, pictures are those that load() would give, to the last bit. `options` are those of the pictures to come:
  // with another border width the mesh is made with the first picture. The array of photographs has places for the
  // tiles of both snapshots; where few tiles change, that is little more than for one, and where no tile stays, a
  // second array is made. With a new surface, what is new of the mesh is on the GPU beside the former one meanwhile. A
  // surface that differs from the former one in the places of its vertices alone, as after a loop closure, is only
  // moved, and pictures may be others: cells fade into each other as they did, and where no photograph is, the colours
  // of the former snapshot are shown until a snapshot is begun whose surface has not moved again.
  // Throws std::invalid_argument unless the options pass check().
  [[nodiscard]] NextSnapshot begin(Snapshot snapshot, const BlendOptions& options);
  // Copies parts of the next snapshot to the GPU until about `milliseconds` have passed, one part at least if one is
  // prepared and memory is allocated (RendererOptions::allocate_aside). Parts have at most 256 KB, which takes far less
  // than a millisecond. These steps take longer: the second context, some milliseconds once; a program that the former
  // snapshot did not need, which is compiled at once; and large objects where upload() allocates and frees them.
  // Returns whether nothing is left: the next snapshot is drawn from now on, or there is none. A former array that is
  // replaced is freed at once, except in a context of desktop OpenGL beside which memory is allocated aside. There its
  // memory is freed aside with the second picture of the next snapshot, or when another array is allocated or load() is
  // called. Throws GlError as load() does, and what prepare() has thrown; the former snapshot is drawn on then, and
  // load() may be called. Throws std::invalid_argument unless milliseconds >= 0.
  bool upload(double milliseconds);

  [[nodiscard]] RendererWork work() const;

  // Both take effect from the next picture on.
  void set_options(const RendererOptions& steps);
  void set_listener(PassListener listener);
  // The listener may ask the driver for the time, and must leave all other state of the context as it is.
  void set_upload_listener(UploadListener listener);

  // Makes what the first picture with these options would have to make: the mesh and its zones on the GPU, and all
  // programs of draw() and draw_into(), at the same time where the driver compiles on several threads. Throws
  // std::invalid_argument unless the options pass check(), and without load().
  void make_ready(const BlendOptions& options);

  // Throws GlError for a picture above the driver's texture size or 2^29 pixels, std::invalid_argument unless camera
  // and options pass check(), and without load(). So do the functions below.
  [[nodiscard]] Rendering render(const Camera& camera, const BlendOptions& options);
  // Like render(), but leaves the picture on the GPU, in picture_texture(). The GPU may still be at work on it.
  void draw(const Camera& camera, const BlendOptions& options);
  // The same, and copies the picture into a framebuffer of the caller's (0: the window), where its lower left corner
  // comes to the given pixel: sRGB values as they are, with alpha 1. Pixels that see no surface stay as they were. With
  // `depth`, the framebuffer's depths are compared and written, so that the model hides what the caller has drawn
  // behind it, and is hidden by what is nearer. Throws std::invalid_argument for numbers of `depth` that are not finite
  // or a factor of 0.
  void draw_into(std::uint32_t framebuffer, int left, int bottom, const Camera& camera, const BlendOptions& options,
                 const std::optional<HostDepth>& depth = std::nullopt);
  // Returns the picture that was drawn last: the name of a GL_TEXTURE_2D of GL_RGBA8, sRGB values, its first row the
  // picture's last; alpha is PixelState / 255. It belongs to the renderer: the next picture is drawn into it, and one
  // of another size replaces it. 0 before the first.
  [[nodiscard]] std::uint32_t picture_texture() const;
  // The picture that render() gives, before it is rounded and cut off at white.
  [[nodiscard]] LinearRendering render_linear(const Camera& camera, const BlendOptions& options);
  // Returns the views and weights of the picture that render() returns.
  [[nodiscard]] Diagnosis diagnose(const Camera& camera, const BlendOptions& options);
  // Returns how many texels the shader fetches at the middle of each pixel, row by row; 0 where no surface is seen.
  // With RendererOptions::filtered_taps set, the driver and its GPU have no part in the number. Texels that the GPU
  // filters are one.
  [[nodiscard]] std::vector<std::uint32_t> count_fetches(const Camera& camera, const BlendOptions& options);

 private:
  struct State;
  void prepare(const Camera& camera, const BlendOptions& options);
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
