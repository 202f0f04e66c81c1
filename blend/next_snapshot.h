// SPDX-License-Identifier: GPL-3.0-or-later
// A snapshot on its way to a renderer that draws the former one meanwhile:
//
//   NextSnapshot next = renderer.begin(snapshot, options);         // at once, on the thread that draws
//   std::thread worker([next]() mutable {
//     try {
//       next.prepare();
//     } catch (const std::exception&) {  // upload() throws the same
//     }
//   });
//   while (running) {
//     renderer.upload(4);              // at most about 4 ms of each frame
//     renderer.draw(camera, options);  // the former, until the next one is whole
//   }
//   next.cancel();
//   worker.join();
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace lumatlas {

// A step of Renderer::upload().
struct UploadStep {
  // "wait" for another thread, "list" of what is copied next, "allocation", rows of a "page" of the former array, a
  // piece of a "buffer" or "table", rows of a "tile", a "program" that is compiled, or "exchange" of the snapshots.
  const char* what = "wait";
  std::uint64_t bytes = 0;  // that were copied, or of textures that were allocated, on the thread that draws
};

// Called after each step. It must not call the renderer, nor throw.
using UploadListener = std::function<void(const UploadStep&)>;

class SnapshotPreparation;

// Copies stand for the same snapshot.
class NextSnapshot {
 public:
  // Makes all that needs no OpenGL: tables, the mesh of a new surface, and the texels of each tile that is not on the
  // GPU yet. May be called once, on any thread, while the renderer draws and uploads. Returns when all is made. While
  // RendererOptions::waiting_bytes of texels wait, it waits for upload(); std::logic_error if it would wait on the
  // thread that called begin(). cancel(), the renderer's load() and begin(), and its end make it return early, after
  // the step that it is at. Throws std::invalid_argument unless the snapshot passes check(), and what Renderer::load()
  // throws for limits of the driver; upload() throws the same then.
  void prepare();

  // Gives the snapshot up. The renderer goes on with the former one. Any thread may call it.
  void cancel();

  // Returns the bytes of texels that are prepared and not on the GPU yet. Any thread may call it.
  [[nodiscard]] std::uint64_t waiting_bytes() const;

 private:
  friend class Renderer;
  explicit NextSnapshot(std::shared_ptr<SnapshotPreparation> preparation);

  std::shared_ptr<SnapshotPreparation> preparation_;  // never null
};

}  // namespace lumatlas
