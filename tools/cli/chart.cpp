// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "blend/gl/egl_context.h"
#include "mesh/base/errors.h"
#include "tools/base/commit.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/base/process/machine.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/output/json_output.h"
#include "tools/lab/sweep/runner.h"
#include "tools/lab/sweep/scene_facts.h"
#include "tools/lab/sweep/shown/markdown.h"
#include "tools/lab/sweep/shown/page.h"
#include "tools/lab/sweep/shown/plot.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct ChartFlags {
  std::vector<std::string> sweeps;  // FILE or FILE#NAME
  fs::path output, scenes, markdown;
  std::size_t jobs = 1;
  std::vector<std::string> only;
  SweepScale scale = SweepScale::full;
  bool keep_points = false;
  bool list = false;
  bool json_output = false;
  bool quiet = false;
};

// The program's own commands, stopped before they do anything: what they accept, a sweep may ask for.
class Commands {
 public:
  Commands() {
    program_.formatter(std::make_shared<HelpFormatter>());
    program_.option_defaults()->always_capture_default();
    add_synth_command(program_);
    add_mesh_command(program_);
    add_build_command(program_);
    add_validate_command(program_);
    for (CLI::App* command : program_.get_subcommands({})) command->parse_complete_callback([] { throw Accepted(); });
  }

  // `name`: of an option, without dashes, or of a setting.
  [[nodiscard]] bool knows(const std::string& command, const std::string& name) const {
    const CLI::App& asked = *program_.get_subcommand(command);
    if (!is_setting(name)) return asked.get_option_no_throw("--" + name) != nullptr;
    const std::vector<ListedSetting>& settings = settings_of(asked);
    return std::any_of(settings.begin(), settings.end(), [&](const ListedSetting& row) { return row.name == name; });
  }

  // Throws InputError, with `place` first, if the command refuses them.
  void check(std::vector<std::string> arguments, const std::string& place) {
    const std::string command = arguments.front();
    if (!checked_.insert(shell_line("", arguments)).second) return;
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants a vector
    try {
      program_.parse(std::move(arguments));
    } catch (const Accepted&) {
      return;
    } catch (const CLI::ParseError& error) {
      throw InputError(place + ": " + command + ": " + error.what());
    }
  }

 private:
  struct Accepted {};

  CLI::App program_;
  std::set<std::string> checked_;
};

void append(std::vector<std::string>& arguments, const OptionValues& options) {
  const auto any = [] { return SceneFacts{1, 1, 1, 1}; };
  for (std::string& argument : arguments_of(resolved(options, "SCENE", any))) arguments.push_back(std::move(argument));
}

// Checks before anything runs. What only a scene can tell (a photograph that does not fit a budget) shows when its
// point runs.
void check_points(const Sweep& sweep, const fs::path& file, Commands& commands) {
  for (const SweepPoint& point : points_of(sweep)) {
    const std::string place = file.string() + ": " + point.name;
    try {
      std::vector<std::string> synth{"synth", point.kind, "--output=SCENE"};
      std::vector<std::string> build{"build", "SCENE", "--output=MODEL"};
      std::vector<std::string> validate{"validate", "MODEL", "--views=SCENE"};
      append(synth, point.synth);
      if (!point.mesh.empty()) {
        std::vector<std::string> mesh{"mesh", "SCENE", "--output=MESH.ply"};
        append(mesh, point.mesh);
        commands.check(mesh, place);
        build.emplace_back("--mesh=MESH.ply");
      }
      append(build, point.build);
      append(validate, point.validate);
      if (point.folder.empty()) commands.check(synth, place);
      commands.check(build, place);
      commands.check(validate, place);
    } catch (const InputError& error) {
      const std::string what = error.what();
      throw InputError(what.starts_with(place) ? what : std::string(place).append(": ").append(what));
    }
  }
}

// FILE#NAME is one sweep of a file that has several. A file that is called so itself is taken as it is.
struct SweepSource {
  fs::path file;
  std::string name;  // empty: all of the file's sweeps
};

SweepSource source_of(const std::string& text) {
  const std::size_t sign = text.rfind('#');
  if (sign == std::string::npos || fs::exists(text)) return {text, ""};
  return {text.substr(0, sign), text.substr(sign + 1)};
}

std::vector<Sweep> read_sweeps(const ChartFlags& flags) {
  Commands commands;
  const auto knows = [&](const std::string& command, const std::string& option) {
    return commands.knows(command, option);
  };
  std::vector<Sweep> sweeps;
  std::set<std::string> names;
  for (const std::string& text : flags.sweeps) {
    const SweepSource source = source_of(text);
    std::vector<Sweep> of_file = read_sweeps(source.file, flags.scale, knows);
    if (!source.name.empty()) of_file = {sweep_named(source.name, of_file, source.file)};
    for (Sweep& sweep : of_file) {
      check_points(sweep, source.file, commands);
      if (!names.insert(sweep.name).second) {
        throw InputError(source.file.string() + ": the name \"" + sweep.name + "\" is that of another of these sweeps");
      }
      sweeps.push_back(std::move(sweep));
    }
  }
  return sweeps;
}

