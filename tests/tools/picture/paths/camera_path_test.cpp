// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of paths through key frames, and of the file that they are read from.
#include "tools/picture/paths/camera_path.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"
#include "tools/picture/paths/path_file.h"

namespace lumatlas {
namespace {

using glm::dquat;
using glm::dvec3;

double angle_between(const dquat& a, const dquat& b) {
  const dquat turn = a * glm::conjugate(b);
  return 2 * std::atan2(glm::length(dvec3(turn.x, turn.y, turn.z)), std::abs(turn.w));
}

// Ten keys at uneven times; turns up to half a circle, of either sign of the quaternion.
std::vector<KeyFrame> random_keys(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<KeyFrame> keys;
  double time = -3;
  for (int i = 0; i < 10; ++i) {
    KeyFrame key;
    key.time = time += 0.3 + 2 * std::abs(any(random));
    key.vantage.position = 5.0 * dvec3(any(random), any(random), any(random));
    key.vantage.cam_from_world = glm::normalize(dquat(any(random), any(random), any(random), any(random)));
    key.vantage.fov_deg = 60 + 40 * any(random);
    keys.push_back(key);
  }
  return keys;
}

TEST_CASE("a path goes through its key frames at their times, and stays at its ends before and after") {
  const std::vector<KeyFrame> keys = random_keys(1);
  const CameraPath path(keys);
  for (const KeyFrame& key : keys) {
    for (const double time : {key.time, key.time - 1e-9, key.time + 1e-9}) {
      const Vantage at = path.at(time);
      CHECK(glm::distance(at.position, key.vantage.position) < 1e-6);
      CHECK(angle_between(at.cam_from_world, key.vantage.cam_from_world) < 1e-6);
      CHECK(at.fov_deg == Approx(key.vantage.fov_deg).margin(1e-6));
    }
  }
  CHECK(path.at(-1e9).position == keys.front().vantage.position);
  CHECK(path.at(1e9).position == keys.back().vantage.position);
  CHECK(path.begin() == keys.front().time);
  CHECK(path.end() == keys.back().time);
}

// Per unit of time, over a step of 1e-5 from `time` on.
struct Speeds {
  dvec3 position, turn;
  double fov;
};
Speeds speeds(const CameraPath& path, double time) {
  constexpr double kStep = 1e-5;
  const Vantage a = path.at(time);
  const Vantage b = path.at(time + kStep);
  dquat turn = b.cam_from_world * glm::conjugate(a.cam_from_world);
  if (turn.w < 0) turn = -turn;
  return {(b.position - a.position) / kStep, 2.0 * dvec3(turn.x, turn.y, turn.z) / kStep,
          (b.fov_deg - a.fov_deg) / kStep};
}

TEST_CASE("position, turn and field of view pass key frames without a change of speed") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::vector<KeyFrame> keys = random_keys(seed);
    const CameraPath path(keys);
    for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
      CAPTURE(seed, i);
      const Speeds before = speeds(path, keys[i].time - 1.1e-5);
      const Speeds after = speeds(path, keys[i].time + 1e-6);
      // Speeds change by accelerations of up to some hundreds times the step.
      CHECK(glm::distance(before.position, after.position) < 0.01);
      CHECK(glm::distance(before.turn, after.turn) < 0.01);
      CHECK(before.fov == Approx(after.fov).margin(0.1));
    }
  }
}

TEST_CASE("two key frames are joined by constant speed, on the shortest turn") {
  std::vector<KeyFrame> keys(2);
  keys[0].time = 2;
  keys[1].time = 6;
  keys[1].vantage.position = {4, 0, -8};
  keys[1].vantage.cam_from_world = -glm::angleAxis(1.2, glm::normalize(dvec3(1, 2, 3)));  // the same turn as without -
  const CameraPath path(keys);
  for (const double part : {0.1, 0.25, 0.5, 0.9}) {
    const Vantage at = path.at(2 + 4 * part);
    CHECK(glm::distance(at.position, part * keys[1].vantage.position) < 1e-12);
    CHECK(angle_between(at.cam_from_world, glm::angleAxis(1.2 * part, glm::normalize(dvec3(1, 2, 3)))) < 1e-12);
    CHECK(at.fov_deg == Approx(70));
  }
}

TEST_CASE("key frames on a parabola, and turns at constant speed, are followed exactly between inner key frames") {
  std::vector<KeyFrame> keys;
  const auto parabola = [](double t) { return dvec3(1 + t, 2 * t * t - t, -0.5 * t * t); };
  for (const double time : {0.0, 1.0, 1.5, 3.0, 4.5, 5.0}) {
    KeyFrame key;
    key.time = time;
    key.vantage.position = parabola(time);
    key.vantage.cam_from_world = glm::angleAxis(0.7 * time, dvec3(0, 0.6, 0.8));
    keys.push_back(key);
  }
  const CameraPath path(keys);
  for (double time = 1; time < 4.5; time += 0.1) {
    CHECK(glm::distance(path.at(time).position, parabola(time)) < 1e-12);
    CHECK(angle_between(path.at(time).cam_from_world, glm::angleAxis(0.7 * time, dvec3(0, 0.6, 0.8))) < 1e-12);
  }
}

