// SPDX-License-Identifier: GPL-3.0-or-later
// Known errors of a synthetic scene's mesh: what a reconstruction gets wrong although the photographs show the true
// surface. Each depends on the seed, the mesh and its own option alone.
#pragma once

#include <cstdint>

#include "mesh/mesh.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {

// Each vertex is moved along the normal of the surface there, by a distance of its own of mean 0 and of this root mean
// square, scene units. Faces stay as they are.
[[nodiscard]] Mesh with_mesh_noise(Mesh mesh, double rms, std::uint64_t seed);

// The mesh without patches that make up this share of its area, [0, 1), to within a face. A patch is what hangs
// together with a random point of the surface and is nearer to it than a random radius, between 1 and 3 % of the
// diagonal of the mesh's box. Vertices that would join two corners of the rest are parted, so that it stays manifold.
[[nodiscard]] Mesh with_holes(const Mesh& mesh, double share, std::uint64_t seed);

// All of it that the options ask for: noise, then holes, then edge collapses (mesh/repair/decimation.h).
[[nodiscard]] Mesh with_mesh_errors(Mesh mesh, const SynthOptions& options);

}  // namespace lumatlas::synth
