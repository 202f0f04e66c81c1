// SPDX-License-Identifier: GPL-3.0-or-later
// The program where files are not what it expects: outputs that hold other people's work, disks that take no more,
// streams that are closed, signals, JSON and pipes that somebody prepared. Each run ends in exit 0, 1 with one true
// sentence, or death by the signal that was sent; what was there before is untouched or replaced whole.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/tools/cli/run_program.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// The scene of all tests here, and a model of it built with --hold 4; made once.
struct Made {
  TemporaryFolder folder;
  std::string scene = (folder / "scene").string();
  std::string model = (folder / "model").string();
  Outcome synth = lumatlas({"synth", "apartment", "-o", scene, "--photographs", "8", "--width", "64", "--height", "48",
                            "--samples", "2", "--triangles", "3000", "--quiet"});
  Outcome build = lumatlas({"build", scene, kLargeCells, "-o", model, "--hold", "4", "--refine", "none", "--quiet"});
};
const Made& made() {
  static const Made once;
  REQUIRE(once.build.status == 0);
  return once;
}

Arguments depth_pictures(const std::string& out, const std::string& frames = "3", const std::string& size = "200") {
  return {"render", made().model, "--orbit", "--frames", frames,    "--width",       size, "--height", size,
          "--mode", "depth",      "-o",      out,        "--quiet", "--no-color-bar"};
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

bool holds_temporary(const fs::path& folder) {
  const std::vector<std::string> names = names_in(folder);
  return std::any_of(names.begin(), names.end(),
                     [](const std::string& name) { return name.starts_with(".lumatlas-"); });
}

void copy_of_model(const fs::path& target) {
  fs::copy(made().model, target, fs::copy_options::recursive);
}

TEST_CASE("pictures, models and scenes that a disk does not take to the end are told and not left behind") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  // With its signal as it is by default, which kills, and ignored.
  const bool is_ignored = GENERATE(false, true);
  const auto few_bytes = [is_ignored] {
    const rlimit limit{2000, 2000};
    setrlimit(RLIMIT_FSIZE, &limit);
    signal(SIGXFSZ, is_ignored ? SIG_IGN : SIG_DFL);
  };
  const std::vector<Arguments> runs{
      depth_pictures(out),
      {"render", made().model, "--orbit", "--frames", "1", "--mode", "depth", "--format", "exr", "-o", out, "--quiet"},
      {"synth", "apartment", "-o", out, "--photographs", "2", "--width", "64", "--height", "48", "--samples", "1",
       "--triangles", "3000", "--quiet"},
      {"build", made().scene, kLargeCells, "-o", out, "--refine", "none", "--quiet"},
      {"build", made().scene, kLargeCells, "-o", out + ".glb", "--refine", "none", "--quiet"},
      {"export", made().model, "--to", "obj", "--texture", "512", "-o", out, "--quiet"},
      {"export", made().model, "--to", "web", "-o", out, "--quiet"},
      {"export", made().model, "--to", "web", "-o", out + ".html", "--quiet"},
  };
  for (const Arguments& arguments : runs) {
    CAPTURE(arguments);
    const Outcome outcome = lumatlas(arguments, few_bytes);
    INFO(outcome.err);
    CHECK(outcome.status == 1);
    CHECK(outcome.out.empty());
    std::string said = outcome.err;
    while (said.starts_with("warning: ")) said.erase(0, said.find('\n') + 1);  // of the scene
    CHECK_THAT(said, Catch::StartsWith("lumatlas: ") && Catch::Contains(out) && !Catch::Contains(".lumatlas-"));
    if (arguments.front() == "export") CHECK_THAT(said, Catch::Contains("the limit of file size"));
    CHECK(names_in(folder.path()).empty());
  }
}

