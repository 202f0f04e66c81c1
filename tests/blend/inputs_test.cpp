// SPDX-License-Identifier: GPL-3.0-or-later
// The inputs of a caller that the renderers and their helpers refuse, and a host whose numbers have commas.
#include <catch2/catch.hpp>
#include <clocale>
#include <locale>
#include <optional>
#include <stdexcept>
#include <string>

#include "blend/exposure.h"
#include "blend/gl_visibility.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "blend/sampling/supersampling.h"
#include "blend/tables/cell_runs.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

Snapshot bad_snapshot() {
  Snapshot snapshot = small_snapshot();
  snapshot.references.views[0] = 4;  // a free slot
  return snapshot;
}
const auto kBadSnapshot = Catch::Message("snapshot: references.views[0] is 4, must be a slot with a view");

TEST_CASE("a snapshot whose tables do not fit is drawn by neither renderer") {
  const Snapshot bad = bad_snapshot();
  const Camera camera = forward_camera(8, 6);
  const auto visibility = make_ray_visibility(bad.surface->mesh);
  CHECK_THROWS_MATCHES(render_reference(bad, camera, *visibility, {}), std::invalid_argument, kBadSnapshot);
  CHECK_THROWS_MATCHES(render_reference(bad, camera, visibility->trace(camera), {}), std::invalid_argument,
                       kBadSnapshot);
  CHECK_THROWS_MATCHES(diagnose_reference(bad, camera, visibility->trace(camera), {}), std::invalid_argument,
                       kBadSnapshot);
  Snapshot without_gain = bad;
  without_gain.gains.pop_back();
  CHECK_THROWS_MATCHES(NearbyExposure(without_gain), std::invalid_argument,
                       Catch::Message("snapshot: gains has 4 entries, must have one per slot of views, 5"));
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Renderer renderer;
  CHECK_THROWS_MATCHES(renderer.load(bad), std::invalid_argument, kBadSnapshot);
  CHECK_THROWS_MATCHES(array_bytes(bad), std::invalid_argument, kBadSnapshot);
  renderer.load(small_snapshot());
  const Rendering before = renderer.render(camera, {});
  CHECK_THROWS_AS(renderer.load(bad), std::invalid_argument);
  CHECK(renderer.render(camera, {}).picture.rgb == before.picture.rgb);  // what was loaded stays
}

TEST_CASE("a visibility buffer that is not the camera's and the mesh's is refused") {
  const Snapshot snapshot = small_snapshot();
  const Camera camera = forward_camera(8, 6);
  const VisibilityBuffer good = make_ray_visibility(snapshot.surface->mesh)->trace(camera);
  const auto refused = [&](const VisibilityBuffer& bad, const std::string& sentence) {
    CHECK_THROWS_MATCHES(render_reference(snapshot, camera, bad, {}), std::invalid_argument, Catch::Message(sentence));
    CHECK_THROWS_MATCHES(diagnose_reference(snapshot, camera, bad, {}), std::invalid_argument,
                         Catch::Message(sentence));
  };
  const std::string size = "reference renderer: the visibility buffer must be as large as the camera's image";
  VisibilityBuffer bad = good;
  bad.width = 7;
  refused(bad, size);
  bad = good;
  bad.depth.pop_back();
  refused(bad, size);
  CHECK_THROWS_AS(silhouettes(camera, bad), std::invalid_argument);
  bad = good;
  bad.face.pop_back();
  refused(bad, size);
  CHECK_THROWS_AS(silhouettes(camera, bad), std::invalid_argument);
  bad = good;
  bad.face[5] = 34;
  refused(bad, "reference renderer: pixel 5 of the visibility buffer shows face 34, the mesh has 34");
}

TEST_CASE("samples are as many as a picture may have") {
  const Camera camera = forward_camera(8, 6);
  for (const std::uint32_t across : {0u, 5u}) {
    CHECK_THROWS_MATCHES(sample_cameras(camera, across), std::invalid_argument,
                         Catch::Message("supersampling: across is " + std::to_string(across) + ", must be in [1, 4]"));
  }
  CHECK_THROWS_AS(sample_cameras(Camera{}, 2), std::invalid_argument);
}

TEST_CASE("cells that are not a mesh's are refused") {
  const auto surface = wall_and_panel(3);
  Cells cells = surface->cells;
  cells.cell_of_face[3] = 3;
  CHECK_THROWS_MATCHES(CellRuns(cells, 34), std::invalid_argument,
                       Catch::Message("cells: face 3 is in cell 3, must be below the number of cells, 3"));
  cells = surface->cells;
  cells.cells[1].faces += 1;
  CHECK_THROWS_MATCHES(CellRuns(cells, 34), std::invalid_argument,
                       Catch::Message("cells: cell 1 says that it has 12 faces, but 11 are in it"));
  CHECK_THROWS_AS(make_gl_visibility(surface->mesh, cells), std::invalid_argument);
  Mesh mesh = surface->mesh;
  mesh.faces[2].z = 29;
  CHECK_THROWS_MATCHES(
      make_gl_visibility(mesh, surface->cells), std::invalid_argument,
      Catch::Message("GL visibility: face 2 has the vertex 29, must be below the number of vertices, 29"));
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST_CASE("shaders compile, and draw the same, where the host's numbers have a comma") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = small_snapshot();
  const Camera camera = forward_camera(24, 18);
  const auto picture = [&] {
    Renderer renderer;
    renderer.load(snapshot);
    return renderer.render(camera, {}).picture.rgb;
  };
  const std::vector<std::uint8_t> expected = picture();
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8"}) {
    if (std::setlocale(LC_NUMERIC, name)) break;  // where such a one is installed
  }
  CHECK(picture() == expected);
  std::locale::global(before);
  std::setlocale(LC_NUMERIC, "C");
}

}  // namespace
}  // namespace lumatlas
