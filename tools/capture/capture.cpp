// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/capture.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/requirement.h"
#include "mesh/readers/mesh_file.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/interrupt.h"
#include "tools/capture/colmap/known_poses.h"
#include "tools/capture/colmap/matching_plan.h"
#include "tools/capture/colmap/reconstructions.h"
#include "tools/capture/sources/capture_sources.h"
#include "tools/capture/sources/captured_masks.h"
#include "tools/capture/sources/captured_photographs.h"
#include "tools/capture/step_record.h"
#include "tools/capture/work_folder.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/output/save_model.h"
#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_list.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr Requirement capture_requires{"capture"};

void remove_database(const fs::path& database) {
  for (const char* const ending : {"", "-wal", "-shm", "-journal"}) remove_all_of(database.string() + ending);
}

// A stage's bar, told by how much is done in all; COLMAP may begin anew.
class Bar {
 public:
  Bar(const StageProgress& stage, std::string name) : stage_(stage), name_(std::move(name)) {}

  void show(std::size_t done, std::size_t of) {
    throw_if_interrupted();
    if (!stage_ || of == 0) return;
    if (!tick_) tick_ = stage_(name_, of);
    // The caller may end the work between steps too.
    tick_(done > shown_ ? std::min(done, of) - std::min(shown_, of) : 0);
    shown_ = std::max(shown_, done);
  }

 private:
  const StageProgress& stage_;
  std::string name_;
  std::function<void(std::size_t)> tick_;
  std::size_t shown_ = 0;
};

class CaptureRun {
 public:
  CaptureRun(const fs::path& given, const fs::path& work, const fs::path& model, const CaptureOptions& options,
             const CaptureListener& listener)
      : mask_folder_(folder_of_masks(options.masks)),
        sources_(find_sources(given, mask_folder_)),
        work_(fs::weakly_canonical(fs::absolute(work))),  // the same whether it is there yet or not
        model_(fs::weakly_canonical(fs::absolute(model))),
        options_(options),
        listener_(listener) {
    if (fs::is_directory(given)) {
      check_outside(work_, sources_.folder);
      check_outside(model_, sources_.folder);
    }
    open_work_folder(work_, work_ / kRecord);
    record_.emplace(work_ / kRecord);
  }

  CaptureResult run() {
    prepare();
    features();
    match();
    map();
    count_placed();
    mesh();
    build();
    return std::move(result_);
  }

 private:
  static constexpr const char* kRecord = "capture.json";

  void say(const std::string& sentence) const {
    if (listener_.say) listener_.say(sentence);
  }

  [[nodiscard]] std::string label_of(const std::string& step) const {
    const std::size_t steps = need_preparation(sources_) ? 6 : 5;
    return "step " + std::to_string(result_.steps.size() + 1) + " of " + std::to_string(steps) + ", " + step;
  }

  // Calls work() unless the step is done; `what` says to people what it is. The inputs are what is given and when the
  // step before was finished.
  template <typename Work>
  void step(const std::string& name, const std::string& what, json inputs, std::span<const fs::path> outputs,
            const Work& work) {
    inputs["after"] = last_recorded_.empty() ? json() : record_->stamp(last_recorded_);
    last_recorded_ = name;
    const std::string label = label_of(name);
    if (record_->is_done(name, inputs)) {
      say(label + ": done before");
      result_.steps.push_back({name, true, 0});
      return;
    }
    const auto start = std::chrono::steady_clock::now();
    say(label + ": " + what);
    record_->begin(name, inputs);
    work();
    record_->finish(name, outputs);
    const double time_ms = ms_since(start);
    result_.steps.push_back({name, false, time_ms});
  }

  static std::string count_text(std::size_t count, const std::string& thing) {
    return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
  }

