// SPDX-License-Identifier: GPL-3.0-or-later
// Records which steps of a long job are done, and from which inputs, so that the job can resume where it ended.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace lumatlas {

// Size and time of last change of a file, by which another one under its name is told. Null: there is no such file.
[[nodiscard]] nlohmann::json file_state(const std::filesystem::path& file);

// Returns whether JSON can hold the text as it is.
[[nodiscard]] bool is_utf8(const std::string& text);

// Returns the value as a StepRecord keeps it: texts that JSON cannot hold are replaced, different ones by different
// texts.
[[nodiscard]] nlohmann::json kept_json(const nlohmann::json& value);

// A JSON file that is written anew, in one step, whenever a step begins or ends. Texts in it that are not UTF-8, names
// of files, are kept in hexadecimal digits, so that they are known again.
class StepRecord {
 public:
  // Reads what an earlier run wrote, or writes an empty record where there is no such file. Throws InputError for a
  // file that is no record, and where none can be written.
  explicit StepRecord(std::filesystem::path file);

  // Returns whether the step was finished with these inputs, and its outputs are still as it left them.
  [[nodiscard]] bool is_done(const std::string& step, const nlohmann::json& inputs) const;
  // kept_json() of what the step was last begun with; null: it never was.
  [[nodiscard]] nlohmann::json inputs(const std::string& step) const;
  // Different after each time that the step was finished: an input of the steps after it. Null: it is not finished.
  [[nodiscard]] nlohmann::json stamp(const std::string& step) const;

  void forget(const std::string& step);
  void begin(const std::string& step, const nlohmann::json& inputs);
  void finish(const std::string& step, std::span<const std::filesystem::path> outputs);

 private:
  [[nodiscard]] nlohmann::json entry(const std::string& step) const;
  void write() const;

  std::filesystem::path file_;
  nlohmann::json steps_ = nlohmann::json::object();
};

}  // namespace lumatlas
