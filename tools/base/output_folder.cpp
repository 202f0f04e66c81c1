// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/output_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>

#include "mesh/base/errors.h"
#include "tools/base/interrupt.h"

namespace lumatlas {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const fs::path& path, const std::string& reason) {
  throw InputError(path.string() + ": " + reason);
}

[[noreturn]] void refuse(const fs::path& path, const std::string& action, const std::error_code& error) {
  refuse(path, action + ": " + error.message());
}

// Through links and without a trailing slash, whether or not the path exists.
fs::path resolved(const fs::path& path) {
  if (path.empty()) {
    throw InputError("the output path is empty, name a file or folder");
  }
  std::error_code error;
  fs::path result = fs::weakly_canonical(fs::absolute(path), error);
  if (error) {
    refuse(path, "cannot be resolved", error);
  }
  return result.has_filename() ? result : result.parent_path();
}

fs::path fresh_name_beside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  while (true) {
    const std::string name = ".lumatlas-" + std::to_string(getpid()) + "-" + std::to_string(counter++);
    fs::path candidate = target.parent_path() / name;
    std::error_code error;
    if (fs::symlink_status(candidate, error).type() == fs::file_type::not_found) {
      return candidate;
    }
    if (error) {
      refuse(candidate, "cannot be made", error);
    }
  }
}

std::vector<fs::path> make_parents(const fs::path& target) {
  std::vector<fs::path> missing;
  for (fs::path parent = target.parent_path(); !fs::exists(parent); parent = parent.parent_path()) {
    missing.insert(missing.begin(), parent);
  }
  for (const fs::path& parent : missing) {
    std::error_code error;
    fs::create_directory(parent, error);
    if (error) {
      refuse(parent, "cannot be made", error);
    }
  }
  return missing;
}

// Innermost first, and only while they are empty: others may write there by now.
void remove_parents(const std::vector<fs::path>& made) {
  std::error_code error;
  for (auto parent = made.rbegin(); parent != made.rend() && !error; ++parent) {
    fs::remove(*parent, error);
  }
}

bool holds_marker(const fs::path& folder) {
  constexpr std::uintmax_t kLargestMarker = 1 << 20;
  const fs::path marker = folder / kMarkerFile;
  std::error_code error;
  if (!fs::is_regular_file(marker, error) || fs::file_size(marker, error) > kLargestMarker || error) {
    return false;
  }
  std::ifstream file(marker, std::ios::binary);
  const nlohmann::json content = nlohmann::json::parse(file, nullptr, false);
  return content.is_object() && content.contains("lumatlas");
}

void write_marker(const fs::path& folder, const nlohmann::json& options) {
  write_json(folder / kMarkerFile, {{"lumatlas", LUMATLAS_VERSION}, {"options", options}});
}

void rename_or_refuse(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) {
    refuse(to, "cannot be put in place", error);
  }
}

}  // namespace

void check_replaceable(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) {
    return;
  }
  if (status.type() != fs::file_type::directory) {
    refuse(folder, "is not a folder, name another output");
  }
  const bool empty = fs::is_empty(folder, error);
  if (error) {
    refuse(folder, "cannot be read", error);
  }
  if (!empty && !holds_marker(folder)) {
    refuse(folder, std::string("is not an earlier output of lumatlas (it has no ") + kMarkerFile +
                       ") and will not be replaced, name another folder or remove it");
  }
}

void check_apart(const fs::path& output, std::span<const fs::path> inputs) {
  const fs::path target = resolved(output);
  for (const fs::path& input : inputs) {
    if (input.empty()) continue;
    std::error_code error;
    const fs::path source = fs::weakly_canonical(fs::absolute(input), error);
    if (error || std::mismatch(target.begin(), target.end(), source.begin(), source.end()).first != target.end()) {
      continue;  // what cannot be resolved cannot be read either
    }
    refuse(target, "would be replaced, with the input " + input.string() + " in it: name another output");
  }
}

bool exchange_folders(const fs::path& fresh, const fs::path& target) {
  if (renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) {
    return true;
  }
  const int error = errno;
  if (error == EINVAL || error == ENOSYS || error == ENOTSUP) {
    return false;
  }
  refuse(target, "cannot be put in place", std::error_code(error, std::generic_category()));
}

void swap_folders_by_renaming(const fs::path& fresh, const fs::path& target) {
  const fs::path aside = fresh_name_beside(target);
  rename_or_refuse(target, aside);
  try {
    rename_or_refuse(fresh, target);
  } catch (const InputError&) {
    rename_or_refuse(aside, target);
    throw;
  }
  rename_or_refuse(aside, fresh);
}

OutputFolder::OutputFolder(const fs::path& path) : target_(resolved(path)) {
  check_replaceable(target_);
  made_parents_ = make_parents(target_);
  temporary_ = fresh_name_beside(target_);
  std::error_code error;
  fs::create_directory(temporary_, error);
  if (error) {
    remove_parents(made_parents_);
    refuse(target_, "cannot be made", error);
  }
}

OutputFolder::~OutputFolder() {
  if (!committed_) {
    std::error_code ignored;  // a destructor has nobody to tell
    fs::remove_all(temporary_, ignored);
    remove_parents(made_parents_);
  }
}

void OutputFolder::commit(const nlohmann::json& effective_options) {
  if (committed_) {
    throw std::invalid_argument("output folder: committed is true, must be committed only once");
  }
  throw_if_interrupted();
  write_marker(temporary_, effective_options);
  check_replaceable(target_);
  const bool replaces = fs::exists(target_);
  if (!replaces) {
    rename_or_refuse(temporary_, target_);
  } else if (!exchange_folders(temporary_, target_)) {
    swap_folders_by_renaming(temporary_, target_);
  }
  committed_ = true;
  std::error_code error;
  fs::remove_all(temporary_, error);
  if (error) {
    refuse(target_, "is complete, but the earlier output, now " + temporary_.string() + ", cannot be removed", error);
  }
}

AtomicFile::AtomicFile(const fs::path& path) : target_(resolved(path)), pending_(target_) {
  std::error_code error;
  const fs::file_type type = fs::status(target_, error).type();
  if (type != fs::file_type::not_found && type != fs::file_type::regular) {
    refuse(target_, "is not a regular file, name another output");
  }
  stream_.open(pending_.path(), std::ios::binary);
  if (!stream_) {
    refuse(target_, "cannot be written", std::error_code(errno, std::generic_category()));
  }
}

void AtomicFile::commit() {
  if (committed_) {
    throw std::invalid_argument("output file: committed is true, must be committed only once");
  }
  stream_.close();  // flushes
  if (!stream_) {
    refuse(target_, "could not be written to the end, is the disk full?");
  }
  pending_.commit();
  committed_ = true;
}

std::string json_text(const nlohmann::json& value) {
  return value.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

void write_json(const fs::path& path, const nlohmann::json& value) {
  AtomicFile file(path);
  file.stream() << json_text(value);
  file.commit();
}

}  // namespace lumatlas
