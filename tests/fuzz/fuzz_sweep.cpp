// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps: what is read has scenes and values, and the options of every point can be put on a command line.
#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/lab/sweep/sweep.h"

namespace {

using namespace lumatlas;

bool knows(const std::string& command, const std::string& option) {
  return command != "synth" || option != "hold";
}

void require_usable(const Sweep& sweep) {
  require(!sweep.name.empty() && !sweep.scenes.empty() && !sweep.series.empty());
  for (const SweepSeries& series : sweep.series) {
    require(!series.values.empty());
    for (const SweepValue& value : series.values) {
      CommandOptions options = sweep.options;
      overlay(options, series.options);
      overlay(options, value.options);
      for (const std::string& argument : arguments_of(options.build)) require(argument.starts_with("--"));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  write_input("sweep.json", text_of(data, size));
  for (const SweepScale scale : {SweepScale::small, SweepScale::full}) {
    check_refusal([&] {
      for (const Sweep& sweep : read_sweeps("sweep.json", scale, knows)) require_usable(sweep);
    });
  }
  return 0;
}
