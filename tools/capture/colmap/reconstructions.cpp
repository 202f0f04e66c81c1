// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/reconstructions.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "tools/scene/forms/colmap/colmap.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

bool is_model(const fs::path& folder) {
  const std::vector<fs::path> files = files_of_model(folder);
  return std::any_of(files.begin(), files.end(), [](const fs::path& file) { return fs::exists(file); });
}

// COLMAP numbers them in the order in which it began them.
std::size_t number_of(const fs::path& folder) {
  const std::string name = folder.filename().string();
  std::size_t number = std::numeric_limits<std::size_t>::max();
  (void)std::from_chars(name.data(), name.data() + name.size(), number);
  return number;
}

}  // namespace

std::vector<fs::path> files_of_model(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* const name : {"cameras", "images", "points3D"}) {
    for (const char* const ending : {".bin", ".txt"}) files.push_back(folder / (std::string(name) + ending));
  }
  return files;
}

std::vector<Reconstruction> reconstructions_in(const fs::path& folder) {
  std::vector<Reconstruction> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_directory() || !is_model(entry.path())) continue;
    Reconstruction reconstruction{entry.path(), {}};
    for (const ColmapImage& image : read_colmap_model(entry.path()).images) reconstruction.placed.push_back(image.name);
    found.push_back(std::move(reconstruction));
  }
  std::sort(found.begin(), found.end(), [](const Reconstruction& a, const Reconstruction& b) {
    if (a.placed.size() != b.placed.size()) return a.placed.size() > b.placed.size();
    return number_of(a.folder) < number_of(b.folder);
  });
  return found;
}

}  // namespace lumatlas