void list_points(const std::vector<Sweep>& sweeps) {
  for (const Sweep& sweep : sweeps) {
    for (const SweepPoint& point : points_of(sweep)) std::cout << sweep.name << ": " << point.name << '\n';
  }
}

json listed(const std::vector<Sweep>& sweeps) {
  json all = json::array();
  for (const Sweep& sweep : sweeps) {
    json points = json::array();
    for (const SweepPoint& point : points_of(sweep)) points.push_back(point.name);
    all.push_back({{"name", sweep.name}, {"title", sweep.title}, {"points", std::move(points)}});
  }
  return {{"sweeps", std::move(all)}};
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> drawn(const Sweep& sweep, const std::vector<PointResult>& results, const fs::path& gnuplot,
                               const fs::path& folder) {
  const std::vector<Curve> curves = curves_of(sweep, results);
  std::vector<std::string> plots;
  for (std::size_t i = 0; i < sweep.plots.size(); ++i) {
    const fs::path svg = folder / (sweep.name + "-" + std::to_string(i + 1) + ".svg");
    const std::string script = gnuplot.empty() ? "" : plot_script(sweep, sweep.plots[i], curves, svg);
    if (!script.empty()) draw_plot(gnuplot, script, svg);
    plots.push_back(script.empty() ? "" : text_of(svg));
  }
  return plots;
}

std::string renderer() {
  try {
    return EglContext().description();
  } catch (const std::exception& error) {
    return std::string("none: ") + error.what();
  }
}

std::vector<std::pair<std::string, std::string>> facts_of(const ChartFlags& flags, const std::string& identity) {
  std::vector<std::string> arguments{"chart"};
  for (const std::string& sweep : flags.sweeps) arguments.push_back(sweep);
  arguments.push_back(std::string("--scale=") + name_of(flags.scale));
  if (flags.jobs > 1) arguments.push_back("--jobs=" + std::to_string(flags.jobs));
  return {{"program", "lumatlas " + identity},
          {"machine", machine_description()},
          {"renderer", renderer()},
          {"command", shell_line("lumatlas", arguments)}};
}

void write_results(const fs::path& folder, const SweepReport& report, const ChartPage& page) {
  AtomicFile csv(folder / (report.sweep.name + ".csv"));
  csv.stream() << results_csv(report.sweep, report.results);
  csv.commit();
  json all = results_json(report.sweep, report.results);
  for (const auto& [what, value] : page.facts) all[what] = value;
  write_json(folder / (report.sweep.name + ".json"), all);
}

struct Counts {
  std::size_t points = 0, done = 0, made = 0, failed = 0, skipped = 0;
  std::string first_failure;
};

void count(const SweepReport& report, Counts& counts) {
  using Status = PointResult::Status;
  for (const PointResult& result : report.results) {
    ++counts.points;
    counts.done += result.status == Status::done ? 1 : 0;
    counts.made += result.status == Status::done && result.made_now ? 1 : 0;
    counts.skipped += result.status == Status::skipped ? 1 : 0;
    if (result.status != Status::failed) continue;
    const std::string name = report.sweep.name + ": " + result.point.name + ": " + result.reason;
    if (++counts.failed == 1) counts.first_failure = name;
    std::cerr << "failed: " << name << '\n';
  }
}

void say_skipped(const SweepReport& report) {
  std::set<std::string> reasons;
  for (const PointResult& result : report.results) {
    if (result.status != PointResult::Status::skipped || !reasons.insert(result.reason).second) continue;
    std::cerr << "skipped: " << report.sweep.name << ": " << result.reason << '\n';
  }
}

ChartPage made_page(const ChartFlags& flags, const std::vector<Sweep>& sweeps, Counts& counts) {
  SweepRunOptions options;
  options.program = program_file();
  options.identity = program_identity(LUMATLAS_VERSION, kCommit, options.program);
  options.output = fs::absolute(flags.output);
  if (!flags.scenes.empty()) options.scenes = fs::absolute(flags.scenes);
  options.jobs = flags.jobs;
  options.keep_points = flags.keep_points;
  options.only = flags.only;
  options.quiet = flags.quiet;
  SweepRunner runner(options);
  ChartPage page;
  page.program = options.identity;
  page.facts = facts_of(flags, options.identity);
  const fs::path gnuplot = find_program("gnuplot");
  if (gnuplot.empty()) {
    page.notes.emplace_back("There are no plots, because there is no gnuplot: install it (on Debian: gnuplot-nox).");
  }
  if (flags.jobs > 1) {
    page.notes.push_back("Points were made " + std::to_string(flags.jobs) +
                         " side by side: the times of such points say little.");
  }
  for (const Sweep& sweep : sweeps) {
    SweepReport report{sweep, runner.run(sweep), {}};
    report.plots = drawn(sweep, report.results, gnuplot, options.output);
    write_results(options.output, report, page);
    count(report, counts);
    say_skipped(report);
    page.sweeps.push_back(std::move(report));
  }
  AtomicFile html(options.output / "index.html");
  html.stream() << chart_page(page);
  html.commit();
  if (!flags.markdown.empty()) update_markdown(flags.markdown, page);
  return page;
}

// A folder that `lumatlas chart` has worked in has points/. In any other folder, files with the names of figures belong
// to other work.
void check_replaceable_figures(const fs::path& folder, const std::vector<Sweep>& sweeps) {
  std::error_code ignored;
  if (fs::exists(folder / "points", ignored)) return;
  std::vector<std::string> names{"index.html"};
  for (const Sweep& sweep : sweeps) names.insert(names.end(), {sweep.name + ".csv", sweep.name + ".json"});
  for (const std::string& name : names) {
    if (!fs::exists(folder / name, ignored)) continue;
    throw InputError((folder / name).string() +
                     ": was not written by `lumatlas chart` and will not be replaced, name " +
                     "another folder or remove it");
  }
}

void run(const ChartFlags& flags) {
  if (flags.output.empty() && !flags.list) throw CLI::RequiredError("--output");
  const std::vector<Sweep> sweeps = read_sweeps(flags);
  if (flags.list) {
    flags.json_output ? print_json(listed(sweeps)) : list_points(sweeps);
    return;
  }
  std::vector<fs::path> files;
  for (const std::string& sweep : flags.sweeps) files.push_back(source_of(sweep).file);
  for (const Sweep& sweep : sweeps) check_apart(flags.output / (sweep.name + ".json"), files);
  check_replaceable_figures(flags.output, sweeps);
  Counts counts;
  const ChartPage page = made_page(flags, sweeps, counts);
  for (const std::string& note : page.notes) std::cerr << note << '\n';
  if (counts.failed > 0) {
    throw InputError(std::to_string(counts.failed) + " of " + std::to_string(counts.points) + " points failed, " +
                     (flags.output / "index.html").string() + " has the others; the first is " + counts.first_failure);
  }
  if (flags.json_output) {
    print_result(
        json{{"page", (flags.output / "index.html").string()},
             {"points",
              {{"all", counts.points}, {"done", counts.done}, {"made", counts.made}, {"skipped", counts.skipped}}},
             {"sweeps", listed(sweeps)["sweeps"]}},
        flags.output / "index.html");
    return;
  }
  const fs::path html = flags.output / "index.html";
  print_result(html.string() + ": " + std::to_string(counts.done) + " of " + std::to_string(counts.points) +
                   " points, made now " + std::to_string(counts.made) + ", skipped " + std::to_string(counts.skipped) +
                   '\n',
               html);
}

}  // namespace

