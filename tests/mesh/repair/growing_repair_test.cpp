// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/growing/growing_repair.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/face_corners.h"
#include "mesh/repair/repair.h"

using namespace lumatlas;

namespace {

// A mesh without the numbers of its vertices: by place of each face, in one of its turns, and corner, the smallest such
// place and corner that has the same vertex.
using Form = std::map<std::pair<FaceCorners, int>, std::pair<FaceCorners, int>>;

Form form_of(const Mesh& mesh) {
  Form vertices;
  std::map<std::uint32_t, std::pair<FaceCorners, int>> first;
  std::vector<std::pair<std::pair<FaceCorners, int>, std::uint32_t>> corners;
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    const FaceCorners place = face_corners(mesh, face);
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.faces[face][corner];
      const glm::vec3 position = mesh.positions[vertex];
      int rank = 0;  // of the corner in the face's place
      while (place.at(3 * static_cast<std::size_t>(rank)) != std::bit_cast<std::uint32_t>(position.x + 0.0f) ||
             place.at(3 * static_cast<std::size_t>(rank) + 1) != std::bit_cast<std::uint32_t>(position.y + 0.0f) ||
             place.at(3 * static_cast<std::size_t>(rank) + 2) != std::bit_cast<std::uint32_t>(position.z + 0.0f)) {
        ++rank;
      }
      corners.emplace_back(std::pair(place, rank), vertex);
    }
  }
  for (const auto& [corner, vertex] : corners) {
    const auto [entry, added] = first.emplace(vertex, corner);
    if (!added) entry->second = std::min(entry->second, corner);
  }
  for (const auto& [corner, vertex] : corners) vertices.emplace(corner, first.at(vertex));
  return vertices;
}

// A soup that changes at random: its faces lie between few positions, so that edges have many faces, faces repeat each
// other, and some have no area. With `side`, the faces are those of a sheet of that many squares instead.
class ChangingSoup {
 public:
  explicit ChangingSoup(std::uint32_t seed, int side = 0) : random_(seed) {
    for (int i = 0; i < (side > 0 ? (side + 1) * (side + 1) : 30); ++i) {
      positions_.push_back({next_number_++, side > 0 ? glm::dvec3(i % (side + 1), i / (side + 1), 0.1 * (i % 3))
                                                     : glm::dvec3(below(4), below(4), below(3))});
    }
    for (int i = 0; i < side * side; ++i) {
      const auto a = static_cast<std::uint32_t>(i / side * (side + 1) + i % side),
                 c = a + static_cast<std::uint32_t>(side) + 2;
      add(a, a + 1, c);
      add(a, c, c - 1);
    }
    for (int i = 0; side == 0 && i < 40; ++i) add_random();
  }

  // Drops some faces and positions without faces, moves the numbers of others, and adds new ones.
  void change(int count) {
    for (int i = 0; i < count; ++i) {
      if (!faces_.empty())
        faces_.erase(faces_.begin() + static_cast<std::ptrdiff_t>(below(static_cast<int>(faces_.size()))));
      if (below(2) == 0) {
        positions_.insert(
            positions_.begin() + below(static_cast<int>(positions_.size())),
            {next_number_++, positions_[static_cast<std::size_t>(below(static_cast<int>(positions_.size())))].place});
      }
      add_random();
      if (below(2) == 0) add_random();
    }
    if (below(3) == 0) swap_faces();
    const auto is_used = [&](const Position& position) {
      return std::any_of(faces_.begin(), faces_.end(), [&](const Face& face) {
        return std::find(face.corners.begin(), face.corners.end(), position.number) != face.corners.end();
      });
    };
    std::erase_if(positions_, [&](const Position& position) { return !is_used(position) && below(3) == 0; });
  }

