// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/model_file.h"

#include <sys/resource.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/gltf/gltf_mesh.h"
#include "blend/reference.h"
#include "mesh/base/errors.h"
#include "mesh/upright.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

constexpr ValidityOptions kValidity{0.031, 1, 3, ValidityOptions::Edges::both_sides};  // no default

template <typename T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

void check_same(const Camera& a, const Camera& b) {
  CHECK(a.width == b.width);
  CHECK(a.height == b.height);
  for (const auto field : {&Camera::fx, &Camera::fy, &Camera::cx, &Camera::cy}) CHECK(same_bits(a.*field, b.*field));
  CHECK(same_bits(a.cam_from_world_rotation, b.cam_from_world_rotation));
  CHECK(same_bits(a.cam_from_world_translation, b.cam_from_world_translation));
}

void check_same(const StoredView& a, const StoredView& b) {
  CAPTURE(a.name);
  CHECK(a.name == b.name);
  check_same(a.camera, b.camera);
  CHECK(a.photograph->width() == b.photograph->width());
  CHECK(a.photograph->height() == b.photograph->height());
  CHECK(a.photograph->whole().rgb == b.photograph->whole().rgb);
  CHECK(a.photograph->valid() == b.photograph->valid());
  CHECK(a.mask->trust == b.mask->trust);
  CHECK(a.mask->depth == b.mask->depth);
  CHECK(a.mask->validity == b.mask->validity);
}

void check_same(const Cells& a, const Cells& b) {
  CHECK(same_bits(a.size, b.size));
  CHECK(a.cell_of_face == b.cell_of_face);
  REQUIRE(a.cells.size() == b.cells.size());
  for (std::size_t cell = 0; cell < a.cells.size(); ++cell) {
    CHECK(a.cells[cell].centroid == b.cells[cell].centroid);
    CHECK(a.cells[cell].normal == b.cells[cell].normal);
    CHECK(a.cells[cell].normal_cone_cos == b.cells[cell].normal_cone_cos);
    CHECK(a.cells[cell].area == b.cells[cell].area);
    CHECK(a.cells[cell].radius == b.cells[cell].radius);
    CHECK(a.cells[cell].faces == b.cells[cell].faces);
  }
}

// Without free slots: the views in their order, and references by their numbers in it.
Snapshot compacted(const Snapshot& snapshot) {
  Snapshot compact = snapshot;
  compact.views.clear();
  compact.gains.clear();
  compact.tiles.first_tile.clear();
  std::map<std::uint32_t, std::uint32_t> number;
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    number[slot] = static_cast<std::uint32_t>(compact.views.size());
    compact.views.push_back(snapshot.views[slot]);
    compact.gains.push_back(snapshot.gains[slot]);
    if (!snapshot.tiles.whole_views()) compact.tiles.first_tile.push_back(snapshot.tiles.first_tile[slot]);
  }
  if (!snapshot.tiles.whole_views()) compact.tiles.first_tile.push_back(snapshot.tiles.first_tile.back());
  for (ViewSlot& view : compact.references.views) view = ViewSlot(number.at(view));
  return compact;
}

// Returns the values at the corners of the faces, which do not depend on the numbers of their vertices.
template <typename T>
std::vector<T> by_corner(const Mesh& mesh, const std::vector<T>& by_vertex) {
  std::vector<T> values;
  for (const glm::uvec3& face : mesh.faces) {
    for (int corner = 0; corner < 3; ++corner) values.push_back(by_vertex.at(face[corner]));
  }
  return values;
}

void check_same_surface(const Snapshot& a, const Snapshot& b) {
  const Mesh &first = a.surface->mesh, &second = b.surface->mesh;
  REQUIRE(first.faces.size() == second.faces.size());
  CHECK(by_corner(first, first.positions) == by_corner(second, second.positions));
  CHECK(by_corner(first, a.vertex_colors.get()) == by_corner(second, b.vertex_colors.get()));
}

void check_same(const Snapshot& a, const Snapshot& b) {
  check_same_surface(a, b);
  CHECK(same_bits(a.surface->offset, b.surface->offset));
  check_same(a.surface->cells, b.surface->cells);
  REQUIRE(a.views.size() == b.views.size());
  for (std::size_t slot = 0; slot < a.views.size(); ++slot) check_same(*a.views[slot], *b.views[slot]);
  REQUIRE(a.gains.size() == b.gains.size());
  for (std::size_t slot = 0; slot < a.gains.size(); ++slot) CHECK(same_bits(a.gains[slot], b.gains[slot]));
  CHECK(a.references.offsets == b.references.offsets);
  CHECK(a.references.views == b.references.views);
  CHECK(a.cell_seen == b.cell_seen);
  CHECK(a.cell_coverage == b.cell_coverage);
  CHECK(a.cell_deviation == b.cell_deviation);
}

nlohmann::json json_of(const fs::path& file) {
  return nlohmann::json::parse(bytes_of(file));
}

TEST_CASE("a model reads back as the snapshot that was written, with its free slots left out") {
  const TemporaryFolder folder;
  const Snapshot written = small_snapshot(kValidity);
  REQUIRE(written.views.size() == 5);
  write_model(folder.path(), written, kValidity);
  const Model read = read_model(folder.path());
  CHECK(read.snapshot.views.size() == 3);
  check_same(read.snapshot, compacted(written));
  CHECK(read.validity.depth_edge == kValidity.depth_edge);
  CHECK(read.validity.edge_radius_px == kValidity.edge_radius_px);
  CHECK(read.validity.fade_px == kValidity.fade_px);
  CHECK(read.validity.edges == kValidity.edges);
}

TEST_CASE("a model keeps how well its cells are covered and how far they are off, to the bit") {
  const TemporaryFolder folder;
  Snapshot written = small_snapshot();
  for (std::size_t cell = 0; cell < written.cell_seen.size(); ++cell) {
    written.cell_coverage.push_back(0.1f * static_cast<float>(cell));
    written.cell_deviation.push_back(0.3f * static_cast<float>(cell));
  }
  write_model(folder.path(), written, {});
  check_same(read_model(folder.path()).snapshot, compacted(written));
}

