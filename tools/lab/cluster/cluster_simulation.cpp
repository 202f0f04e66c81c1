// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/cluster/cluster_simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

void check_cluster(const Cluster& cluster) {
  if (cluster.machines < 1 || cluster.cores < 1) throw std::invalid_argument("cluster: has no machine or no core");
  if (!(cluster.memory_bytes > 0)) throw std::invalid_argument("cluster: memory must be above 0");
  if (!(cluster.disk_bytes_per_s > 0)) throw std::invalid_argument("cluster: the disk's speed must be above 0");
}

struct Machine {
  std::size_t free_cores;
  double free_bytes;
};

struct RunningJob {
  std::size_t machine;
  double peak_bytes;
  std::array<double, 3> left;  // bytes to read, seconds to compute, bytes to write
  std::size_t step = 0;        // of `left`

  [[nodiscard]] bool uses_disk() const { return step != 1; }
  // Goes on to the next step that is not empty. Returns whether there is one.
  bool advance() {
    while (step < left.size() && left[step] <= 0) ++step;
    return step < left.size();
  }
};

// The jobs of one part, all of which may run at once.
class Stage {
 public:
  Stage(const std::vector<ClusterJob>& jobs, const Cluster& cluster)
      : disk_bytes_per_s_(cluster.disk_bytes_per_s),
        waiting_(jobs),
        machines_(std::min(cluster.machines, std::max<std::size_t>(1, jobs.size())),
                  Machine{cluster.cores, cluster.memory_bytes}) {}

  double run() {
    double now = 0;
    for (begin_jobs(); !running_.empty(); begin_jobs()) now += step();
    return now;
  }

 private:
  // Begins each waiting job for which a machine has room, in their order.
  void begin_jobs() {
    std::vector<ClusterJob> still;
    bool has_cores = true;
    for (const ClusterJob& job : waiting_) {
      has_cores =
          has_cores && std::any_of(machines_.begin(), machines_.end(), [](auto& m) { return m.free_cores > 0; });
      const auto machine = std::find_if(machines_.begin(), machines_.end(), [&](const Machine& m) {
        return has_cores && m.free_cores > 0 && m.free_bytes >= job.peak_bytes;
      });
      if (machine == machines_.end()) {
        still.push_back(job);
        continue;
      }
      RunningJob running{static_cast<std::size_t>(machine - machines_.begin()),
                         job.peak_bytes,
                         {job.read_bytes, job.processor_s, job.written_bytes}};
      if (!running.advance()) continue;  // it takes no time
      --machine->free_cores;
      machine->free_bytes -= job.peak_bytes;
      running_.push_back(running);
    }
    waiting_ = std::move(still);
  }

  // Goes on until a job ends a step of its own, and returns how long that takes.
  double step() {
    const auto on_disk = std::count_if(running_.begin(), running_.end(), [](auto& job) { return job.uses_disk(); });
    const auto rate = [&](const RunningJob& job) {
      return job.uses_disk() ? disk_bytes_per_s_ / static_cast<double>(on_disk) : 1.0;
    };
    double time = kEndless;
    for (const RunningJob& job : running_) time = std::min(time, job.left[job.step] / rate(job));
    for (RunningJob& job : running_) {
      double& left = job.left[job.step];
      // Jobs that end together end at once, whatever rounding says.
      left = left / rate(job) <= time * (1 + 1e-12) ? 0 : left - time * rate(job);
    }
    std::erase_if(running_, [&](RunningJob& job) {
      if (job.advance()) return false;
      ++machines_[job.machine].free_cores;
      machines_[job.machine].free_bytes += job.peak_bytes;
      return true;
    });
    return time;
  }

  double disk_bytes_per_s_;
  std::vector<ClusterJob> waiting_;
  std::vector<Machine> machines_;
  std::vector<RunningJob> running_;
};

void require_fits(const ClusterJob& job, const Cluster& cluster, const std::string& name) {
  if (job.peak_bytes <= cluster.memory_bytes) return;
  throw std::invalid_argument(name + " takes " + number_text(job.peak_bytes / 1e9, 1) +
                              " GB of memory, a machine has " + number_text(cluster.memory_bytes / 1e9, 1) + " GB");
}

ClusterJob mean_of(const std::vector<ClusterJob>& jobs) {
  ClusterJob mean;
  const double share = 1 / static_cast<double>(jobs.size());
  for (const ClusterJob& job : jobs) {
    mean.processor_s += share * job.processor_s;
    mean.peak_bytes += share * job.peak_bytes;
    mean.read_bytes += share * job.read_bytes;
    mean.written_bytes += share * job.written_bytes;
  }
  return mean;
}

}  // namespace

ClusterRun simulated_run(const ClusterCity& city, const Cluster& cluster) {
  check_cluster(cluster);
  require_fits(city.plan, cluster, "the plan");
  for (std::size_t i = 0; i < city.blocks.size(); ++i) {
    require_fits(city.blocks[i], cluster, "block " + std::to_string(i));
  }
  require_fits(city.join, cluster, "the join");
  return {Stage({city.plan}, cluster).run(), Stage(city.blocks, cluster).run(), Stage({city.join}, cluster).run()};
}

std::vector<ClusterBound> bounds_of(const ClusterCity& city, const Cluster& cluster) {
  const double total = simulated_run(city, cluster).total_s();
  std::vector<ClusterBound> bounds;
  const auto add = [&](const char* name, const ClusterCity& other, const Cluster& machines) {
    bounds.push_back({name, std::max(0.0, total - simulated_run(other, machines).total_s())});
  };
  ClusterCity other = city;
  other.plan = {};
  add("plan", other, cluster);
  other = city;
  other.join = {};
  add("join", other, cluster);
  Cluster machines = cluster;
  machines.disk_bytes_per_s = kEndless;
  add("disk", city, machines);
  machines = cluster;
  machines.machines = std::max<std::size_t>(1, city.blocks.size());
  add("processors", city, machines);
  machines = cluster;
  machines.memory_bytes = kEndless;
  add("memory", city, machines);
  if (!city.blocks.empty()) {
    other = city;
    const auto longest = std::max_element(other.blocks.begin(), other.blocks.end(),
                                          [](auto& a, auto& b) { return a.processor_s < b.processor_s; });
    *longest = mean_of(city.blocks);
    add("longest block", other, cluster);
  }
  std::stable_sort(bounds.begin(), bounds.end(), [](auto& a, auto& b) { return a.gain_s > b.gain_s; });
  return bounds;
}

}  // namespace lumatlas
