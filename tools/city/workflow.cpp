// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/workflow.h"

#include <nlohmann/json.hpp>

#include "tools/base/process/child_process.h"

namespace lumatlas {

std::string snakefile(const CityPlan& plan, const std::filesystem::path& program) {
  const std::string quoted = nlohmann::json(shell_line(program.string(), {})).dump();
  return R"(# Written by `lumatlas city`. Run it in this folder:
#
#   snakemake --cores 4
#   snakemake --cluster "sbatch --mem=2G" --jobs 100     # with Slurm
#   snakemake --cores 4 --config model=/somewhere/model
#
# Each job is a command from files to files. A job that fails or is killed leaves nothing behind, and is run again by
# the next call, or at once by --retries.
import os

BLOCKS = range()" +
         std::to_string(plan.blocks.size()) + R"()
PROGRAM = )" +
         quoted +
         R"(
MODEL = config.get("model", "model")

rule model:
    input: expand("blocks/{block}/lumatlas.json", block=BLOCKS)
    output: os.path.join(MODEL, "tileset.json")
    params: model=MODEL
    shell: "{PROGRAM} city . -o {params.model:q} --quiet"

rule block:
    input: "plan.json"
    output: "blocks/{block,[0-9]+}/lumatlas.json"
    log: "logs/{block}.txt"
    threads: 1
    shell: "{PROGRAM} city . --job {wildcards.block} --threads {threads} --quiet > {log} 2>&1"
)";
}

}  // namespace lumatlas
