// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how long the thread that draws is kept by the next snapshot of a model.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/renderer.h"
#include "mesh/camera/camera.h"

namespace lumatlas {

// The longest time in one frame, beside its picture, milliseconds.
struct SnapshotTime {
  double wall = 0, processor = 0;  // the processor's: of the calling thread alone
  int frames = 0;                  // from the first call until the snapshot can be drawn
};

// Loads the snapshot in one call, with the mesh and programs that pictures of it need.
[[nodiscard]] SnapshotTime time_at_once(Renderer& renderer, const Snapshot& snapshot, const BlendOptions& blend);

// Calls upload(milliseconds) once a frame, while another thread prepares the snapshot and each frame draws the former
// one. The renderer must have one. Throws what Renderer::begin() and upload() throw.
[[nodiscard]] SnapshotTime time_in_pieces(Renderer& renderer, const Snapshot& snapshot, const Camera& camera,
                                          const BlendOptions& blend, double milliseconds);

// Times of all calls of one kind, milliseconds.
struct CallTimes {
  std::string what;
  int calls = 0;
  double wall = 0, longest_wall = 0;            // of all calls, and of one
  double processor = 0, longest_processor = 0;  // the same, of the calling thread alone
  std::uint64_t most_bytes = 0;                 // of one call, as UploadStep::bytes
};

// Takes a snapshot as time_in_pieces() does. Returns the times of "begin()", of "upload()", of the steps of upload() by
// their names, and of each "picture" until the driver has finished it. The "last picture" follows the last step: with
// it drivers may free memory.
[[nodiscard]] std::vector<CallTimes> time_steps(Renderer& renderer, const Snapshot& snapshot, const Camera& camera,
                                                const BlendOptions& blend, double milliseconds);

}  // namespace lumatlas
