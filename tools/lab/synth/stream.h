// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs of a synthetic scene as the stream of an RGB-D sensor, in the form of the TUM benchmark
// (tools/scene/forms/tum_rgbd.h).
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "mesh/camera/camera.h"
#include "tools/lab/synth/tracer.h"

namespace lumatlas::synth {

// One frame of a stream.
struct StreamFrame {
  std::filesystem::path photograph;  // a file, which is copied
  Camera true_camera, written;       // all of one size, without distortion
};

// Writes rgb.txt, depth.txt, groundtruth.txt with the written poses, camera.txt, and the pictures into `folder`, which
// must exist. Depths are those of depth_image() (tools/lab/synth/scan.h). `rate`: frames a second, > 0; the first is at
// 0 seconds. Throws InputError where the folder cannot be written.
void write_stream(const std::filesystem::path& folder, std::span<const StreamFrame> frames, const Tracer& tracer,
                  double rate, std::uint64_t seed);

}  // namespace lumatlas::synth