void add_chart_command(CLI::App& program) {
  auto flags = std::make_shared<ChartFlags>();
  CLI::App* command = program.add_subcommand(
      "chart", "Make models with one setting changed at a time, as sweeps describe, score them, and plot the scores");
  command
      ->add_option("SWEEP", flags->sweeps,
                   "JSON files that describe sweeps, as in data/sweeps; FILE#NAME: one of several in a file")
      ->required()
      ->type_name("SWEEP")
      ->check(file_name())
      ->default_str("");
  begin_group(*command, "Models");
  add_choice(*command, "--scale", flags->scale,
             {{"small", SweepScale::small}, {"medium", SweepScale::medium}, {"full", SweepScale::full}},
             "Scenes and values: small for a quick check, medium for some hours, full for all");
  add_file(*command, "--scenes", flags->scenes, "DIR",
           "Folder of real scenes, each a COLMAP workspace with a mesh; points whose scene is not there are skipped");
  command
      ->add_option("--only", flags->only,
                   "Only points whose SCENE/SERIES/VALUE matches a pattern, '*/printed/*' for example; may be repeated")
      ->type_name("PATTERN")
      ->allow_extra_args(false)
      ->default_str("");
  command->add_flag("--keep-points", flags->keep_points,
                    "Also use finished points that another commit of the program made");
  command->add_option("--jobs", flags->jobs, "Number of points to make at once; above 1, measured times say little")
      ->type_name("N")
      ->transform(whole_number(1, 256));
  command->add_flag("--list", flags->list, "Only check the sweeps and print the names of their points");
  begin_group(*command, "Files and messages");
  add_file(*command, "-o,--output", flags->output, "DIR",
           "Folder of the page, index.html, and the figures; what was made in it before is not made again");
  add_file(*command, "--markdown", flags->markdown, "FILE",
           "Also put plots and tables into this page, between <!-- chart NAME --> and <!-- end of chart NAME -->");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
