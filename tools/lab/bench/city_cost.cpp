// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of cities by photographs and faces, from the jobs of plans that were joined, and the time that a city of
// any size would take on machines that share a disk. Tables go to stdout, or JSON.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/city/city_plan.h"
#include "tools/city/job_cost.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/cluster/cluster_simulation.h"
#include "tools/lab/cluster/cost_fit.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Flags {
  std::vector<std::string> plans;
  double photographs = 100'000, faces = 1e9, block_faces = 1.5e6;
  std::vector<std::size_t> machines{1, 10, 100};
  std::size_t cores = 8;
  double memory_gb = 32, disk_mb_per_s = 1000;
  bool json_output = false;
};

// A job's measured cost, and what it depends on.
struct MeasuredJob {
  double photographs, faces;
  JobCost cost;
};

// The kinds of jobs: one plan, its blocks, the block of the far sphere, and the join.
enum class Kind { plan, block, far, join };
constexpr std::array kKinds{std::pair{"plan", Kind::plan}, std::pair{"block", Kind::block},
                            std::pair{"far sphere", Kind::far}, std::pair{"join", Kind::join}};

struct Measured {
  std::array<std::vector<MeasuredJob>, kKinds.size()> jobs;
  double uses = 0;  // blocks that a photograph is in, the largest plan's

  [[nodiscard]] std::vector<MeasuredJob>& of(Kind kind) { return jobs.at(static_cast<std::size_t>(kind)); }
  [[nodiscard]] const std::vector<MeasuredJob>& of(Kind kind) const { return jobs.at(static_cast<std::size_t>(kind)); }
};

JobCost cost_in(const fs::path& plan, const std::string& name) {
  if (const std::optional<JobCost> cost = read_job_cost(plan, name)) return *cost;
  throw InputError((plan / "costs").string() + ": says nothing of " + name +
                   ": plan with `lumatlas city SCENE --plan " + plan.string() + "`, and join with `lumatlas city " +
                   plan.string() + " -o MODEL`");
}

void add_plan(const fs::path& folder, Measured& measured, double& most_faces) {
  const CityPlan plan = read_city_plan(folder);
  double faces = 0, uses = 0;
  for (const CityBlock& block : plan.blocks) {
    if (block.far) continue;
    faces += static_cast<double>(block.size.faces);
    uses += static_cast<double>(block.views.size());
  }
  const auto photographs = static_cast<double>(plan.views.size());
  for (std::size_t number = 0; number < plan.blocks.size(); ++number) {
    const CityBlock& block = plan.blocks[number];
    const double own = block.far ? faces : static_cast<double>(block.size.faces);
    measured.of(block.far ? Kind::far : Kind::block)
        .push_back({static_cast<double>(block.views.size()), own, cost_in(folder, std::to_string(number))});
  }
  measured.of(Kind::plan).push_back({photographs, faces, cost_in(folder, "plan")});
  measured.of(Kind::join).push_back({photographs, faces, cost_in(folder, "join")});
  if (faces > most_faces && photographs > 0) {
    most_faces = faces;
    measured.uses = uses / photographs;
  }
}

struct JobFit {
  CostFit processor_s, peak_bytes, read_bytes, written_bytes;

  [[nodiscard]] ClusterJob at(double photographs, double faces) const {
    return {processor_s.at(photographs, faces), peak_bytes.at(photographs, faces), read_bytes.at(photographs, faces),
            written_bytes.at(photographs, faces)};
  }
};

template <typename Value>
CostFit fit_of(const std::vector<MeasuredJob>& jobs, Value JobCost::*value) {
  std::vector<CostSample> samples;
  samples.reserve(jobs.size());
  for (const MeasuredJob& job : jobs) {
    samples.push_back({job.photographs, job.faces, static_cast<double>(job.cost.*value)});
  }
  return fitted_cost(samples);
}

JobFit fit_of(const std::vector<MeasuredJob>& jobs) {
  return {fit_of(jobs, &JobCost::processor_s), fit_of(jobs, &JobCost::peak_bytes), fit_of(jobs, &JobCost::read_bytes),
          fit_of(jobs, &JobCost::written_bytes)};
}

using Fits = std::array<JobFit, kKinds.size()>;

const JobFit& of(const Fits& fits, Kind kind) {
  return fits.at(static_cast<std::size_t>(kind));
}

ClusterCity city_of(const Fits& fits, const Measured& measured, const Flags& flags) {
  ClusterCity city;
  city.plan = of(fits, Kind::plan).at(flags.photographs, flags.faces);
  city.join = of(fits, Kind::join).at(flags.photographs, flags.faces);
  const double blocks = std::ceil(flags.faces / flags.block_faces);
  const double each = flags.photographs * measured.uses / blocks;
  city.blocks.assign(static_cast<std::size_t>(blocks), of(fits, Kind::block).at(each, flags.faces / blocks));
  if (!measured.of(Kind::far).empty()) city.blocks.push_back(of(fits, Kind::far).at(each, flags.faces));
  return city;
}

// The units in which tables have a cost: its name, and how many of the cost are one.
struct Unit {
  const char* name;
  CostFit JobFit::*fit;
  double size;
  int digits;
};
constexpr std::array kUnits{
    Unit{"processor time, s", &JobFit::processor_s, 1, 2}, Unit{"peak memory, MB", &JobFit::peak_bytes, 1e6, 0},
    Unit{"read, MB", &JobFit::read_bytes, 1e6, 0}, Unit{"written, MB", &JobFit::written_bytes, 1e6, 0}};

