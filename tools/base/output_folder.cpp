// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/final_names.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/process/process_limits.h"
#include "tools/base/strict_json.h"

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

// The contents of a marker file.
struct Marker {
  std::string command;
  std::set<std::string> files;  // names in the folder, as name_in_marker() gives them
};

// A name as JSON holds it: bytes that are not UTF-8 become U+FFFD.
std::string name_in_marker(const std::string& name) {
  return nlohmann::json(name).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::optional<Marker> marker_in(const fs::path& folder) {
  constexpr std::uintmax_t kLargestMarker = 256 << 20;
  const fs::path file = folder / kMarkerFile;
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > kLargestMarker || error) return std::nullopt;
  try {
    const nlohmann::json content = read_json(file);
    content.at("lumatlas").get_ref<const std::string&>();
    Marker marker{content.at("command").get<std::string>(), {name_in_marker(kMarkerFile)}};
    for (const auto& name : content.at("files")) marker.files.insert(name_in_marker(name.get<std::string>()));
    return marker;
  } catch (const std::runtime_error&) {  // no such file that lumatlas writes
    return std::nullopt;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

// Everything in a folder but folders, by name; throws InputError.
std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (!entry->is_directory(error) || entry->is_symlink(error)) files.push_back(entry->path());
  }
  if (error) refuse(folder, "cannot be read", error);
  std::sort(files.begin(), files.end());
  return files;
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

// Folders that hold a report of `lumatlas validate`, with what it lists.
std::map<fs::path, Marker> reports_among(const std::vector<fs::path>& files, const fs::path& folder) {
  std::map<fs::path, Marker> reports;
  for (const fs::path& file : files) {
    if (file.filename() != kMarkerFile || file.parent_path() == folder) continue;
    auto marker = marker_in(file.parent_path());
    if (marker && marker->command == "validate") reports.emplace(file.parent_path(), std::move(*marker));
  }
  return reports;
}

// The first file that no marker lists; empty: there is none.
fs::path first_foreign_file(const fs::path& folder, const Marker& marker) {
  const std::vector<fs::path> files = files_in(folder);
  const std::map<fs::path, Marker> reports = reports_among(files, folder);
  const auto is_listed = [](const fs::path& file, const fs::path& in, const Marker& by) {
    return by.files.contains(name_in_marker(file.lexically_relative(in).generic_string()));
  };
  for (const fs::path& file : files) {
    if (is_listed(file, folder, marker)) continue;
    const auto lists = [&](const auto& report) {
      return is_below(file, report.first) && is_listed(file, report.first, report.second);
    };
    if (std::none_of(reports.begin(), reports.end(), lists)) return file;
  }
  return {};
}

void write_marker(const fs::path& folder, const std::string& command, const nlohmann::json& options) {
  nlohmann::json files = nlohmann::json::array();
  for (const fs::path& file : files_in(folder)) files.push_back(file.lexically_relative(folder).generic_string());
  write_json(folder / kMarkerFile,
             {{"lumatlas", LUMATLAS_VERSION}, {"command", command}, {"files", files}, {"options", options}});
}

void rename_or_refuse(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) {
    refuse(to, "cannot be put in place", error);
  }
}

// Returns the ending of swap_name(target); empty if the whole name would be longer than file systems allow.
std::string swap_ending(const fs::path& target) {
  constexpr std::size_t kLongestName = 204;
  const std::string name = target.filename().string();
  return name.size() <= kLongestName ? "-earlier-" + name : "";
}

// Paths that swap_name(target) gave to processes that did not end their swaps.
std::vector<fs::path> unfinished_swaps(const fs::path& target) {
  std::vector<fs::path> found;
  const std::string ending = swap_ending(target);
  if (ending.empty()) return found;
  const std::size_t length = random_temporary_name(ending).size();
  std::error_code error;
  for (fs::directory_iterator entry(target.parent_path(), error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() == length && name.starts_with(".lumatlas-") && name.ends_with(ending)) found.push_back(*entry);
  }
  return found;
}

// See swap_name(). Leaves alone what a living process holds.
void recover_from_swaps(const fs::path& target) {
  for (const fs::path& aside : unfinished_swaps(target)) {
    const int folder = open(aside.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY | O_NOFOLLOW);
    if (folder < 0) continue;
    std::error_code error;
    if (flock(folder, LOCK_EX | LOCK_NB) == 0) {
      fs::rename(aside, target, error);
      if (error && marker_in(target)) fs::remove_all(aside, error);
    }
    close(folder);
  }
}

}  // namespace

