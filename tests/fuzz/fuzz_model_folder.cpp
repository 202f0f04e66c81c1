// SPDX-License-Identifier: GPL-3.0-or-later
// A model in a folder: the input is the text of scene.gltf, a zero byte, and scene.bin. The images are those of a model
// that make_corpus writes too, so that the views of its JSON have theirs.
#include <filesystem>
#include <string_view>

#include "atlas/model/model_file.h"
#include "tests/fuzz/laws/sentence_laws.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"

extern "C" int LLVMFuzzerInitialize(int* /*argument_count*/, char*** /*arguments*/) {
  std::filesystem::create_directories("model");
  lumatlas::write_model("model", lumatlas::small_snapshot(), {});
  lumatlas::make_one_gltf("model");
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input = lumatlas::text_of(data, size);
  const std::size_t end = std::min(input.find('\0'), input.size());
  lumatlas::write_input("model/scene.gltf", input.substr(0, end));
  lumatlas::write_input("model/scene.bin", input.substr(std::min(end + 1, input.size())));
  lumatlas::check_refusal([] { (void)lumatlas::read_model_facts("model/scene.gltf"); });
  lumatlas::check_refusal([] {
    const lumatlas::Model model = lumatlas::read_model("model/scene.gltf");
    lumatlas::require(lumatlas::read_model_facts("model/scene.gltf").views.size() == model.snapshot.views.size());
  });
  return 0;
}