void print_fits(const Fits& fits) {
  std::cout << "| job | cost | each job | 1000 photographs | a million faces |\n|---|---|---|---|---|\n";
  for (const auto& [name, kind] : kKinds) {
    for (const Unit& unit : kUnits) {
      const CostFit& fit = of(fits, kind).*unit.fit;
      std::cout << "| " << name << " | " << unit.name << " | " << number_text(fit.per_job / unit.size, unit.digits)
                << " | " << number_text(1e3 * fit.per_photograph / unit.size, unit.digits) << " | "
                << number_text(1e6 * fit.per_face / unit.size, unit.digits) << " |\n";
    }
  }
}

json fit_json(const JobFit& fit) {
  json result;
  const auto add = [&](const char* name, const CostFit& cost) {
    result[name] = {{"job", cost.per_job}, {"photograph", cost.per_photograph}, {"face", cost.per_face}};
  };
  add("processor_s", fit.processor_s);
  add("peak_bytes", fit.peak_bytes);
  add("read_bytes", fit.read_bytes);
  add("written_bytes", fit.written_bytes);
  return result;
}

json runs_json(const ClusterCity& city, const Flags& flags) {
  json runs = json::array();
  for (const std::size_t machines : flags.machines) {
    const Cluster cluster{machines, flags.cores, 1e9 * flags.memory_gb, 1e6 * flags.disk_mb_per_s};
    json run{{"machines", machines}};
    try {
      const ClusterRun times = simulated_run(city, cluster);
      run["plan_s"] = times.plan_s;
      run["blocks_s"] = times.blocks_s;
      run["join_s"] = times.join_s;
      run["total_s"] = times.total_s();
      for (const ClusterBound& bound : bounds_of(city, cluster)) {
        run["bounds"].push_back({{"name", bound.name}, {"gain_s", bound.gain_s}});
      }
    } catch (const std::invalid_argument& error) {
      run["refused"] = error.what();
    }
    runs.push_back(std::move(run));
  }
  return runs;
}

void print_runs(const json& runs) {
  std::cout << "\n| machines | plan, h | blocks, h | join, h | in all, h | what limits first, and what it costs |\n"
               "|---|---|---|---|---|---|\n";
  const auto hours = [](const json& seconds) { return number_text(seconds.get<double>() / 3600, 2); };
  for (const json& run : runs) {
    std::cout << "| " << run["machines"];
    if (run.contains("refused")) {
      std::cout << " | | | | | " << run["refused"].get<std::string>() << " |\n";
      continue;
    }
    const json& first = run["bounds"][0];
    std::cout << " | " << hours(run["plan_s"]) << " | " << hours(run["blocks_s"]) << " | " << hours(run["join_s"])
              << " | " << hours(run["total_s"]) << " | " << first["name"].get<std::string>() << ", "
              << hours(first["gain_s"]) << " |\n";
  }
}

void run(const Flags& flags) {
  Measured measured;
  double most_faces = 0;
  for (const std::string& plan : flags.plans) add_plan(plan, measured, most_faces);
  Fits fits;
  for (std::size_t kind = 0; kind < fits.size(); ++kind) fits.at(kind) = fit_of(measured.jobs.at(kind));
  const ClusterCity city = city_of(fits, measured, flags);
  const json runs = runs_json(city, flags);
  if (flags.json_output) {
    json result{{"uses", measured.uses}, {"blocks", city.blocks.size()}, {"runs", runs}};
    for (const auto& [name, kind] : kKinds) result["fits"][name] = fit_json(of(fits, kind));
    std::cout << result.dump(2) << '\n';
    return;
  }
  print_fits(fits);
  std::cout << "\nA photograph is in " << number_text(measured.uses, 1) << " blocks; " << city.blocks.size()
            << " blocks of " << number_text(city.blocks.front().peak_bytes / 1e9, 1) << " GB; plan and join take "
            << number_text(city.plan.peak_bytes / 1e9, 1) << " and " << number_text(city.join.peak_bytes / 1e9, 1)
            << " GB.\n";
  print_runs(runs);
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Cost of cities by photographs and faces, and their time on a cluster, simulated");
  program.option_defaults()->always_capture_default();
  lumatlas::Flags flags;
  program.add_option("PLAN", flags.plans, "Plans of `lumatlas city SCENE --plan PLAN`, joined by `city PLAN -o MODEL`")
      ->required();
  program.add_option("--photographs", flags.photographs, "Of the simulated city")->check(CLI::Range(1.0, 1e9));
  program.add_option("--faces", flags.faces, "Of the simulated city")->check(CLI::Range(1.0, 1e12));
  program.add_option("--block-faces", flags.block_faces, "Faces of a block")->check(CLI::Range(1e3, 1e9));
  program.add_option("--machines", flags.machines, "Numbers of machines")
      ->delimiter(',')
      ->check(CLI::Range(1u, 100000u));
  program.add_option("--cores", flags.cores, "Cores of a machine; a job uses one")->check(CLI::Range(1u, 1024u));
  program.add_option("--memory", flags.memory_gb, "Memory of a machine, GB")->check(CLI::Range(1e-3, 1e5));
  program.add_option("--disk", flags.disk_mb_per_s, "Speed of the disk that all share, MB a second")
      ->check(CLI::Range(1e-3, 1e9));
  program.add_flag("--json", flags.json_output, "Print JSON");
  return lumatlas::run_program(program, "bench_city_cost", argc, argv, [&] { lumatlas::run(flags); });
}
