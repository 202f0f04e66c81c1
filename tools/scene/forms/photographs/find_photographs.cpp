// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photographs/find_photographs.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "mesh/base/text_fields.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// The folder that photographs are looked for in.
struct PhotographFolder {
  fs::path path;             // the path that is opened
  fs::path below_the_scene;  // the beginning of PosedPhotograph::file; empty where that is not looked at
};

PhotographFolder folder_of(const fs::path& scene, const std::optional<fs::path>& images) {
  if (images) return {*images, {}};
  std::error_code ignored;
  if (fs::is_directory(scene / "images", ignored)) return {scene / "images", "images"};
  return {scene, {}};
}

class Finder {
 public:
  Finder(Capture& capture, const fs::path& path, const fs::path& scene, const std::optional<fs::path>& images,
         BadPhotographs bad)
      : capture_(capture), path_(path), scene_(scene), images_(images), folder_(folder_of(scene, images)), bad_(bad) {}

  void find_all() {
    std::vector<PosedPhotograph*> missing;
    for (PosedPhotograph& photograph : capture_.photographs) {
      if (!photograph.bad.empty()) continue;
      if (is_there(photograph)) {
        if (!inner_path(photograph.name)) name_by_file(photograph);
        named_.insert(file_of(photograph));
      } else {
        missing.push_back(&photograph);
      }
    }
    if (!missing.empty()) {
      const PhotographNames names(pictures_not_named());
      for (PosedPhotograph* photograph : missing) find(*photograph, names);
      if (found_ > 0) note_found(missing.size());
    }
    for (PosedPhotograph& photograph : capture_.photographs) keep_inside(photograph);
    finish(capture_, path_, bad_);
  }

 private:
  [[nodiscard]] fs::path file_of(const PosedPhotograph& photograph) const {
    return (images_ ? *images_ / photograph.name : scene_ / photograph.file).lexically_normal();
  }

  [[nodiscard]] bool is_there(const PosedPhotograph& photograph) const {
    const std::string& named = images_ ? photograph.name : photograph.file.string();
    std::error_code ignored;
    return inner_path(named) && fs::exists(file_of(photograph), ignored);
  }

  // A name may lead out of the folder of photographs and back to it.
  void name_by_file(PosedPhotograph& photograph) const {
    photograph.file = photograph.file.lexically_normal();
    photograph.name = name_without(photograph.file, "images");
  }

  [[nodiscard]] std::vector<std::string> pictures_not_named() const {
    std::vector<std::string> pictures = pictures_in(folder_.path);
    std::erase_if(pictures, [&](const std::string& picture) {
      const bool hidden = fs::path(picture).filename().string().starts_with('.');
      return hidden || named_.contains((folder_.path / picture).lexically_normal());
    });
    return pictures;
  }

  void find(PosedPhotograph& photograph, const PhotographNames& names) {
    const std::string named = images_ ? photograph.name : photograph.file.generic_string();
    std::string name;
    try {
      name = names.find_by_path(named);
    } catch (const InputError& error) {
      return refuse(photograph, error.what());
    }
    if (!names.has(name)) return;
    if (found_++ == 0) first_ = in_quotes(photograph.name) + " is " + in_quotes(name);
    move_to(photograph, name);
  }

  void refuse(PosedPhotograph& photograph, const std::string& reason) const {
    const std::string sentence = path_.string() + ": " + reason;
    if (bad_ == BadPhotographs::refuse) throw InputError(sentence);
    photograph.bad = sentence;
  }

  // Masks are looked for, and pictures are written, by a photograph's name: no name or file may lead out of its folder.
  void keep_inside(PosedPhotograph& photograph) const {
    if (const std::optional<fs::path> name = inner_path(photograph.name)) {
      photograph.name = name->generic_string();
      if (!inner_path(photograph.file.string())) move_to(photograph, photograph.name);
      return;
    }
    std::string last = photograph.name;
    last.erase(0, last.find_last_of("/\\") + 1);
    if (inner_path(last)) return move_to(photograph, last);
    const std::string named = photograph.name;
    move_to(photograph, "a photograph without a name");
    if (photograph.bad.empty()) refuse(photograph, "the photograph " + in_quotes(named) + " is no path to a file");
  }

  void move_to(PosedPhotograph& photograph, const std::string& name) const {
    photograph.name = name;
    photograph.file = folder_.below_the_scene / name;
  }

  void note_found(std::size_t missing) {
    capture_.notes.push_back(std::to_string(found_) + " of " + std::to_string(capture_.photographs.size()) +
                             " photographs are not where " + path_.string() + " says, but were found in " +
                             folder_.path.string() + " by their names, of which the first, " + first_ +
                             (found_ == missing ? "" : "; " + std::to_string(missing - found_) + " were not found"));
  }

  Capture& capture_;
  const fs::path& path_;
  const fs::path& scene_;
  const std::optional<fs::path>& images_;
  const PhotographFolder folder_;
  const BadPhotographs bad_;
  std::set<fs::path> named_;  // files of photographs that are where the form says
  std::size_t found_ = 0;
  std::string first_;
};

}  // namespace

void find_photographs(Capture& capture, const fs::path& path, const fs::path& scene,
                      const std::optional<fs::path>& images, BadPhotographs bad) {
  Finder(capture, path, scene, images, bad).find_all();
}

}  // namespace lumatlas
