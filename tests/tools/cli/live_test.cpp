// SPDX-License-Identifier: GPL-3.0-or-later
// `lumatlas live`, from a synthetic stream to a saved model.
#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/tools/cli/program.h"
#include "tests/tools/cli/run_program.h"
#include "tests/tools/live/playback/stream_client.h"

namespace lumatlas {
namespace {

// A walk of 48 frames through the laboratory, 8 a second.
struct Streamed {
  TemporaryFolder folder;
  std::string scene = (folder / "scene").string();
  std::string stream = (folder / "scene" / "stream").string();
  Outcome synth = lumatlas({"synth", "lab", "-o", scene, "--photographs", "48", "--width", "96", "--height", "72",
                            "--fov", "65", "--samples", "2", "--triangles", "3000", "--stream", "8", "--quiet"});
};

const Streamed& streamed() {
  static const Streamed stream;
  REQUIRE(stream.synth.status == 0);
  return stream;
}

nlohmann::json scores_of(const std::string& model) {
  const Outcome validate = lumatlas({"validate", model, "--views", streamed().stream, "--json", "--quiet"});
  REQUIRE(validate.status == 0);
  return nlohmann::json::parse(validate.out)["methods"]["store"];
}

TEST_CASE("a model of a stream shows held-out photographs as well as one built from the same frames at rest") {
  const TemporaryFolder folder;
  const std::string live = (folder / "live").string(), shown = (folder / "shown").string();
  const std::string built = (folder / "built").string();
  const std::string mesh = (folder / "mesh.ply").string();
  const Outcome played = lumatlas({"live", streamed().stream, "-o", live, "--hold", "8", "--speed", "2", "--voxel",
                                   "0.06", "--joint", "--json", "--quiet"});
  REQUIRE(played.status == 0);
  const nlohmann::json totals = nlohmann::json::parse(played.out);
  CHECK(totals["views"]["offered"] == 42);
  CHECK(totals["views"]["stored"] > 20);
  CHECK(totals["live"]["depths"]["given"] == 48);
  CHECK(totals["live"]["offer_ms"]["median"] > 0);
  CHECK(totals["live"]["finish"]["done"] == true);
  const Outcome unfinished = lumatlas({"live", streamed().stream, "-o", shown, "--hold", "8", "--speed", "2", "--voxel",
                                       "0.06", "--joint", "--no-finish", "--json", "--quiet"});
  REQUIRE(unfinished.status == 0);
  CHECK(nlohmann::json::parse(unfinished.out)["live"]["finish"]["done"] == false);
  REQUIRE(lumatlas({"mesh", streamed().stream, "--from", "depth", "-o", mesh, "--quiet"}).status == 0);
  REQUIRE(
      lumatlas({"build", streamed().stream, "--mesh", mesh, "--mesh-as-given", "--hold", "8", "-o", built, "--quiet"})
          .status == 0);
  const auto of_frames = [](const std::string& model) {
    return scores_of(model)["frame"]["raw"]["psnr"].get<double>();
  };
  const double of_live = of_frames(live), of_shown = of_frames(shown), of_built = of_frames(built);
  WARN("frames of the model while live " << of_shown << " dB, of the finished one " << of_live
                                         << " dB, of the one built at rest " << of_built << " dB");
  CHECK(of_live > of_built - 0.5);
  CHECK(of_shown > of_built - 2.5);  // which frames are fused and stored depends on the time that the machine has
}

TEST_CASE("Ctrl-C ends a stream, and what came until then is saved as a whole model") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  const Run run({"live", streamed().stream, "-o", model, "--speed", "0.2", "--voxel", "0.06"});
  const auto some_are_stored = [&] {
    const std::string said = run.err();
    const std::size_t line = said.rfind(" are in the model");
    return line != std::string::npos && said[line - 1] != '0';
  };
  Run::wait_until([&] { return some_are_stored() || run.has_ended(); });
  run.send(SIGINT);
  const Outcome outcome = run.wait();
  CAPTURE(outcome.err);
  CHECK(outcome.status == 0);
  const Outcome inspect = lumatlas({"inspect", model, "--json", "--quiet"});
  REQUIRE(inspect.status == 0);
  const nlohmann::json saved = nlohmann::json::parse(inspect.out);
  CHECK(saved["views"]["count"] > 0);
  CHECK(saved["views"]["count"] < 40);
  CHECK(saved["mesh"]["faces"] > 100);
}

TEST_CASE("Ctrl-C while the model is made anew saves it as the stream left it, at each stage") {
  // What the program says when it begins to fuse, and when it has begun to store photographs.
  for (const char* stage : {"finishing: ", "storing views: "}) {
    CAPTURE(stage);
    const TemporaryFolder folder;
    const std::string model = (folder / "model").string();
    const Run run({"live", streamed().stream, "-o", model, "--speed", "4", "--voxel", "0.06"});
    Run::wait_until([&] { return run.err().find(stage) != std::string::npos || run.has_ended(); });
    run.send(SIGINT);
    const Outcome outcome = run.wait();
    CAPTURE(outcome.err);
    CHECK(outcome.status == 0);
    CHECK_THAT(outcome.err, Catch::Contains("saved as the stream left it: it was asked to stop"));
    const Outcome inspect = lumatlas({"inspect", model, "--json", "--quiet"});
    REQUIRE(inspect.status == 0);
    CHECK(nlohmann::json::parse(inspect.out)["views"]["count"] > 0);
    CHECK(names_in(folder.path()) == std::vector<std::string>{"model"});
  }
}

TEST_CASE("a second Ctrl-C stops the end of a stream that the first one asked for") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  const Run run({"live", streamed().stream, "-o", model, "--speed", "0.5", "--voxel", "0.06"});
  const auto said = [&](const char* text) { return run.err().find(text) != std::string::npos || run.has_ended(); };
  Run::wait_until([&] { return said("4 are in the model"); });
  run.send(SIGINT);
  Run::wait_until([&] { return said("finishing: "); });
  run.send(SIGINT);
  const Outcome outcome = run.wait();
  CAPTURE(outcome.err);
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.err, Catch::Contains("it was asked to stop"));
  CHECK(lumatlas({"inspect", model, "--json", "--quiet"}).status == 0);
}

