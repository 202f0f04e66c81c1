// SPDX-License-Identifier: GPL-3.0-or-later
// The time that a city's jobs take on machines that share a disk, simulated event by event: plan, then blocks in any
// order, then join.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace lumatlas {

// A job reads its files, computes on one core, and writes its files, one after the other.
struct ClusterJob {
  double processor_s = 0;
  double peak_bytes = 0;  // of memory, from its begin to its end
  double read_bytes = 0, written_bytes = 0;
};

struct ClusterCity {
  ClusterJob plan, join;
  std::vector<ClusterJob> blocks;
};

struct Cluster {
  std::size_t machines = 1, cores = 2;  // >= 1; cores of one machine
  double memory_bytes = 8e9;            // of one machine, > 0
  double disk_bytes_per_s = 200e6;      // of the disk that all share, > 0; jobs that read or write share it equally
};

struct ClusterRun {
  double plan_s = 0, blocks_s = 0, join_s = 0;

  [[nodiscard]] double total_s() const { return plan_s + blocks_s + join_s; }
};

// Returns how long each part takes. The first waiting job that fits begins on the first machine with a free core and
// memory for it, as a workflow engine does. The same input gives the same numbers. Throws std::invalid_argument for a
// cluster that breaks a rule, and for a job that needs more memory than a machine has, which it names.
[[nodiscard]] ClusterRun simulated_run(const ClusterCity& city, const Cluster& cluster);

// The speed-up of a run without one of its bounds.
struct ClusterBound {
  std::string name;   // "plan", "join", "disk", "longest block", "processors", "memory"
  double gain_s = 0;  // >= 0
};

// Returns all bounds, that which costs most first. Without it the plan or the join takes no time, the disk is endlessly
// fast, the longest block takes what blocks take on average, each block has a core, or memory does not count.
[[nodiscard]] std::vector<ClusterBound> bounds_of(const ClusterCity& city, const Cluster& cluster);

}  // namespace lumatlas
