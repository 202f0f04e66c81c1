// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/export/replaceable_export.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "tools/base/strict_json.h"
#include "tools/texture/write_textured_mesh.h"
#include "tools/viewer/site.h"

namespace lumatlas {

void check_replaceable_export(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return;  // nothing to lose, or refused as an AtomicFile
  std::string generator;
  try {
    const nlohmann::json gltf = parse_json(read_model_json(file), file.string());
    generator = gltf.at("asset").at("generator").get<std::string>();
  } catch (const std::runtime_error&) {  // no glTF at all
  } catch (const nlohmann::json::exception&) {
  }
  if (generator == kExportGenerator) return;
  throw InputError(file.string() +
                   ": is nothing that `lumatlas export` wrote and will not be replaced, name another output or remove "
                   "it");
}

void check_replaceable_page(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return;
  std::string head(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.find(kSiteGenerator) != std::string::npos) return;
  throw InputError(file.string() +
                   ": is no page that `lumatlas export` wrote and will not be replaced, name another output or remove "
                   "it");
}

}  // namespace lumatlas