void check_replaceable(const fs::path& folder, const std::string& command) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return;
  if (status.type() != fs::file_type::directory) refuse(folder, "is not a folder, name another output");
  const bool is_empty = fs::is_empty(folder, error);
  if (error) refuse(folder, "cannot be read", error);
  if (is_empty) return;
  const std::optional<Marker> marker = marker_in(folder);
  if (!marker) {
    refuse(folder, std::string("is not an earlier output of lumatlas (it has no ") + kMarkerFile +
                       " that lists its files) and will not be replaced, name another folder or remove it");
  }
  if (marker->command != command) {
    refuse(folder, "is an output of `lumatlas " + marker->command + "` and will not be replaced by one of `lumatlas " +
                       command + "`, name another folder or remove it");
  }
  if (const fs::path foreign = first_foreign_file(folder, *marker); !foreign.empty()) {
    refuse(folder, "will not be replaced, because lumatlas did not write " +
                       foreign.lexically_relative(folder).generic_string() +
                       " in it: move that elsewhere, or name another folder");
  }
}

void check_apart(const fs::path& output, std::span<const fs::path> inputs) {
  const fs::path target = resolved(output);
  for (const fs::path& input : inputs) {
    if (input.empty()) continue;
    std::error_code error;
    const fs::path source = fs::weakly_canonical(fs::absolute(input), error);
    if (error || std::mismatch(target.begin(), target.end(), source.begin(), source.end()).first != target.end()) {
      continue;  // a link that cannot be resolved cannot be read either
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

fs::path swap_name(const fs::path& target) {
  return target.parent_path() / random_temporary_name(swap_ending(target));
}

void swap_folders_by_renaming(const fs::path& fresh, const fs::path& target) {
  const fs::path aside = swap_name(target);
  rename_or_refuse(target, aside);
  try {
    rename_or_refuse(fresh, target);
  } catch (const InputError&) {
    rename_or_refuse(aside, target);
    throw;
  }
  rename_or_refuse(aside, fresh);
}

OutputFolder::OutputFolder(const fs::path& path, std::string command)
    : target_(resolved(path)), command_(std::move(command)) {
  recover_from_swaps(target_);
  check_replaceable(target_, command_);
  made_parents_ = make_parents(target_);
  remove_leftovers(target_.parent_path());
  try {
    temporary_ = std::make_unique<TemporaryEntry>(TemporaryEntry::Kind::folder, target_.parent_path(),
                                                  [] { return random_temporary_name(); });
  } catch (const std::system_error& error) {
    remove_parents(made_parents_);
    refuse(target_, "cannot be made", error.code());
  }
  note_final_name(temporary_->path(), target_);
}

OutputFolder::~OutputFolder() {
  temporary_.reset();
  if (!committed_) remove_parents(made_parents_);
}

void OutputFolder::put_in_place() {
  const bool replaces = fs::exists(target_);
  const LeftoverLock held(
      target_);  // whatever its name: no process takes it for a leftover while it may have to go back
  {
    const auto paused = removal_paused();
    if (!replaces) {
      rename_or_refuse(temporary_->path(), target_);
      temporary_->release();
    } else if (!exchange_folders(temporary_->path(), target_)) {
      swap_folders_by_renaming(temporary_->path(), target_);
    }
    committed_ = true;
    forget_final_name(temporary_->path());
  }
  if (!replaces) return;
  std::error_code error;
  fs::remove_all(temporary_->path(), error);
  if (error) {
    refuse(target_, "is complete, but the earlier output, now " + temporary_->path().string() + ", cannot be removed",
           error);
  }
}

void OutputFolder::commit(const nlohmann::json& effective_options) {
  if (committed_) {
    throw std::invalid_argument("output folder: committed is true, must be committed only once");
  }
  throw_if_interrupted();
  write_marker(temporary_->path(), command_, effective_options);
  if (!sync_file_system(temporary_->path())) {
    refuse(target_, "could not be written to the end", std::error_code(errno, std::generic_category()));
  }
  check_replaceable(target_, command_);
  put_in_place();
  (void)sync_to_disk(target_.parent_path());  // it is in place for every process; only a power cut might undo that
}

AtomicFile::AtomicFile(const fs::path& path) : target_(resolved(path)), pending_(target_) {
  remove_leftovers(target_.parent_path());
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
    refuse(target_, "could not be written to the end, " + why_not_written());
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
