// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/runner.h"

#include <fcntl.h>
#include <fnmatch.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/progress.h"
#include "tools/base/strict_json.h"
#include "tools/lab/sweep/scene_facts.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kMesh = "mesh.ply";  // of a point that makes one

// Only one runner at a time may write into a folder: two would remove each other's unfinished points.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw InputError(folder.string() + ": cannot be made: " + error.message());
    const fs::path file = folder / ".lock";
    if (!fs::exists(file) && !fs::is_empty(folder, error)) {
      throw InputError(folder.string() +
                       ": is neither empty nor an earlier output of `lumatlas chart`, name another folder");
    }
    file_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0) throw InputError(file.string() + ": cannot be made: " + std::strerror(errno));
    if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    close(file_);
    throw InputError(folder.string() +
                     ": another `lumatlas chart` is at work here, wait for it or name another folder");
  }
  ~FolderLock() { close(file_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

// Null if there is no such file, or none that is JSON.
json json_in(const fs::path& path) {
  try {
    return read_json(path);
  } catch (const InputError&) {
    return {};
  }
}

// The last line that a failing program wrote to stderr: its one sentence.
std::string last_sentence(const fs::path& err) {
  std::ifstream file(err, std::ios::binary);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  constexpr std::string_view kPrefix = "lumatlas: ";
  return last.starts_with(kPrefix) ? last.substr(kPrefix.size()) : last;
}

// Calls `job` for 0 ... count - 1 from `threads` threads; the first exception ends the work and is thrown here.
void side_by_side(std::size_t count, std::size_t threads, const std::function<void(std::size_t)>& job) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failing;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) job(i);
    } catch (...) {
      const std::scoped_lock lock(failing);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  std::vector<std::thread> pool;
  for (std::size_t i = 1; i < std::min(threads, count); ++i) pool.emplace_back(work);
  work();
  for (std::thread& thread : pool) thread.join();
  if (failure) std::rethrow_exception(failure);
}

// A step of a point that did not succeed; what() is the sentence.
class StepFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

bool matches(const std::string& name, const std::vector<std::string>& patterns) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
           return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
         });
}

}  // namespace

const char* name_of(PointResult::Status status) {
  switch (status) {
    case PointResult::Status::done:
      return "done";
    case PointResult::Status::failed:
      return "failed";
    case PointResult::Status::skipped:
      return "skipped";
    case PointResult::Status::left_out:
      break;
  }
  return "left out";
}

class SweepRunner::Work {
 public:
  explicit Work(SweepRunOptions options) : options_(std::move(options)), lock_(options_.output) {
    for (const fs::path& folder : {scenes(), points()}) {
      fs::create_directories(folder);
      remove_leftovers(folder);
    }
  }

  std::vector<PointResult> run(const Sweep& sweep);

 private:
  struct SceneToMake {
    std::string kind;
    OptionValues synth;
  };

  [[nodiscard]] fs::path scenes() const { return options_.output / "scenes"; }
  [[nodiscard]] fs::path points() const { return options_.output / "points"; }
  [[nodiscard]] fs::path synthetic_scene(const std::string& kind, const OptionValues& synth) const {
    return scenes() / (kind + "-" + key_of(scene_description(kind, synth)));
  }
  [[nodiscard]] fs::path scene_of(const SweepPoint& point) const {
    return point.folder.empty() ? synthetic_scene(point.kind, point.synth) : options_.scenes / point.folder;
  }
  [[nodiscard]] fs::path scored_scene_of(const SweepPoint& point) const {
    return point.folder.empty() ? synthetic_scene(point.kind, point.scored_synth) : scene_of(point);
  }

  [[nodiscard]] PointResult begun(SweepPoint point) const;
  bool find(PointResult& result) const;
  void make_scenes(const std::vector<PointResult*>& wanted);
  void make_scene(const SceneToMake& scene);
  void make(PointResult& result);
  void make_mesh(PointResult& result, const fs::path& folder);
  void build_and_score(PointResult& result, const fs::path& folder);
  void step(PointResult& result, std::vector<std::string> arguments, const fs::path& folder, const char* output) const;
  SceneFacts facts_of(const fs::path& scene, const OptionValues& build);

  SweepRunOptions options_;
  FolderLock lock_;
  std::map<std::string, std::string> failed_scenes_;  // folder: sentence
  std::map<std::string, SceneFacts> facts_;
  std::mutex state_;  // of both
};

