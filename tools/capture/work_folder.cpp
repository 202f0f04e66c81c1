// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/work_folder.h"

#include <algorithm>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace fs = std::filesystem;

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

void put_link(const fs::path& link, const fs::path& target) {
  std::error_code error;
  if (!target.empty() && fs::is_symlink(link) && fs::read_symlink(link, error) == target) return;
  fs::remove(link, error);
  if (!error && !target.empty()) fs::create_symlink(target, link, error);
  if (error) {
    throw InputError(link.string() + ": cannot be linked to " + target.string() + " (" + error.message() + ")");
  }
}

void remove_all_of(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) throw InputError(path.string() + ": cannot be removed (" + error.message() + ")");
}

}  // namespace lumatlas