TEST_CASE("live refuses what is no stream with depths, and options that cannot be") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string();
  check_failure(lumatlas({"live", made().scene, "-o", model, "--quiet"}), "has no depth images");
  CHECK(names_in(folder.path()).empty());
  const Outcome slow = lumatlas({"live", streamed().stream, "-o", model, "--speed", "0"});
  CHECK(slow.status == 2);
  CHECK_THAT(slow.err, Catch::Contains("--speed: 0, must be finite and above 0"));
}

// Runs it with a file for its standard input.
Outcome lumatlas_reading(const std::string& file, const Arguments& arguments) {
  return lumatlas(arguments, [&] { dup2(open(file.c_str(), O_RDONLY | O_CLOEXEC), STDIN_FILENO); });
}

TEST_CASE("a stream on standard input becomes a model, and one without a frame is refused") {
  const TemporaryFolder folder;
  const std::string model = (folder / "model").string(), file = (folder / "stream").string();
  StreamBytes bytes = room_opening();
  for (std::size_t number = 0; number < 6; ++number) append(bytes, room_frame(number));
  bytes.resize(bytes.size() - 10);  // it is cut off
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  const Outcome made = lumatlas_reading(file, {"live", "-", "-o", model, "--no-finish", "--json", "--quiet"});
  REQUIRE(made.status == 0);
  CHECK_THAT(made.err, Catch::Contains("warning: the input ends in the middle of a message"));
  CHECK(nlohmann::json::parse(made.out)["live"]["frames"] == 5);
  CHECK(lumatlas({"inspect", model, "--json", "--quiet"}).status == 0);

  std::ofstream(file) << "no stream at all, but some words that are long enough";
  const std::string other = (folder / "other").string();
  const Outcome none = lumatlas_reading(file, {"live", "-", "-o", other, "--quiet"});
  CHECK(none.status == 1);
  CHECK_THAT(none.err, Catch::Contains("warning: the input's greeting is not LUMLIVE1"));
  CHECK_THAT(none.err, Catch::Contains("no frame arrived, so no model was saved"));
  CHECK_FALSE(std::filesystem::exists(other));
  check_failure(lumatlas({"live", "-", "-o", other, "--quiet"}), "no frame arrived");
  const Outcome held = lumatlas_reading(file, {"live", "-", "-o", other, "--hold", "8"});
  CHECK(held.status == 2);
  CHECK_THAT(held.err, Catch::Contains("--hold"));
}

}  // namespace
}  // namespace lumatlas
