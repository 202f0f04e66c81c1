// SPDX-License-Identifier: GPL-3.0-or-later
// The notes that `build` writes beside a model, lumatlas.json and plan.json, and what a report takes from them. The
// input is the text of the first, a zero byte, and that of the second.
#include <algorithm>
#include <filesystem>

#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/score/report/report_refinements.h"

extern "C" int LLVMFuzzerInitialize(int* /*argument_count*/, char*** /*arguments*/) {
  std::filesystem::create_directories("model");
  lumatlas::write_input("model/tileset.json", "{\"asset\": {\"version\": \"1.1\"}}");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input = lumatlas::text_of(data, size);
  const std::size_t end = std::min(input.find('\0'), input.size());
  lumatlas::write_input("model/lumatlas.json", input.substr(0, end));
  lumatlas::write_input("model/plan.json", input.substr(std::min(end + 1, input.size())));
  lumatlas::check_refusal([] {
    const lumatlas::ModelNotes notes = lumatlas::read_model_notes("model");
    lumatlas::require(notes.options.is_null() || notes.options.is_object());
    lumatlas::require(notes.plan.is_null() || notes.plan.is_object());
    (void)lumatlas::read_refinements(notes.plan);
  });
  return 0;
}
