// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/step_record.h"

#include <chrono>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/output_folder.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::string_view kHexadecimal = "hexadecimal:";

// A text that JSON can hold, another one for each text.
std::string kept_text(const std::string& text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  if (is_utf8(text) && !text.starts_with(kHexadecimal)) return text;
  std::string kept(kHexadecimal);
  for (const unsigned char byte : text) kept.append({kDigits[byte / 16], kDigits[byte % 16]});
  return kept;
}

// The inverse of kept_text().
std::string given_text(const std::string& kept) {
  if (!kept.starts_with(kHexadecimal)) return kept;
  std::string text;
  for (std::size_t at = kHexadecimal.size(); at + 1 < kept.size(); at += 2) {
    text += static_cast<char>(std::strtol(kept.substr(at, 2).c_str(), nullptr, 16));
  }
  return text;
}

}  // namespace

bool is_utf8(const std::string& text) {
  try {
    (void)json(text).dump();
    return true;
  } catch (const json::type_error&) {
    return false;
  }
}

json kept_json(const json& value) {
  if (value.is_string()) return kept_text(value.get<std::string>());
  if (!value.is_structured()) return value;
  json result = value.is_array() ? json::array() : json::object();
  for (const auto& [key, element] : value.items()) {
    value.is_array() ? result.push_back(kept_json(element)) : void(result[kept_text(key)] = kept_json(element));
  }
  return result;
}

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
  if (!fs::exists(file_, ignored)) {
    write();
    return;
  }
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
  if (this->inputs(step) != kept_json(inputs) || stamp(step).is_null()) return false;
  const json outputs = entry(step).value("outputs", json());
  for (const auto& [path, state] : outputs.items()) {
    if (file_state(given_text(path)) != state) return false;
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
  steps_[step] = {{"inputs", kept_json(inputs)}};
  write();
}

void StepRecord::finish(const std::string& step, std::span<const fs::path> outputs) {
  json& entry = steps_[step];
  entry["outputs"] = json::object();
  for (const fs::path& output : outputs) entry["outputs"][kept_text(output.string())] = file_state(output);
  entry["finished"] = std::chrono::system_clock::now().time_since_epoch().count();
  write();
}

void StepRecord::write() const {
  write_json(file_, {{"lumatlas", LUMATLAS_VERSION}, {"steps", steps_}});
}

}  // namespace lumatlas
