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
#include "mesh/mesh_file.h"
#include "tools/base/elapsed.h"
#include "tools/base/interrupt.h"
#include "tools/base/output_folder.h"
#include "tools/capture/captured_photographs.h"
#include "tools/capture/step_record.h"
#include "tools/pipeline/model_output.h"
#include "tools/pipeline/save_model.h"
#include "tools/scene/forms/colmap.h"
#include "tools/scene/scene.h"
#include "tools/scene/scene_list.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kSteps = 5;

bool is_within(const fs::path& path, const fs::path& folder) {
  const fs::path inner = fs::weakly_canonical(path);
  return std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end()).first == folder.end();
}

void check_outside(const fs::path& output, const fs::path& photographs) {
  if (!is_within(output, photographs)) return;
  throw InputError(output.string() +
                   ": lies in the folder of the photographs, which would find its pictures there the " +
                   "next time: name another place");
}

// A folder of one's own: new, empty, or an earlier capture's.
void open_work_folder(const fs::path& work, const fs::path& record) {
  std::error_code error;
  if (fs::exists(work, error) && !fs::exists(record, error) && (!fs::is_directory(work) || !fs::is_empty(work))) {
    throw InputError(work.string() + ": is in use, and not by `lumatlas capture`: name another folder with --work");
  }
  fs::create_directories(work / "log", error);
  if (error) throw InputError(work.string() + ": cannot be made (" + error.message() + ")");
}

// Makes `link` a link to the folder; an empty `target` removes it.
void put_link(const fs::path& link, const fs::path& target) {
  std::error_code error;
  if (!target.empty() && fs::is_symlink(link) && fs::read_symlink(link, error) == target) return;
  fs::remove(link, error);
  if (!error && !target.empty()) fs::create_directory_symlink(target, link, error);
  if (error)
    throw InputError(link.string() + ": cannot be linked to " + target.string() + " (" + error.message() + ")");
}

// Absolute and without links; empty: no masks were given. Throws InputError where there is no such folder.
fs::path folder_of_masks(const CaptureOptions& options) {
  if (!options.masks) return {};
  std::error_code error;
  fs::path folder = fs::canonical(*options.masks, error);
  if (error || !fs::is_directory(folder, error))
    throw InputError(options.masks->string() + ": no such folder of masks");
  return folder;
}

// The photographs of a folder, without the masks, which may lie in it.
CapturedPhotographs photographs_beside_masks(const fs::path& folder, const fs::path& masks) {
  CapturedPhotographs photographs = find_photographs(folder);
  if (masks.empty()) return photographs;
  std::erase_if(photographs.names,
                [&](const std::string& name) { return is_within((photographs.folder / name).parent_path(), masks); });
  return photographs;
}

// The mask of each photograph that has one, by the photograph's name.
std::map<std::string, fs::path> masks_by_photograph(const fs::path& folder, const CapturedPhotographs& photographs) {
  std::map<std::string, fs::path> masks;
  if (folder.empty()) return masks;
  for (const std::string& name : photographs.names) {
    SceneView view;
    view.name = name;
    if (const std::optional<fs::path> mask = mask_of(view, folder)) masks.emplace(name, *mask);
  }
  if (!masks.empty()) return masks;
  const std::string first = photographs.names.empty() ? "NAME.jpg" : photographs.names.front();
  throw InputError(folder.string() + ": has a mask of none of the " + std::to_string(photographs.names.size()) +
                   " photographs; that of " + first + " would be " + first + ".png");
}

void remove_all_of(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) throw InputError(path.string() + ": cannot be removed (" + error.message() + ")");
}

void remove_database(const fs::path& database) {
  for (const char* const ending : {"", "-wal", "-shm", "-journal"}) remove_all_of(database.string() + ending);
}

// COLMAP's model in a folder of its own: binary, or text where somebody has told it so.
std::vector<fs::path> files_of_model(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* const name : {"cameras", "images", "points3D"}) {
    for (const char* const ending : {".bin", ".txt"}) files.push_back(folder / (std::string(name) + ending));
  }
  return files;
}

bool is_model(const fs::path& folder) {
  const std::vector<fs::path> files = files_of_model(folder);
  return std::any_of(files.begin(), files.end(), [](const fs::path& file) { return fs::exists(file); });
}

