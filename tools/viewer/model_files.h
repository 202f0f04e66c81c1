// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a model as they lie on the disk, for a page that reads them. Nothing is read but the JSON that names
// them, and what tells whether they are a model.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/viewer/http/site_server.h"

namespace lumatlas {

// Serves a model with its owner's file, and looks whether another one takes its place.
class ServedModel {
 public:
  // `follow`: the page asks which version there is. `unit`: name of the unit of its lengths, if it is known. The server
  // must outlive this. Throws InputError where the path is no model that read_model_facts() takes.
  ServedModel(SiteServer& server, std::filesystem::path model, bool follow, const std::string& unit = {});

  // Serves the model that is there now, if it was replaced since the last call; a page that already has an earlier one
  // asks for files of it in vain, and takes this one then. Returns whether it did. Throws InputError, once for each bad
  // model; the page keeps the earlier one.
  bool refresh();

 private:
  [[nodiscard]] std::filesystem::file_time_type last_written() const;
  void serve();
  // Serves the owner's file as it is now, an empty one if there is none.
  void serve_page_file();

  SiteServer& server_;
  std::filesystem::path model_, file_;  // as it was given; its main file
  bool follow_;
  std::filesystem::file_time_type written_;
  bool has_page_file_ = false;
  std::uint64_t version_ = 0;
  std::vector<std::string> names_;  // of the files that are served
};

}  // namespace lumatlas
