// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/step_record.h"

#include <chrono>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/output_folder.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

namespace fs = std::filesystem;
using nlohmann::json;

json file_state(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) return {};
  const auto time = fs::last_write_time(file, error);
  if (error) return {};
  return {{"size", size}, {"time", time.time_since_epoch().count()}};
}

StepRecord::StepRecord(fs::path file) : file_(std::move(file)) {
  std::error_code ignored;
  if (!fs::exists(file_, ignored)) return;
  json read = read_json(file_);
  const bool is_record = read.is_object() && read.contains("steps") && read["steps"].is_object();
  if (!is_record) throw InputError(file_.string() + ": is no record of `lumatlas capture`: remove it, or its folder");
  steps_ = std::move(read["steps"]);
}

json StepRecord::entry(const std::string& step) const {
  const auto found = steps_.find(step);
  return found != steps_.end() && found->is_object() ? *found : json::object();
}

bool StepRecord::is_done(const std::string& step, const json& inputs) const {
  if (this->inputs(step) != inputs || stamp(step).is_null()) return false;
  const json outputs = entry(step).value("outputs", json());
  for (const auto& [path, state] : outputs.items()) {
    if (file_state(path) != state) return false;
  }
  return true;
}

json StepRecord::inputs(const std::string& step) const {
  return entry(step).value("inputs", json());
}

json StepRecord::stamp(const std::string& step) const {
  return entry(step).value("finished", json());
}

void StepRecord::forget(const std::string& step) {
  if (steps_.erase(step) > 0) write();
}

void StepRecord::begin(const std::string& step, const json& inputs) {
  steps_[step] = {{"inputs", inputs}};
  write();
}

void StepRecord::finish(const std::string& step, std::span<const fs::path> outputs) {
  json& entry = steps_[step];
  entry["outputs"] = json::object();
  for (const fs::path& output : outputs) entry["outputs"][output.string()] = file_state(output);
  entry["finished"] = std::chrono::system_clock::now().time_since_epoch().count();
  write();
}

void StepRecord::write() const {
  write_json(file_, {{"lumatlas", LUMATLAS_VERSION}, {"steps", steps_}});
}

}  // namespace lumatlas