// Left out, skipped, or yet to be looked for (done, without figures).
PointResult SweepRunner::Work::begun(SweepPoint point) const {
  PointResult result;
  result.point = std::move(point);
  if (!matches(result.point.name, options_.only)) return result;
  result.status = PointResult::Status::done;
  if (result.point.folder.empty() || (!options_.scenes.empty() && fs::is_directory(scene_of(result.point)))) {
    return result;
  }
  result.status = PointResult::Status::skipped;
  result.reason = options_.scenes.empty() ? "the scene " + result.point.folder + " needs --scenes, a folder that has it"
                                          : scene_of(result.point).string() + ": there is no such scene";
  return result;
}

bool SweepRunner::Work::find(PointResult& result) const {
  const json description = description_of(result.point);
  const fs::path folder = points() / key_of(description);
  const json marker = json_in(folder / kMarkerFile);
  const json options = marker.is_object() ? marker.value("options", json()) : json();
  if (!options.is_object() || options.value("point", json()) != description) return false;
  const json made_by = options.value("made_by", json());
  if (!made_by.is_string() || (made_by != options_.identity && !options_.keep_points)) return false;
  json build = json_in(folder / "build.json"), scores = json_in(folder / "scores.json");
  const json commands = options.value("commands", json());
  if (!build.is_object() || !scores.is_object() || !commands.is_array()) return false;
  result.status = PointResult::Status::done;
  result.made_by = made_by;
  result.build = std::move(build);
  result.scores = std::move(scores);
  for (const json& command : commands) result.commands.push_back(command.is_string() ? command : json(""));
  return true;
}

void SweepRunner::Work::make_scene(const SceneToMake& scene) {
  const fs::path folder = synthetic_scene(scene.kind, scene.synth);
  fs::path out = folder, err = folder;
  out += ".out";
  err += ".err";
  std::vector<std::string> arguments{"synth", scene.kind, "--output=" + folder.string(), "--quiet"};
  for (const std::string& argument : arguments_of(scene.synth)) arguments.push_back(argument);
  const int status = run_to_end({options_.program, arguments, out, err});
  if (status != 0) {
    const std::scoped_lock lock(state_);
    failed_scenes_[folder.string()] = "synth: " + last_sentence(err);
  }
  fs::remove(out);
  fs::remove(err);
}

void SweepRunner::Work::make_scenes(const std::vector<PointResult*>& wanted) {
  std::map<fs::path, SceneToMake> missing;
  for (const PointResult* result : wanted) {
    const SweepPoint& point = result->point;
    if (!point.folder.empty()) continue;
    missing[scene_of(point)] = {point.kind, point.synth};
    missing[scored_scene_of(point)] = {point.kind, point.scored_synth};
  }
  std::erase_if(missing, [](const auto& scene) { return fs::exists(scene.first / kMarkerFile); });
  std::vector<SceneToMake> scenes;
  scenes.reserve(missing.size());
  for (const auto& [folder, scene] : missing) scenes.push_back(scene);
  Progress progress("making scenes", scenes.size(), ProgressOptions::standard_error(options_.quiet));
  side_by_side(scenes.size(), options_.jobs, [&](std::size_t i) {
    make_scene(scenes[i]);
    progress.tick();
  });
}

SceneFacts SweepRunner::Work::facts_of(const fs::path& scene, const OptionValues& build) {
  OptionValues deciding;
  for (const char* const name : {"hold", "block", "mesh", "max-views"}) {
    if (const auto found = build.find(name); found != build.end()) deciding.insert(*found);
  }
  const std::string key = shell_line(scene.string(), arguments_of(deciding));
  const std::scoped_lock lock(state_);
  const auto known = facts_.find(key);
  return known != facts_.end() ? known->second : facts_[key] = scene_facts(scene, deciding);
}

void SweepRunner::Work::step(PointResult& result, std::vector<std::string> arguments, const fs::path& folder,
                             const char* output) const {
  const std::string command = arguments.front();
  const fs::path err = folder / (command + ".err");
  const int status = run_to_end({options_.program, arguments, folder / output, err});
  // For people, without the places of this machine.
  for (std::string& argument : arguments) {
    for (const auto& [path, name] :
         {std::pair{folder / "model", "MODEL"}, std::pair{folder / kMesh, "MESH"},
          std::pair{scene_of(result.point), "SCENE"}, std::pair{scored_scene_of(result.point), "UNDISTURBED"}}) {
      const std::size_t at = argument.find(path.string());
      if (at != std::string::npos) argument.replace(at, path.string().size(), name);
    }
  }
  std::erase_if(arguments, [&](const std::string& argument) { return argument.find(folder) != std::string::npos; });
  result.commands.push_back(shell_line("lumatlas", arguments));
  const std::string sentence = last_sentence(err);
  fs::remove(err);
  if (status < 0) throw StepFailed(command + ": was ended by signal " + std::to_string(-status));
  if (status > 0) throw StepFailed(command + ": " + sentence);
}