  // Videos and photographs in other forms become photographs that COLMAP reads. What of them is there is known by the
  // files themselves, so that no record tells it.
  void prepare() {
    const bool needed = need_preparation(sources_);
    const auto start = std::chrono::steady_clock::now();
    if (needed) {
      say(label_of("photographs") + ": made of " + count_text(sources_.videos.size(), "video") + " and " +
          count_text(sources_.converted.size(), "photograph") + " in other forms");
    }
    PreparedPhotographs prepared =
        prepare_photographs(sources_, work_, options_.most_frames, {listener_.say, listener_.stage});
    captured_ = std::move(prepared.captured);
    masks_ = masks_by_photograph(mask_folder_, captured_);
    put_link(work_ / "masks", mask_folder_);
    result_.photographs = captured_.photographs.size();
    result_.converted = prepared.converted;
    result_.videos = std::move(prepared.videos);
    result_.left_out = std::move(prepared.left_out);
    for (const auto& [name, why] : result_.left_out) {
      std::string sentence = "  left out: ";
      say(sentence.append(name).append(" ").append(why));
    }
    if (needed) result_.steps.push_back({"photographs", !prepared.made_anything, ms_since(start)});
    check_inputs();
  }

  [[nodiscard]] ColmapProgress bar(const std::string& name) const {
    return [shown = std::make_shared<Bar>(listener_.stage, name)](std::size_t done, std::size_t of) {
      shown->show(done, of);
    };
  }

  [[nodiscard]] std::string log_of(const std::string& step) const {
    return " (COLMAP's log: " + ColmapProgram::log(work_, step).string() + ")";
  }

  // Returns whether a database of the photographs `before` holds nothing that is not so `now`: COLMAP passes over
  // photographs that it has looked at already.
  [[nodiscard]] bool only_adds(const json& before, const json& now) const {
    if (!before.is_object()) return false;
    const json folder = before.value("folder", json());
    if (folder != now["folder"] && folder != kept_json(earlier_photographs(work_).string())) return false;
    for (const char* const key : {"gpu", "masks", "camera_model"}) {
      if (before.value(key, json()) != now[key]) return false;
    }
    const json known = before.value("photographs", json::object());
    for (const auto& [name, state] : known.items()) {
      if (now["photographs"].value(name, json()) != state) return false;
    }
    return true;
  }

  // Refuses at once what would be refused after hours.
  void check_inputs() {
    plan_ = plan_matching(captured_, options_.colmap.matching);
    if (!options_.poses && options_.colmap.mapper == Mapper::global) ColmapProgram(work_).require(Mapper::global);
    if (!options_.poses) return;
    poses_ = read_known_poses(*options_.poses, captured_);
    say("  " + options_.poses->string() + " is read as " + poses_.form + ": it has poses of " +
        std::to_string(poses_.views.size()) + " of the " + std::to_string(result_.photographs) + " photographs");
  }

  void features() {
    const fs::path database = ColmapProgram::database(work_);
    std::error_code ignored;
    if (!fs::exists(database, ignored)) record_->forget("features");
    const json inputs{{"folder", captured_.source_folder.string()},
                      {"photographs", states_of(captured_)},
                      {"gpu", options_.colmap.use_gpu},
                      {"camera_model", options_.colmap.camera_model},
                      {"masks", states_of_masks(masks_)}};
    const bool keeps_database = only_adds(record_->inputs("features"), kept_json(inputs));
    step("features", std::to_string(result_.photographs) + " photographs" + log_of("features"), inputs, {}, [&] {
      const ColmapProgram colmap(work_);
      if (!keeps_database) remove_database(database);
      const std::vector<std::vector<std::string>> lenses = names_by_lens(captured_);
      say(lenses_text(lenses));
      const fs::path masks = link_masks_for_colmap(masks_, work_ / "colmap-masks");
      colmap.extract_features(captured_, lenses, masks, options_.colmap, bar("features"));
    });
  }

  static std::string lenses_text(const std::vector<std::vector<std::string>>& lenses) {
    constexpr std::size_t kMostTold = 4;
    if (lenses.size() == 1) return "  taken as of one lens: nothing tells them apart";
    std::string text =
        "  taken as of " + std::to_string(lenses.size()) + " lenses, for their sizes or cameras differ: ";
    for (std::size_t i = 0; i < std::min(lenses.size(), kMostTold); ++i) {
      text += (i == 0 ? "" : ", ") + std::to_string(lenses[i].size()) + " like " + lenses[i].front();
    }
    return text + (lenses.size() > kMostTold ? " and others" : "");
  }