// 1 for each tile that is there.
std::vector<bool> resident(const TileTable& tiles) {
  std::vector<bool> there;
  for (const TilePlace slot : tiles.places) there.push_back(slot != TilePlace::none);
  return there;
}

TEST_CASE("a model in tiles reads back: which are there, their pixels, and black where none is") {
  const TemporaryFolder folder;
  const Snapshot written = compacted(small_snapshot({}, {8, 2, 0}));
  write_model(folder.path(), written, {});
  const Snapshot read = read_model(folder.path()).snapshot;
  CHECK(read.tiles.options.tile_px == 8);
  CHECK(read.tiles.options.gutter_px == 2);
  CHECK(read.tiles.first_tile == std::vector<std::uint32_t>{0, 6, 15, 31});
  CHECK(resident(read.tiles) == resident(written.tiles));
  CHECK(read.tiles.resident_tiles() == written.tiles.resident_tiles());
  std::size_t black = 0;
  for (std::uint32_t view = 0; view < read.views.size(); ++view) {
    const std::vector<std::uint8_t> there = written.tiles.resident_pixels(ViewSlot(view), written.views[view]->camera);
    const Photograph given = written.views[view]->photograph->whole(), got = read.views[view]->photograph->whole();
    for (std::size_t byte = 0; byte < 3 * there.size(); ++byte) {
      const std::uint8_t expected = there[byte / 3] ? given.rgb[byte] : 0;
      if (got.rgb[byte] != expected) FAIL_CHECK("view " << view << ", byte " << byte);
      black += there[byte / 3] ? 0 : 1;
    }
    for (std::size_t pixel = 0; pixel < there.size(); ++pixel) {
      if (!there[pixel]) continue;
      const StoredView &before = *written.views[view], &after = *read.views[view];
      const bool same = after.mask->depth[pixel] == before.mask->depth[pixel] &&
                        after.mask->validity[pixel] == before.mask->validity[pixel];
      if (!same) FAIL_CHECK("view " << view << ", depth or validity of pixel " << pixel);
    }
  }
  CHECK(black > 0);
}

TEST_CASE("a model lists many views in a file of their own, and reads back as with a few") {
  const TemporaryFolder few, many;
  const Snapshot snapshot = small_snapshot({}, {8, 2, 0});
  write_model(few.path(), snapshot, kValidity);
  write_model(many.path(), snapshot, kValidity, {.listed_views = 1});
  const nlohmann::json listed = lumigraph_of(few.path()), apart = lumigraph_of(many.path());
  CHECK_FALSE(listed.contains("viewFile"));
  CHECK_FALSE(apart.contains("views"));
  const fs::path list = many.path() / apart.at("viewFile").at("uri").get<std::string>();
  CHECK(fs::file_size(list) == apart.at("viewFile").at("byteLength"));
  const nlohmann::json lists = json_of(list);
  CHECK(lists.at("views") == listed.at("views"));
  CHECK(lists.at("images").size() + 1 == listed.at("images").size());
  CHECK(apart.at("images") == nlohmann::json::array({listed.at("images").back()}));
  CHECK(apart.at("images").at(apart.at("start").at("image").get<std::size_t>()) == apart.at("images").at(0));
  CHECK(apart.at("start").at("name") == listed.at("views").at(listed.at("firstView").get<std::size_t>()).at("name"));
  check_same(read_model(few.path()).snapshot, read_model(many.path()).snapshot);
  CHECK(read_model(few.path()).snapshot.tiles.places == read_model(many.path()).snapshot.tiles.places);

  const ModelFacts facts = read_model_facts(many.path()), of_few = read_model_facts(few.path());
  CHECK(facts.uris.size() == of_few.uris.size() + 1);
  CHECK(std::count(facts.uris.begin(), facts.uris.end(), list.filename().string()) == 1);
  CHECK(facts.photograph_bytes == of_few.photograph_bytes);
  CHECK(facts.preview_bytes == of_few.preview_bytes);
  CHECK(facts.json_bytes >= facts.json.size() + fs::file_size(list));
}

TEST_CASE("a model is read from its folder or from its file") {
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot(), {});
  check_same(read_model(folder / "tileset.json").snapshot, read_model(folder.path()).snapshot);
}

TEST_CASE("a model that was read is written as the same bytes") {
  const TemporaryFolder first, second;
  write_model(first.path(), small_snapshot(), {});
  write_model(second.path(), read_model(first.path()).snapshot, {});
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(first.path())) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), first.path()).string();
    CAPTURE(name);
    CHECK(bytes_of(entry.path()) == bytes_of(second / name));
    ++files;
  }
  CHECK(files == 2 + 3 + 1 + 2 + 2 * 3 + 1);  // tileset, surface; images as in README.md
}

TEST_CASE("a model is written and read the same by any number of threads") {
  const TemporaryFolder folder, alone;
  const Snapshot snapshot = small_snapshot();
  const BaseTexture texture = small_texture(*snapshot.surface);
  const BaseTexture* const given = GENERATE(false, true) ? &texture : nullptr;
  write_model(folder.path(), snapshot, {}, {.texture = given});
  const Snapshot by_all = read_model(folder.path()).snapshot;
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  write_model(alone.path(), snapshot, {}, {.texture = given});
  CHECK(bytes_of(file_of_model(folder.path(), "surface.glb")) == bytes_of(file_of_model(alone.path(), "surface.glb")));
  CHECK(bytes_of(folder / "tileset.json") == bytes_of(alone / "tileset.json"));
  check_same(read_model(folder.path()).snapshot, by_all);
}