TEST_CASE("progress is not written into an output where a stream is closed") {
  for (const int stream : {0, 1, 2}) {
    CAPTURE(stream);
    const TemporaryFolder folder;
    const std::string out = (folder / "out.glb").string();
    const Outcome outcome = lumatlas({"build", made().scene, kLargeCells, "-o", out, "--refine", "none", "--verbose"},
                                     [&] { close(stream); });
    CHECK(outcome.status == (stream == 1 ? 1 : 0));  // the summary could not be told
    CHECK(lumatlas({"inspect", out}).status == 0);
    CHECK(bytes_of(out).starts_with("glTF"));
  }
}

TEST_CASE("whichever streams are closed, a run ends as it should and its output is whole") {
  const auto run_without = [](const Arguments& arguments, int closed) {
    return lumatlas(arguments, [closed] {
      for (const int stream : {0, 1, 2}) {
        if ((closed & 1 << stream) != 0) close(stream);
      }
    });
  };
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const Arguments validate{"validate",       made().model, "--views", made().scene,  "--no-pictures",
                           "--no-alignment", "-o",         out,       "--baselines", "none"};
  const bool opengl = lumatlas(validate).status == 0;  // validate needs it
  std::vector<std::pair<Arguments, const char*>> runs{
      {{"build", made().scene, kLargeCells, "-o", out, "--refine", "none"}, "tileset.json"},
      {depth_pictures(out, "1"), "00000.png"},
  };
  if (opengl) runs.emplace_back(validate, "index.html");
  for (const auto& [arguments, file] : runs) {
    for (int closed = 0; closed < 8; ++closed) {
      CAPTURE(arguments.front(), closed);
      fs::remove_all(out);
      const bool can_tell = (closed & 2) == 0;
      CHECK(run_without(arguments, closed).status == (can_tell ? 0 : 1));
      CHECK(fs::exists(fs::path(out) / file));  // its result could not be told, yet it is complete
      CHECK(fs::exists(fs::path(out) / "lumatlas.json"));
      CHECK_FALSE(holds_temporary(folder.path()));
    }
  }
}

TEST_CASE("whichever streams are closed, a model is served until Ctrl-C, or refused if its address cannot be printed") {
  for (int closed = 0; closed < 8; ++closed) {
    CAPTURE(closed);
    const Run run({"view", made().model, "--no-browser"}, [closed] {
      for (const int stream : {0, 1, 2}) {
        if ((closed & 1 << stream) != 0) close(stream);
      }
    });
    const bool can_tell = (closed & 2) == 0;
    if (can_tell) Run::wait_until([&] { return run.out().find("http://") != std::string::npos; });
    if (!can_tell) Run::wait_until([&] { return run.has_ended(); });
    run.send(SIGINT);
    CHECK(run.wait().status == (can_tell ? -SIGINT : 1));
  }
}

TEST_CASE("where standard output takes no result, the output that is complete stays and the sentence says so") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const std::vector<Arguments> runs{
      {"build", made().scene, kLargeCells, "-o", out, "--refine", "none", "--quiet"},
      {"build", made().scene, kLargeCells, "-o", out, "--refine", "none", "--quiet", "--json"},
      {"build", made().scene, kLargeCells, "-o", out + ".glb", "--refine", "none", "--quiet", "--json"},
      depth_pictures(out, "1"),
      {"mesh", made().scene, "-o", out + ".ply", "--from", "points", "--quiet"},
      {"export", made().model, "-o", out + "-page", "--to", "web", "--quiet", "--json"},
      {"synth", "apartment", "-o", out, "--photographs", "2", "--width", "64", "--height", "48", "--samples", "1",
       "--triangles", "3000", "--quiet", "--json"},
  };
  for (const Arguments& arguments : runs) {
    CAPTURE(arguments);
    const std::string output = *(std::find(arguments.begin(), arguments.end(), "-o") + 1);
    const Outcome outcome = lumatlas(arguments, [] {
      const int full = open("/dev/full", O_WRONLY);
      dup2(full, STDOUT_FILENO);
    });
    INFO(outcome.err);
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.err, Catch::EndsWith(output + ": is complete, but the result cannot be written to standard "
                                                     "output, is the disk full?\n"));
    CHECK(fs::exists(output));
    fs::remove_all(output);
    CHECK(names_in(folder.path()).empty());
  }
}

