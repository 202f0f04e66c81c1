// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/work_folder.h"

#include <algorithm>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace fs = std::filesystem;

namespace {

fs::file_time_type time_of(const fs::path& file) {
  std::error_code error;
  const fs::file_time_type time = fs::last_write_time(file, error);
  if (error) throw InputError(file.string() + ": cannot be read (" + error.message() + ")");
  return time;
}

// Linux says so of FAT, exFAT and shares of Windows.
bool has_no_links(const std::error_code& error) {
  return error == std::errc::operation_not_permitted || error == std::errc::operation_not_supported ||
         error == std::errc::function_not_supported;
}

// Returns whether an earlier call has copied the file.
bool is_copy_of(const fs::path& copy, const fs::path& target) {
  std::error_code error;
  return !target.empty() && !fs::is_symlink(copy, error) && fs::is_regular_file(copy, error) &&
         fs::is_regular_file(target, error) && is_made_of(copy, target);
}

void copy_file_to(const fs::path& copy, const fs::path& target) {
  std::error_code error;
  fs::copy_file(target, copy, error);
  if (error) {
    throw InputError(copy.string() + ": can be neither linked to " + target.string() + " nor copied from there (" +
                     error.message() + ")");
  }
  mark_as_made_of(copy, target);
}

}  // namespace

bool is_within(const fs::path& path, const fs::path& folder) {
  const fs::path inner = fs::weakly_canonical(path);
  return std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end()).first == folder.end();
}

void check_outside(const fs::path& output, const fs::path& photographs) {
  if (!is_within(output, photographs)) return;
  throw InputError(output.string() +
                   ": lies in the folder of the photographs, which would find its pictures there the " +
                   "next time: name another place");
}

void open_work_folder(const fs::path& work, const fs::path& record) {
  std::error_code error;
  if (fs::exists(work, error) && !fs::exists(record, error) && (!fs::is_directory(work) || !fs::is_empty(work))) {
    throw InputError(work.string() + ": is in use, and not by `lumatlas capture`: name another folder with --work");
  }
  fs::create_directories(work / "log", error);
  if (error) throw InputError(work.string() + ": cannot be made (" + error.message() + ")");
}

bool is_made_of(const fs::path& made, const fs::path& source) {
  std::error_code error;
  const fs::file_time_type time = fs::last_write_time(made, error);
  return !error && time == time_of(source);
}

void mark_as_made_of(const fs::path& made, const fs::path& source) {
  std::error_code error;
  fs::last_write_time(made, time_of(source), error);
  if (error) throw InputError(made.string() + ": its time cannot be set (" + error.message() + ")");
}

void put_link(const fs::path& link, const fs::path& target) {
  std::error_code error;
  if (!target.empty() && fs::is_symlink(link) && fs::read_symlink(link, error) == target) return;
  if (is_copy_of(link, target)) return;
  fs::remove(link, error);
  if (!error && !target.empty()) fs::create_symlink(target, link, error);
  if (!error) return;
  std::error_code ignored;
  if (has_no_links(error) && fs::is_regular_file(target, ignored)) return copy_file_to(link, target);
  throw InputError(link.string() + ": cannot be linked to " + target.string() + " (" + error.message() +
                   "): name a folder on another file system with --work");
}

void remove_all_of(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) throw InputError(path.string() + ": cannot be removed (" + error.message() + ")");
}

}  // namespace lumatlas