TEST_CASE("a model that was read renders the same picture") {
  const TemporaryFolder folder;
  const std::uint32_t tile_px = GENERATE(0u, 8u);
  const TexelFormat texels = GENERATE(TexelFormat::rgb8, TexelFormat::bc7);
  const std::uint32_t gutter_px = texels == TexelFormat::bc7 ? 4 : 2;
  const Snapshot written = small_snapshot(kValidity, {tile_px, gutter_px, 0, texels});
  write_model(folder.path(), written, kValidity);
  const Model read = read_model(folder.path());
  CHECK(read.snapshot.tiles.options.texels == texels);
  const Camera camera = oblique_camera(48, 40, 0.03, {0.1, 0, -0.6});
  const auto picture = [&](const Snapshot& snapshot) {
    const VisibilityBuffer visible = make_ray_visibility(snapshot.surface->mesh)->trace(camera);
    return render_reference(snapshot, camera, visible, {});
  };
  const Rendering before = picture(written), after = picture(read.snapshot);
  CHECK(before.picture.rgb == after.picture.rgb);
  CHECK(before.state == after.state);
  for (const PixelState state : {PixelState::empty, PixelState::unseen, PixelState::untextured, PixelState::textured}) {
    CHECK(std::count(before.state.begin(), before.state.end(), state) > 0);  // the scene shows every case
  }
}

fs::path written_glb(const TemporaryFolder& folder, const Snapshot& snapshot, const ImageCoding& coding = {},
                     const std::string& notes = {}) {
  fs::path file = folder / "model.glb";
  std::ofstream stream(file, std::ios::binary);
  write_glb(stream, snapshot, kValidity, {.photographs = coding}, notes);
  stream.close();
  REQUIRE(stream);
  return file;
}

TEST_CASE("a model in one file reads back as the one in a folder") {
  const TemporaryFolder folder, alone;
  const std::uint32_t tile_px = GENERATE(0u, 8u);
  const Snapshot written = small_snapshot(kValidity, {tile_px, 2, 0});
  write_model(folder.path(), written, kValidity);
  const fs::path file = written_glb(alone, written);
  const Model from_folder = read_model(folder.path()), from_file = read_model(file);
  check_same(from_file.snapshot, from_folder.snapshot);
  CHECK(resident(from_file.snapshot.tiles) == resident(from_folder.snapshot.tiles));
  CHECK(from_file.validity.depth_edge == kValidity.depth_edge);
  CHECK(std::distance(fs::directory_iterator(alone.path()), {}) == 1);
}

TEST_CASE("a model in one file is read whatever its name is, and written again as the same bytes") {
  const TemporaryFolder folder;
  const fs::path file = written_glb(folder, small_snapshot(kValidity));
  fs::rename(file, folder / "scene.of.mine");
  const std::string bytes = bytes_of(folder / "scene.of.mine");
  const Snapshot read = read_model(folder / "scene.of.mine").snapshot;
  CHECK((bytes_of(written_glb(folder, read)) == bytes));
}

TEST_CASE("notes are in the file as the asset's extras, whatever they hold") {
  const TemporaryFolder folder;
  const nlohmann::json notes = {{"options", {{"hold_out", nullptr}, {"bytes", 5'000'000'000}, {"share", 0.1}}},
                                {"plan", {{{"name", "c \u00e9.jpg"}, {"kept", true}, {"gain", -3}}}}};
  const fs::path file = written_glb(folder, small_snapshot(), {}, notes.dump());
  const nlohmann::json gltf = nlohmann::json::parse(read_model_json(file));
  CHECK(gltf.at("asset").at("extras") == notes);
  CHECK_FALSE(
      nlohmann::json::parse(read_model_json(written_glb(folder, small_snapshot()))).at("asset").contains("extras"));
}

TEST_CASE("a .glb has no room for 4 GiB") {
  CHECK_NOTHROW(require_fits_glb(4'294'967'295));
  CHECK_THROWS_MATCHES(require_fits_glb(4'294'967'296), InputError,
                       Catch::Message("the model takes 4294967296 bytes, a .glb holds less than 4 GiB: name a folder "
                                      "instead"));
}

TEST_CASE("photographs as JPEG are smaller and nearly the same, masks stay exact") {
  const TemporaryFolder folder, alone;
  const std::uint32_t tile_px = GENERATE(0u, 8u);
  const Snapshot written = compacted(small_snapshot(kValidity, {tile_px, 2, 0}));
  const ImageCoding coding{ImageFormat::jpeg, 95};
  write_model(folder.path(), written, kValidity, {.photographs = coding});
  CHECK(fs::exists(file_of_model(folder.path(), "images/00001.jpg")));
  CHECK(fs::exists(file_of_model(folder.path(), "images/00001-trust.png")));
  const Snapshot read = read_model(folder.path()).snapshot;
  check_same(read_model(written_glb(alone, written, coding)).snapshot, read);
  for (std::uint32_t view = 0; view < 3; ++view) {
    const StoredView &before = *written.views[view], &after = *read.views[view];
    std::vector<std::uint8_t> there(before.photograph->pixels(), 1);
    if (tile_px > 0) there = written.tiles.resident_pixels(ViewSlot(view), before.camera);
    REQUIRE(after.mask->trust.size() == before.mask->trust.size());
    for (std::size_t pixel = 0; pixel < there.size(); ++pixel) {
      if (!there[pixel]) continue;
      const bool same_trust = before.mask->trust.empty() || after.mask->trust[pixel] == before.mask->trust[pixel];
      const bool same_lens = after.photograph->is_inside_lens(pixel) == before.photograph->is_inside_lens(pixel);
      if (!same_trust || !same_lens) FAIL_CHECK("view " << view << ", trust or lens of pixel " << pixel);
    }
    const Photograph given = before.photograph->whole(), got = after.photograph->whole();
    double squares = 0, count = 0;
    for (std::size_t byte = 0; byte < given.rgb.size(); ++byte) {
      if (!there[byte / 3]) continue;
      squares += std::pow(given.rgb[byte] - got.rgb[byte], 2);
      ++count;
    }
    CHECK(std::sqrt(squares / count) < 4);  // of 255; with black beside the tiles it is 9
  }
}

TEST_CASE("each vertex belongs to one cell, and a vertex of several cells is there once for each") {
  const TemporaryFolder folder;
  const Snapshot written = small_snapshot();
  write_model(folder.path(), written, {});
  const Snapshot read = read_model(folder.path()).snapshot;
  const Mesh& mesh = read.surface->mesh;
  std::vector<std::set<std::uint32_t>> cells_of(mesh.positions.size());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      cells_of[mesh.faces[face][corner]].insert(read.surface->cells.cell_of_face[face]);
    }
  }
  for (const auto& cells : cells_of) CHECK(cells.size() == 1);
  std::set<std::pair<std::uint32_t, std::uint32_t>> needed;  // vertex of the mesh that was written, cell
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      needed.emplace(written.surface->mesh.faces[face][corner], written.surface->cells.cell_of_face[face]);
    }
  }
  CHECK(mesh.positions.size() == needed.size());
}

// Returns a wall of columns x rows squares, two faces each, and a cell for every `faces_per_cell` neighbouring faces,
// each with one reference to the only view.
Snapshot tiled_wall(std::uint32_t columns, std::uint32_t rows, std::uint32_t faces_per_cell) {
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, columns, rows, 8.0f / static_cast<float>(columns), 4);
  std::vector<CellId> cell_of_face;
  for (std::uint32_t face = 0; face < surface->mesh.faces.size(); ++face) {
    cell_of_face.emplace_back(face / faces_per_cell);
  }
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 0.1);
  Atlas atlas(surface, 1);
  const Camera camera = oblique_camera(24, 16, 0.1, {0.1, 0.2, -0.3});
  atlas.insert(traced_view(*surface, "a.jpg", camera, position_photograph(24, 16)));
  for (std::uint32_t cell = 0; cell < surface->cells.cells.size(); cell += 3) atlas.set_references(CellId(cell), {0});
  return atlas.snapshot();
}

