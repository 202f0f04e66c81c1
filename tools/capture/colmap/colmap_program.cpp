// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/colmap_program.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tools/base/process/child_process.h"
#include "tools/capture/colmap/colmap_log.h"
#include "tools/scene/lenses/camera_model.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::streamoff kWholeLog = 1 << 24;

// The end of a file, which another program may be writing.
std::string last_bytes(const fs::path& file, std::streamoff count) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) return {};
  const std::streamoff size = stream.tellg();
  stream.seekg(std::max<std::streamoff>(0, size - count));
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// The last match of the pattern, if there is one.
std::smatch last_match(const std::string& text, const std::regex& pattern) {
  std::smatch last;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), pattern); at != std::sregex_iterator(); ++at)
    last = *at;
  return last;
}

std::size_t number(const std::ssub_match& match) {
  return static_cast<std::size_t>(std::strtoull(match.str().c_str(), nullptr, 10));
}

// The whole name of the option whose name ends so: newer COLMAPs have moved some from one group to another. Empty:
// there is none.
std::string option_named(const std::string& help, const std::string& ending) {
  std::smatch found;
  return std::regex_search(help, found, std::regex("--([A-Za-z.]+\\." + ending + ")\\b")) ? "--" + found[1].str() : "";
}

void add_gpu(const std::string& help, bool use_gpu, std::vector<std::string>& arguments) {
  const std::string option = option_named(help, "use_gpu");
  if (!option.empty()) arguments.insert(arguments.end(), {option, use_gpu ? "1" : "0"});
}

// COLMAP tells how far it is after each block of photographs, and its own blocks of 50 are most captures as a whole.
std::string block_size(std::size_t photographs) {
  constexpr std::size_t kBlocks = 8, kSmallest = 4, kLargest = 50;
  return std::to_string(std::clamp(photographs / kBlocks, kSmallest, kLargest));
}

// The block that COLMAP named last is done now; photographs without a place stay so.
void show_end(const ColmapState& state, const ColmapProgress& progress) {
  if (progress) progress(state.counts_places ? state.done : state.of, state.of);
}

}  // namespace

void check(const ColmapOptions& options) {
  const std::optional<LensModel> model = lens_model(std::string_view(options.camera_model));
  if (model && can_be_pinhole(*model)) return;
  throw std::invalid_argument("COLMAP: camera_model is '" + options.camera_model +
                              "', must be one of COLMAP's models of photographs, such as SIMPLE_RADIAL, OPENCV or "
                              "OPENCV_FISHEYE");
}

ColmapState colmap_state(const std::string& log, std::size_t photographs) {
  static const std::regex kRegistered(R"(Registering image #\d+ \((?:num_reg_frames=)?(\d+)\))");
  static const std::regex kBlocks(R"(\[(\d+)/(\d+), (\d+)/(\d+)\])");
  static const std::regex kFiles(R"(\[(\d+)/(\d+)\])");
  if (const std::smatch match = last_match(log, kRegistered); !match.empty())
    return {number(match[1]), photographs, true};
  // The block that is named is at work.
  if (const std::smatch match = last_match(log, kBlocks); !match.empty()) {
    const std::size_t before = (std::max<std::size_t>(number(match[1]), 1) - 1) * number(match[4]) + number(match[3]);
    return {std::max<std::size_t>(before, 1) - 1, number(match[2]) * number(match[4])};
  }
  if (const std::smatch match = last_match(log, kFiles); !match.empty()) return {number(match[1]), number(match[2])};
  return {};
}

fs::path ColmapProgram::database(const fs::path& work) {
  return work / "database.db";
}

fs::path ColmapProgram::reconstructions(const fs::path& work) {
  return work / "reconstructions";
}

fs::path ColmapProgram::log(const fs::path& work, const std::string& step) {
  return work / "log" / (step + ".txt");
}

ColmapProgram::ColmapProgram(fs::path work) : program_(find_program("colmap")), work_(std::move(work)) {
  if (!program_.empty()) return;
  throw InputError(
      "colmap: no such program in PATH, and the poses of photographs are found by it: install COLMAP (on Debian "
      "`apt install colmap`)");
}

