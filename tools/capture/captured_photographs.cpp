// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/captured_photographs.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/base/interrupt.h"
#include "tools/capture/step_record.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

bool is_photograph(const fs::path& path) {
  constexpr std::array kEndings{".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

bool is_hidden(const fs::path& path) {
  return path.filename().string().starts_with('.');
}

// What a header says of the lens; a file that cannot be read says nothing, and COLMAP passes over it.
std::string lens_text(const fs::path& path) {
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) {
    (void)OIIO::geterror();
    return {};
  }
  const OIIO::ImageSpec& spec = input->spec();
  return size_text(spec.width, spec.height) + " " + std::string(spec.get_string_attribute("Make")) + " " +
         std::string(spec.get_string_attribute("Model")) + " " +
         std::to_string(spec.get_float_attribute("Exif:FocalLength"));
}

}  // namespace

CapturedPhotographs find_photographs(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw InputError(folder.string() + ": no such folder of photographs");
  CapturedPhotographs result{fs::canonical(folder), {}};
  for (auto entry = fs::recursive_directory_iterator(result.folder, error); entry != fs::end(entry);
       entry.increment(error)) {
    if (error) break;
    if (is_hidden(entry->path())) {
      entry.disable_recursion_pending();
    } else if (std::error_code ignored; is_photograph(entry->path()) && entry->is_regular_file(ignored)) {
      result.names.push_back(entry->path().lexically_relative(result.folder).generic_string());
    }
  }
  if (error) throw InputError(folder.string() + ": cannot be read (" + error.message() + ")");
  std::sort(result.names.begin(), result.names.end());
  if (result.names.size() >= 2) return result;
  throw InputError(folder.string() + ": holds " + std::to_string(result.names.size()) +
                   " photographs (.jpg, .png, .tif, .webp), at least two must be there, better twenty that overlap");
}

nlohmann::json states_of(const CapturedPhotographs& photographs) {
  nlohmann::json states = nlohmann::json::object();
  for (const std::string& name : photographs.names) states[name] = file_state(photographs.folder / name);
  return states;
}

bool of_one_lens(const CapturedPhotographs& photographs) {
  std::set<std::string> lenses;
  for (const std::string& name : photographs.names) {
    throw_if_interrupted();
    lenses.insert(lens_text(photographs.folder / name));
    lenses.erase("");
    if (lenses.size() > 1) return false;
  }
  return true;
}

}  // namespace lumatlas