// Returns waves before a camera whose image is large enough to be traced sparsely. One of their two cells has the
// reference, so that not all tiles are resident.
Snapshot large_view_of_waves(const TileOptions& layout) {
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 60, 60, 8.0f / 60, 4);
  for (glm::vec3& position : surface->mesh.positions) position.z += 0.2f * std::sin(2 * position.x + position.y);
  std::vector<CellId> cell_of_face(surface->mesh.faces.size(), 1);
  std::fill_n(cell_of_face.begin(), cell_of_face.size() / 2, CellId{0});
  surface->cells = measure_cells(surface->mesh, std::move(cell_of_face), 8);
  Atlas atlas(surface, 1, layout);
  const Camera camera = oblique_camera(512, 384, 0.1, {0.1, 0.2, -0.3});
  const auto visibility = make_ray_visibility(surface->mesh);
  TiledView tiled = make_tiled_view("a.png", camera, position_photograph(512, 384), visibility->trace_sparsely(camera),
                                    surface->cells, layout, kValidity);
  atlas.insert(std::move(tiled.view), std::move(tiled.shown));
  atlas.set_references(0, {0});
  return atlas.snapshot();
}

TEST_CASE("what a large view sees is read back to the bit, whole and in tiles") {
  const TileOptions layout = GENERATE(kWholeViews, TileOptions{64, 2, 0});
  const Snapshot written = large_view_of_waves(layout);
  const TemporaryFolder folder;
  write_model(folder.path(), written, kValidity);
  const Snapshot read = read_model(folder.path()).snapshot;
  REQUIRE(read.views.size() == 1);
  const StoredView &before = *written.views[0], &after = *read.views[0];
  std::vector<std::uint8_t> there(before.mask->depth.size(), 1);
  if (!layout.whole_views()) there = written.tiles.resident_pixels(0, before.camera);
  std::size_t compared = 0, different = 0;
  for (std::size_t pixel = 0; pixel < there.size(); ++pixel) {
    if (there[pixel] == 0) continue;
    ++compared;
    different += before.mask->depth[pixel] != after.mask->depth[pixel] ||
                 before.mask->validity[pixel] != after.mask->validity[pixel];
  }
  CHECK(different == 0);
  CHECK(compared > there.size() / 4);
  CHECK((compared < there.size()) == !layout.whole_views());
}

TEST_CASE("a model of more than 2^16 cells reads back") {
  const TemporaryFolder folder;
  const Snapshot written = tiled_wall(300, 240, 2);
  REQUIRE(written.cell_seen.size() == 72000);
  write_model(folder.path(), written, {});
  const Snapshot read = read_model(folder.path()).snapshot;
  check_same_surface(read, written);
  CHECK(read.surface->cells.cell_of_face == written.surface->cells.cell_of_face);
  CHECK(read.references.offsets == written.references.offsets);
  CHECK(read.references.views == written.references.views);
}

TEST_CASE("a model of ten million faces reads back", "[.large]") {
  const TemporaryFolder folder;
  const Snapshot written = tiled_wall(2500, 2000, 64);
  REQUIRE(written.surface->mesh.faces.size() == 10'000'000);
  write_model(folder.path(), written, {});
  const Snapshot read = read_model(folder.path()).snapshot;
  CHECK((by_corner(read.surface->mesh, read.surface->mesh.positions) ==
         by_corner(written.surface->mesh, written.surface->mesh.positions)));  // not printed
  CHECK((read.surface->cells.cell_of_face == written.surface->cells.cell_of_face));
}

