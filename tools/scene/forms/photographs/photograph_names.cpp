// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photographs/photograph_names.h"

#include <utf8proc.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "tools/base/files_below.h"
#include "tools/scene/forms/capture.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_picture(const fs::path& file) {
  constexpr std::array kPhotographEndings{".jpg", ".jpeg", ".png",  ".tif", ".tiff", ".webp", ".exr",
                                          ".bmp", ".heic", ".heif", ".hif", ".avif", ".dng",  ".cr2",
                                          ".cr3", ".nef",  ".arw",  ".raf", ".orf",  ".rw2"};
  return std::find(kPhotographEndings.begin(), kPhotographEndings.end(), lower_case(file.extension().string())) !=
         kPhotographEndings.end();
}

bool ends_a_path(const std::string& name, std::string_view end) {
  if (!name.ends_with(end)) return false;
  return name.size() == end.size() || name[name.size() - end.size() - 1] == '/';
}

std::string without_ending(const std::string& name) {
  return fs::path(name).replace_extension().generic_string();
}

}  // namespace

std::vector<std::string> pictures_in(const fs::path& folder) {
  std::vector<std::string> names = files_below(folder).names;
  std::erase_if(names, [](const std::string& name) { return !is_picture(name); });
  return names;
}

std::vector<fs::path> files_ending_in(const fs::path& folder, std::string_view ending) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    const bool fits = lower_case(entry->path().extension().string()) == ending;
    if (fits && entry->is_regular_file(ignored)) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string first_bytes(const fs::path& file) {
  std::string bytes(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

std::string folded(const std::string& text) {
  constexpr auto kOptions = static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_CASEFOLD);
  utf8proc_uint8_t* mapped = nullptr;
  const utf8proc_ssize_t length = utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                                               static_cast<utf8proc_ssize_t>(text.size()), &mapped, kOptions);
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(mapped, &std::free);
  if (length < 0) return lower_case(text);
  return {reinterpret_cast<const char*>(mapped), static_cast<std::size_t>(length)};
}

PhotographNames::PhotographNames(std::vector<std::string> names) : names_(std::move(names)) {
  std::sort(names_.begin(), names_.end());
  for (std::size_t i = 0; i < names_.size(); ++i) {
    folded_.push_back(folded(names_[i]));
    by_file_.emplace(fs::path(folded_[i]).filename().string(), i);
    by_stem_.emplace(fs::path(folded_[i]).stem().string(), i);
  }
}

// Returns the only name that ends in the label, in folded form. Where several do, returns the only one of these that
// ends in the label as it is written.
std::optional<std::string> PhotographNames::only_one(const Index& index, const std::string& label, bool with_ending,
                                                     const std::string& named) const {
  const auto form = [&](const std::string& name) { return with_ending ? name : without_ending(name); };
  const std::string folded_label = folded(label);
  std::vector<std::size_t> found, exact;
  const auto [first, last] = index.equal_range(fs::path(folded_label).filename().string());
  for (auto entry = first; entry != last; ++entry) {
    if (!ends_a_path(form(folded_[entry->second]), folded_label)) continue;
    found.push_back(entry->second);
    if (ends_a_path(form(names_[entry->second]), label)) exact.push_back(entry->second);
  }
  if (found.empty()) return std::nullopt;
  if (exact.size() == 1) return names_[exact.front()];
  if (found.size() == 1) return names_[found.front()];
  const std::vector<std::size_t>& several = exact.empty() ? found : exact;
  const auto [a, b] = std::minmax(names_[several[0]], names_[several[1]]);
  throw InputError("the photograph " + in_quotes(named) + " may be " + in_quotes(a) + " or " + in_quotes(b) +
                   ": keep one of them");
}

bool PhotographNames::has(const std::string& name) const {
  return std::binary_search(names_.begin(), names_.end(), name);
}

std::string PhotographNames::find(const std::string& label) const {
  if (has(label)) return label;
  if (const auto name = only_one(by_file_, label, true, label)) return *name;
  if (const auto name = only_one(by_stem_, label, false, label)) return *name;
  return only_one(by_stem_, without_ending(label), false, label).value_or(label);
}

std::string PhotographNames::find_by_path(std::string_view path) const {
  std::string end(path);
  std::replace(end.begin(), end.end(), '\\', '/');
  const std::optional<fs::path> inner = inner_path(end);
  while (true) {
    std::string name = find(end);
    if (has(name)) return name;
    const std::size_t separator = end.find('/');
    if (separator == std::string::npos) return inner ? inner->generic_string() : name;
    end.erase(0, separator + 1);
  }
}

}  // namespace lumatlas
