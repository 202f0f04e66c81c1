// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/error_sentence.h"

#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>
#include <typeinfo>

#include "mesh/base/final_names.h"

namespace lumatlas {

namespace {

std::string sentence_of_files(const std::filesystem::filesystem_error& error) {
  const std::string first = error.path1().string(), second = error.path2().string();
  const std::string paths = second.empty() ? first : first + " and " + second;
  return (paths.empty() ? "a file" : paths) + ": cannot be used: " + error.code().message();
}

std::string sentence_of(const std::exception& error) {
  if (const auto* files = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    return sentence_of_files(*files);
  }
  if (const auto* system = dynamic_cast<const std::system_error*>(&error)) {
    if (system->code() != std::errc::resource_unavailable_try_again) return system->what();
    return "no more threads can be started: raise the limits of processes and memory (`ulimit -u`, `ulimit -v`)";
  }
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) {
    return "out of memory: use fewer or smaller photographs (--max-views), or a smaller mesh";
  }
  if (dynamic_cast<const nlohmann::json::exception*>(&error) != nullptr) {
    return std::string("a JSON file holds something else than expected: ") + error.what();
  }
  return error.what();
}

}  // namespace

std::string error_sentence(const std::exception& error) {
  std::string sentence = with_final_names(sentence_of(error));
  if (!sentence.empty()) return sentence;
  return std::string("an error of the kind ") + typeid(error).name() + " that says nothing more";
}

}  // namespace lumatlas
