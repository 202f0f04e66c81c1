// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/skip.h"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/support/skipped_cases.h"

namespace lumatlas {

std::vector<SkippedCase>& skipped_cases() {
  static std::vector<SkippedCase> cases;
  return cases;
}

void skip(const std::string& reason) {
  skipped_cases().push_back({Catch::getResultCapture().getCurrentTestName(), reason});
}

std::optional<std::filesystem::path> real_scene_or_skip(const std::string& name) {
  const char* const scenes = std::getenv("LUMATLAS_SCENES");
  if (scenes == nullptr || *scenes == '\0') {
    skip("no real scenes: LUMATLAS_SCENES is not set");
    return std::nullopt;
  }
  std::filesystem::path scene = std::filesystem::path(scenes) / name;
  if (std::filesystem::is_directory(scene)) return scene;
  skip("no real scene: " + scene.string() + " is not a folder");
  return std::nullopt;
}

}  // namespace lumatlas