std::string ColmapProgram::help_of(const std::string& command) const {
  const fs::path text = log(work_, command + "-help");
  (void)run_to_end({program_, {command, "-h"}, text, text});
  return last_bytes(text, 1 << 16);
}

void ColmapProgram::run(const std::string& step, const std::vector<std::string>& arguments, std::size_t photographs,
                        const ColmapProgress& progress) const {
  run(step, program_, arguments, photographs, progress);
}

void ColmapProgram::run(const std::string& step, const fs::path& program, const std::vector<std::string>& arguments,
                        std::size_t photographs, const ColmapProgress& progress) const {
  constexpr auto kBetweenLooks = std::chrono::milliseconds(200);
  constexpr std::streamoff kTail = 1 << 14;
  const fs::path log_file = log(work_, step);
  auto next_look = std::chrono::steady_clock::now();
  const auto look = [&] {
    if (std::chrono::steady_clock::now() < next_look) return;
    next_look = std::chrono::steady_clock::now() + kBetweenLooks;
    const ColmapState state = colmap_state(last_bytes(log_file, kTail), photographs);
    if (progress) progress(state.done, state.of);
  };
  const int status = run_to_end({program, arguments, log_file, log_file}, look);
  if (status == 0) return show_end(colmap_state(last_bytes(log_file, kTail), photographs), progress);
  const std::string how = status < 0 ? "was ended by signal " + std::to_string(-status)
                                     : "failed with exit status " + std::to_string(status);
  const std::string said = last_told(last_bytes(log_file, kTail));
  throw InputError(program.filename().string() + " " + arguments.front() + " " + how +
                   (said.empty() ? "" : " and said '" + said + "'") + ": see " + log_file.string());
}

std::vector<ColmapProgram::ListedNames> ColmapProgram::lists_of(const std::vector<std::vector<std::string>>& lenses) {
  std::vector<ListedNames> lists;
  ListedNames alone{{}, lenses.size() == 1};
  for (const std::vector<std::string>& names : lenses) {
    if (names.size() > 1) {
      lists.push_back({names, true});
    } else {
      alone.names.insert(alone.names.end(), names.begin(), names.end());
    }
  }
  if (!alone.names.empty()) lists.push_back(std::move(alone));
  return lists;
}

void ColmapProgram::extract_features(const CapturedPhotographs& photographs,
                                     const std::vector<std::vector<std::string>>& lenses, const fs::path& masks,
                                     const ColmapOptions& options, const ColmapProgress& progress) const {
  const std::string help = help_of("feature_extractor");
  const std::size_t all = photographs.photographs.size();
  std::size_t before = 0;
  FeatureCounts found;
  for (const ListedNames& listed : lists_of(lenses)) {
    const fs::path list = work_ / "photographs.txt";
    std::string names;
    for (const std::string& name : listed.names) names += name + '\n';
    write_whole_file(list, names);
    std::vector<std::string> arguments{"feature_extractor",
                                       "--database_path",
                                       database(work_).string(),
                                       "--image_path",
                                       photographs.folder.string(),
                                       "--image_list_path",
                                       list.string(),
                                       "--ImageReader.camera_model",
                                       options.camera_model,
                                       "--ImageReader.single_camera",
                                       listed.one_lens ? "1" : "0"};
    if (!listed.one_lens) arguments.insert(arguments.end(), {"--ImageReader.single_camera_per_image", "1"});
    if (!masks.empty()) arguments.insert(arguments.end(), {"--ImageReader.mask_path", masks.string()});
    add_gpu(help, options.use_gpu, arguments);
    run("features", arguments, listed.names.size(), [&](std::size_t done, std::size_t of) {
      if (progress && of > 0) progress(before + done * listed.names.size() / of, all);
    });
    before += listed.names.size();
    const FeatureCounts counts = feature_counts(last_bytes(log(work_, "features"), kWholeLog));
    found.photographs += counts.photographs;
    found.without_features += counts.without_features;
  }
  if (found.photographs == 0 || found.without_features < found.photographs) return;
  throw InputError(photographs.given.string() + ": COLMAP found nothing that can be told apart in any of the " +
                   std::to_string(found.photographs) +
                   " photographs: they are blank, blurred or masked out; take sharp ones of what has texture (see " +
                   log(work_, "features").string() + ")");
}

