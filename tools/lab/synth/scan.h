// SPDX-License-Identifier: GPL-3.0-or-later
// A synthetic scene as a hand-held depth sensor of the structured-light kind sees it, and the mesh that is made of
// that: noisy, rounded off, and with holes where the sensor got nothing back. Noise and limits are those of Nguyen,
// Izadi, Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and tracking", 2012; one scene unit is a
// metre.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/mesh.h"
#include "tools/lab/synth/synth.h"
#include "tools/lab/synth/tracer.h"
#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas::synth {

// Standard deviation of a depth of `depth` scene units.
[[nodiscard]] double axial_noise(double depth);

// One depth image of `scene`, from where the camera is. Nothing is measured nearer than 0.4 or farther than 3.5, at
// more than 75 degrees off the normal, or on surfaces that shine by themselves. The same holds where too little of the
// sensor's own light comes back: from afar, aslant, off dark surfaces, and off metal and gloss, which reflect it
// elsewhere.
[[nodiscard]] DepthImage depth_image(const Tracer& tracer, const Camera& camera, std::uint64_t seed);

// 192 depth images from along the scene's walk, fused into a mesh of about options.triangles faces: of some more
// voxels, then by edge collapses. Pieces of a few faces in the air are left out. Manifold, without colours; the same
// for any number of threads. Throws InputError if the sensor sees nothing at all.
[[nodiscard]] Mesh scanned(const Scene& scene, const Tracer& tracer, const SynthOptions& options);

}  // namespace lumatlas::synth
