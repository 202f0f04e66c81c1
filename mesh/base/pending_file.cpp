// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/pending_file.h"

#include <unistd.h>

#include <atomic>
#include <string>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

std::filesystem::path temporary_beside(const std::filesystem::path& target) {
  static std::atomic<unsigned> serial{0};
  std::string name = ".";
  name += target.stem().string();
  name.append(".").append(std::to_string(getpid())).append("-").append(std::to_string(serial++));
  name += target.extension().string();
  return target.parent_path() / name;
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path target)
    : target_(std::move(target)), temporary_(temporary_beside(target_)) {
  const std::filesystem::path folder = target_.has_parent_path() ? target_.parent_path() : ".";
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    throw InputError(target_.string() + ": cannot be written, its folder does not exist");
  }
}

PendingFile::~PendingFile() {
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void PendingFile::commit() {
  std::error_code error;
  std::filesystem::rename(temporary_, target_, error);
  if (error) throw InputError(target_.string() + ": cannot be written (" + error.message() + ")");
}

}  // namespace lumatlas
