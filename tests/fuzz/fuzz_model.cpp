// SPDX-License-Identifier: GPL-3.0-or-later
// A model in one file: a whole .glb, whose length is put right, or, so that more of what changes gets past the frame,
// its JSON, a zero byte and its binary chunk.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <string>

#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"

namespace {

std::string glb_of(std::string bytes) {
  if (bytes.starts_with("{")) {
    const std::size_t end = std::min(bytes.find('\0'), bytes.size());
    std::ostringstream file;
    const std::string binary = bytes.substr(std::min(end + 1, bytes.size()));
    lumatlas::write_glb_frame(file, bytes.substr(0, end),
                              std::span(reinterpret_cast<const unsigned char*>(binary.data()), binary.size()));
    return file.str();
  }
  for (std::size_t i = 8; i < 12 && i < bytes.size(); ++i) bytes[i] = static_cast<char>(bytes.size() >> (8 * (i - 8)));
  return bytes;
}

}  // namespace

// A model that can be read can be written, and reads back.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("fuzz-model-" + std::to_string(getpid()) + ".glb");
  std::ofstream(file, std::ios::binary) << glb_of(std::string(reinterpret_cast<const char*>(data), size));
  lumatlas::Model model;
  try {
    model = lumatlas::read_model(file);
  } catch (const lumatlas::InputError&) {
    return 0;
  }
  std::ofstream stream(file, std::ios::binary);
  lumatlas::write_glb(stream, model.snapshot, model.validity);
  stream.close();
  if (lumatlas::read_model(file).snapshot.views.size() != model.snapshot.views.size()) std::abort();
  return 0;
}
