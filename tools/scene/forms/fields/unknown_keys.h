// SPDX-License-Identifier: GPL-3.0-or-later
// Keys of JSON files that a reader does not know: they are told in a note, or refused where they may bend the picture.
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "tools/base/strict_json.h"
#include "tools/scene/forms/capture.h"

namespace lumatlas {

// Gathers keys that a reader does not know, to tell them in one note.
class UnknownKeys {
 public:
  // Gathers the keys of an object for which `is_known` is false, or which are not in `known`.
  void look_at(const JsonPlace& object, const std::function<bool(std::string_view key)>& is_known);
  void look_at(const JsonPlace& object, std::span<const std::string_view> known);
  // The same for a lens, but refuses an unknown key whose value is a number other than 0 or holds one: it may be a
  // coefficient that bends the picture.
  void look_at_lens(const JsonPlace& lens, std::span<const std::string_view> known);
  // Adds a note that names up to ten of them; none where there are no unknown keys.
  void tell(const std::filesystem::path& path, Capture& capture) const;

 private:
  std::set<std::string> keys_;
};

}  // namespace lumatlas