void SweepRunner::Work::make_mesh(PointResult& result, const fs::path& folder) {
  const fs::path scene = scene_of(result.point);
  const auto facts = [&] { return facts_of(scene, result.point.build); };
  std::vector<std::string> mesh{"mesh", scene.string(), "--output=" + (folder / kMesh).string(), "--json", "--quiet"};
  for (std::string& argument : arguments_of(resolved(result.point.mesh, scene, facts))) {
    mesh.push_back(std::move(argument));
  }
  step(result, mesh, folder, "mesh.json");
  fs::remove(folder / "mesh.json");
}

void SweepRunner::Work::build_and_score(PointResult& result, const fs::path& folder) {
  const fs::path scene = scene_of(result.point), model = folder / "model";
  const auto facts = [&] { return facts_of(scene, result.point.build); };
  // Completing the mesh anew at each point would take more time than the rest.
  std::vector<std::string> build{
      "build", scene.string(), "--output=" + model.string(), "--texture=none", "--mesh-as-given", "--json", "--quiet"};
  if (!result.point.mesh.empty()) {
    make_mesh(result, folder);
    build.push_back("--mesh=" + (folder / kMesh).string());
  }
  for (std::string& argument : arguments_of(resolved(result.point.build, scene, facts))) {
    build.push_back(std::move(argument));
  }
  step(result, build, folder, "build.json");
  std::vector<std::string> validate{"validate",
                                    model.string(),
                                    "--views=" + scored_scene_of(result.point).string(),
                                    "--output=" + (folder / "report").string(),
                                    "--no-pictures",
                                    "--json",
                                    "--quiet"};
  for (std::string& argument : arguments_of(resolved(result.point.validate, scored_scene_of(result.point), facts))) {
    validate.push_back(std::move(argument));
  }
  step(result, validate, folder, "scores.json");
  fs::remove_all(model);
  fs::remove(folder / kMesh);
  fs::remove_all(folder / "report");
}

void SweepRunner::Work::make(PointResult& result) {
  const json description = description_of(result.point);
  try {
    for (const fs::path& scene : {scene_of(result.point), scored_scene_of(result.point)}) {
      const auto failed = failed_scenes_.find(scene.string());
      if (failed != failed_scenes_.end()) throw StepFailed(failed->second);
    }
    OutputFolder folder(points() / key_of(description), "chart");
    build_and_score(result, folder.path());
    result.build = json_in(folder.path() / "build.json");
    result.scores = json_in(folder.path() / "scores.json");
    if (!result.build.is_object() || !result.scores.is_object()) throw StepFailed("its results are not JSON");
    result.made_by = options_.identity;
    result.made_now = true;
    folder.commit(
        {{"command", "chart"}, {"point", description}, {"made_by", result.made_by}, {"commands", result.commands}});
  } catch (const std::runtime_error& error) {  // StepFailed, InputError, of a full disk too; not Interrupted
    result.status = PointResult::Status::failed;
    result.reason = error.what();
  }
}

std::vector<PointResult> SweepRunner::Work::run(const Sweep& sweep) {
  std::vector<PointResult> results;
  for (SweepPoint& point : points_of(sweep)) results.push_back(begun(std::move(point)));
  std::map<std::string, PointResult*> first;  // by key: points that are the same are made once
  std::vector<PointResult*> missing;
  for (PointResult& result : results) {
    if (result.status != PointResult::Status::done) continue;
    const bool is_first = first.emplace(key_of(description_of(result.point)), &result).second;
    if (is_first && !find(result)) missing.push_back(&result);
  }
  make_scenes(missing);
  {
    Progress progress(sweep.name, missing.size(), ProgressOptions::standard_error(options_.quiet));
    side_by_side(missing.size(), options_.jobs, [&](std::size_t i) {
      make(*missing[i]);
      progress.tick();
    });
  }
  for (PointResult& result : results) {
    if (result.status != PointResult::Status::done) continue;
    const PointResult& same = *first.at(key_of(description_of(result.point)));
    if (&same == &result) continue;
    SweepPoint point = std::move(result.point);
    result = same;
    result.point = std::move(point);
    result.made_now = false;
  }
  return results;
}

SweepRunner::SweepRunner(SweepRunOptions options) : work_(std::make_unique<Work>(std::move(options))) {}
SweepRunner::~SweepRunner() = default;

std::vector<PointResult> SweepRunner::run(const Sweep& sweep) {
  return work_->run(sweep);
}

}  // namespace lumatlas
