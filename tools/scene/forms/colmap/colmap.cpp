// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/colmap/colmap.h"

#include <algorithm>
#include <array>
#include <system_error>
#include <tuple>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "tools/scene/forms/unread_forms.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code error;
  const bool exists = fs::exists(path, error);
  if (error) throw InputError(path.string() + ": cannot be accessed (" + error.message() + ")");
  return exists;
}

struct Files {
  fs::path cameras, images;
  bool binary;
};

std::array<Files, 2> files_in(const fs::path& folder) {
  return {
      {{folder / "cameras.bin", folder / "images.bin", true}, {folder / "cameras.txt", folder / "images.txt", false}}};
}

std::optional<Files> whole_model(const fs::path& folder) {
  for (const Files& files : files_in(folder)) {
    if (is_there(files.cameras) && is_there(files.images)) return files;
  }
  return std::nullopt;
}

// The mapper's folders, which it counts from 0, and others after them.
std::vector<fs::path> folders_of_models(const fs::path& sparse) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator entry(sparse, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_directory(ignored)) folders.push_back(entry->path());
  }
  const auto order = [](const fs::path& folder) {
    const std::string name = folder.filename().string();
    const std::optional<long long> number = parse_integer(name);
    return std::tuple(!number.has_value(), number.value_or(0), name);
  };
  std::sort(folders.begin(), folders.end(), [&](const fs::path& a, const fs::path& b) { return order(a) < order(b); });
  return folders;
}

// A model among several.
struct Candidate {
  fs::path folder;
  Files files;
  std::optional<std::size_t> images;  // none: they cannot be read
};

std::optional<std::size_t> image_count(const Files& files) {
  try {
    const std::string images = read_whole_file(files.images);
    return files.binary ? parse_images_binary(std::as_bytes(std::span(images)), files.images).size()
                        : parse_images_text(images, files.images).size();
  } catch (const InputError&) {
    return std::nullopt;
  }
}

struct Choice {
  Files files;
  std::string note;  // see ColmapModel
};

std::string count_text(const Candidate& candidate) {
  return candidate.images ? "with " + std::to_string(*candidate.images) : "which cannot be read";
}

std::string note_on(const std::vector<Candidate>& candidates, const Candidate& chosen, const fs::path& sparse) {
  std::string others;
  for (const Candidate& candidate : candidates) {
    if (candidate.folder == chosen.folder) continue;
    const bool counted = candidate.images.has_value();
    others += (others.empty() ? "" : ", ") + candidate.folder.string() + (counted ? " " : ", ") + count_text(candidate);
  }
  return "of " + std::to_string(candidates.size()) + " models the one in " + chosen.folder.string() +
         " is read, which has " + std::to_string(chosen.images.value_or(0)) + " photographs; not that in " + others +
         (chosen.folder == sparse ? ": to read another one, move it to a folder of its own"
                                  : ": to read another one, copy its files to " + sparse.string());
}

// The whole models in `sparse` and its folders, the first of them in `sparse` itself if there is one.
std::vector<Candidate> models_in(const fs::path& sparse) {
  std::vector<fs::path> folders{sparse};
  for (fs::path& folder : folders_of_models(sparse)) folders.push_back(std::move(folder));
  std::vector<Candidate> candidates;
  for (const fs::path& folder : folders) {
    if (const std::optional<Files> files = whole_model(folder)) candidates.push_back({folder, *files, std::nullopt});
  }
  return candidates;
}

Choice largest_of(std::vector<Candidate> candidates, const fs::path& sparse) {
  for (Candidate& candidate : candidates) candidate.images = image_count(candidate.files);
  const auto smaller = [](const Candidate& a, const Candidate& b) { return a.images < b.images; };  // none is least
  const bool in_sparse_itself = candidates.front().folder == sparse;
  const auto chosen =
      in_sparse_itself ? candidates.begin() : std::max_element(candidates.begin(), candidates.end(), smaller);
  return {chosen->files, note_on(candidates, *chosen, sparse)};
}

std::optional<Choice> choose_model(const fs::path& scene) {
  const fs::path sparse = scene / "sparse";
  std::vector<Candidate> candidates = models_in(sparse);
  if (candidates.size() > 1) return largest_of(std::move(candidates), sparse);
  if (candidates.size() == 1) return Choice{candidates.front().files, {}};
  const std::optional<Files> files = whole_model(scene);
  return files ? std::optional(Choice{*files, {}}) : std::nullopt;
}

[[noreturn]] void refuse_missing(const fs::path& scene) {
  for (const fs::path& folder : {scene / "sparse", scene / "sparse" / "0", scene}) {
    for (const Files& files : files_in(folder)) {
      const bool cameras = is_there(files.cameras);
      if (!cameras && !is_there(files.images)) continue;
      throw InputError((cameras ? files.images : files.cameras).string() + ": no such file, but COLMAP's model needs " +
                       "it beside " + (cameras ? files.cameras : files.images).filename().string());
    }
  }
  if (!is_there(scene)) throw InputError(scene.string() + ": no such folder");
  throw InputError(no_poses(scene));
}

void check_cameras_exist(const ColmapModel& model) {
  for (const ColmapImage& image : model.images) {
    (void)model.camera_of(image);
  }
}

}  // namespace

const ColmapCamera& ColmapModel::camera_of(const ColmapImage& image) const {
  const auto found = std::lower_bound(cameras.begin(), cameras.end(), image.camera_id,
                                      [](const ColmapCamera& camera, std::uint32_t id) { return camera.id < id; });
  if (found == cameras.end() || found->id != image.camera_id) {
    throw InputError(images_path.string() + ": image " + std::to_string(image.id) + " ('" + image.name +
                     "') has camera " + std::to_string(image.camera_id) + ", which is not in " +
                     cameras_path.filename().string());
  }
  return *found;
}

ColmapModel read_colmap_model(const fs::path& scene, BadPhotographs bad) {
  std::optional<Choice> choice = choose_model(scene);
  if (!choice) refuse_missing(scene);
  const Files& files = choice->files;
  const std::string cameras = read_whole_file(files.cameras);
  const std::string images = read_whole_file(files.images);
  ColmapModel model{files.cameras, files.images, {}, {}, std::move(choice->note)};
  model.cameras = files.binary ? parse_cameras_binary(std::as_bytes(std::span(cameras)), files.cameras, bad)
                               : parse_cameras_text(cameras, files.cameras, bad);
  model.images = files.binary ? parse_images_binary(std::as_bytes(std::span(images)), files.images, bad)
                              : parse_images_text(images, files.images, bad);
  if (model.images.empty()) {
    throw InputError(files.images.string() + ": holds no image, so there is nothing to see the scene from");
  }
  std::sort(model.cameras.begin(), model.cameras.end(),
            [](const ColmapCamera& a, const ColmapCamera& b) { return a.id < b.id; });
  std::stable_sort(model.images.begin(), model.images.end(),
                   [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  check_cameras_exist(model);
  return model;
}

std::optional<fs::path> find_colmap_images(const fs::path& scene) {
  try {
    const std::optional<Choice> choice = choose_model(scene);
    return choice ? std::optional(choice->files.images) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

fs::path points_path(const ColmapModel& model) {
  return model.images_path.parent_path() / ("points3D" + model.images_path.extension().string());
}

std::vector<ColmapPoint> read_colmap_points(const ColmapModel& model) {
  const fs::path path = points_path(model);
  const std::string file = read_whole_file(path);
  return path.extension() == ".bin" ? parse_points_binary(std::as_bytes(std::span(file)), path)
                                    : parse_points_text(file, path);
}

}  // namespace lumatlas