TEST_CASE("paths that lead in a circle are named, with the system's reason") {
  const TemporaryFolder folder;
  const fs::path loop = folder / "loop";
  fs::create_symlink(loop, loop);
  const std::string below = (loop / "below").string();
  const std::vector<Arguments> runs{
      {"validate", below, "--views", made().scene, "--quiet"},
      {"inspect", below, "--quiet"},
      {"render", below, "--orbit", "-o", (folder / "out").string(), "--quiet"},
      {"export", below, "-o", (folder / "out.glb").string(), "--quiet"},
      {"build", made().scene, "-o", below, "--quiet"},
      {"build", below, "-o", (folder / "out").string(), "--quiet"},
      {"build", made().scene, "--mesh", below, "-o", (folder / "out").string(), "--quiet"},
      {"capture", made().scene + "/images", "-o", below, "--quiet"},
      {"capture", made().scene + "/images", "-o", (folder / "out").string(), "--work", below, "--quiet"},
      {"capture", below, "-o", (folder / "out").string(), "--quiet"},
      {"mesh", below, "-o", (folder / "out.ply").string(), "--quiet"},
  };
  for (const Arguments& arguments : runs) {
    CAPTURE(arguments);
    const Outcome outcome = lumatlas(arguments);
    check_failure(outcome, loop.string());
    CHECK_THAT(outcome.err, !Catch::Contains("filesystem error"));
  }
}

TEST_CASE("an output never takes the place of what another command or a person wrote") {
  const TemporaryFolder folder;
  const fs::path model = folder / "model", file = folder / "x.glb";
  copy_of_model(model);
  (void)folder.with_file("x.glb", "precious");
  check_failure(lumatlas({"build", made().scene, "-o", file.string(), "--quiet"}),
                file.string() + ": is no model that `lumatlas build` wrote and will not be replaced");
  CHECK(bytes_of(file) == "precious");
  check_failure(lumatlas({"synth", "apartment", "-o", model.string(), "--quiet"}),
                "is an output of `lumatlas build` and will not be replaced by one of `lumatlas synth`");
  check_failure(lumatlas({"build", made().scene, "-o", made().scene, "--quiet"}), made().scene);
  check_failure(lumatlas(depth_pictures(model.string())), model.string());
  (void)folder.with_file("model/notes.txt", "precious");
  check_failure(lumatlas({"build", made().scene, "-o", model.string(), "--quiet"}),
                "because lumatlas did not write notes.txt in it");
  CHECK(bytes_of(model / "notes.txt") == "precious");
  CHECK(lumatlas({"inspect", model.string()}).status == 0);
  fs::remove(model / "notes.txt");
  CHECK(lumatlas({"build", made().scene, kLargeCells, "-o", model.string(), "--refine", "none", "--quiet"}).status ==
        0);
}

TEST_CASE("charts do not replace a page that a person wrote") {
  const TemporaryFolder folder;
  const fs::path page = folder.with_file("index.html", "precious");
  const fs::path sweep = fs::path(LUMATLAS_DATA) / "sweeps" / "cell-size.json";
  check_failure(lumatlas({"chart", sweep.string(), "-o", folder.path().string(), "--scale", "small", "--quiet"}),
                page.string() + ": was not written by `lumatlas chart` and will not be replaced");
  CHECK(bytes_of(page) == "precious");
  CHECK(names_in(folder.path()) == std::vector<std::string>{"index.html"});
}

TEST_CASE("a .glb that lumatlas wrote is replaced") {
  const TemporaryFolder folder;
  const Arguments build{"build",    made().scene, kLargeCells, "-o", (folder / "x.glb").string(),
                        "--refine", "none",       "--quiet"};
  REQUIRE(lumatlas(build).status == 0);
  const std::string first = bytes_of(folder / "x.glb");
  REQUIRE(lumatlas(build).status == 0);
  CHECK(bytes_of(folder / "x.glb").size() == Approx(static_cast<double>(first.size())).epsilon(0.01));
  CHECK(names_in(folder.path()) == std::vector<std::string>{"x.glb"});
}

