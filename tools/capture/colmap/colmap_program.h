// SPDX-License-Identifier: GPL-3.0-or-later
// The COLMAP that is installed, as a program of its own: from photographs to poses and points.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/capture/colmap/matching_plan.h"
#include "tools/capture/sources/captured_photographs.h"

namespace lumatlas {

enum class Mapper {
  incremental,  // one photograph after another, COLMAP's own
  global,       // all at once, which is quicker for many: COLMAP's from 4.0 on, or the program GLOMAP
};

struct ColmapOptions {
  MatchingOptions matching;
  Mapper mapper = Mapper::incremental;
  std::string camera_model = "SIMPLE_RADIAL";  // every lens's model, by COLMAP's name, see lens_model(); no panorama
  bool use_gpu = false;                        // COLMAP must have been built for one, and find it
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const ColmapOptions& options);

// Called with how many of all steps of a command are done, as COLMAP's log tells.
using ColmapProgress = std::function<void(std::size_t done, std::size_t of)>;

class ColmapProgram {
 public:
  // `work` is the folder of database.db, reconstructions/ and log/. Throws InputError where PATH has no `colmap`,
  // saying how to install it.
  explicit ColmapProgram(std::filesystem::path work);

  // The three commands, each with its arguments beyond those that name files. They throw InputError, with the last
  // line that COLMAP wrote and its log, where COLMAP fails, and Interrupted, once it has ended.
  //
  // `lenses`: the names by lens, see names_by_lens(); COLMAP runs once for each lens of several photographs, and once
  // for all others, each of which gets a lens of its own. `masks`: a folder with NAME.png for photographs NAME, black
  // where no features are to be looked for; empty: there are none. Throws InputError, too, where no features were
  // found.
  void extract_features(const CapturedPhotographs& photographs, const std::vector<std::vector<std::string>>& lenses,
                        const std::filesystem::path& masks, const ColmapOptions& options,
                        const ColmapProgress& progress) const;
  void match(const MatchingPlan& plan, std::size_t photographs, const ColmapOptions& options,
             const ColmapProgress& progress) const;
  // `exhaustive`: how photographs were matched, for what to do where none is placed, which throws InputError, as does a
  // global mapper that is not installed.
  void map(const CapturedPhotographs& photographs, bool exhaustive, Mapper mapper,
           const ColmapProgress& progress) const;
  // Throws InputError where the mapper is not installed.
  void require(Mapper mapper) const { (void)mapper_command(mapper); }
  // Instead of map(): finds points by the poses of the COLMAP model in the folder `poses`, and leaves all of it in
  // reconstructions/0. Poses and lenses stay as they are.
  void triangulate(const CapturedPhotographs& photographs, const std::filesystem::path& poses,
                   const ColmapProgress& progress) const;

  [[nodiscard]] static std::filesystem::path database(const std::filesystem::path& work);
  [[nodiscard]] static std::filesystem::path reconstructions(const std::filesystem::path& work);
  // Returns the log of the step "features", "matching" or "mapping".
  [[nodiscard]] static std::filesystem::path log(const std::filesystem::path& work, const std::string& step);

 private:
  struct ListedNames {
    std::vector<std::string> names;
    bool one_lens;
  };
  [[nodiscard]] static std::vector<ListedNames> lists_of(const std::vector<std::vector<std::string>>& lenses);
  [[nodiscard]] std::string help_of(const std::string& command) const;
  // Runs `command` of COLMAP on its database, with `arguments` besides, as a part of matching.
  void match_by(const std::string& command, std::vector<std::string> arguments, std::size_t photographs, bool use_gpu,
                const ColmapProgress& progress) const;
  struct Command {
    std::filesystem::path program;
    std::string name;
  };
  [[nodiscard]] Command mapper_command(Mapper mapper) const;
  void run(const std::string& step, const std::vector<std::string>& arguments, std::size_t photographs,
           const ColmapProgress& progress) const;
  void run(const std::string& step, const std::filesystem::path& program, const std::vector<std::string>& arguments,
           std::size_t photographs, const ColmapProgress& progress) const;

  std::filesystem::path program_, work_;
};

// The progress of a command by its log: the last "[3/16]", the last "[2/4, 1/4]" or the largest "Registering image
// #12 (3)" of it; 0 of 0: it says nothing yet. `photographs` is what the last one is out of.
struct ColmapState {
  std::size_t done = 0, of = 0;
  bool counts_places = false;  // counts placed photographs, which need not become all
};
[[nodiscard]] ColmapState colmap_state(const std::string& log, std::size_t photographs);

}  // namespace lumatlas