  void match() {
    step("matching", text_of(plan_) + log_of("matching"), {{"plan", json_of(plan_)}, {"gpu", options_.colmap.use_gpu}},
         {}, [&] { ColmapProgram(work_).match(plan_, result_.photographs, options_.colmap, bar("matching")); });
  }

  void map() {
    const fs::path model = work_ / "sparse" / "0";
    const std::vector<fs::path> outputs = files_of_model(model);
    const bool is_global = options_.colmap.mapper == Mapper::global;
    const std::string what = options_.poses ? "points, by the poses in " + options_.poses->string()
                             : is_global    ? "poses and points, of all photographs at once"
                                            : "poses and points";
    step("mapping", what + log_of("mapping"), {{"poses", states_of_poses()}, {"global", is_global}}, outputs, [&] {
      const fs::path all = ColmapProgram::reconstructions(work_);
      remove_all_of(all);
      remove_all_of(work_ / "sparse");
      fs::create_directories(all);
      fs::create_directories(model.parent_path());
      const ColmapProgram colmap(work_);
      if (options_.poses) {
        write_known_poses(poses_, ColmapProgram::database(work_), work_ / "poses");
        colmap.triangulate(captured_, work_ / "poses", bar("mapping"));
      } else {
        colmap.map(captured_, plan_.exhaustive, options_.colmap.mapper, bar("mapping"));
      }
      const std::vector<Reconstruction> found = reconstructions_in(all);
      if (found.empty()) {
        throw InputError(captured_.given.string() + ": COLMAP placed none of its " +
                         std::to_string(result_.photographs) + " photographs: they overlap too little, or show too " +
                         "little that can be told apart; see " + ColmapProgram::log(work_, "mapping").string());
      }
      fs::copy(found.front().folder, model, fs::copy_options::recursive);
    });
  }

  // The files that say the poses, by their sizes and times; null: they are not known.
  [[nodiscard]] json states_of_poses() const {
    if (!options_.poses) return {};
    json states{{"scene", fs::absolute(*options_.poses).string()}};
    for (const fs::path& file : files_of_list(*options_.poses)) states[file.string()] = file_state(file);
    return states;
  }

  void count_placed() {
    const std::vector<Reconstruction> found = reconstructions_in(ColmapProgram::reconstructions(work_));
    for (const Reconstruction& reconstruction : found) result_.reconstructions.push_back(reconstruction.placed.size());
    std::vector<std::string> placed;
    for (const ColmapImage& image : read_colmap_model(work_).images) placed.push_back(image.name);
    const std::vector<std::string> names = names_of(captured_);
    std::set_difference(names.begin(), names.end(), placed.begin(), placed.end(), std::back_inserter(result_.missed));
    std::string sentence =
        "  " + std::to_string(placed.size()) + " of " + std::to_string(result_.photographs) + " photographs are placed";
    if (found.size() > 1) {
      sentence += ", in the largest of " + std::to_string(found.size()) +
                  " reconstructions that do not hang together (" + sizes_text(result_.reconstructions) +
                  " photographs): take more photographs between them";
    }
    if (!result_.missed.empty()) sentence += "; without a place: " + result_.missed.front();
    if (result_.missed.size() > 1) sentence += " and " + std::to_string(result_.missed.size() - 1) + " more";
    say(sentence);
  }

  static std::string sizes_text(const std::vector<std::size_t>& sizes) {
    constexpr std::size_t kMostTold = 6;
    std::string text;
    for (std::size_t i = 0; i < std::min(sizes.size(), kMostTold); ++i) {
      text += (i == 0 ? "" : ", ") + std::to_string(sizes[i]);
    }
    return text + (sizes.size() > kMostTold ? " and fewer" : "");
  }