  // Returns the soup as it is, and where its parts were in the one returned before. With `names_faces`, some of the
  // faces that stayed are named, and begin with the corner that they began with.
  GrownSoup version(bool names_faces = false) {
    GrownSoup grown;
    std::uint32_t next = 0;  // face before that may be named
    std::map<std::uint32_t, std::uint32_t> positions_now;
    for (const Position& position : positions_) {
      positions_now.emplace(position.number, static_cast<std::uint32_t>(grown.soup.positions.size()));
      grown.soup.positions.push_back(position.place);
      const auto before = positions_before_.find(position.number);
      grown.previous_position.push_back(before == positions_before_.end() ? VertexId::none : VertexId(before->second));
    }
    for (Face& face : faces_) {
      const bool is_named = names_faces && face.before && *face.before >= next && below(8) != 0;
      if (names_faces) grown.previous_face.push_back(is_named ? FaceId(*face.before) : FaceId::none);
      if (is_named) next = *face.before + 1;
      const auto turn = is_named ? face.turn : static_cast<std::size_t>(below(3));
      face.before = static_cast<std::uint32_t>(grown.soup.faces.size());
      face.turn = turn;
      grown.soup.faces.emplace_back(positions_now.at(face.corners.at(turn)),
                                    positions_now.at(face.corners.at((turn + 1) % 3)),
                                    positions_now.at(face.corners.at((turn + 2) % 3)));
    }
    positions_before_ = std::move(positions_now);
    return grown;
  }

 private:
  struct Position {
    std::uint32_t number;
    glm::dvec3 place;
  };
  struct Face {
    std::array<std::uint32_t, 3> corners;      // numbers of positions
    std::optional<std::uint32_t> before = {};  // its number in the version before
    std::size_t turn = 0;                      // the corner that it began with there
  };

  int below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    faces_.push_back({{positions_[a].number, positions_[b].number, positions_[c].number}});
  }
  void swap_faces() {
    const auto any = [&] { return static_cast<std::size_t>(below(static_cast<int>(faces_.size()))); };
    std::swap(faces_[any()], faces_[any()]);
  }
  void add_random() {
    const auto any = [&] { return static_cast<std::uint32_t>(below(static_cast<int>(positions_.size()))); };
    add(any(), any(), any());
  }

  std::mt19937 random_;
  std::uint32_t next_number_ = 0;
  std::vector<Position> positions_;
  std::vector<Face> faces_;
  std::map<std::uint32_t, std::uint32_t> positions_before_;
};

// Compares each version with the repair of its soup, and previous faces with what they were.
void check_versions(ChangingSoup& soup, int versions, int changes, bool names_faces) {
  GrowingRepair repair_of_all;
  Mesh before;
  for (int i = 0; i < versions; ++i) {
    const GrownSoup grown = soup.version(names_faces);
    const GrownMesh made = repair_of_all.next(grown);
    const Mesh at_once = GrowingRepair().next({grown.soup, {}}).mesh;
    REQUIRE(made.mesh.faces == at_once.faces);
    REQUIRE(made.mesh.positions == at_once.positions);
    const Mesh whole = repair(grown.soup, glm::dvec3(0)).mesh;
    REQUIRE(made.mesh.positions.size() == whole.positions.size());
    REQUIRE(form_of(made.mesh) == form_of(whole));
    REQUIRE(made.previous_face.size() == made.mesh.faces.size());
    for (FaceId face{0}; face < made.mesh.faces.size(); ++face) {
      const FaceId previous = made.previous_face[face];
      if (previous == FaceId::none) continue;
      FaceCorners now = face_corners(made.mesh, face), then = face_corners(before, previous);
      Mesh turned = before;
      std::swap(turned.faces[previous].x, turned.faces[previous].y);
      REQUIRE((now == then || now == face_corners(turned, previous)));
    }
    before = made.mesh;
    soup.change(changes);
  }
}

}  // namespace

TEST_CASE("a soup that changes at random is repaired as if it were whole, version by version") {
  const auto seed = static_cast<std::uint32_t>(GENERATE(range(0, 40)));
  const bool names_faces = GENERATE(false, true);
  CAPTURE(seed, names_faces);
  ChangingSoup soup(seed);
  check_versions(soup, 12, 2, names_faces);
}

TEST_CASE("faces that are put anywhere on a sheet, and taken from it, leave it as the repair of all does") {
  const auto seed = static_cast<std::uint32_t>(GENERATE(range(0, 10)));
  const int side = GENERATE(7, 20);
  const bool names_faces = GENERATE(false, true);
  CAPTURE(seed, side, names_faces);
  ChangingSoup soup(seed, side);
  check_versions(soup, 10, 1, names_faces);
}

