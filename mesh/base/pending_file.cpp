// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/pending_file.h"

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/final_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

fs::path folder_of(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : ".";
}

// Writers choose the format by it. A longer one would make a name that is too long, and means no format.
std::string short_ending(const fs::path& target) {
  constexpr std::size_t kLongestEnding = 16;
  const std::string ending = target.extension().string();
  return ending.size() <= kLongestEnding ? ending : "";
}

[[noreturn]] void refuse(const fs::path& target, const std::string& reason) {
  throw InputError(target.string() + ": cannot be written (" + reason + ")");
}

std::unique_ptr<TemporaryEntry> temporary_beside(const fs::path& target) {
  const fs::path folder = folder_of(target);
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    throw InputError(target.string() + ": cannot be written, its folder does not exist");
  }
  try {
    return std::make_unique<TemporaryEntry>(TemporaryEntry::Kind::file, folder,
                                            [&] { return random_temporary_name(short_ending(target)); });
  } catch (const std::system_error& error) {
    refuse(target, error.code().message());
  }
}

}  // namespace

PendingFile::PendingFile(fs::path target) : target_(std::move(target)), temporary_(temporary_beside(target_)) {
  note_final_name(path(), target_);
}

void PendingFile::commit(Durability durability) {
  const auto code = [] { return std::error_code(errno, std::generic_category()).message(); };
  if (durability == Durability::on_disk && !sync_to_disk(path())) refuse(target_, code());
  {
    const auto lock = removal_paused();
    std::error_code error;
    fs::rename(path(), target_, error);
    if (error) refuse(target_, error.message());
    temporary_->release();
    forget_final_name(path());
  }
  if (durability == Durability::on_disk && !sync_to_disk(folder_of(target_))) refuse(target_, code());
}

}  // namespace lumatlas