TEST_CASE("more cells than a float can count are refused") {
  const TemporaryFolder folder;
  Snapshot snapshot = small_snapshot();
  snapshot.cell_seen.assign((1 << 24) + 1, 1);
  CHECK_THROWS_MATCHES(write_model(folder.path(), snapshot, {}), InputError,
                       Catch::Message("the model has 16777217 cells, a model file holds 16777216: give a larger "
                                      "--cell-size"));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("a model without views or references can be kept") {
  const TemporaryFolder folder;
  write_model(folder.path(), Atlas(wall_and_panel(), 2).snapshot(), {});
  const Snapshot read = read_model(folder.path()).snapshot;
  CHECK(read.views.empty());
  CHECK(read.references.views.empty());
  CHECK(read.references.offsets == std::vector<std::uint32_t>(6, 0));
}

TEST_CASE("vertex colours survive for each of the 256 sRGB values") {
  const TemporaryFolder folder;
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 15, 15, 1, 4);
  surface->cells = measure_cells(surface->mesh, std::vector<CellId>(surface->mesh.faces.size(), 0), 1);
  Snapshot snapshot = Atlas(surface, 1).snapshot();
  REQUIRE(snapshot.vertex_colors.size() == 256);
  FallbackColors::Colors colors;
  for (std::size_t value = 0; value < 256; ++value) {
    colors.emplace_back(value, 255 - value, (7 * value) % 256);
  }
  snapshot.vertex_colors = std::move(colors);
  write_model(folder.path(), snapshot, {});
  check_same_surface(read_model(folder.path()).snapshot, snapshot);
}

TEST_CASE("a name that is no Unicode is made one, with a control character replaced") {
  const TemporaryFolder folder;
  Atlas atlas(wall_and_panel(), 2);
  const Camera camera = forward_camera(8, 8);
  atlas.insert(traced_view(*atlas.surface(), "caf\xe9.jpg", camera, position_photograph(8, 8)));
  atlas.insert(traced_view(*atlas.surface(), "a\nb\x7f.jpg", camera, position_photograph(8, 8)));
  write_model(folder.path(), atlas.snapshot(), {});
  const Snapshot read = read_model(folder.path()).snapshot;
  CHECK(read.views[0]->name == "caf\xef\xbf\xbd.jpg");  // U+FFFD
  CHECK(read.views[1]->name == "a?b?.jpg");
}

TEST_CASE("the file is glTF with a mesh that any viewer shows") {
  const TemporaryFolder folder;
  const Snapshot snapshot = small_snapshot();
  write_model(folder.path(), snapshot, {});
  const nlohmann::json gltf = surface_json(folder.path());
  CHECK(gltf.at("asset").at("version") == "2.0");
  CHECK(gltf.at("extensionsUsed") == nlohmann::json{"KHR_materials_unlit", "LUMATLAS_lumigraph"});
  CHECK_FALSE(gltf.contains("extensionsRequired"));
  const auto& primitive = gltf.at("meshes").at(0).at("primitives").at(0);
  const auto& positions = gltf.at("accessors").at(primitive.at("attributes").at("POSITION").get<std::size_t>());
  CHECK(positions.at("min") == nlohmann::json{-2.0, -2.0, 2.0});
  CHECK(positions.at("max") == nlohmann::json{2.0, 2.0, 4.0});
  const auto& material = gltf.at("materials").at(primitive.at("material").get<std::size_t>());
  CHECK(material.at("extensions").contains("KHR_materials_unlit"));
  CHECK(material.at("doubleSided") == true);
  const auto& colors = gltf.at("accessors").at(primitive.at("attributes").at("COLOR_0").get<std::size_t>());
  CHECK(colors.at("normalized") == true);
  CHECK(colors.at("count") == positions.at("count"));
  CHECK(positions.at("count").get<std::size_t>() > snapshot.vertex_colors.size());  // split at the borders of cells
}

// A node's rotation and translation, the latter optional.
glm::dvec3 placed(const nlohmann::json& node, const glm::dvec3& point) {
  const auto q = node.at("rotation").get<std::vector<double>>();
  const auto t = node.value("translation", std::vector<double>(3, 0));
  return glm::dquat(q[3], q[0], q[1], q[2]) * point + glm::dvec3(t[0], t[1], t[2]);
}

TEST_CASE("the file stands upright for other programs, and has a camera for each stored view") {
  const TemporaryFolder folder;
  const Snapshot snapshot = compacted(small_snapshot());
  const nlohmann::json gltf = glb_json(written_glb(folder, snapshot)), &nodes = gltf.at("nodes"), &root = nodes.at(0);
  CHECK(gltf.at("scenes") == nlohmann::json::parse(R"([{"nodes": [0]}])"));
  CHECK(root.at("mesh") == 0);
  REQUIRE(nodes.size() == 1 + snapshot.views.size());
  std::vector<Camera> cameras;
  for (const auto& view : snapshot.views) cameras.push_back(view->camera);
  CHECK(glm::distance(placed(root, upward(cameras)), {0, 1, 0}) < 1e-9);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& camera = cameras[i];
    const nlohmann::json& node = nodes.at(1 + i);
    CHECK(root.at("children").at(i) == 1 + i);
    CHECK(node.at("name") == snapshot.views[i]->name);
    const nlohmann::json& perspective = gltf.at("cameras").at(node.at("camera").get<std::size_t>()).at("perspective");
    CHECK_FALSE(perspective.contains("zfar"));
    const glm::dvec3 world = camera.center() + 3.0 * camera.ray(camera.image_from_cam({1, 2, 3}));
    CHECK(glm::distance(placed(node, {1, -2, -3}), world) < 1e-9);
  }
}

// Returns the position at which glTF (3.10.3) has a camera show a point of its own frame: 1 is the right and the upper
// border.
glm::dvec2 shown_at(const nlohmann::json& perspective, const glm::dvec3& point) {
  const double half_height = std::tan(0.5 * perspective.at("yfov").get<double>());
  const double half_width = half_height * perspective.at("aspectRatio").get<double>();
  return glm::dvec2(point.x / half_width, point.y / half_height) / -point.z;
}

