// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/final_names.h"

#include <map>
#include <mutex>

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::mutex final_names_mutex;
std::map<std::string, std::string>& final_names() {                   // guarded by final_names_mutex
  static auto* const names = new std::map<std::string, std::string>;  // never destroyed: threads may outlive main()
  return *names;
}

}  // namespace

void note_final_name(const fs::path& temporary, const fs::path& target) {
  const std::lock_guard lock(final_names_mutex);
  final_names()[temporary.string()] = target.string();
}

void forget_final_name(const fs::path& temporary) {
  const std::lock_guard lock(final_names_mutex);
  final_names().erase(temporary.string());
}

std::string with_final_names(std::string sentence) {
  const std::lock_guard lock(final_names_mutex);
  // In descending order a path comes before the folder that it is in: a temporary file in a temporary folder becomes
  // its target in that folder, and then the folder's target.
  const auto& names = final_names();
  for (auto name = names.rbegin(); name != names.rend(); ++name) {
    const auto& [temporary, target] = *name;
    for (std::size_t at = 0; (at = sentence.find(temporary, at)) != std::string::npos; at += target.size()) {
      sentence.replace(at, temporary.size(), target);
    }
  }
  return sentence;
}

}  // namespace lumatlas
