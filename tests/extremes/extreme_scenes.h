// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes at the edges of what the program is given: made in memory, changed by a test, written to disk as a user would
// have them, and built by the same function as `lumatlas build` calls. Every colour in their photographs is a function
// of the surface point, so that what a picture should show is known.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "blend/blend_options.h"
#include "blend/rendering.h"
#include "mesh/camera/camera.h"
#include "mesh/mesh.h"
#include "tests/support/temporary_folder.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {

struct EdgeView {
  std::string name;  // of the photograph, relative to images/
  Camera camera;     // in the mesh's coordinates
  Photograph photograph;
};

struct EdgeScene {
  TriangleSoup soup;
  std::vector<EdgeView> views;
};

// The corner of a court: a bumpy floor and two bumpy walls that meet at the origin, 4 x 4 each. Coordinates are
// multiples of 2^-10, so that they can be scaled by powers of two, and moved by whole numbers, without rounding.
[[nodiscard]] TriangleSoup court();
// Looks at the court from in front of it, 96 x 72 pixels; `place` in [0, 1] is from one wall to the other.
[[nodiscard]] Camera court_camera(double place);
// From `center`, towards `target`.
[[nodiscard]] Camera camera_towards(const glm::dvec3& center, const glm::dvec3& target, std::uint32_t width,
                                    std::uint32_t height, double focal_px);

// Linear light of a surface point seen from a camera's centre.
using EdgeShading = std::function<glm::dvec3(const glm::dvec3& point, const glm::dvec3& center)>;
// Three smooth waves, within [0.05, 0.5].
[[nodiscard]] glm::dvec3 court_color(const glm::dvec3& point);
[[nodiscard]] EdgeShading court_shading();

// Draws by ray casting, black where no surface is. `exposure` multiplies the linear light.
[[nodiscard]] Photograph photographed(const TriangleSoup& soup, const Camera& camera,
                                      const EdgeShading& shading = court_shading(), double exposure = 1);
[[nodiscard]] Photograph plain_photograph(const Camera& camera, int level);
// Adds a view with its photograph by photographed().
void add_view(EdgeScene& scene, const Camera& camera);
// The court from `views` places, from wall to wall.
[[nodiscard]] EdgeScene court_scene(std::size_t views);
[[nodiscard]] const EdgeScene& six_views();  // made once
// Sees the court from where no view of it was taken.
[[nodiscard]] Camera novel_camera();

// Writes mesh.ply (in double precision, text), sparse/ and images/ into `folder`, which must exist.
void write_scene(const EdgeScene& scene, const std::filesystem::path& folder);

// Without refinement, with room for all and a threshold of 0: what is asked for is the arithmetic, not the judgement.
[[nodiscard]] BuildOptions plain_build();
// The defaults, quietly.
[[nodiscard]] BuildOptions default_build();

// Writes, builds, and checks what must hold whatever was asked for: every view is answered for, once; what was kept and
// did not leave is stored, and nothing else; every number is finite.
[[nodiscard]] BuildResult built(const EdgeScene& scene, const BuildOptions& options);
// The sentence that the build is refused with, without the scene's folder; "" if it is not.
[[nodiscard]] std::string refused(const EdgeScene& scene, const BuildOptions& options);

[[nodiscard]] std::size_t count_of(const BuildResult& result, Decision decision);
[[nodiscard]] std::vector<std::string> stored_names(const BuildResult& result);  // sorted

// Draws by the CPU reference, from a camera in the mesh's coordinates.
[[nodiscard]] Rendering pictured(const BuildResult& result, const Camera& camera, const BlendOptions& options = {});
// The share of the picture's pixels that are textured.
[[nodiscard]] double textured_share(const Rendering& rendering);
// Root mean square over the textured pixels against a photograph from the same camera, levels; 0 if none is textured.
[[nodiscard]] double textured_error(const Rendering& rendering, const Photograph& truth);

// Every length times `scale`, then turned, then moved.
[[nodiscard]] EdgeScene transformed(EdgeScene scene, double scale, const glm::dmat3& rotation,
                                    const glm::dvec3& translation);
[[nodiscard]] Camera transformed(Camera camera, double scale, const glm::dmat3& rotation,
                                 const glm::dvec3& translation);

}  // namespace lumatlas
