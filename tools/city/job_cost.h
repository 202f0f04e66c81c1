// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of a job of a city, which it writes into the plan's folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace lumatlas {

struct JobCost {
  double processor_s = 0;           // of all threads
  double wall_s = 0;                // since the process began
  std::uint64_t peak_bytes = 0;     // largest resident memory
  std::uint64_t read_bytes = 0;     // by calls that read files, whether or not the disk was asked
  std::uint64_t written_bytes = 0;  // by calls that write files

  friend bool operator==(const JobCost&, const JobCost&) = default;
};

// Returns what this process took until now, without its child processes. Bytes are 0 where the system does not tell.
[[nodiscard]] JobCost cost_of_this_process();

// Writes PLAN/costs/NAME.json. `name`: "plan", a block's number, or "join". Throws InputError.
void write_job_cost(const std::filesystem::path& plan, const std::string& name, const JobCost& cost);

// Reads it; none if there is no such file. Throws InputError for a file of other content.
[[nodiscard]] std::optional<JobCost> read_job_cost(const std::filesystem::path& plan, const std::string& name);

}  // namespace lumatlas