// COLMAP numbers them in the order in which it began them; the one of most photographs is the capture, the first of
// equals.
std::vector<fs::path> reconstructions_in(const fs::path& folder, fs::path& largest) {
  std::vector<fs::path> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory() && is_model(entry.path())) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  std::size_t most = 0;
  for (const fs::path& model : found) {
    const std::size_t images = read_colmap_model(model).images.size();
    if (images > most) largest = model;
    most = std::max(most, images);
  }
  return found;
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
  CaptureRun(const fs::path& photographs, const fs::path& work, const fs::path& model, const CaptureOptions& options,
             const CaptureListener& listener)
      : mask_folder_(folder_of_masks(options)),
        photographs_(photographs_beside_masks(photographs, mask_folder_)),
        masks_(masks_by_photograph(mask_folder_, photographs_)),
        work_(fs::weakly_canonical(fs::absolute(work))),  // the same whether it is there yet or not
        model_(fs::weakly_canonical(fs::absolute(model))),
        options_(options),
        listener_(listener) {
    check_outside(work_, photographs_.folder);
    check_outside(model_, photographs_.folder);
    open_work_folder(work_, work_ / kRecord);
    record_.emplace(work_ / kRecord);
    put_link(work_ / "images", photographs_.folder);
    put_link(work_ / "masks", mask_folder_);
    result_.photographs = photographs_.names.size();
  }

  CaptureResult run() {
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

  // Calls work() unless the step is done; `what` says to people what it is. The inputs are what is given and when the
  // step before was finished.
  template <typename Work>
  void step(const std::string& name, const std::string& what, json inputs, std::span<const fs::path> outputs,
            const Work& work) {
    inputs["after"] = result_.steps.empty() ? json() : record_->stamp(result_.steps.back().name);
    const std::string label =
        "step " + std::to_string(result_.steps.size() + 1) + " of " + std::to_string(kSteps) + ", " + name;
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

  [[nodiscard]] ColmapProgress bar(const std::string& name) const {
    return [shown = std::make_shared<Bar>(listener_.stage, name)](std::size_t done, std::size_t of) {
      shown->show(done, of);
    };
  }

  [[nodiscard]] std::string log_of(const std::string& step) const {
    return " (COLMAP's words: " + ColmapProgram::log(work_, step).string() + ")";
  }

  // Whether a database of the photographs `before` holds nothing that is not so `now`: COLMAP passes over photographs
  // that it has looked at already.
  static bool only_adds(const json& before, const json& now) {
    if (!before.is_object() || before.value("folder", json()) != now["folder"]) return false;
    for (const char* const key : {"gpu", "masks"}) {
      if (before.value(key, json()) != now[key]) return false;
    }
    const json known = before.value("photographs", json::object());
    for (const auto& [name, state] : known.items()) {
      if (now["photographs"].value(name, json()) != state) return false;
    }
    return true;
  }

  void features() {
    const fs::path database = ColmapProgram::database(work_);
    std::error_code ignored;
    if (!fs::exists(database, ignored)) record_->forget("features");
    const json inputs{{"folder", photographs_.folder.string()},
                      {"photographs", states_of(photographs_)},
                      {"gpu", options_.colmap.use_gpu},
                      {"masks", states_of_masks()}};
    const bool keeps_database = only_adds(record_->inputs("features"), kept_json(inputs));
    step("features", std::to_string(photographs_.names.size()) + " photographs" + log_of("features"), inputs, {}, [&] {
      const ColmapProgram colmap(work_);
      if (!keeps_database) remove_database(database);
      const std::vector<std::vector<std::string>> lenses = names_by_lens(photographs_);
      say(lenses_text(lenses));
      colmap.extract_features(photographs_, lenses, masks_for_colmap(), options_.colmap, bar("features"));
    });
  }

  static std::string lenses_text(const std::vector<std::vector<std::string>>& lenses) {
    constexpr std::size_t kMostTold = 4;
    if (lenses.size() == 1) return "  taken as of one lens: they tell the same size and camera";
    std::string text =
        "  taken as of " + std::to_string(lenses.size()) + " lenses, for their sizes or cameras differ: ";
    for (std::size_t i = 0; i < std::min(lenses.size(), kMostTold); ++i) {
      text += (i == 0 ? "" : ", ") + std::to_string(lenses[i].size()) + " like " + lenses[i].front();
    }
    return text + (lenses.size() > kMostTold ? " and others" : "");
  }

  // Name, size and time of each mask, by its photograph; null: there are none.
  [[nodiscard]] json states_of_masks() const {
    json states;
    for (const auto& [name, mask] : masks_) states[name] = {{"file", mask.string()}, {"state", file_state(mask)}};
    return states;
  }

  // A folder of links, for COLMAP knows one name for a mask: NAME.jpg.png. Empty: there are no masks.
  [[nodiscard]] fs::path masks_for_colmap() const {
    fs::path folder = work_ / "colmap-masks";
    remove_all_of(folder);
    if (masks_.empty()) return {};
    for (const auto& [name, mask] : masks_) {
      const fs::path link = folder / (name + ".png");
      fs::create_directories(link.parent_path());
      fs::create_symlink(mask, link);
    }
    return folder;
  }

  [[nodiscard]] bool is_exhaustive() const {
    return matching_for(result_.photographs, options_.colmap.matching) == Matching::exhaustive;
  }

  void match() {
    const bool exhaustive = is_exhaustive();
    step(
        "matching",
        (exhaustive ? "each photograph with each" : "each photograph with its neighbours by name") + log_of("matching"),
        {{"exhaustive", exhaustive}, {"gpu", options_.colmap.use_gpu}}, {},
        [&] { ColmapProgram(work_).match(result_.photographs, options_.colmap, bar("matching")); });
  }

  void map() {
    const fs::path model = work_ / "sparse" / "0";
    const std::vector<fs::path> outputs = files_of_model(model);
    step("mapping", "poses and points" + log_of("mapping"), json::object(), outputs, [&] {
      const fs::path all = ColmapProgram::reconstructions(work_);
      remove_all_of(all);
      remove_all_of(work_ / "sparse");
      fs::create_directories(all);
      fs::create_directories(model.parent_path());
      ColmapProgram(work_).map(photographs_, is_exhaustive(), bar("mapping"));
      fs::path largest;
      const std::vector<fs::path> found = reconstructions_in(all, largest);
      if (found.empty()) {
        throw InputError(photographs_.folder.string() + ": COLMAP placed none of its " +
                         std::to_string(result_.photographs) + " photographs: they overlap too little, or show too " +
                         "little that can be told apart; see " + ColmapProgram::log(work_, "mapping").string());
      }
      fs::copy(largest, model, fs::copy_options::recursive);
    });
  }

  void count_placed() {
    fs::path largest;
    result_.reconstructions = reconstructions_in(ColmapProgram::reconstructions(work_), largest).size();
    std::vector<std::string> placed;
    for (const ColmapImage& image : read_colmap_model(work_).images) placed.push_back(image.name);
    std::set_difference(photographs_.names.begin(), photographs_.names.end(), placed.begin(), placed.end(),
                        std::back_inserter(result_.missed));
    std::string sentence =
        "  " + std::to_string(placed.size()) + " of " + std::to_string(result_.photographs) + " photographs are placed";
    if (result_.reconstructions > 1) {
      sentence += ", in the largest of " + std::to_string(result_.reconstructions) +
                  " reconstructions that do not hang together";
    }
    if (!result_.missed.empty()) sentence += "; without a place: " + result_.missed.front();
    if (result_.missed.size() > 1) sentence += " and " + std::to_string(result_.missed.size() - 1) + " more";
    say(sentence);
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
      inputs["masks"] = states_of_masks();
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
            {"masks", states_of_masks()}};
  }

  void build() {
    const bool is_file = model_.extension() == ".glb";
    const std::vector<fs::path> outputs =
        is_file ? std::vector<fs::path>{model_} : std::vector<fs::path>{model_ / "plan.json", model_ / "scene.gltf"};
    step("build", "a model of them", build_inputs(), outputs, [&] {
      ModelOutput output(model_);
      BuildOptions options = options_.build;
      options.completion.surface = false;  // the mesh is as it was asked for
      options.mesh = work_ / "mesh.ply";
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
  CapturedPhotographs photographs_;
  std::map<std::string, fs::path> masks_;  // by photograph
  fs::path work_, model_;
  const CaptureOptions& options_;
  const CaptureListener& listener_;
  std::optional<StepRecord> record_;
  CaptureResult result_;
};

}  // namespace

void check(const CaptureOptions& options) {
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
