// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of planning: what a view costs before its photograph is looked at, and whether that stays the same however
// long the stream is. Tables in Markdown go to stdout, progress to stderr; exit status as of lumatlas itself.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tools/cli/flags/option_rules.h"
#include "tools/lab/bench/planning_time.h"
#include "tools/lab/bench/program.h"

namespace lumatlas {

namespace {

struct PlannerFlags {
  std::uint32_t views = 100;
  std::uint32_t visibility_px = PlannerOptions{}.visibility_px;

  void add_to(CLI::App& command) {
    command.add_option("--views", views, "N, views in the store")->check(CLI::Range(1u, 100000u));
    command.add_option("--visibility", visibility_px, "Longer side of the image that cells are counted in, pixels")
        ->check(CLI::Range(1u, 65536u));
  }
  [[nodiscard]] PlannerOptions options(std::uint32_t references) const {
    PlannerOptions options;
    options.visibility_px = visibility_px;
    options.coverage.max_references = references;
    return options;
  }
};

struct TimeFlags {
  std::vector<std::filesystem::path> scenes;
  std::vector<double> millions;
  std::vector<std::uint32_t> references{8, 16, 32, 60};
  PlannerFlags planner;
};

struct StreamFlags {
  double millions = 1.6;
  std::uint32_t references = CoverageOptions{}.max_references;
  PlannerFlags planner;
};

double visibility_of(const PlannedTime& time) {
  return time.visibility_ms;
}
double decision_of(const PlannedTime& time) {
  return time.decision_ms;
}
double planning_of(const PlannedTime& time) {
  return time.planning_ms();
}

double cpu_of(const PlannedTime& time) {
  return time.cpu_ms;
}

bool is_stored(const PlannedTime& time) {
  return time.decision != Decision::rejected;
}

std::vector<PlannedTime> not_stored(std::vector<PlannedTime> times) {
  std::erase_if(times, is_stored);
  return times;
}

std::string number(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << value;
  return text.str();
}

std::string text_of(const Spread& spread) {
  return number(spread.median, 1) + " / " + number(spread.p95, 1);
}

void print_head(const std::vector<std::uint32_t>& references) {
  std::cout << "| surface | ms a view, median / 95th percentile |";
  for (const std::uint32_t r : references) std::cout << " R = " << r << " |";
  std::cout << "\n|---|---|";
  for (std::size_t i = 0; i < references.size(); ++i) std::cout << "---|";
  std::cout << '\n';
}

// Erat et al. 2019, Table 2, left half.
struct PaperRow {
  const char* name;
  std::map<std::uint32_t, double> ms;  // for each R
};
const std::vector<PaperRow>& paper_rows() {
  static const std::vector<PaperRow> rows = {
      {"village, 6.1 M triangles", {{8, 4.2}, {16, 4.5}, {32, 6.3}, {60, 22.7}}},
      {"apartment, 1.6 M triangles", {{8, 3.1}, {16, 3.1}, {32, 8.7}, {60, 16.9}}},
      {"city wall, 10.3 M triangles", {{8, 37.5}, {16, 53.5}, {32, 70.4}, {60, 104.2}}},
      {"lab, 1.6 M triangles", {{8, 2.1}, {16, 15.2}, {32, 44.2}, {60, 63.3}}},
  };
  return rows;
}

void print_paper(const std::vector<std::uint32_t>& references) {
  for (const PaperRow& row : paper_rows()) {
    std::cout << "| *the paper's " << row.name << "* | both |";
    for (const std::uint32_t r : references) {
      const auto known = row.ms.find(r);
      std::cout << ' ' << (known == row.ms.end() ? "-" : number(known->second, 1)) << " |";
    }
    std::cout << '\n';
  }
}

void print_times(const PlanningScene& scene, const TimeFlags& flags) {
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(scene.surface->mesh);
  std::vector<std::vector<PlannedTime>> runs;
  for (const std::uint32_t references : flags.references) {
    runs.push_back(time_planning(scene, *visibility, flags.planner.options(references), flags.planner.views));
  }
  const std::string surface = scene.name + ": " + std::to_string(scene.surface->mesh.faces.size()) + " triangles, " +
                              std::to_string(scene.surface->cells.cells.size()) + " cells, " +
                              std::to_string(scene.cameras.size()) + " views";
  const auto print_row = [&](const std::string& name, const char* what, double (*value)(const PlannedTime&)) {
    std::cout << "| " << name << " | " << what << " |";
    for (const std::vector<PlannedTime>& run : runs) std::cout << ' ' << text_of(spread(run, value)) << " |";
    std::cout << '\n';
  };
  print_row(surface, "visibility", visibility_of);
  print_row("", "decision", decision_of);
  print_row("", "both", planning_of);
  for (std::vector<PlannedTime>& run : runs) run = not_stored(std::move(run));
  print_row("", "both, CPU time of the views not stored", cpu_of);
  std::cout << std::flush;
}

void run_time(const TimeFlags& flags) {
  constexpr std::uint32_t kMostTimedViews = 500;
  std::vector<double> millions = flags.millions;
  if (millions.empty() && flags.scenes.empty()) millions = {1.6, 6.1, 10.3};
  print_head(flags.references);
  for (const std::filesystem::path& folder : flags.scenes) {
    print_times(load_planning_scene(folder, kMostTimedViews), flags);
  }
  for (const double size : millions) {
    ApartmentOptions apartment;
    apartment.triangles = static_cast<std::uint32_t>(std::lround(1e6 * size));
    apartment.views_per_lap = kMostTimedViews;
    print_times(make_planning_scene(apartment), flags);
  }
  print_paper(flags.references);
}

std::string middle_memory(std::span<const PlannedTime> window) {
  constexpr double kMebibyte = 1 << 20;
  return number(static_cast<double>(window[window.size() / 2].resident_bytes) / kMebibyte, 1);
}

void print_window(const char* name, const std::vector<PlannedTime>& window) {
  std::cout << "| " << name;
  for (const auto value : {visibility_of, decision_of, planning_of})
    std::cout << " | " << text_of(spread(window, value));
  std::cout << " | " << text_of(spread(not_stored(window), cpu_of)) << " | "
            << std::count_if(window.begin(), window.end(), is_stored) << " | " << middle_memory(window) << " |\n";
}

void run_stream(const StreamFlags& flags) {
  ApartmentOptions apartment;
  apartment.triangles = static_cast<std::uint32_t>(std::lround(1e6 * flags.millions));
  apartment.width = 320;  // small photographs, because storing is not what is measured
  apartment.height = 240;
  apartment.laps = 11;
  const PlanningScene scene = make_planning_scene(apartment);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(scene.surface->mesh);
  const std::vector<PlannedTime> times =
      time_planning(scene, *visibility, flags.planner.options(flags.references), flags.planner.views);
  // Nine laps apart: the same stretch of the walk.
  const std::vector<PlannedTime> early(times.begin() + 400, times.begin() + 600);
  const std::vector<PlannedTime> late(times.begin() + 4900, times.begin() + 5100);
  std::cout
      << "| views | visibility, ms | decision, ms | both, ms | both, CPU time of the views not stored, ms | stored | "
         "resident, MiB |\n|---|---|---|---|---|---|---|\n";
  print_window("400 to 599", early);
  print_window("4900 to 5099", late);
  std::cout << "| ratio of medians |";
  for (const auto value : {visibility_of, decision_of, planning_of}) {
    std::cout << ' ' << number(spread(late, value).median / spread(early, value).median, 3) << " |";
  }
  const double cpu = spread(not_stored(late), cpu_of).median / spread(not_stored(early), cpu_of).median;
  const double memory = static_cast<double>(late[100].resident_bytes) / static_cast<double>(early[100].resident_bytes);
  std::cout << ' ' << number(cpu, 3) << " | | " << number(memory, 3) << " |\n";
}

void add_time_command(CLI::App& program, TimeFlags& flags) {
  CLI::App* command = program.add_subcommand("time", "Time of planning a view, 500 views of each surface at most");
  command->add_option("SCENE", flags.scenes, "COLMAP workspaces with a mesh");
  command
      ->add_option("--triangles", flags.millions,
                   "A synthetic apartment of this many millions; may be repeated; 1.6, 6.1 and 10.3 without a SCENE")
      ->allow_extra_args(false)
      ->check(number_between(0.03, 20));
  command->add_option("--references", flags.references, "R, references per cell, once for each")
      ->allow_extra_args(false)
      ->check(CLI::Range(1u, 1000u));
  flags.planner.add_to(*command);
  command->callback([&flags] { run_time(flags); });
}

void add_stream_command(CLI::App& program, StreamFlags& flags) {
  CLI::App* command =
      program.add_subcommand("stream", "Whether time and memory grow in a stream of 5500 views, 11 laps of a walk");
  command->add_option("--triangles", flags.millions, "Of the synthetic apartment, millions")
      ->check(number_between(0.03, 20));
  command->add_option("--references", flags.references, "R, references per cell")->check(CLI::Range(1u, 1000u));
  flags.planner.add_to(*command);
  command->callback([&flags] { run_stream(flags); });
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of lumatlas's view planning");
  program.option_defaults()->always_capture_default();
  program.require_subcommand(1);
  lumatlas::TimeFlags time;
  lumatlas::StreamFlags stream;
  lumatlas::add_time_command(program, time);
  lumatlas::add_stream_command(program, stream);
  return lumatlas::run_program(program, "bench_planner", argc, argv);
}
