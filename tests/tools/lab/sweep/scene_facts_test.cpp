// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/scene_facts.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "atlas/tiles/tiles.h"
#include "blend/gpu_bytes.h"
#include "mesh/base/errors.h"
#include "tests/support/colmap_bytes.h"
#include "tests/support/temporary_folder.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {
namespace {

TEST_CASE("options that depend on the scene are worked out from it") {
  const auto facts = [] { return SceneFacts{12, 40, 30, 30 * 640 * 480.0, 5e7}; };
  const auto of = [&](const std::string& text) {
    return resolved({{"name", {true, text}}}, "/scenes/a", facts).at("name").text.value();
  };
  CHECK(of("plain") == "plain");
  CHECK(of("=diameter/60") == "0.2");
  CHECK(of("=diameter*2.5") == "30.0");
  CHECK(of("=diameter") == "12.0");
  CHECK(of("=photographs") == "40");
  CHECK(of("=offered/4") == "8");  // 7.5, rounded
  CHECK(of("=offered/1000") == "1");
  CHECK(of("=texels/2") == "4608000texels");
  CHECK(of("=bytes/10") == "5000000");
  CHECK(of("=scene/truth/mesh.ply") == "/scenes/a/truth/mesh.ply");
  for (const char* const wrong : {"=", "=size", "=diameter/", "=diameter/0", "=diameter/-1", "=diameter/x",
                                  "=offered/4 ", "=diameter/nan", "=diameter/inf"}) {
    CHECK_THROWS_WITH(of(wrong), Catch::Contains("--name is \"" + std::string(wrong) + "\", must be =scene/FILE"));
  }
  const auto none = []() -> SceneFacts { throw std::logic_error("asked for"); };
  CHECK(resolved({{"path", {true, "=scene/path"}}}, "/a", none).at("path").text == "/a/path");
}

// A rectangle of 3 x 4, seen in six photographs of 40 x 30 pixels.
void write_rectangle(const TemporaryFolder& folder) {
  test::write_file(folder / "mesh.ply",
                   "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                   "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                   "0 0 0\n3 0 0\n3 4 0\n0 4 0\n3 0 1 2\n3 0 2 3\n");
  std::filesystem::create_directory(folder / "images");
  test::write_file(folder / "sparse/cameras.txt", "1 PINHOLE 40 30 50 50 20 15\n");
  std::string images;
  for (int i = 1; i <= 6; ++i) {
    const std::string name = std::to_string(i) + ".png";
    images += std::to_string(i) + " 1 0 0 0 0 0 5 1 " + name + "\n\n";
    write_image(folder / ("images/" + name), {40, 30, std::vector<std::uint8_t>(3 * 40 * 30), {}});
  }
  test::write_file(folder / "sparse/images.txt", images);
}

TEST_CASE("the texels and bytes of a scene are of the photographs offered, or of as many as the model may hold") {
  const TemporaryFolder folder;
  write_rectangle(folder);
  const auto with = [&](const OptionValues& build) { return scene_facts(folder.path(), build); };
  const OptionValues::mapped_type two{true, "2"}, ten{true, "10"}, all{true, "=offered"};
  const SceneFacts plain = with({});
  CHECK(plain.diameter == Approx(4.9));  // less the outermost 1% on each side
  CHECK(plain.photographs == 6);
  CHECK(plain.offered == 6);
  CHECK(plain.texels == 6 * 40 * 30);
  // A tile for each of six photographs, and the mesh.
  const SurfaceInput surface = load_surface(folder.path(), {}, {});
  CHECK(plain.bytes == static_cast<double>(6 * place_bytes({}) + GpuByteCount(surface.surface).of_surface()));
  CHECK(plain.bytes - with({{"max-views", two}}).bytes == static_cast<double>(4 * place_bytes({})));
  CHECK(with({{"hold", two}}).offered == 3);
  CHECK(with({{"hold", two}}).texels == 3 * 40 * 30);
  CHECK(with({{"max-views", two}}).offered == 6);
  CHECK(with({{"max-views", two}}).texels == 2 * 40 * 30);
  CHECK(with({{"hold", two}, {"max-views", two}}).texels == 2 * 40 * 30);
  CHECK(with({{"max-views", ten}}).texels == 6 * 40 * 30);
  CHECK(with({{"max-views", all}}).texels == 6 * 40 * 30);
}

}  // namespace
}  // namespace lumatlas