// Two sheets of squares side by side, the second of fewer, whose faces turn against those of the first.
GrownSoup opposed_sheets(std::uint32_t first, std::uint32_t second) {
  GrownSoup grown;
  const std::uint32_t columns = first + second;
  for (std::uint32_t i = 0; i < 2 * (columns + 1); ++i) grown.soup.positions.emplace_back(i / 2, i % 2, 0);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const std::uint32_t a = 2 * column;
    glm::uvec3 low(a, a + 2, a + 3), high(a, a + 3, a + 1);
    if (column >= first) {
      std::swap(low.y, low.z);
      std::swap(high.y, high.z);
    }
    grown.soup.faces.push_back(low);
    grown.soup.faces.push_back(high);
  }
  return grown;
}

TEST_CASE("faces far from a change are turned round as soon as those that turn against them are more, and back") {
  GrowingRepair growing;
  std::uint32_t positions_before = 0;
  std::size_t faces_before = 0;
  for (const std::uint32_t second : {90U, 99U, 101U, 130U, 100U, 60U, 140U}) {
    CAPTURE(second);
    GrownSoup grown = opposed_sheets(100, second);
    const auto positions = static_cast<std::uint32_t>(grown.soup.positions.size());
    for (std::uint32_t i = 0; positions_before > 0 && i < positions; ++i) {
      grown.previous_position.push_back(i < positions_before ? VertexId(i) : VertexId::none);
    }
    const std::size_t faces = grown.soup.faces.size();
    for (std::uint32_t i = 0; faces_before > 0 && i < faces; ++i) {
      grown.previous_face.push_back(i < faces_before ? FaceId(i) : FaceId::none);
    }
    positions_before = positions;
    faces_before = faces;
    const Mesh made = growing.next(grown).mesh;
    CHECK(form_of(made) == form_of(repair(grown.soup, glm::dvec3(0)).mesh));
    const Mesh at_once = GrowingRepair().next({grown.soup, {}}).mesh;
    CHECK(made.faces == at_once.faces);
    CHECK(made.positions == at_once.positions);
  }
}