TEST_CASE("a camera of the file shows the whole photograph, wherever that has its principal point") {
  Snapshot snapshot = compacted(small_snapshot());
  auto view = std::make_shared<StoredView>(*snapshot.views[0]);
  Camera& camera = view->camera;
  const glm::dvec2 size(camera.width, camera.height);
  camera.fy = 1.25 * camera.fx;
  for (const glm::dvec2 share : {glm::dvec2(0.5, 0.5), {0.6, 0.5}, {0.5, 0.3}, {0.42, 0.56}, {-0.1, 1.2}}) {
    camera.cx = share.x * size.x;
    camera.cy = share.y * size.y;
    nlohmann::json gltf{{"nodes", {nlohmann::json::object()}}};
    snapshot.views[0] = view;
    add_cameras(gltf, snapshot);
    const nlohmann::json& written = gltf.at("cameras").at(0);
    const nlohmann::json& perspective = written.at("perspective");
    double outermost = 0;
    for (const glm::dvec2 corner : {glm::dvec2(0, 0), {size.x, 0}, {0, size.y}, size}) {
      const glm::dvec2 ray = (corner - glm::dvec2(camera.cx, camera.cy)) / glm::dvec2(camera.fx, camera.fy);
      const glm::dvec2 at = glm::abs(shown_at(perspective, {ray.x, -ray.y, -1}));
      outermost = std::max({outermost, at.x, at.y});
    }
    INFO("principal point at " << share.x << ", " << share.y);
    CHECK(outermost == Approx(1));  // all of it is there, and no more than needed
    CHECK(perspective.at("aspectRatio").get<double>() ==
          Approx(size.x / camera.fx / (size.y / camera.fy)));  // the shape of the photograph, as it is seen
    CHECK(written.at("extras").at("principalPoint") == nlohmann::json{camera.cx, camera.cy});
    CHECK(written.at("extras").at("focalLength") == nlohmann::json{camera.fx, camera.fy});
    CHECK(written.at("extras").at("imageSize") == nlohmann::json{camera.width, camera.height});
  }
}

TEST_CASE("a model that is read as a mesh is where its photographs see it, with its offset") {
  const TemporaryFolder folder;
  Snapshot snapshot = small_snapshot();
  const auto far = std::make_shared<Surface>(*snapshot.surface);
  far->offset = {1e6, -2, 0.5};
  snapshot.surface = far;
  write_model(folder.path(), snapshot, {});
  const TriangleSoup soup = read_gltf_mesh(file_of_model(folder.path(), "surface.glb"));
  const Mesh& mesh = snapshot.surface->mesh;
  REQUIRE(soup.faces.size() == mesh.faces.size());
  // Faces are written cell by cell, so that only the outline can be compared.
  const Bounds read = bounds(soup), written = bounds(mesh);
  CHECK(read.min == written.min + far->offset);
  CHECK(read.max == written.max + far->offset);
}

TEST_CASE("a rotation is stored row by row") {
  const TemporaryFolder folder;
  const Snapshot snapshot = small_snapshot();
  write_model(folder.path(), snapshot, {});
  const nlohmann::json view = lumigraph_of(folder.path()).at("views").at(0);
  const glm::dmat3& rotation = snapshot.views[0]->camera.cam_from_world_rotation;
  // Its second number multiplies y of the world for x of the camera.
  CHECK(view.at("rotation").at(1).get<double>() == (rotation * glm::dvec3(0, 1, 0)).x);
}

TEST_CASE("a view has the masks that it needs in the file, and no others") {
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot(), {});
  const nlohmann::json properties = lumigraph_of(folder.path()), &views = properties.at("views");
  const auto uri = [&](std::size_t view, const char* mask) {
    const auto image = views.at(view).at(mask).get<std::size_t>();
    return without_content(properties.at("images").at(image).at("uri").get<std::string>());
  };
  CHECK_FALSE(views.at(0).contains("lensMask"));
  CHECK_FALSE(views.at(0).contains("trustMask"));
  CHECK(uri(1, "lensMask") == "images/00001-lens.png");
  CHECK(uri(1, "trustMask") == "images/00001-trust.png");
  CHECK_FALSE(views.at(2).contains("lensMask"));
  CHECK(uri(2, "trustMask") == "images/00002-trust.png");
}

TEST_CASE("a gain is stored as red, green, blue") {
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot(), {});
  const nlohmann::json view = lumigraph_of(folder.path()).at("views").at(2);
  CHECK(view.at("gain") == nlohmann::json{1.7, 0.9, 1.2});
}

// Acts like a disk that is full after a number of bytes of a file.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    (void)std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder)] = bytes_of(entry.path());
  }
  return files;
}

TEST_CASE("a full disk leaves the model that was there, and nothing else") {
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot(), {});
  const std::map<std::string, std::string> before = files_in(folder.path());
  Snapshot other = small_snapshot();
  for (auto& gain : other.gains) gain = glm::dvec3(0.5);
  std::size_t largest = 0;
  for (const auto& [name, bytes] : before) largest = std::max(largest, bytes.size());
  for (const std::size_t room : {largest / 2, largest / 10, std::size_t{0}}) {
    CAPTURE(room);
    std::string sentence = "written";
    {
      const FileSizeLimit limit(room);
      try {
        write_model(folder.path(), other, {}, {.photographs = {ImageFormat::jpeg, 90}});
      } catch (const InputError& error) {
        sentence = error.what();
      }
    }
    CHECK_THAT(sentence, Catch::EndsWith("cannot be written: check that the disk has room and the folder is writable"));
    CHECK(files_in(folder.path()) == before);
  }
  const TemporaryFolder fresh;
  {
    const FileSizeLimit limit(0);
    CHECK_THROWS_AS(write_model(fresh.path(), other, {}), InputError);
  }
  CHECK(fs::is_empty(fresh.path()));
}

