// SPDX-License-Identifier: GPL-3.0-or-later
// Every file that a synthetic scene is written as, to compare bytes.
#pragma once

#include <tbb/global_control.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>

#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas {

// Returns contents by path below the scene's folder, written by `threads` threads.
inline std::map<std::string, std::string> written(const SynthOptions& options, std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const TemporaryFolder folder;
  write_synthetic_scene(options, folder.path());
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(folder.path()).generic_string()] = bytes_of(entry.path());
  }
  return files;
}

}  // namespace lumatlas