TEST_CASE("what a killed program leaves behind is removed by the next one, which leaves a living one's alone") {
  const TemporaryFolder folder;
  const Arguments endless{"synth", "apartment", "-o", (folder / "a").string(), "--photographs", "5000", "--quiet"};
  const Run killed(endless);
  Run::wait_until([&] { return holds_temporary(folder.path()); });
  killed.send(SIGKILL);
  CHECK(killed.wait().status == -SIGKILL);
  const std::vector<std::string> leftover = names_in(folder.path());
  CHECK(holds_temporary(folder.path()));
  const Run living(endless);
  Run::wait_until([&] { return names_in(folder.path()).size() == 1 && names_in(folder.path()) != leftover; });
  REQUIRE(lumatlas(depth_pictures((folder / "b").string())).status == 0);
  CHECK(names_in(folder.path()).size() == 2);
  CHECK(holds_temporary(folder.path()));
  living.send(SIGTERM);
  CHECK(living.wait().status == -SIGTERM);
  CHECK(names_in(folder.path()) == std::vector<std::string>{"b"});
}

TEST_CASE("a terminal that goes, a reader that goes, and Ctrl-C in the middle of a large frame leave nothing, soon") {
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const std::vector<Arguments> runs{
      {"synth", "apartment", "-o", out, "--photographs", "1", "--width", "8192", "--height", "8192", "--samples", "64",
       "--quiet"},
      depth_pictures(out, "2", "32768"),
  };
  for (const Arguments& arguments : runs) {
    for (const int signal : {SIGINT, SIGHUP, SIGPIPE}) {
      CAPTURE(arguments.front(), signal);
      const Run run(arguments);
      Run::wait_until([&] { return holds_temporary(folder.path()); });
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      run.send(signal);
      const auto sent = std::chrono::steady_clock::now();
      CHECK(run.wait().status == -signal);
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - sent;
      CHECK(taken.count() < 5);  // at most one on a machine with nothing else to do
      CHECK(names_in(folder.path()).empty());
    }
  }
}

TEST_CASE("results without a reader end the program as its shell expects") {
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  close(ends[0]);
  const Outcome outcome = lumatlas({"inspect", made().model}, [&] { dup2(ends[1], STDOUT_FILENO); });
  close(ends[1]);
  CHECK(outcome.status == -SIGPIPE);
  CHECK(outcome.err.empty());
}

TEST_CASE("limits that are too low are told by name, instead of a crash or a wrong reason") {
  const auto limited = [](int resource, rlim_t bytes) {
    return [resource, bytes] {
      const rlimit limit{bytes, bytes};
      setrlimit(resource, &limit);
    };
  };
  const TemporaryFolder folder;
  const std::string out = (folder / "out").string();
  const std::vector<Arguments> runs{
      {"inspect", made().scene, "--quiet"},
      {"build", made().scene, "-o", out, "--quiet"},
      depth_pictures(out),
      {"validate", made().model, "--views", made().scene, "-o", out, "--quiet"},
      {"synth", "apartment", "-o", out, "--photographs", "2", "--quiet"},
  };
  for (const Arguments& arguments : runs) {
    CAPTURE(arguments.front());
    const bool only_reads = arguments.front() == "inspect";
    for (const rlim_t megabytes : {600, 800, 1000, 1500}) {
      if (only_reads && megabytes > 1024) continue;
      check_failure(lumatlas(arguments, limited(RLIMIT_AS, megabytes << 20)),
                    "the limit of memory is " + std::to_string(megabytes << 10) + " KiB, lumatlas needs at least");
    }
    check_failure(lumatlas(arguments, limited(RLIMIT_STACK, 64 << 10)), "the limit of the stack is 64 KiB");
    CHECK(names_in(folder.path()).empty());
  }
  CHECK(lumatlas(runs[0], limited(RLIMIT_AS, rlim_t{1} << 30)).status == 0);
  CHECK(lumatlas({"inspect", made().model}, limited(RLIMIT_AS, rlim_t{1} << 30)).status == 0);
  CHECK(lumatlas(runs[1], limited(RLIMIT_STACK, 1 << 20)).status == 0);
}