TEST_CASE("turned, moved and scaled key frames give the turned, moved and scaled path") {
  const std::vector<KeyFrame> keys = random_keys(5);
  std::vector<KeyFrame> other = keys;
  const dquat turn = glm::normalize(dquat(0.3, -0.8, 0.2, 0.4));
  const dvec3 shift(4, -1, 9);
  for (KeyFrame& key : other) {
    key.time = 10 + 3 * key.time;
    key.vantage.position = 2.5 * (turn * key.vantage.position) + shift;
    key.vantage.cam_from_world = key.vantage.cam_from_world * glm::conjugate(turn);
  }
  const CameraPath path(keys);
  const CameraPath moved(other);
  for (double time = path.begin(); time < path.end(); time += 0.17) {
    const Vantage a = path.at(time);
    const Vantage b = moved.at(10 + 3 * time);
    CHECK(glm::distance(2.5 * (turn * a.position) + shift, b.position) < 1e-10);
    CHECK(angle_between(a.cam_from_world * glm::conjugate(turn), b.cam_from_world) < 1e-7);
    CHECK(a.fov_deg == Approx(b.fov_deg));
  }
}

TEST_CASE("frames are spread evenly over a path, from its beginning to its end") {
  const CameraPath path(random_keys(2));
  const std::vector<Vantage> frames = path.evenly(5);
  REQUIRE(frames.size() == 5);
  CHECK(frames.front().position == path.at(path.begin()).position);
  CHECK(frames.back().position == path.at(path.end()).position);
  CHECK(glm::distance(frames[2].position, path.at((path.begin() + path.end()) / 2).position) < 1e-9);
  CHECK(path.evenly(1).front().position == frames.front().position);
  const CameraPath still({random_keys(2).front()});
  CHECK(still.evenly(3)[2].position == still.evenly(3)[0].position);
}

TEST_CASE(
    "a camera that looks at a point has it in the middle, with up upwards and the field of view that was asked for") {
  for (const dvec3& up : {dvec3(0, 0, 1), dvec3(0.3, -2, 0.1), dvec3(0)}) {
    const Vantage vantage{{1, 2, 3}, look_at({1, 2, 3}, {4, -2, 5}, up), 80};
    const Camera camera = camera_at(vantage, 400, 300);
    const glm::dvec2 middle = camera.image_from_cam(camera.cam_from_world({4, -2, 5}));
    CHECK(glm::distance(middle, glm::dvec2(200, 150)) < 1e-9);
    CHECK(camera.cam_from_world({4, -2, 5}).z > 0);
    CHECK(glm::distance(camera.center(), dvec3(1, 2, 3)) < 1e-12);
    CHECK(2 * std::atan(200 / camera.fx) == Approx(glm::radians(80.0)));
    if (glm::length(up) == 0) continue;
    const dvec3 higher = camera.cam_from_world(dvec3(4, -2, 5) + 0.01 * glm::normalize(up));
    CHECK(camera.image_from_cam(higher).y < 150);
    CHECK(camera.image_from_cam(higher).x == Approx(200).margin(1e-9));
  }
  CHECK_NOTHROW(camera_at({{}, look_at({0, 0, 0}, {0, 0, 5}, {0, 0, 1}), 60}, 9, 9));  // straight up
  CHECK_THROWS_WITH(look_at({1, 1, 1}, {1, 1, 1}, {0, 0, 1}), Catch::Contains("looks at the point where it stands"));
  CHECK_THROWS_WITH(camera_at({{}, {1, 0, 0, 0}, 180}, 9, 9), Catch::Contains("field of view is 180"));
}

TEST_CASE("key frames that make no path are refused by number") {
  std::vector<KeyFrame> keys = random_keys(3);
  CHECK_THROWS_WITH(CameraPath({}), Catch::Contains("no key frames"));
  keys[4].time = keys[3].time;
  CHECK_THROWS_WITH(CameraPath(keys), Catch::Contains("key frame 4 is at time") && Catch::Contains("must be later"));
  keys = random_keys(3);
  keys[2].vantage.position.y = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(CameraPath(keys), "path: key frame 2 has a position that is not finite");
  keys = random_keys(3);
  keys[7].vantage.cam_from_world *= 1.1;
  CHECK_THROWS_WITH(CameraPath(keys), "path: key frame 7 has a turn that is no unit quaternion");
  keys = random_keys(3);
  keys[0].vantage.fov_deg = 0;
  CHECK_THROWS_WITH(CameraPath(keys), Catch::Contains("key frame 0 has a field of view of 0"));
}