// A snapshot whose slot 0 has no resident tile any more, and whose table still says so tile by tile.
Snapshot with_idle_view() {
  Snapshot snapshot = small_snapshot({}, {8, 2, 0});
  for (std::uint32_t tile = 0; tile < snapshot.tiles.first_tile[1]; ++tile)
    snapshot.tiles.places[tile] = TilePlace::none;
  return snapshot;
}

TEST_CASE("a photograph without a resident tile is not written") {
  const TemporaryFolder folder;
  write_model(folder.path(), with_idle_view(), {});
  const Model model = read_model(folder.path());
  REQUIRE(model.snapshot.views.size() == 2);
  CHECK(model.snapshot.views[0]->name == "left/b.jpg");
  CHECK(fs::exists(file_of_model(folder.path(), "images/00001.png")));
  CHECK_FALSE(fs::exists(file_of_model(folder.path(), "images/00002.png")));
  for (const ViewSlot slot : model.snapshot.references.views) CHECK(slot < 2);
  CHECK_NOTHROW(check(model.snapshot));
}

TEST_CASE("a smaller model in the place of a larger one leaves no image that nothing refers to") {
  const TemporaryFolder folder, anew;
  write_model(folder.path(), small_snapshot({}, {8, 2, 0}), {});
  (void)folder.with_file("images/mine.png", "a person's own");
  const std::size_t before = files_in(folder.path()).size();
  write_model(folder.path(), with_idle_view(), {});
  write_model(anew.path(), with_idle_view(), {});
  std::map<std::string, std::string> expected = files_in(anew.path());
  expected["images/mine.png"] = "a person's own";
  CHECK(files_in(folder.path()) == expected);
  CHECK(expected.size() < before);
  const BaseTexture texture = small_texture(*with_idle_view().surface);
  write_model(folder.path(), with_idle_view(), {}, {.texture = &texture});
  CHECK(files_in(folder.path()).size() == expected.size() + 1);
  write_model(folder.path(), with_idle_view(), {});
  CHECK(files_in(folder.path()) == expected);
}

// Returns the values of one attribute's accessor in a glTF file, as they are stored.
template <typename T>
std::vector<T> attribute_of(const nlohmann::json& gltf, const std::string& buffer, const char* name) {
  const auto& primitive = gltf.at("meshes").at(0).at("primitives").at(0);
  const auto number = std::string(name) == "indices" ? primitive.at(name) : primitive.at("attributes").at(name);
  const auto& accessor = gltf.at("accessors").at(number.get<std::size_t>());
  const auto& view = gltf.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  std::vector<T> values(view.at("byteLength").get<std::size_t>() / sizeof(T));
  std::memcpy(values.data(), &buffer.at(view.value("byteOffset", std::size_t{0})), values.size() * sizeof(T));
  return values;
}

TEST_CASE("a base texture lies in the file where it was given, for any viewer, in place of the vertices' colours") {
  const TemporaryFolder folder;
  const Snapshot snapshot = small_snapshot();
  const BaseTexture texture = small_texture(*snapshot.surface);
  write_model(folder.path(), snapshot, {}, {.texture = &texture});
  make_one_gltf(folder.path());
  const nlohmann::json gltf = json_of(folder / "scene.gltf");
  const std::string buffer = bytes_of(folder / "scene.bin");
  const auto& primitive = gltf.at("meshes").at(0).at("primitives").at(0);
  CHECK_FALSE(primitive.at("attributes").contains("COLOR_0"));
  const auto& material = gltf.at("materials").at(primitive.at("material").get<std::size_t>());
  CHECK(material.at("extensions").contains("KHR_materials_unlit"));
  const auto& reference = material.at("pbrMetallicRoughness").at("baseColorTexture");
  CHECK(reference.value("texCoord", 0) == 0);
  const auto& of_material = gltf.at("textures").at(reference.at("index").get<std::size_t>());
  const auto& image = gltf.at("images").at(of_material.at("source").get<std::size_t>());
  CHECK(read_photograph(folder / image.at("uri").get<std::string>()).rgb == texture.image.rgb);
  const auto positions = attribute_of<glm::vec3>(gltf, buffer, "POSITION");
  const auto places = attribute_of<glm::u16vec2>(gltf, buffer, "TEXCOORD_0");
  const auto faces = attribute_of<glm::uvec3>(gltf, buffer, "indices");
  CHECK(gltf.at("accessors").at(primitive.at("attributes").at("TEXCOORD_0").get<std::size_t>()).at("normalized"));
  REQUIRE(faces.size() == texture.faces.size());
  const Mesh& mesh = snapshot.surface->mesh;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      CHECK(positions.at(faces[face][corner]) == mesh.positions[mesh.faces[face][corner]]);
      const glm::vec2 place = glm::vec2(places.at(faces[face][corner])) / 65535.0f;
      const glm::vec2 off = place - texture.faces[face][static_cast<std::size_t>(corner)];
      CHECK(std::max(std::abs(off.x), std::abs(off.y)) <= 0.51f / 65535);  // rounded to 16 bit
    }
  }
}

