// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps: models of the same scenes made again and again with one thing changed, and what is to be shown of them. Read
// from JSON files, see tools/lab/sweep/README.md.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace lumatlas {

// The value of an option of the program. A text that begins with '=' stands for a quantity of the scene, see
// tools/lab/sweep/scene_facts.h.
struct OptionValue {
  bool given = true;                // false: takes back what was given before
  std::optional<std::string> text;  // none: a flag

  bool operator==(const OptionValue&) const = default;
};

// Values by name: an option's without dashes, or a setting's, which has a point in it.
using OptionValues = std::map<std::string, OptionValue>;

// Returns whether a name is that of a setting, "coverage.metric", rather than of an option.
[[nodiscard]] bool is_setting(const std::string& name);

// Options of the commands that make a point.
struct CommandOptions {
  OptionValues synth;
  OptionValues mesh;  // of the scene's photographs, points or depth images; none: the scene's own mesh is used
  OptionValues build, validate;
};

// Replaces options of `options` by those of `over` with the same names.
void overlay(CommandOptions& options, const CommandOptions& over);

// "--name=text" or "--name", and "--set=name=text" for settings, for those that are given, by name.
[[nodiscard]] std::vector<std::string> arguments_of(const OptionValues& options);

struct SweepScene {
  std::string name;
  std::string folder;      // below the folder of scenes; empty: it is synthetic
  std::string kind;        // as `lumatlas synth` knows it; empty: it is a folder
  CommandOptions options;  // synth: of the scene
};

struct SweepValue {
  std::string label;        // "1/60"
  std::optional<double> x;  // where it stands on an axis of numbers
  CommandOptions options;
};

struct SweepSeries {
  enum class Mark { none, is_default, printed };

  std::string label;
  Mark mark = Mark::none;
  bool once = false;  // it does not depend on the order of the stream: not repeated
  CommandOptions options;
  std::vector<SweepValue> values;  // at least one
};

struct SweepLine {
  bool on_x = false;  // at this x, else at this y
  double at = 0;
  std::string label;
};

struct SweepPlot {
  std::string title;
  std::string x;               // "value", "label" (evenly spaced), or a metric's name
  std::vector<std::string> y;  // metrics, one row each
  bool log_x = false, log_y = false;
  bool front = false;  // draw what no other point beats in both x and y; of metrics only
  std::vector<SweepLine> lines;
};

// The rule by which a method breaks: at the first value at which the metric is worse by `fall` than at the first value.
struct SweepBreaking {
  std::string metric;
  double fall = 1;  // > 0, in the metric's unit
};

struct Sweep {
  std::string name;      // of files: a-z, 0-9 and '-'
  std::string title;     // for people
  std::string source;    // which figure or section of the paper; empty: none
  std::string expected;  // one sentence
  std::string label;     // of the swept values
  std::vector<SweepScene> scenes;
  std::vector<SweepSeries> series;
  CommandOptions options;   // of all points, before those of scene, series and value
  std::size_t repeats = 0;  // by shuffled orders with the seeds 1 and up; 0: once, in the given order
  bool scored_undisturbed =
      false;  // against the scene's own photographs, without the synth options of series and value
  std::vector<std::string> metrics;  // of the table
  std::vector<SweepPlot> plots;
  std::optional<SweepBreaking> breaking;
};

// small: tiny scenes, to see that it works; medium: hours for all of data/sweeps; full: most of a day. What a
// file has no medium of, it takes from full.
enum class SweepScale { small, medium, full };

[[nodiscard]] const char* name_of(SweepScale scale);

// Returns whether a command ("synth", "mesh", "build" or "validate") has an option (without dashes) or a setting of
// this name.
using KnowsOption = std::function<bool(const std::string& command, const std::string& option)>;

// Reads what a file describes at one scale: one sweep, {"name": ..., "scenes": ..., ...}, or several,
//   {"common": {...}, "sweeps": [{"name": ...}, ...]},
// each of which has the members of "common", which may be missing, that it does not have itself; their names differ.
// Throws InputError by file and place for whatever is missing, unknown, of the wrong type or contradictory.
[[nodiscard]] std::vector<Sweep> read_sweeps(const std::filesystem::path& path, SweepScale scale,
                                             const KnowsOption& knows_option);

// Returns the sweep of this name among several. Throws InputError naming `file` and those that there are.
[[nodiscard]] Sweep sweep_named(const std::string& name, const std::vector<Sweep>& sweeps,
                                const std::filesystem::path& file);

}  // namespace lumatlas