TEST_CASE("a machine without a library of OpenGL is told which one to install") {
  const TemporaryFolder folder;
  const auto without = [](const char* library) {
    return [library] {
      setenv("LD_PRELOAD", LUMATLAS_HIDDEN_LIBRARY, 1);
      setenv("LUMATLAS_TEST_HIDES", library, 1);
    };
  };
  const Arguments render{"render", made().model, "--views", made().scene, "-o", (folder / "out").string(), "--quiet"};
  check_failure(lumatlas(render, without("libEGL.so.1")), "libEGL.so.1 cannot be loaded");
  check_failure(lumatlas(render, without("libOpenGL.so.0 libGL.so.1")),
                "neither libOpenGL.so.0 nor libGL.so.1 can be loaded");
  CHECK(names_in(folder.path()).empty());

  const Outcome built = lumatlas({"build", made().scene, kLargeCells, "-o", (folder / "model").string(), "--budget",
                                  "auto", "--loss", "3", "--refine", "none", "--json", "--quiet"},
                                 without("libEGL.so.1"));
  REQUIRE(built.status == 0);
  CHECK_THAT(built.err, Catch::Contains("its loss cannot be measured: no OpenGL: libEGL.so.1 cannot be loaded"));
  const nlohmann::json summary = nlohmann::json::parse(built.out);
  CHECK(summary["parsimony"]["measured_loss_db"].is_null());
  CHECK(summary["parsimony"]["predicted_loss_db"] <= 3);
  CHECK_FALSE(summary["parsimony"]["taken_away"].empty());
  CHECK(summary["texels"]["scale"] == 1);

  const Arguments build{"build",       made().scene,
                        "-o",          (folder / "fitted").string(),
                        "--refine",    "none",
                        "--json",      "--quiet",
                        "--set",       "tiles.texels=rgb8",
                        "--set",       "tiles.tile=8",
                        "--cell-size", "2",
                        "--faces",     "keep"};
  const nlohmann::json whole = nlohmann::json::parse(lumatlas(build).out)["gpu"];
  const auto colors = whole["colors"].get<std::uint64_t>();
  const std::uint64_t budget = whole["sum"].get<std::uint64_t>() - colors * 2 / 3;
  Arguments bounded = build;
  bounded.insert(bounded.end(), {"--budget", std::to_string(budget)});
  const Outcome fitted = lumatlas(bounded, without("libEGL.so.1"));
  CAPTURE(budget, fitted.err);
  REQUIRE(fitted.status == 0);
  CHECK_THAT(fitted.err, Catch::Contains("photographs are downscaled until all fit") &&
                             Catch::Contains("libEGL.so.1 cannot be loaded"));
  const nlohmann::json told = nlohmann::json::parse(fitted.out);
  CHECK(told["gpu"]["sum"] <= budget);
  CHECK(told["texels"]["scale"] < 1);
  CHECK(told["texels"]["loss_db"].is_null());
}

TEST_CASE("a limit of processes is told by name") {
  // Root has no such limit: the program runs as a user who owns nothing else, if the test may become one.
  constexpr uid_t kUser = 54321;
  if (geteuid() != 0) {
    WARN("skipped: only root can become a user without processes");
    return;
  }
  const fs::path outside = fs::path(LUMATLAS_PROGRAM);
  for (const rlim_t processes : {1, 2, 4}) {
    CAPTURE(processes);
    const Outcome outcome = lumatlas({"inspect", "/"}, [&] {
      const rlimit limit{processes, processes};
      setrlimit(RLIMIT_NPROC, &limit);
      if (setuid(kUser) != 0 || access(outside.c_str(), X_OK) != 0) _exit(42);
    });
    if (outcome.status == 42) {
      WARN("skipped: another user cannot start the program");
      return;
    }
    check_failure(outcome, "threads can be started, lumatlas needs");
  }
}