TEST_CASE("a mesh of many chunks that grows is the same to the byte for any number of threads, and made at once") {
  const auto versions = [](int threads) {
    std::vector<Mesh> meshes;
    tbb::task_arena(threads).execute([&] {
      GrowingRepair growing;
      GrownSoup grown = opposed_sheets(30'000, 29'000);
      meshes.push_back(growing.next(grown).mesh);
      for (std::uint32_t i = 0; i < grown.soup.positions.size(); ++i) grown.previous_position.emplace_back(i);
      // Each version has more holes in the larger sheet, until it is the smaller one.
      for (std::uint32_t version = 1; version < 5; ++version) {
        std::uint32_t face = 0;
        std::erase_if(grown.soup.faces, [&](const glm::uvec3&) { return ++face % 97 == version && face < 60'000; });
        meshes.push_back(growing.next(grown).mesh);
        const Mesh at_once = GrowingRepair().next({grown.soup, {}}).mesh;
        CHECK(meshes.back().faces == at_once.faces);
        CHECK(meshes.back().positions == at_once.positions);
      }
    });
    return meshes;
  };
  const std::vector<Mesh> one = versions(1), two = versions(2);
  REQUIRE(one.size() == two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    CHECK(one[i].faces == two[i].faces);
    CHECK(one[i].positions == two[i].positions);
  }
}

namespace {

// A floor of tiles in a row. Each is a sheet of squares with positions of its own, so that the soup has many chunks,
// and faces that stay are in runs. Tiles come, go, bend, and begin their faces with other corners. Some turn against
// others.
class ChangingFloor {
 public:
  ChangingFloor(std::uint32_t seed, int tiles) : random_(seed) {
    for (int i = 0; i < tiles; ++i) tiles_.push_back({.turns_over = below(4) == 0});
  }

  void change_some() {
    for (Tile& tile : tiles_) {
      if (below(12) == 0) tile.is_there = !tile.is_there;
      if (below(12) == 0) tile.bent = below(kSide);
      if (below(20) == 0) tile.first_corner = below(3);
      if (below(20) == 0) tile.doubled = below(kSide);
    }
  }
  void keep_one() {
    for (Tile& tile : tiles_) tile.is_there = false;
    tiles_[static_cast<std::size_t>(below(static_cast<int>(tiles_.size())))].is_there = true;
  }
  void bend_all() {
    for (Tile& tile : tiles_) tile = {.bent = (tile.bent + 1) % kSide, .turns_over = tile.turns_over};
  }

  GrownSoup version() {
    GrownSoup grown;
    for (std::size_t i = 0; i < tiles_.size(); ++i) append(tiles_[i], static_cast<double>(kSide * i), grown);
    return grown;
  }

 private:
  static constexpr int kSide = 16;  // squares
  struct Tile {
    bool is_there = true;
    int bent = 0;          // row that is higher than the others
    int first_corner = 0;  // of its faces
    int doubled = 0;       // row whose faces are there twice
    bool turns_over = false;
    // The places in the last version; none: it was not there.
    std::optional<std::uint32_t> first_position = {}, first_face = {};
    int bent_before = 0, first_corner_before = 0, doubled_before = 0;
  };

  int below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }

  void append(Tile& tile, double left, GrownSoup& grown) {
    if (!tile.is_there) {
      tile.first_position = tile.first_face = std::nullopt;
      return;
    }
    const auto first = static_cast<std::uint32_t>(grown.soup.positions.size());
    for (int row = 0; row <= kSide; ++row) {
      const bool stays = tile.first_position && (row == tile.bent) == (row == tile.bent_before);
      for (int column = 0; column <= kSide; ++column) {
        const std::uint32_t number = static_cast<std::uint32_t>(row * (kSide + 1) + column);
        grown.soup.positions.emplace_back(left + column, row, row == tile.bent ? 1 : 0);
        grown.previous_position.push_back(stays ? VertexId(*tile.first_position + number) : VertexId::none);
      }
    }
    const auto first_face = static_cast<std::uint32_t>(grown.soup.faces.size());
    const bool keeps_faces = tile.first_face && tile.bent == tile.bent_before &&
                             tile.first_corner == tile.first_corner_before && tile.doubled == tile.doubled_before;
    const bool names_faces = keeps_faces && below(4) != 0;
    for (int row = 0; row < kSide; ++row) append_row(tile, row, first, grown);
    for (std::uint32_t face = first_face; face < grown.soup.faces.size(); ++face) {
      grown.previous_face.push_back(names_faces ? FaceId(*tile.first_face + face - first_face) : FaceId::none);
    }
    tile.first_position = first;
    tile.first_face = first_face;
    tile.bent_before = tile.bent;
    tile.first_corner_before = tile.first_corner;
    tile.doubled_before = tile.doubled;
  }

  static void append_row(const Tile& tile, int row, std::uint32_t first, GrownSoup& grown) {
    for (int times = 0; times < (row == tile.doubled ? 2 : 1); ++times) {
      for (int column = 0; column < kSide; ++column) {
        const std::uint32_t a = first + static_cast<std::uint32_t>(row * (kSide + 1) + column), c = a + kSide + 2;
        append_face(tile, {a, a + 1, c}, grown);
        append_face(tile, {a, c, c - 1}, grown);
      }
    }
  }

  static void append_face(const Tile& tile, std::array<std::uint32_t, 3> corners, GrownSoup& grown) {
    if (tile.turns_over) std::swap(corners[1], corners[2]);
    std::rotate(corners.begin(), corners.begin() + tile.first_corner, corners.end());
    grown.soup.faces.emplace_back(corners[0], corners[1], corners[2]);
  }

  std::mt19937 random_;
  std::vector<Tile> tiles_;
};

// Makes each version with that many threads, compares it with the mesh of its soup made at once, and returns all.
std::vector<GrownMesh> floors(std::uint32_t seed, int threads) {
  std::vector<GrownMesh> made;
  tbb::task_arena(threads).execute([&] {
    ChangingFloor floor(seed, 100);
    GrowingRepair growing;
    for (int version = 0; version < 12; ++version) {
      const GrownSoup grown = floor.version();
      GrownSoup wrong = grown;
      wrong.soup.faces.emplace_back(0, 1, static_cast<std::uint32_t>(wrong.soup.positions.size()));
      if (version % 3 == 1) CHECK_THROWS_AS(growing.next(wrong), std::invalid_argument);
      made.push_back(growing.next(grown));
      const Mesh at_once = GrowingRepair().next({grown.soup, {}}).mesh;
      CHECK(made.back().mesh.faces == at_once.faces);
      CHECK(made.back().mesh.positions == at_once.positions);
      if (version == 5) {
        floor.keep_one();
      } else if (version == 8) {
        floor.bend_all();
      } else if (version != 3) {  // one version is that before it
        floor.change_some();
      }
    }
  });
  return made;
}

}  // namespace

TEST_CASE("pieces that come, go, bend and turn leave the mesh of their soup, for any number of threads") {
  const auto seed = static_cast<std::uint32_t>(GENERATE(range(0, 6)));
  CAPTURE(seed);
  const std::vector<GrownMesh> one = floors(seed, 1), four = floors(seed, 4);
  REQUIRE(one.size() == four.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    CHECK(one[i].mesh.faces == four[i].mesh.faces);
    CHECK(one[i].mesh.positions == four[i].mesh.positions);
    CHECK(one[i].previous_face == four[i].previous_face);
    for (FaceId face{0}; i > 0 && face < one[i].previous_face.size(); ++face) {
      const FaceId previous = one[i].previous_face[face];
      if (previous == FaceId::none) continue;
      const FaceCorners now = face_corners(one[i].mesh, face);
      const glm::uvec3& f = one[i].mesh.faces[face];
      const std::vector<glm::vec3>& places = one[i].mesh.positions;
      const Mesh turned{{places[f.y], places[f.x], places[f.z]}, {}, {{0, 1, 2}}};
      const FaceCorners then = face_corners(one[i - 1].mesh, previous);
      if (now != then && face_corners(turned, FaceId{0}) != then) FAIL("face " << face << " was another");
    }
  }
}

TEST_CASE("where faces turn against each other, only those around a change are repaired again") {
  GrowingRepair growing;
  GrownSoup grown = opposed_sheets(1000, 100);
  (void)growing.next(grown);
  for (std::uint32_t i = 0; i < grown.soup.positions.size(); ++i) grown.previous_position.emplace_back(i);
  (void)growing.next(grown);
  CHECK(growing.faces_repaired() == 0);
  grown.soup.faces.erase(grown.soup.faces.begin() + 20);
  CHECK(form_of(growing.next(grown).mesh) == form_of(repair(grown.soup, glm::dvec3(0)).mesh));
  CHECK(growing.faces_repaired() > 0);
  CHECK(growing.faces_repaired() < 20);
}

TEST_CASE("of faces between the same points the first one is kept, also after their order has changed") {
  const bool joined = GENERATE(false, true);
  CAPTURE(joined);
  GrownSoup grown;
  for (int i = 0; i < 5; ++i) grown.soup.positions.emplace_back(i % 2, i / 2, i == 4 ? 1 : 0);
  for (int i = 0; joined && i < 3; ++i)
    grown.soup.positions.push_back(grown.soup.positions[static_cast<std::size_t>(i)]);
  const glm::uvec3 first(0, 1, 2), second = joined ? glm::uvec3(5, 6, 7) : glm::uvec3(0, 2, 1);
  grown.soup.faces = {first, second};
  GrowingRepair repairs;
  (void)repairs.next(grown);
  grown.soup.faces = {second, first, {0, 3, 4}};
  for (std::uint32_t i = 0; i < grown.soup.positions.size(); ++i) grown.previous_position.emplace_back(i);
  CHECK(form_of(repairs.next(grown).mesh) == form_of(repair(grown.soup, glm::dvec3(0)).mesh));
}

TEST_CASE("faces around one position are found again in time that grows with their number") {
  constexpr std::uint32_t kFaces = 200'000;
  GrownSoup fan;
  fan.soup.positions.emplace_back(0, 0, 0);
  for (std::uint32_t i = 0; i <= kFaces; ++i) fan.soup.positions.emplace_back(1 + i, i % 7, i % 5);
  for (std::uint32_t i = 1; i <= kFaces; ++i) fan.soup.faces.emplace_back(0, i, i + 1);
  GrowingRepair repairs;
  const std::size_t faces = repairs.next(fan).mesh.faces.size();
  for (std::uint32_t i = 0; i < fan.soup.positions.size(); ++i) fan.previous_position.emplace_back(i);
  const GrownMesh again = repairs.next(fan);
  CHECK(again.mesh.faces.size() == faces);
  CHECK(repairs.faces_repaired() == 0);
  for (FaceId face{0}; face < faces; ++face) REQUIRE(again.previous_face[face] == face);
}

TEST_CASE("only faces around a change are repaired again") {
  ChangingSoup sheet(0, 100);
  GrowingRepair growing;
  const GrownMesh first = growing.next(sheet.version());
  CHECK(growing.faces_repaired() == 20'000);
  GrownSoup same = sheet.version();
  const GrownMesh again = growing.next(same);
  CHECK(growing.faces_repaired() == 0);
  CHECK(form_of(again.mesh) == form_of(first.mesh));
  CHECK(
      std::none_of(again.previous_face.begin(), again.previous_face.end(), [](FaceId f) { return f == FaceId::none; }));
  GrownSoup less = sheet.version();
  less.soup.faces.erase(less.soup.faces.begin() + 10'100);
  CHECK(growing.next(less).mesh.faces.size() == 19'999);
  CHECK(growing.faces_repaired() > 0);
  CHECK(growing.faces_repaired() < 20);
}

TEST_CASE("positions that are not finite drop their faces, in later versions too") {
  ChangingSoup sheet(0, 3);
  GrownSoup grown = sheet.version();
  grown.soup.positions[5].x = std::numeric_limits<double>::infinity();
  GrowingRepair growing;
  const Mesh whole = repair(grown.soup, glm::dvec3(0)).mesh;
  CHECK(form_of(growing.next(grown).mesh) == form_of(whole));
  GrownSoup next = sheet.version();
  next.soup.positions[5] = grown.soup.positions[5];
  next.soup.faces.pop_back();
  CHECK(form_of(growing.next(next).mesh) == form_of(repair(next.soup, glm::dvec3(0)).mesh));
}

TEST_CASE("a growing repair refuses lists that do not fit, and goes on from the version before") {
  ChangingSoup sheet(0, 3);
  GrowingRepair growing;
  const GrownMesh first = growing.next(sheet.version());
  const GrownSoup good = sheet.version();
  const auto refuses = [&](const GrownSoup& bad, const std::string& why) {
    CHECK_THROWS_WITH(growing.next(bad), Catch::Contains(why));
  };
  GrownSoup bad = good;
  bad.previous_position.pop_back();
  refuses(bad, "previous_position has 15 entries, must be empty or have 16");
  bad = good;
  bad.previous_position[3] = VertexId(16);
  refuses(bad, "previous_position names 16 of 16");
  bad = good;
  bad.previous_position[3] = VertexId(4);
  refuses(bad, "previous_position names 4 twice");
  bad = good;
  bad.soup.faces[2].y = 16;
  refuses(bad, "face 2 refers to no position");
  const auto names = [&](std::vector<FaceId> faces, const std::string& why) {
    bad = good;
    faces.resize(good.soup.faces.size());
    bad.previous_face = std::move(faces);
    refuses(bad, why);
  };
  names({FaceId(18)}, "previous_face names 18 of 18");
  names({FaceId(3), FaceId(2)}, "previous_face names 2 after 3");
  names({FaceId(3), FaceId(3)}, "previous_face names 3 after 3");
  names({FaceId(3)}, "previous_face names 3 at face 0, which has other corners");
  bad = good;
  bad.previous_face.resize(3);
  refuses(bad, "previous_face has 3 entries, must be empty or have 18");
  bad.previous_position.clear();
  bad.previous_face.assign(18, FaceId::none);
  bad.previous_face[7] = 7;
  refuses(bad, "previous_face names 7, whose positions are all new");
  bad.previous_face[7] = FaceId::none;  // nothing stays: that is no fault
  CHECK(form_of(growing.next(bad).mesh) == form_of(GrowingRepair().next(bad).mesh));
  (void)growing.next(good);
  bad = GrownSoup{};
  CHECK_THROWS_AS(growing.next(bad), InputError);
  CHECK(form_of(growing.next(good).mesh) == form_of(first.mesh));
}
