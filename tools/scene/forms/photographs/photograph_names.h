// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures in folders, and how a photograph is found by the name that a form of capture gives it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace lumatlas {

// The names of photographs, to be found by what a form calls them.
class PhotographNames {
 public:
  explicit PhotographNames(std::vector<std::string> names);

  // The name that is `label`, else the only one that ends in it after a '/', else the only one that does so without its
  // ending, or without both's; where several do, the only one of the same capitals. `label` itself if there is none.
  // Throws InputError if there are several.
  [[nodiscard]] std::string find(const std::string& label) const;

  // Finds a photograph by a path of another computer, with '/' or '\\' between folders: tries its ends with find(),
  // the longest first. Where none is found, returns the path itself if it stays in its folder, else its last part.
  [[nodiscard]] std::string find_by_path(std::string_view path) const;

  // Returns whether a photograph has this name.
  [[nodiscard]] bool has(const std::string& name) const;

 private:
  using Index = std::unordered_multimap<std::string, std::size_t>;
  // `named`: what sentences call the label.
  [[nodiscard]] std::optional<std::string> only_one(const Index& index, const std::string& label, bool with_ending,
                                                    const std::string& named) const;

  std::vector<std::string> names_;   // in byte order
  std::vector<std::string> folded_;  // the same names, see folded()
  Index by_file_, by_stem_;          // the last part of a folded name, with and without its ending
};

// Returns `text` in Unicode's composed and case-folded form (NFC with case folding), in which names that differ only
// in capitals, or in how accents are encoded, are equal. In text that is not UTF-8 it lowers ASCII capitals only.
[[nodiscard]] std::string folded(const std::string& text);

// Returns the names of all pictures in a folder and those below, as files_below() lists them
// (tools/base/files_below.h). What cannot be looked at is left out.
[[nodiscard]] std::vector<std::string> pictures_in(const std::filesystem::path& folder);

// Returns the files of a folder, without those of folders below, whose names end in `ending` in any case, sorted by
// name; empty where the folder cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> files_ending_in(const std::filesystem::path& folder,
                                                                 std::string_view ending);
// Returns up to 4096 bytes from the start of a file; empty where it cannot be read.
[[nodiscard]] std::string first_bytes(const std::filesystem::path& file);

}  // namespace lumatlas