std::string deep(std::size_t levels) {
  return std::string(levels, '[') + std::string(levels, ']');
}

TEST_CASE("JSON that is too deep, a pipe in its place, and plans of another shape are refused by name") {
  const TemporaryFolder folder;
  const fs::path model = folder / "model", plan = model / "plan.json";
  copy_of_model(model);
  const auto inspect = [&](const std::string& text) {
    std::ofstream(plan, std::ios::binary) << text;
    return lumatlas({"inspect", model.string()});
  };
  check_failure(inspect("{\"summary\":" + deep(100000) + "}"), plan.string() + ": has arrays or objects more than 100");
  check_failure(inspect(deep(100000)), plan.string() + ": has arrays or objects more than 100 deep");
  check_failure(inspect("{\"summary\":[]}"), model.string() + ": its plan");
  check_failure(inspect("{\"summary\":{\"parsimony\":{\"bound_db\":1}}}"), model.string() + ": its plan");
  check_failure(inspect("[]"), plan.string() + ": must be a JSON object");
  check_failure(inspect("{\"summary\""), plan.string() + ": is not JSON");
  CHECK(inspect("{}").status == 0);
  fs::remove(plan);
  CHECK(lumatlas({"inspect", model.string()}).status == 0);
  REQUIRE(mkfifo(plan.c_str(), 0600) == 0);
  check_failure(lumatlas({"inspect", model.string()}), plan.string() + ": is not a file");

  const std::string out = (folder / "out").string();
  const fs::path pipe = folder / "pipe.json", deep_file = folder.with_file("deep.json", deep(100000));
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  for (const auto& [file, reason] : {std::pair<fs::path, std::string>{pipe, ": is not a file"},
                                     {deep_file, ": has arrays or objects more than 100 deep"}}) {
    check_failure(lumatlas({"render", made().model, "--path", file.string(), "-o", out, "--quiet"}),
                  file.string() + reason);
    check_failure(lumatlas({"chart", file.string(), "-o", out, "--quiet"}), file.string() + reason);
    CHECK_FALSE(fs::exists(out));
  }
}

TEST_CASE("files of a scene that are pipes are refused, and not waited for") {
  for (const std::string name : {"sparse/cameras.bin", "sparse/images.bin", "mesh.ply", "images/0003.png"}) {
    CAPTURE(name);
    const TemporaryFolder folder;
    const fs::path scene = folder / "scene";
    fs::copy(made().scene, scene, fs::copy_options::recursive);
    fs::remove(scene / name);
    REQUIRE(mkfifo((scene / name).c_str(), 0600) == 0);
    const Outcome outcome = lumatlas({"build", scene.string(), "-o", (folder / "out").string(), "--quiet"});
    check_failure(outcome, name == "mesh.ply" ? "no mesh in it" : (scene / name).string() + ": is not a file");
  }
}

TEST_CASE("a folder that cannot be looked into is not called missing") {
  const TemporaryFolder folder;
  const fs::path scene = folder / "scene";
  for (const std::string name : {"images", "sparse", "images/0003.png"}) {
    CAPTURE(name);
    fs::remove_all(scene);
    fs::copy(made().scene, scene, fs::copy_options::recursive);
    fs::remove_all(scene / name);
    fs::create_symlink(fs::path(name).filename(), scene / name);  // a link to itself, which root cannot follow either
    const Outcome outcome = lumatlas({"build", scene.string(), "-o", (folder / "out").string(), "--quiet"});
    check_failure(outcome, "cannot be accessed (Too many levels of symbolic links)");
    CHECK_THAT(outcome.err, Catch::Contains((scene / name).string()));
  }
}

}  // namespace
}  // namespace lumatlas