TEST_CASE("key frames are read with what each says, less the offset, and the defaults for the rest") {
  const TemporaryFolder folder;
  const auto file = folder.with_file("path.json", R"({"keys": [
    {"position": [101, 200, 300], "look_at": [101, 205, 300]},
    {"time": 2.5, "position": [104, 200, 300], "rotation": [0, 1, 0, 0], "fov": 35},
    {"time": 7, "position": [104, 200, 301], "look_at": [0, 0, 0], "up": [1, 0, 0]}]})");
  PathDefaults defaults;
  defaults.offset = {100, 200, 300};
  defaults.fov_deg = 55;
  const std::vector<KeyFrame> keys = read_path(file, defaults);
  REQUIRE(keys.size() == 3);
  CHECK(keys[0].time == 0);
  CHECK(keys[1].time == 2.5);
  CHECK(keys[0].vantage.position == dvec3(1, 0, 0));
  CHECK(angle_between(keys[0].vantage.cam_from_world, look_at({1, 0, 0}, {1, 5, 0}, {0, 0, 1})) < 1e-12);
  CHECK(keys[0].vantage.fov_deg == 55);
  CHECK(angle_between(keys[1].vantage.cam_from_world, dquat(0, 1, 0, 0)) < 1e-12);
  CHECK(keys[1].vantage.fov_deg == 35);
  CHECK(angle_between(keys[2].vantage.cam_from_world, look_at({4, 0, 1}, {-100, -200, -300}, {1, 0, 0})) < 1e-12);
}

TEST_CASE("a path file with something wrong gets one sentence that names it") {
  const TemporaryFolder folder;
  const auto sentence = [&](const std::string& text) -> std::string {
    const auto file = folder.with_file("path.json", text);
    try {
      (void)read_path(file, {});
    } catch (const InputError& error) {
      const std::string said = error.what();
      CHECK(said.find('\n') == std::string::npos);
      REQUIRE(said.starts_with(file.string() + ": "));
      return said.substr(file.string().size() + 2);
    }
    return "accepted";
  };
  const auto key = [&](const std::string& fields) { return sentence("{\"keys\": [{" + fields + "}]}"); };
  const std::string at = "\"position\": [0, 0, 0], ";
  CHECK(key(at + "\"look_at\": [0, 1, 0]") == "accepted");
  CHECK(sentence("") == "is empty");
  CHECK_THAT(sentence("keys"), Catch::StartsWith("is not JSON: parse error at line 1"));
  CHECK_THAT(sentence("{\"keys\": [1e999]}"), Catch::StartsWith("is not JSON: "));
  for (const char* const none : {"[]", "{}", "{\"keys\": []}", "{\"keys\": 3}"}) {
    CHECK(sentence(none) == "must be an object with \"keys\", an array of at least one key frame");
  }
  CHECK(sentence(R"({"keys": [5]})") == "key frame 0 must be an object with a \"position\"");
  CHECK(sentence(R"({"keys": [{"position": [0,0,0], "look_at": [1,0,0]}], "loop": 1})") ==
        "it has the unknown field \"loop\"");
  CHECK(key(at + "\"look_at\": [0, 1, 0], \"fow\": 3") == "key frame 0 has the unknown field \"fow\"");
  CHECK(key("\"look_at\": [0, 1, 0]") == "key frame 0 must be an object with a \"position\"");
  CHECK(key("\"position\": [0, 0], \"look_at\": [0, 1, 0]") ==
        "key frame 0: \"position\" must be an array of 3 numbers, at most 1e12");
  CHECK(key("\"position\": [0, 0, 1e13], \"look_at\": [0, 1, 0]") ==
        "key frame 0: \"position\" must be an array of 3 numbers, at most 1e12");
  CHECK(key(at + "\"time\": \"now\", \"look_at\": [0, 1, 0]") ==
        "key frame 0: \"time\" must be a number, at most 1e12");
  CHECK(key(at + "\"fov\": 0") == "key frame 0 must have either \"look_at\" or \"rotation\"");
  CHECK(key(at + "\"look_at\": [0, 1, 0], \"rotation\": [1, 0, 0, 0]") ==
        "key frame 0 must have either \"look_at\" or \"rotation\"");
  CHECK(key(at + "\"look_at\": [0, 0, 0]") == "key frame 0: \"look_at\" must differ from \"position\"");
  CHECK(key(at + "\"look_at\": [0, 1, 0], \"up\": [0, 0, 0]") == "key frame 0: \"up\" must not be zero");
  CHECK(key(at + "\"rotation\": [1, 0, 0, 0], \"up\": [0, 0, 1]") ==
        "key frame 0 has \"up\", which goes with \"look_at\" alone");
  CHECK(key(at + "\"rotation\": [1, 1, 0, 0]") == "key frame 0: \"rotation\" must be a unit quaternion, w x y z");
  CHECK(key(at + "\"look_at\": [0, 1, 0], \"fov\": 180") == "key frame 0: \"fov\" must be in [0.01, 179] degrees");
  const std::string good = "{" + at + "\"look_at\": [0, 1, 0], \"time\": 5}";
  CHECK(sentence("{\"keys\": [" + good + ", " + good + "]}") == "key frame 1 must be later than the one before it");
  CHECK_THROWS_WITH(read_path(folder / "none.json", {}), Catch::Contains("none.json"));
}

}  // namespace
}  // namespace lumatlas