TEST_CASE("a model reads back and renders the same with a base texture and without") {
  const TemporaryFolder plain, folder;
  const std::uint32_t tile_px = GENERATE(0u, 8u);
  const Snapshot written = small_snapshot(kValidity, {tile_px, 2, 0});
  BaseTexture texture = small_texture(*written.surface);
  write_model(plain.path(), written, kValidity);
  write_model(folder.path(), written, kValidity, {.texture = &texture});
  const nlohmann::json surface = surface_json(folder.path());
  const std::size_t copies = surface.at("accessors")
                                 .at(lumigraph_of(folder.path()).at("vertexCopies").get<std::size_t>())
                                 .at("count")
                                 .get<std::size_t>();
  CHECK(copies > 0);
  texture.coding = {ImageFormat::jpeg, 90};
  std::ofstream stream(folder / "model.glb", std::ios::binary);
  write_glb(stream, written, kValidity, {.texture = &texture});
  stream.close();
  const Snapshot expected = read_model(plain.path()).snapshot;
  for (const fs::path& path : {folder.path(), folder / "model.glb"}) {
    const Snapshot read = read_model(path).snapshot;
    check_same(read, expected);
    CHECK(read.surface->mesh.positions == expected.surface->mesh.positions);
    CHECK(read.surface->mesh.faces == expected.surface->mesh.faces);
    CHECK(read.vertex_colors == expected.vertex_colors);
    CHECK(resident(read.tiles) == resident(expected.tiles));
    const Camera camera = oblique_camera(48, 40, 0.03, {0.1, 0, -0.6});
    const auto picture = [&](const Snapshot& snapshot) {
      const VisibilityBuffer visible = make_ray_visibility(snapshot.surface->mesh)->trace(camera);
      return render_reference(snapshot, camera, visible, {}).picture.rgb;
    };
    CHECK(picture(read) == picture(expected));
  }
  // The printed size on disk is the size of all files.
  const ModelFacts with = read_model_facts(folder / "model.glb"), without = read_model_facts(plain.path());
  CHECK(with.texture_bytes == encode_image(texture.image, texture.coding).size());
  CHECK(without.texture_bytes == 0);
  const std::size_t vertices = expected.surface->mesh.positions.size() + copies;
  CHECK(with.mesh_bytes == without.mesh_bytes + 12 * copies);
  CHECK(with.vertex_bytes == (8 + 4 + 4) * vertices + 4 * copies);
  CHECK(with.surface->mesh.positions == expected.surface->mesh.positions);
}

TEST_CASE("a base texture that does not fit the mesh is no texture") {
  const TemporaryFolder folder;
  const Snapshot snapshot = small_snapshot();
  const BaseTexture good = small_texture(*snapshot.surface);
  const auto complaint = [&](const std::function<void(BaseTexture&)>& damage) -> std::string {
    BaseTexture texture = good;
    damage(texture);
    try {
      write_model(folder.path(), snapshot, {}, {.texture = &texture});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  CHECK(complaint([](BaseTexture& t) { t.faces.pop_back(); }) ==
        "base texture: has places for 33 faces, must be for each of 34");
  CHECK(complaint([](BaseTexture& t) { t.faces[7][1].y = 1.5f; }) ==
        "base texture: face 7 has a corner at (0.375, 1.5), must be in [0, 1]");
  CHECK_THAT(complaint([](BaseTexture& t) { t.faces[7][1].y = std::nanf(""); }), Catch::Contains("nan"));
  CHECK(complaint([](BaseTexture& t) { t.image.rgb.pop_back(); }) ==
        "base texture: an image of 32x16 with 1535 bytes, must have three for each of at least one pixel");
  CHECK_THAT(complaint([](BaseTexture& t) { t.coding = {ImageFormat::jpeg, 101}; }), Catch::Contains("101"));
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("a photograph without a resident tile is not opened") {
  // Earlier programs wrote models that kept such views: with a resident flag of 0 for each of their tiles.
  const TemporaryFolder folder;
  write_model(folder.path(), small_snapshot({}, {8, 2, 0}), {});
  make_one_gltf(folder.path());
  const nlohmann::json gltf = json_of(folder / "scene.gltf");
  const auto accessor = gltf["extensions"]["LUMATLAS_lumigraph"]["resident"].get<std::size_t>();
  const auto& view = gltf["bufferViews"][gltf["accessors"][accessor]["bufferView"].get<std::size_t>()];
  std::string buffer = bytes_of(folder / "scene.bin");
  const std::size_t tiles_of_first = 3 * 2;  // 24 x 16 pixels
  std::fill_n(buffer.begin() + static_cast<std::ptrdiff_t>(view.value("byteOffset", std::size_t{0})), tiles_of_first,
              0);
  (void)folder.with_file("scene.bin", buffer);
  REQUIRE(fs::remove(folder / "images/00000.png"));
  const Model model = read_model(folder / "scene.gltf");
  REQUIRE(model.snapshot.views.size() == 3);
  CHECK(model.snapshot.views[0] == nullptr);
  CHECK(model.snapshot.views[1] != nullptr);
  CHECK_NOTHROW(check(model.snapshot));
}

TEST_CASE("notes that are no JSON object are refused") {
  std::ostringstream file;
  std::string deep = "{\"a\":";
  deep.append(100'000, '[').append(100'000, ']').append("}");
  for (const std::string& notes : {std::string("[]"), std::string("{"), std::string("7"), deep}) {
    CHECK_THROWS_AS(write_glb(file, small_snapshot(), {}, {}, notes), std::invalid_argument);
  }
  CHECK(file.str().empty());
}

TEST_CASE("a snapshot that is none is not written") {
  Snapshot snapshot = small_snapshot();
  snapshot.gains.pop_back();
  const TemporaryFolder folder;
  CHECK_THROWS_AS(write_model(folder.path(), snapshot, {}), std::invalid_argument);
  CHECK(fs::is_empty(folder.path()));
  std::ostringstream file;
  CHECK_THROWS_AS(write_glb(file, snapshot, {}), std::invalid_argument);
}

TEST_CASE("a model that cannot be written is refused by name") {
  const TemporaryFolder folder;
  const fs::path missing = folder / "missing";
  CHECK_THROWS_AS(write_model(folder.with_file("file", "x"), small_snapshot(), {}), InputError);
  fs::create_directories(folder / "tileset.json");
  CHECK_THROWS_MATCHES(write_model(folder.path(), small_snapshot(), {}), InputError,
                       Catch::Message((folder / "tileset.json").string() +
                                      ": cannot be written: check that the disk has room and the folder is writable"));
  CHECK_THROWS_AS(write_model(missing, small_snapshot(), {0, 2, 8}), std::invalid_argument);
  CHECK_FALSE(fs::exists(missing));
}

}  // namespace
}  // namespace lumatlas