void ColmapProgram::match_by(const std::string& command, std::vector<std::string> arguments, std::size_t photographs,
                             bool use_gpu, const ColmapProgress& progress) const {
  arguments.insert(arguments.begin(), {command, "--database_path", database(work_).string()});
  const std::string help = help_of(command);
  add_gpu(help, use_gpu, arguments);
  if (const std::string option = option_named(help, "block_size"); command == "exhaustive_matcher" && !option.empty()) {
    arguments.insert(arguments.end(), {option, block_size(photographs)});
  }
  run("matching", arguments, photographs, progress);
}

void ColmapProgram::match(const MatchingPlan& plan, std::size_t photographs, const ColmapOptions& options,
                          const ColmapProgress& progress) const {
  const auto match_with = [&](const std::string& command, std::vector<std::string> arguments) {
    match_by(command, std::move(arguments), photographs, options.use_gpu, progress);
  };
  if (plan.exhaustive) match_with("exhaustive_matcher", {});
  if (plan.by_order) match_with("sequential_matcher", {});
  if (plan.by_place) match_with("spatial_matcher", {});
  if (plan.vocabulary) {
    const std::string option = option_named(help_of("vocab_tree_matcher"), "vocab_tree_path");
    match_with("vocab_tree_matcher", {option.empty() ? "--VocabTreeMatching.vocab_tree_path" : option,
                                      fs::absolute(*plan.vocabulary).string()});
  }
  if (plan.links.size() < 2) return;
  const fs::path list = work_ / "links.txt";
  write_whole_file(list, list_of_links(plan));
  match_with("matches_importer", {"--match_list_path", list.string(), "--match_type", "pairs"});
}

ColmapProgram::Command ColmapProgram::mapper_command(Mapper mapper) const {
  if (mapper == Mapper::incremental) return {program_, "mapper"};
  const fs::path text = log(work_, "help");
  (void)run_to_end({program_, {"help"}, text, text});
  if (last_bytes(text, 1 << 16).find("global_mapper") != std::string::npos) return {program_, "global_mapper"};
  if (fs::path glomap = find_program("glomap"); !glomap.empty()) return {std::move(glomap), "mapper"};
  throw InputError(
      "--mapper global: the colmap in PATH has no global mapper (it comes with COLMAP 4), and there is no glomap: "
      "install one of them, or leave the option out");
}

void ColmapProgram::map(const CapturedPhotographs& photographs, bool exhaustive, Mapper mapper,
                        const ColmapProgress& progress) const {
  const auto fail_if_told = [&] {
    const std::string why = why_no_reconstruction(last_bytes(log(work_, "mapping"), kWholeLog), exhaustive);
    if (why.empty()) return;
    throw InputError(photographs.given.string() + ": COLMAP placed none of its " +
                     std::to_string(photographs.photographs.size()) + " photographs: " + why + " (see " +
                     log(work_, "mapping").string() + ")");
  };
  const Command command = mapper_command(mapper);
  try {
    run("mapping", command.program,
        {command.name, "--database_path", database(work_).string(), "--image_path", photographs.folder.string(),
         "--output_path", reconstructions(work_).string()},
        photographs.photographs.size(), progress);
  } catch (const InputError&) {
    fail_if_told();
    throw;
  }
  std::error_code ignored;
  if (fs::is_empty(reconstructions(work_), ignored)) fail_if_told();
}

void ColmapProgram::triangulate(const CapturedPhotographs& photographs, const fs::path& poses,
                                const ColmapProgress& progress) const {
  const fs::path output = reconstructions(work_) / "0";
  std::error_code error;
  fs::create_directories(output, error);
  if (error) throw InputError(output.string() + ": cannot be made (" + error.message() + ")");
  run("mapping",
      {"point_triangulator", "--database_path", database(work_).string(), "--image_path", photographs.folder.string(),
       "--input_path", poses.string(), "--output_path", output.string()},
      photographs.photographs.size(), progress);
}

}  // namespace lumatlas
