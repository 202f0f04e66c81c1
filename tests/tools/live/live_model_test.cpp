// SPDX-License-Identifier: GPL-3.0-or-later
// Tests what the threads of a live model share. No case depends on how long anything takes.
#include "tools/live/live_model.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <future>
#include <glm/glm.hpp>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/tools/live/room_stream.h"

namespace lumatlas {
namespace {

void wait_for(const std::function<bool()>& done) {
  while (!done()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

// A model with a surface of the first frames, and no view.
std::unique_ptr<LiveModel> model_with_surface(const LiveOptions& options, std::size_t frames) {
  auto live = std::make_unique<LiveModel>(options);
  for (std::size_t number = 0; number < frames; ++number) {
    fuse_room(*live, number);
    wait_for([&] { return live->status().fusion.count == number + 1; });  // so that none is given up
  }
  // Views that wait for more of the surface would be ready in another order than that of their offers.
  wait_for([&] { return live->status().surface_rests; });
  return live;
}

// A photograph or depth frame that is there once release() is called.
class BlockedSource {
 public:
  void wait() {
    asked_ = true;
    gate_.get_future().wait();
  }
  void release() { gate_.set_value(); }
  [[nodiscard]] bool asked() const { return asked_; }

 private:
  std::promise<void> gate_;
  std::atomic<bool> asked_ = false;
};

TEST_CASE("a live model chooses views while it fuses a surface, and both are in the result") {
  LiveModel live(room_live_options());
  CHECK(live.snapshot() == nullptr);
  for (std::size_t number = 0; number < 40; ++number) {
    fuse_room(live, number);
    offer_room(live, number);
    wait_for([&] { return live.status().waiting < 20 && live.status().fusion.count > number; });
  }
  const LiveResult model = live.finish();
  REQUIRE(model.snapshot.surface);
  CHECK_NOTHROW(check(model.snapshot));
  const auto& views = model.snapshot.views;
  CHECK(std::count_if(views.begin(), views.end(), [](const auto& view) { return view != nullptr; }) == 12);
  CHECK(model.planner.coverage.ideal_distance > 0.5);
  CHECK(model.summed_coverage > 0);
  // The room is 4 x 4 x 3 and its box stands inside: no vertex is farther out than a part of a voxel.
  for (const glm::vec3& p : model.snapshot.surface->mesh.positions) {
    CHECK(glm::all(glm::greaterThan(p, glm::vec3(-0.1F))));
    CHECK(glm::all(glm::lessThan(p, glm::vec3(4.1F, 4.1F, 3.1F))));
  }
}

TEST_CASE("offers return while a photograph is being read and a depth frame is being fused") {
  const auto live = model_with_surface(room_live_options(), 6);
  BlockedSource photograph, depth;
  const Camera first = room_camera(0);
  REQUIRE(live->offer("first", first,
                      [&] {
                        photograph.wait();
                        return pattern_photograph(first, 0);
                      })
              .decision == LiveDecision::chosen);
  live->fuse("first", first, [&] {
    depth.wait();
    return room_depth(first);
  });
  wait_for([&] { return photograph.asked() && depth.asked(); });
  for (std::size_t number = 1; number < 30; ++number) {  // would not come back before release() if one waited
    (void)offer_room(*live, number);
    fuse_room(*live, number);
  }
  live->move_views({{"first", room_camera(2)}});
  CHECK(live->status().offered == 30);
  CHECK_FALSE(live->status().surface_rests);
  CHECK(live->status().stored == 0);
  CHECK(live->snapshot() != nullptr);
  photograph.release();
  depth.release();
  const LiveResult model = live->finish();
  CHECK_NOTHROW(check(model.snapshot));
  CHECK(live->status().stored > 0);
}

TEST_CASE("a full queue gives up the views with the least news, and says which") {
  LiveOptions options = room_live_options();
  options.waiting_views = 4;
  options.max_views = 30;
  const auto live = model_with_surface(options, 30);
  BlockedSource photograph;
  const Camera first = room_camera(0);
  REQUIRE(live->offer("first", first,
                      [&] {
                        photograph.wait();
                        return pattern_photograph(first, 0);
                      })
              .decision == LiveDecision::chosen);
  wait_for([&] { return photograph.asked(); });
  std::set<std::string> chosen, dropped;
  double least_kept = 1;
  for (std::size_t number = 1; number < 25; ++number) {
    const LiveVerdict verdict = offer_room(*live, number);
    CHECK(verdict.news >= 0);
    CHECK(verdict.news <= 1);
    if (verdict.decision == LiveDecision::not_needed) {
      CHECK(verdict.dropped.empty());
      continue;
    }
    chosen.insert(room_view(number));
    for (const std::string& name : verdict.dropped) CHECK(dropped.insert(name).second);
    CHECK(live->status().waiting <= 4);
    CHECK(verdict.dropped.size() == (chosen.size() > 4 ? 1 : 0));
    least_kept = std::min(least_kept, verdict.news);
  }
  REQUIRE(chosen.size() > 6);
  CHECK(live->status().dropped == dropped.size());
  photograph.release();
  (void)live->finish();
  std::set<std::string> stored;
  for (const LiveOutcome& outcome : live->take_outcomes()) {
    CHECK(outcome.failure.empty());
    if (outcome.name != "first") CHECK(stored.insert(outcome.name).second);
  }
  CHECK(stored.size() == 4);
  for (const std::string& name : dropped) stored.insert(name);
  CHECK((stored == chosen));  // each view was either stored or reported as dropped
}

// Offers views of the room while the photograph of another view is being read. Returns which are stored, in that order.
std::vector<std::string> stored_behind_another(LiveModel& live, std::size_t offers) {
  BlockedSource photograph;
  const Camera first = room_camera(0);
  live.offer("first", first, [&] {
    photograph.wait();
    return pattern_photograph(first, 0);
  });
  wait_for([&] { return photograph.asked(); });
  for (std::size_t number = 1; number < offers; ++number) {
    (void)offer_room(live, number);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  photograph.release();
  (void)live.finish();
  std::vector<std::string> stored;
  for (const LiveOutcome& outcome : live.take_outcomes()) {
    if (outcome.name.starts_with("view ") && outcome.verdict.slot) stored.push_back(outcome.name);
  }
  return stored;
}

TEST_CASE("views that have waited for longer than the longest wait are stored in the order of their offers") {
  LiveOptions options = room_live_options();
  options.longest_wait = std::chrono::milliseconds(1);
  options.max_views = 30;
  const auto live = model_with_surface(options, 30);
  const std::vector<std::string> stored = stored_behind_another(*live, 12);
  REQUIRE(stored.size() > 4);
  const auto number = [](const std::string& name) { return std::stoi(name.substr(name.find(' '))); };
  CHECK(std::is_sorted(stored.begin(), stored.end(),
                       [&](const std::string& a, const std::string& b) { return number(a) < number(b); }));
}

TEST_CASE("four views may wait where each takes longer than the longest wait") {
  LiveOptions options = room_live_options();
  options.longest_wait = std::chrono::milliseconds(1);
  options.max_views = 30;
  const auto live = model_with_surface(options, 30);
  const Camera slow = room_camera(29);
  live->offer("slow", slow, [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return pattern_photograph(slow, 29);
  });
  wait_for([&] { return live->status().storing.count == 1; });
  CHECK(stored_behind_another(*live, 20).size() == 4);
  CHECK(live->status().dropped > 0);
}

TEST_CASE("every snapshot is whole while views, surfaces and poses change") {
  LiveModel live(room_live_options());
  std::atomic<bool> ended = false;
  std::atomic<int> looks = 0, broken = 0, torn = 0;
  // Poses move by whole steps: a snapshot that has one step of one view has it of all that were stored before.
  const auto at_step = [](std::size_t number, int step) {
    Camera camera = room_camera(number);
    camera.cam_from_world_translation += camera.cam_from_world_rotation * glm::dvec3(0, 0, -1000.0 * step);
    return camera;
  };
  std::thread viewer([&] {
    while (!ended) {
      const auto now = live.snapshot();
      if (!now) continue;
      ++looks;
      try {
        check(*now);
      } catch (const std::invalid_argument&) {
        ++broken;
      }
      std::set<int> steps;
      for (const auto& view : now->views) {
        if (view) steps.insert(static_cast<int>(std::lround(view->camera.center().z / 1000)));
      }
      if (steps.size() > 1) ++torn;
    }
  });
  for (std::size_t number = 0; number < 12; ++number) {
    fuse_room(live, number);
    offer_room(live, number);
    wait_for([&] { return live.status().fusion.count == number + 1 && live.status().waiting == 0; });
  }
  wait_for([&] { return live.status().storing.count > 4 && live.status().waiting == 0; });
  for (int step = 1; step < 6; ++step) {
    std::vector<MovedView> moved;
    for (std::size_t number = 0; number < 12; ++number) moved.push_back({room_view(number), at_step(number, step)});
    live.move_views(moved);
    wait_for([&] { return live.status().moving.count == static_cast<std::uint64_t>(step); });
  }
  ended = true;
  viewer.join();
  CHECK(looks > 0);
  CHECK(broken == 0);
  CHECK(torn == 0);
  CHECK_NOTHROW(check(live.finish().snapshot));
}

TEST_CASE("after poses have changed, depths and references are those of the later poses") {
  LiveOptions options = room_live_options();
  const auto live = model_with_surface(options, 30);
  std::vector<MovedView> closed;
  for (std::size_t number = 0; number < 12; ++number) {
    Camera drifted = room_camera(number);
    drifted.cam_from_world_translation += glm::dvec3(0.2, 0.1, -0.1);
    live->offer(room_view(number), drifted, [drifted, number] { return pattern_photograph(drifted, number); });
    closed.push_back({room_view(number), room_camera(number)});
  }
  live->move_views(closed);  // some are stored by now, others wait
  const LiveResult model = live->finish();
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(model.snapshot.surface->mesh);
  std::size_t views = 0;
  for (ViewSlot slot{0}; slot < model.snapshot.views.size(); ++slot) {
    const auto& view = model.snapshot.views[slot];
    if (!view) continue;
    ++views;
    const auto moved = std::find_if(closed.begin(), closed.end(), [&](const auto& v) { return v.name == view->name; });
    REQUIRE(moved != closed.end());
    CHECK(view->camera.center() == moved->camera.center());
    CHECK(view->mask->depth == visibility->trace_sparsely(view->camera).depth);
  }
  CHECK(views > 3);
}

// Returns the largest distance of a vertex from the room's walls, floor and ceiling or the box in it, scene units.
double farthest_from_room(const Mesh& mesh) {
  static const std::unique_ptr<Visibility> visibility = make_ray_visibility(room_surface()->mesh);
  // Vertices of a surface that is in its place are near what a camera sees along the ray to them.
  double farthest = 0;
  for (std::size_t number = 0; number < 20; number += 4) {
    const Camera camera = room_camera(number);
    const VisibilityBuffer room = visibility->trace(camera), fused = make_ray_visibility(mesh)->trace(camera);
    std::vector<double> distances;
    for (std::size_t pixel = 0; pixel < room.depth.size(); ++pixel) {
      if (!std::isfinite(room.depth[pixel]) || !std::isfinite(fused.depth[pixel])) continue;
      distances.push_back(std::abs(room.depth[pixel] - fused.depth[pixel]));
    }
    REQUIRE(distances.size() > room.depth.size() / 4);
    std::nth_element(distances.begin(), distances.begin() + distances.size() * 9 / 10, distances.end());
    farthest = std::max(farthest, distances[distances.size() * 9 / 10]);
  }
  return farthest;
}

TEST_CASE("after a loop closure the surface is that of a stream without drift") {
  constexpr std::size_t kFrames = 20;
  const auto drifted = [](std::size_t number) {
    Camera camera = room_camera(number);
    camera.cam_from_world_translation += 0.03 * static_cast<double>(number) * glm::dvec3(0.6, -0.4, 0.7);
    return camera;
  };
  const auto surface_of = [&](bool drifts, bool closes) {
    LiveModel live(room_live_options());
    std::vector<MovedView> closed;
    for (std::size_t number = 0; number < kFrames; ++number) {
      // The sensor sees the room from where it is, and is said to be elsewhere.
      live.fuse(room_view(number), drifts ? drifted(number) : room_camera(number),
                [number] { return room_depth(room_camera(number)); });
      wait_for([&] { return live.status().fusion.count == number + 1; });  // so that none is given up
      closed.push_back({room_view(number), room_camera(number)});
    }
    if (closes) {
      live.move_views(closed);
      wait_for([&] { return live.status().fusing_again.count == kFrames - 1; });  // the first frame has not moved
      wait_for([&] { return live.status().depths_to_move == 0; });
    }
    return live.finish().snapshot.surface->mesh;
  };
  const Mesh true_mesh = surface_of(false, false);
  const double without = farthest_from_room(true_mesh);
  CHECK(without < 0.05);  // half a voxel
  CHECK(farthest_from_room(surface_of(true, false)) > 4 * without);
  const Mesh closed_mesh = surface_of(true, true);
  CHECK(farthest_from_room(closed_mesh) == without);
  CHECK(closed_mesh.positions == true_mesh.positions);
}

TEST_CASE("a loop closure moves stored views and surface together, before a depth frame is fused again") {
  LiveModel live(room_live_options());
  constexpr std::size_t kFrames = 12;
  const glm::dvec3 shift(0.5, -0.25, -1);
  std::vector<MovedView> closed;
  for (std::size_t number = 0; number < kFrames; ++number) {
    fuse_room(live, number);
    wait_for([&] { return live.status().fusion.count == number + 1; });
    offer_room(live, number);
    wait_for([&] { return live.status().waiting == 0; });
    Camera camera = room_camera(number);
    camera.cam_from_world_translation -= camera.cam_from_world_rotation * shift;
    closed.push_back({room_view(number), camera});
  }
  wait_for([&] { return live.status().surface_rests; });
  // This frame keeps the thread of the surface from all that comes after the bend.
  BlockedSource depth;
  const auto before = live.snapshot();
  live.move_views(closed);
  live.fuse("blocks", room_camera(0), [&]() -> DepthImage {
    depth.wait();
    throw std::runtime_error("it never was there");
  });
  wait_for([&] { return live.status().moving.count == 1; });
  const auto after = live.snapshot();
  REQUIRE(after->surface != before->surface);
  CHECK(after->surface->mesh.faces == before->surface->mesh.faces);
  double farthest = 0;
  for (std::size_t vertex = 0; vertex < after->surface->mesh.positions.size(); ++vertex) {
    const glm::dvec3 off = glm::dvec3(after->surface->mesh.positions[vertex] - before->surface->mesh.positions[vertex]);
    farthest = std::max(farthest, glm::length(off - shift));
  }
  CHECK(farthest < 1e-5);
  std::size_t views = 0;
  for (const auto& view : after->views) {
    if (!view) continue;
    ++views;
    const auto moved = std::find_if(closed.begin(), closed.end(), [&](const auto& v) { return v.name == view->name; });
    REQUIRE(moved != closed.end());
    CHECK(view->camera.center() == moved->camera.center());
  }
  CHECK(views > 3);
  depth.release();
  const Snapshot model = live.finish().snapshot;
  CHECK_NOTHROW(check(model));
  CHECK(live.status().depths_to_move == 0);
}

TEST_CASE("no view is read and refined between the call that moves views and their move") {
  LiveModel live(room_live_options());
  for (std::size_t number = 0; number < 8; ++number) {
    fuse_room(live, number);
    wait_for([&] { return live.status().fusion.count == number + 1; });
  }
  offer_room(live, 0);
  wait_for([&] { return live.status().stored == 1 && live.status().surface_rests; });
  BlockedSource depth;
  live.fuse("blocks", room_camera(0), [&]() -> DepthImage {
    depth.wait();
    throw std::runtime_error("it never was there");
  });
  wait_for([&] { return depth.asked(); });
  std::vector<MovedView> closed;
  for (std::size_t number = 0; number < 8; ++number) {
    Camera camera = room_camera(number);
    camera.cam_from_world_translation -= camera.cam_from_world_rotation * glm::dvec3(0.5, -0.25, -1);
    closed.push_back({room_view(number), camera});
  }
  live.move_views(closed);
  std::atomic<std::uint64_t> moved_before = 0, asked = 0;
  const Camera camera = closed[4].camera;
  live.offer(room_view(4), camera, [&] {
    moved_before = live.status().moving.count;
    ++asked;
    return pattern_photograph(camera, 4);
  });
  depth.release();
  wait_for([&] { return live.status().waiting == 0; });
  (void)live.finish();
  REQUIRE(asked == 1);
  CHECK(moved_before == 1);
}

TEST_CASE("poses that come all the time keep out neither views nor surfaces") {
  LiveModel live(room_live_options());
  for (std::size_t number = 0; number < 4; ++number) {
    fuse_room(live, number);
    wait_for([&] { return live.status().fusion.count == number + 1; });
  }
  wait_for([&] { return live.status().surface_rests; });
  std::atomic<bool> ended = false;
  std::thread slam([&] {
    for (int step = 0; !ended; ++step) {
      std::vector<MovedView> moved;
      for (std::size_t number = 0; number < 12; ++number) {
        Camera camera = room_camera(number);
        camera.cam_from_world_translation += 0.02 * (step % 2) * glm::dvec3(1, -1, 1);
        moved.push_back({room_view(number), camera});
      }
      live.move_views(moved);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  const std::uint64_t surfaces = live.status().surface_making.count;
  for (std::size_t number = 4; number < 8; ++number) {
    fuse_room(live, number);
    offer_room(live, number);
    wait_for([&] { return live.status().waiting == 0; });
  }
  wait_for([&] { return live.status().surface_making.count > surfaces; });
  ended = true;
  slam.join();
  CHECK(live.status().stored > 0);
  CHECK_NOTHROW(check(live.finish().snapshot));
}

TEST_CASE("a caller that makes the surface anew does not wait for depth frames that move") {
  LiveModel live(room_live_options());
  std::vector<MovedView> closed;
  for (std::size_t number = 0; number < 8; ++number) {
    fuse_room(live, number);
    wait_for([&] { return live.status().fusion.count == number + 1; });
    closed.push_back({room_view(number), room_camera(number + 1)});
  }
  BlockedSource depth;
  live.fuse("last", room_camera(9), [&] {
    depth.wait();
    return room_depth(room_camera(9));
  });
  wait_for([&] { return depth.asked(); });
  live.move_views(closed);
  std::future<LiveResult> model = std::async(std::launch::async, [&] { return live.finish(0, false); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  depth.release();
  CHECK(model.get().snapshot.surface != nullptr);
  CHECK(live.status().fusing_again.count == 0);
}

TEST_CASE("a photograph or depth frame that cannot be had is noted, and the others go on") {
  LiveModel live(room_live_options());
  for (std::size_t number = 0; number < 8; ++number) {
    fuse_room(live, number);
    live.fuse("none", room_camera(number), []() -> DepthImage { throw std::runtime_error("no such depth"); });
    const Camera camera = room_camera(number);
    live.offer(room_view(number), camera, [number, camera] {
      if (number % 2 == 1) throw std::runtime_error("no such photograph");
      return pattern_photograph(camera, number);
    });
    wait_for([&] { return live.status().fusion.count == 2 * number + 2; });
  }
  const LiveResult model = live.finish();
  const LiveStatus status = live.status();
  CHECK(status.depths_refused == 8);
  CHECK(status.failed > 0);
  CHECK(status.stored > 0);
  for (const LiveOutcome& outcome : live.take_outcomes()) {
    const bool bad = !outcome.failure.empty();
    if (bad) CHECK(outcome.failure == "no such photograph");
  }
  for (const auto& view : model.snapshot.views) {
    if (view) CHECK((view->name.back() - '0') % 2 == 0);
  }
}

TEST_CASE("a live model of pieces of surface stores views on them, and follows pieces that are replaced") {
  LiveModel live(room_live_options());
  for (std::uint32_t octant = 0; octant < 7; ++octant) CHECK(live.replace_piece(octant, room_piece(octant)));
  for (std::size_t number = 0; number < 30; ++number) {
    offer_room(live, number);
    if (number == 12) CHECK(live.replace_piece(7, room_piece(7)));
    if (number == 20) CHECK(live.replace_piece(3, room_piece(3)));  // the same again changes nothing
    wait_for([&] { return live.snapshot() != nullptr && live.status().waiting < 20; });
  }
  CHECK_THROWS_AS(fuse_room(live, 0), std::logic_error);
  const LiveResult model = live.finish();
  CHECK(live.status().pieces_given == 9);
  REQUIRE(model.snapshot.surface);
  CHECK_NOTHROW(check(model.snapshot));
  const auto& views = model.snapshot.views;
  CHECK(std::count_if(views.begin(), views.end(), [](const auto& view) { return view != nullptr; }) == 12);
  CHECK(model.planner.coverage.ideal_distance > 0.5);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(model.snapshot.surface->mesh);
  const std::unique_ptr<Visibility> room = make_ray_visibility(room_surface()->mesh);
  for (const auto& view : views) {
    if (!view) continue;
    CHECK(view->mask->depth == visibility->trace_sparsely(view->camera).depth);
  }
  const VisibilityBuffer seen = visibility->trace(room_camera(5)), truth = room->trace(room_camera(5));
  for (std::size_t pixel = 0; pixel < seen.depth.size(); ++pixel) {
    if (std::isfinite(truth.depth[pixel])) CHECK(std::abs(seen.depth[pixel] - truth.depth[pixel]) < 1e-3F);
  }
}

TEST_CASE("a live model refuses pieces beyond its bound, beside depth frames and of wrong indices") {
  LiveOptions options = room_live_options();
  options.surface.max_piece_faces = room_piece(0).faces.size() * 3;
  LiveModel live(options);
  CHECK(live.replace_piece(0, room_piece(0)));
  CHECK_FALSE(live.replace_piece(1, room_piece(1)));  // has three vertices for each face
  CHECK(live.replace_piece(0, room_piece(0)));        // is there once
  CHECK(live.replace_piece(0, {}));
  CHECK(live.replace_piece(1, room_piece(0)));
  CHECK(live.status().pieces_refused == 1);
  CHECK(live.status().pieces_given == 4);
  CHECK_THROWS_AS(live.replace_piece(2, TriangleSoup{{}, {}, {{0, 0, 0}}}), std::invalid_argument);
  CHECK(live.replace_piece(1, {}));
  CHECK(offer_room(live, 0).decision == LiveDecision::not_yet);  // a piece may still come
  CHECK(live.finish().snapshot.surface == nullptr);
  CHECK_THROWS_AS(live.replace_piece(1, room_piece(0)), std::logic_error);
  LiveModel of_depths(room_live_options());
  fuse_room(of_depths, 0);
  CHECK_THROWS_AS(of_depths.replace_piece(0, room_piece(0)), std::logic_error);
}

TEST_CASE("a piece that is too large for a surface leaves the one before, and the stream goes on") {
  LiveOptions options = room_live_options();
  LiveModel live(options);
  for (std::uint32_t octant = 0; octant < 8; ++octant) CHECK(live.replace_piece(octant, room_piece(octant)));
  for (std::size_t number = 0; number < 6; ++number) offer_room(live, number);
  wait_for([&] { return live.snapshot() != nullptr && live.status().surface_making.count > 0; });
  wait_for([&] { return live.status().surface_rests; });
  CHECK(live.status().faces == room_surface()->mesh.faces.size());
  CHECK(live.status().surface_failure.empty());
  const std::uint64_t faces = room_surface()->mesh.faces.size();
  const TriangleSoup vast{{{0, 0, 0}, {20'000, 0, 0}, {0, 20'000, 0}}, {}, {{0, 1, 2}}};
  CHECK(live.replace_piece(8, vast));
  wait_for([&] { return !live.status().surface_failure.empty(); });
  CHECK_THAT(live.status().surface_failure, Catch::Contains("too large for cells of 0.5 units"));
  for (std::size_t number = 6; number < 20; ++number) offer_room(live, number);
  CHECK(live.replace_piece(8, {}));
  wait_for([&] { return live.status().surface_failure.empty(); });
  CHECK(live.replace_piece(8, vast));  // and stays to the end
  const LiveResult model = live.finish();
  CHECK_FALSE(live.status().surface_failure.empty());
  REQUIRE(model.snapshot.surface);
  CHECK(model.snapshot.surface->mesh.faces.size() == faces);
  CHECK_NOTHROW(check(model.snapshot));
  CHECK(live.status().stored > 5);
}

TEST_CASE("a model of nothing but a piece that is too large has no surface") {
  LiveOptions options = room_live_options();
  options.surface.cell_size = 0;  // 1/16 of the distance that the photograph has, 2 units
  LiveModel live(options);
  CHECK(live.replace_piece(0, {{{-9'000, -9'000, 0}, {11'000, -9'000, 0}, {-9'000, 11'000, 0}}, {}, {{0, 1, 2}}}));
  Camera above = room_camera(0);
  above.cam_from_world_rotation = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  above.cam_from_world_translation = glm::dvec3(0, 0, 2);
  (void)live.offer("above", above, [above] { return pattern_photograph(above, 0); });
  wait_for([&] { return !live.status().surface_failure.empty(); });
  CHECK(live.snapshot() == nullptr);
  CHECK(live.finish().snapshot.surface == nullptr);
  CHECK_THAT(live.status().last_failure, Catch::Contains("too large for cells of 0.125"));
}

TEST_CASE("pieces that no view sees make a surface at the end alone") {
  LiveModel live(room_live_options());
  for (std::uint32_t octant = 0; octant < 8; ++octant) CHECK(live.replace_piece(octant, room_piece(octant)));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK(live.snapshot() == nullptr);
  const LiveResult model = live.finish();
  REQUIRE(model.snapshot.surface);
  CHECK(model.planner.coverage.ideal_distance > 1);
}

TEST_CASE("a stream that ends at any moment leaves a whole model, and one without depths none") {
  for (const std::size_t frames : {0U, 1U, 2U, 5U}) {
    CAPTURE(frames);
    LiveModel live(room_live_options());
    for (std::size_t number = 0; number < frames; ++number) {
      fuse_room(live, number);
      offer_room(live, number);
    }
    const LiveResult model = live.finish();
    CHECK((model.snapshot.surface != nullptr) == (frames > 0));
    if (model.snapshot.surface) {
      CHECK_NOTHROW(check(model.snapshot));
      CHECK(live.status().stored > 0);
    }
    CHECK(live.status().waiting == 0);
    CHECK_THROWS_AS(offer_room(live, 0), std::logic_error);
    CHECK_THROWS_AS(live.finish(), std::logic_error);
  }
  LiveModel blind(room_live_options());
  CHECK(offer_room(blind, 0).decision == LiveDecision::not_covered);
  CHECK(blind.finish().snapshot.surface == nullptr);
  LiveModel abandoned(room_live_options());  // its destructor does not work off what waits
  for (std::size_t number = 0; number < 20; ++number) {
    fuse_room(abandoned, number);
    offer_room(abandoned, number);
  }
}

TEST_CASE("live calls refuse bad arguments by name") {
  LiveOptions options = room_live_options();
  options.waiting_views = 0;
  CHECK_THROWS_WITH(LiveModel(options), Catch::Contains("waiting_views is 0"));
  options = room_live_options();
  options.surface.voxel = -1;
  CHECK_THROWS_WITH(LiveModel(options), Catch::Contains("voxel is -1"));
  LiveModel live(room_live_options());
  CHECK_THROWS_AS(live.offer("none", room_camera(0), {}), std::invalid_argument);
  CHECK_THROWS_AS(live.fuse("none", room_camera(0), {}), std::invalid_argument);
  CHECK_THROWS_AS(live.fuse("none", Camera{}, [] { return DepthImage{}; }), std::invalid_argument);
  CHECK_THROWS_AS(live.move_views({{"none", Camera{}}}), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
