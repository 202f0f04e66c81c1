// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/planning/mesh_pieces.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <numeric>
#include <set>

#include "mesh/scene_extent.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/city/small_city.h"
#include "tools/city/city_surface.h"
#include "tools/city/planning/block_cut.h"
#include "tools/city/planning/plan_city.h"

namespace lumatlas {

namespace {

using PlaceOfVertex = std::array<float, 3>;

// Returns how often each edge of a surface is used, by the places of its ends.
std::map<std::array<PlaceOfVertex, 2>, int> uses_of_edges(const Mesh& mesh) {
  std::map<std::array<PlaceOfVertex, 2>, int> uses;
  for (const glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3 a = mesh.positions[face[corner]], b = mesh.positions[face[(corner + 1) % 3]];
      std::array<PlaceOfVertex, 2> edge{PlaceOfVertex{a.x, a.y, a.z}, PlaceOfVertex{b.x, b.y, b.z}};
      std::sort(edge.begin(), edge.end());
      ++uses[edge];
    }
  }
  return uses;
}

ChunkedSurface surface_of(const std::filesystem::path& plan) {
  const CitySurface surface(plan);
  std::vector<std::size_t> all(surface.count());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return surface.read(all);
}

}  // namespace

TEST_CASE("Cut faces are each in one part, and parts are near each other", "[mesh_pieces]") {
  const SoupInput input = load_soup(small_city_scene(), std::nullopt);
  Mesh mesh;
  mesh.positions.assign(input.soup.positions.begin(), input.soup.positions.end());
  mesh.faces = input.soup.faces;
  std::set<std::uint32_t> all;
  double volume = 0;
  cut_faces(mesh, 700, [&](const std::vector<std::uint32_t>& faces) {
    CHECK(faces.size() <= 700);
    CHECK(faces.size() >= 340);
    CHECK(std::is_sorted(faces.begin(), faces.end()));
    for (const std::uint32_t face : faces) CHECK(all.insert(face).second);
    const Bounds box = bounds(mesh_of_faces(mesh, faces));
    volume += (box.max.x - box.min.x) * (box.max.y - box.min.y) * (box.max.z - box.min.z);
  });
  CHECK(all.size() == mesh.faces.size());
  const Bounds box = bounds(mesh);
  CHECK(volume < 2 * (box.max.x - box.min.x) * (box.max.y - box.min.y) * (box.max.z - box.min.z));
}

TEST_CASE("The coarse mesh of pieces is as large as the whole, and the whole where that has few faces",
          "[mesh_pieces]") {
  const TemporaryFolder folder;
  const MeshPieces all(load_soup(small_city_scene(), std::nullopt), 3000, 1'000'000, folder.path());
  const std::size_t faces = all.coarse().faces.size();
  CHECK(all.count() > 5);
  std::size_t sum = 0;
  for (std::size_t piece = 0; piece < all.count(); ++piece) sum += all.read(piece).faces.size();
  CHECK(sum == faces);
  const MeshPieces few(load_soup(small_city_scene(), std::nullopt), 3000, faces / 2, folder.path());
  CHECK(5 * few.coarse().faces.size() < 4 * faces);
  CHECK(scene_diameter(few.coarse()) == Approx(scene_diameter(all.coarse())).epsilon(0.02));
}

TEST_CASE("A surface that is planned in pieces has no crack where they meet", "[mesh_pieces]") {
  const TemporaryFolder whole, pieces;
  CityOptions options = small_city_options(6000);
  options.build.cells.size = 2;  // so that faces are split
  const CityPlan in_one = plan_city(small_city_scene(), options, whole.path(), {});
  options.piece_faces = 3000;
  const CityPlan in_pieces = plan_city(small_city_scene(), options, pieces.path(), {});
  CHECK(CitySurface(whole.path()).chunks_of_pieces().size() == 1);
  CHECK(CitySurface(pieces.path()).chunks_of_pieces().size() > 5);
  const ChunkedSurface a = surface_of(whole.path()), b = surface_of(pieces.path());
  CHECK(a.surface.mesh.faces.size() == b.surface.mesh.faces.size());
  CHECK(a.surface.mesh.positions.size() == b.surface.mesh.positions.size());
  CHECK(a.far.mesh.faces.size() == b.far.mesh.faces.size());
  // The same edges between the same faces: a crack would show as edges that end at one of them.
  CHECK(uses_of_edges(a.surface.mesh) == uses_of_edges(b.surface.mesh));
  CHECK(in_one.usual_distance == Approx(in_pieces.usual_distance).epsilon(1e-3));
  REQUIRE(in_one.views.size() == in_pieces.views.size());
  const auto cells = [](const CityPlan& plan) {
    return std::accumulate(plan.chunks.begin(), plan.chunks.end(), std::size_t{0},
                           [](std::size_t sum, const CityChunk& chunk) { return sum + chunk.size.cells; });
  };
  CHECK(static_cast<double>(cells(in_pieces)) == Approx(static_cast<double>(cells(in_one))).epsilon(0.1));
}

TEST_CASE("Blocks are cut as small as the memory of their jobs asks for", "[mesh_pieces]") {
  const TemporaryFolder folder;
  CityOptions options = small_city_options(1'000'000);
  options.memory = kLeastBlockMemory;
  const CityPlan plan = plan_city(small_city_scene(), options, folder.path(), {});
  for (const CityBlock& block : plan.blocks) {
    std::size_t faces = 0;
    for (const std::size_t chunk : block.chunks) faces += plan.chunks[chunk].size.faces;
    if (!block.far && block.own_chunks > 1) CHECK(job_bytes(faces, plan.memory) <= plan.memory);
  }
  CHECK(read_city_plan(folder.path()).memory == kLeastBlockMemory);
  // What is left for faces, beside pixels and the program, falls with the memory.
  CHECK(job_bytes(1'000'000, std::uint64_t{2} << 30) > job_bytes(1'000'000, std::uint64_t{1} << 30));
  CHECK(job_bytes(3'000'000, std::uint64_t{2} << 30) > std::uint64_t{2} << 30);
}

}  // namespace lumatlas
