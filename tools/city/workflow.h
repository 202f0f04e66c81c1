// SPDX-License-Identifier: GPL-3.0-or-later
// The jobs of a plan as a workflow of Snakemake, which runs them on cores, on a cluster by Slurm, or by its other
// executors, and makes again what failed.
#pragma once

#include <filesystem>
#include <string>

#include "tools/city/city_plan.h"

namespace lumatlas {

// Returns the text of a Snakefile that lies in the plan's folder. Its rules call `program`, and its target is the model
// of `config["model"]`, by default "model" in that folder.
[[nodiscard]] std::string snakefile(const CityPlan& plan, const std::filesystem::path& program);

}  // namespace lumatlas
