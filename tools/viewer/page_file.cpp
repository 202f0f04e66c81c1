// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/page_file.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "mesh/base/errors.h"
#include "tools/base/strict_json.h"
#include "tools/viewer/site.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

}  // namespace

fs::path page_file_of(const fs::path& model) {
  const fs::path whole = (fs::absolute(model) / "").lexically_normal().parent_path();
  return whole.parent_path() / (title_of(whole) + ".page.json");
}

std::string read_page_file(const fs::path& model) {
  const fs::path file = page_file_of(model);
  std::error_code missing;
  if (!fs::exists(file, missing)) return {};
  const nlohmann::json value = read_json(file);
  if (!value.is_object()) throw InputError(file.string() + ": must be an object");
  return value.dump(1) + '\n';
}

}  // namespace lumatlas
