// SPDX-License-Identifier: GPL-3.0-or-later
// A scene whose folder fills up while it is used: which of its photographs have come, each once it is whole.
//
// A file counts as written once it has stayed as it is, size and time, from one look at the folder to the next. What
// cannot be read even then is looked at again when it changes, and once more after kPatience looks; then it is named
// as bad. The scene's list is read again when its files have changed and rest. A photograph is given with the pose and
// the mask that it has by then; a pose that changes afterwards is not taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/scene/scene.h"
#include "tools/scene/scene_list.h"

namespace lumatlas {

class GrowingScene {
 public:
  static constexpr std::uint32_t kPatience = 10;  // looks; about a second lies between two

  // Reads views as read_scene_views() does, but accepts a scene without any.
  GrowingScene(std::filesystem::path scene, const glm::dvec3& offset, PictureFolders folders);

  struct News {
    std::vector<SceneView> ready;       // photographs that came since the last look, by name; each is given once
    std::vector<std::string> warnings;  // sentences: what is bad, each said once
    bool changed = false;               // some file did
  };
  // Looks at the folder. Never throws what is the files' fault.
  [[nodiscard]] News look();

  // A photograph that was given is not whole after all, for this reason: look() gives it again when that has changed.
  void give_back(const SceneView& view, const std::string& why);

  // Returns the views as the scene lists them now, whether their photographs are there or not; without orientation and
  // mask.
  [[nodiscard]] const std::vector<ListedView>& listed() const { return listed_; }
  // Returns where the listed views' coordinates lie on the Earth; none: not known.
  [[nodiscard]] const std::optional<GeoReference>& georeference() const { return georeference_; }
  // Returns sentences about the scene, given that `used` came: the notes of the list, and what the folders hold beside
  // the used photographs, as read_scene_views() says it.
  [[nodiscard]] std::vector<std::string> notes(const std::vector<SceneView>& used) const;
  // Why there is no list, or why the last change of it was not read; empty where it was.
  [[nodiscard]] const std::string& list_error() const { return list_error_; }

  struct Missing {
    std::vector<SceneView> bad;         // with SceneView::bad: there, but of no use
    std::vector<std::string> warnings;  // warnings that no look() has returned
    std::size_t absent = 0;             // listed, but not there
    std::string first_absent;           // its name
  };
  // Returns the listed photographs that were not returned so far.
  [[nodiscard]] Missing missing() const;

 private:
  // The state of a file, as far as writing changes it.
  struct FileState {
    std::filesystem::path path;
    std::uintmax_t size = 0;
    std::filesystem::file_time_type time{};
    bool operator==(const FileState&) const = default;
  };
  struct Candidate {
    std::vector<FileState> files;    // photograph and mask at the last look; empty: it was not there
    std::uint32_t rested = 0;        // looks since they last changed
    std::string bad;                 // the fault found since; empty: none, or not looked at
    bool named = false;              // `bad` was reported
    std::optional<SceneView> given;  // the returned view
  };

  [[nodiscard]] static std::vector<FileState> states_of(const std::vector<std::filesystem::path>& files);
  void read_list(News& news);
  void accept(SceneList list, News& news);
  void look_at(const ListedView& listed, Candidate& candidate, News& news) const;

  std::filesystem::path scene_;
  glm::dvec3 offset_;
  PictureFolders folders_;
  std::vector<ListedView> listed_;
  std::vector<std::string> notes_;  // the list's notes
  std::optional<GeoReference> georeference_;
  std::size_t left_out_ = 0;  // photographs that these tell of
  std::string form_;
  std::vector<FileState> list_files_;                 // at the last look
  std::optional<std::vector<FileState>> read_files_;  // that listed_ was read from
  std::uint32_t list_rested_ = 0;
  std::string list_error_;
  bool list_error_named_ = false, moves_named_ = false;
  std::map<std::string, Candidate> candidates_;  // by name
};

}  // namespace lumatlas
