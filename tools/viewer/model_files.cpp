// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/model_files.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "atlas/model/model_file.h"
#include "tools/viewer/page_file.h"
#include "tools/viewer/site.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// The name of a .glb in its page, whatever its own is.
constexpr const char* kGlbName = "model.glb";

std::string type_of(const std::string& name) {
  static const std::map<std::string, std::string> types{{".glb", "model/gltf-binary"},
                                                        {".gltf", "model/gltf+json"},
                                                        {".jpg", "image/jpeg"},
                                                        {".png", "image/png"},
                                                        {".json", "application/json"}};
  const auto found = types.find(fs::path(name).extension().string());
  return found == types.end() ? "application/octet-stream" : found->second;
}

SiteFile text_file(const std::string& name, const std::string& text) {
  return {name, "application/json", {text.begin(), text.end()}, {}};
}

}  // namespace

ServedModel::ServedModel(SiteServer& server, fs::path model, bool follow, const std::string& unit)
    : server_(server), model_(std::move(model)), follow_(follow), written_(last_written()) {
  const ModelFacts facts = read_model_facts(model_);
  file_ = facts.file;
  const bool is_glb = facts.uris.empty();
  for (SiteFile& file : page_files(title_of(model_), {is_glb ? kGlbName : kTilesetName, follow, unit, true})) {
    server_.add(std::move(file));
  }
  server_.add(text_file(kPageFileName, "{}"));
  serve_page_file();
  serve();
}

void ServedModel::serve_page_file() {
  const fs::path file = page_file_of(model_);
  std::error_code missing;
  const bool is_there = fs::is_regular_file(file, missing);
  if (is_there == has_page_file_) return;
  has_page_file_ = is_there;
  server_.add(is_there ? SiteFile{kPageFileName, "application/json", {}, file} : text_file(kPageFileName, "{}"));
}

fs::file_time_type ServedModel::last_written() const {
  std::error_code missing;
  const auto time = fs::last_write_time(fs::is_directory(model_, missing) ? model_ / kTilesetName : model_, missing);
  return missing ? fs::file_time_type::min() : time;
}

bool ServedModel::refresh() {
  serve_page_file();
  const auto written = last_written();
  if (written == written_) return false;
  written_ = written;
  serve();
  return true;
}

void ServedModel::serve() {
  const ModelFacts facts = read_model_facts(model_);
  std::vector<std::string> names = facts.uris;
  for (const std::string& name : names) server_.add({name, type_of(name), {}, file_.parent_path() / name});
  // The names of what it says have to be those of these files.
  if (names.empty()) {
    server_.add({kGlbName, type_of(kGlbName), {}, file_});
  } else {
    server_.add(text_file(kTilesetName, facts.json));
  }
  for (const std::string& name : names_) {
    if (std::find(names.begin(), names.end(), name) == names.end()) server_.remove(name);
  }
  names_ = std::move(names);
  ++version_;
  if (follow_) server_.add(text_file("live.json", nlohmann::json({{"version", version_}, {"last", false}}).dump()));
}

}  // namespace lumatlas