  void mesh() {
    const fs::path file = work_ / "mesh.ply";
    SceneMeshOptions options = options_.mesh;
    options.from = options.from.value_or(options.points ? MeshSource::points : MeshSource::photographs);
    options.stereo_folder = work_ / "stereo";
    options.hold_out = options_.build.hold_out;
    json inputs{{"program", LUMATLAS_VERSION}, {"spacing", options.spacing_px}, {"from", name_of(*options.from)}};
    if (options.from == MeshSource::photographs) {
      inputs["hold"] = hold_inputs();
      inputs["masks"] = states_of_masks(masks_);
    }
    if (const auto& points = options_.mesh.points) {
      inputs["points"] = {{"file", fs::absolute(*points).string()}, {"state", file_state(*points)}};
    }
    const std::string points = options_.mesh.points ? options_.mesh.points->string() : "the points";
    const std::string what = options.from == MeshSource::photographs
                                 ? "from depths of the photographs, which are matched with each other"
                                 : "from " + points + " and the photographs that saw them";
    step("mesh", what, inputs, std::array{file}, [&] {
      AtomicFile output(file);
      const SceneMesh made = mesh_from_scene(work_, options, listener_.stage ? listener_.stage : no_stage());
      write_ply(output.stream(), made.surface);
      output.commit();
      if (made.source == MeshSource::photographs) remove_stereo_work(options.stereo_folder);
      result_.warnings = made.warnings;
    });
  }

  [[nodiscard]] static StageProgress no_stage() {
    return [](const std::string&, std::size_t) { return [](std::size_t) { throw_if_interrupted(); }; };
  }

  [[nodiscard]] json hold_inputs() const {
    const std::optional<HoldOut>& hold = options_.build.hold_out;
    return hold ? json{hold->hold, hold->block} : json();
  }

  [[nodiscard]] json build_inputs() const {
    const BuildOptions& build = options_.build;
    return {{"program", LUMATLAS_VERSION},
            {"model", model_.string()},
            {"hold", hold_inputs()},
            {"max_views", build.max_views.value_or(0)},
            {"image", ending(options_.photographs.format)},
            {"quality", options_.photographs.quality},
            {"masks", states_of_masks(masks_)}};
  }

  void build() {
    const bool is_file = model_.extension() == ".glb";
    const std::vector<fs::path> outputs =
        is_file ? std::vector<fs::path>{model_} : std::vector<fs::path>{model_ / "plan.json", model_ / "tileset.json"};
    step("build", "a model of them", build_inputs(), outputs, [&] {
      ModelOutput output(model_);
      BuildOptions options = options_.build;
      options.completion.surface = false;  // the mesh is as it was asked for
      options.mesh = work_ / "mesh.ply";
      options.memory.scratch_folder = scratch_folder_for(model_);
      const BuildResult built = build_model(work_, options, listener_.build);
      save_model(built, output, options_.photographs, result_.missed.size());
    });
    const json plan = read_model_notes(model_).plan;
    result_.summary = plan.is_object() ? plan.value("summary", json()) : json();
    name_outliers(plan.is_object() ? plan.value("views", json::array()) : json::array());
  }

  void name_outliers(const json& views) {
    for (const json& view : views) {
      if (view.value("decision", "") == "outlier") result_.outliers.push_back(view.value("name", ""));
    }
    if (result_.outliers.empty()) return;
    std::string names;
    for (const std::string& name : result_.outliers) names += (names.empty() ? "" : ", ") + name;
    say("  left out, because they agree with none of the others: " + names);
  }

  fs::path mask_folder_;  // empty: none was given
  CaptureSources sources_;
  CapturedPhotographs captured_;
  std::map<std::string, fs::path> masks_;  // for each photograph
  MatchingPlan plan_;
  KnownPoses poses_;  // with options_.poses
  fs::path work_, model_;
  const CaptureOptions& options_;
  const CaptureListener& listener_;
  std::optional<StepRecord> record_;
  std::string last_recorded_;  // the name of the step before
  CaptureResult result_;
};

}  // namespace

void check(const CaptureOptions& options) {
  capture_requires(options.most_frames >= 2, "most_frames", static_cast<double>(options.most_frames), "at least 2");
  check(options.colmap);
  check(options.mesh);
  check(options.build);
  check(options.photographs);
}

fs::path capture_beside(fs::path model) {
  if (!model.has_filename()) model = model.parent_path();
  if (model.extension() == ".glb") model.replace_extension();
  model += "-capture";
  return model;
}

CaptureResult capture(const fs::path& photographs, const fs::path& work, const fs::path& model,
                      const CaptureOptions& options, const CaptureListener& listener) {
  check(options);
  (void)ModelOutput(model);  // refuses at once what would be refused after hours
  return CaptureRun(photographs, work, model, options, listener).run();
}

}  // namespace lumatlas
