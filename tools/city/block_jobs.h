// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the jobs of a plan's blocks as processes of their own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/budget/build_progress.h"
#include "tools/city/city_plan.h"

namespace lumatlas {

struct FailedBlock {
  std::size_t block = 0;
  std::string why;  // the last line of its log, or how it ended
};

// Starts `program city FOLDER --job K` for each block that is not done, `jobs` (>= 1) at once, which share the
// machine's processors, and returns those that failed, in order; the others went on. What a job says goes to
// block_log(). Throws Interrupted, once the jobs that run have ended: what they have done stays, and another call goes
// on from there. Throws InputError where a job cannot be started.
[[nodiscard]] std::vector<FailedBlock> run_block_jobs(const std::filesystem::path& program,
                                                      const std::filesystem::path& folder, const CityPlan& plan,
                                                      std::size_t jobs, const BuildCallback& callback);

}  // namespace lumatlas
