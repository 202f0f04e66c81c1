// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/setting_flags.h"

#include <algorithm>

namespace lumatlas {

namespace {

CLI::ValidationError refusal(const std::string& name, const std::string& why) {
  return CLI::ValidationError("--set " + name, why);
}

// Throws CLI::ValidationError for a name that is not listed or a value that its row does not allow.
Assignment assignment_of(const std::string& text, const std::vector<ListedSetting>& settings) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos) throw CLI::ValidationError("--set", text + " is not NAME=VALUE");
  Assignment assignment{text.substr(0, sign), text.substr(sign + 1)};
  const auto row = std::find_if(settings.begin(), settings.end(),
                                [&](const ListedSetting& setting) { return setting.name == assignment.name; });
  if (row == settings.end()) {
    std::vector<std::string> names;
    names.reserve(settings.size());
    for (const ListedSetting& setting : settings) names.push_back(setting.name);
    throw CLI::ValidationError("--set", no_such_setting(assignment.name, names));
  }
  const std::string complaint = row->rule.complaint(assignment.value);
  if (!complaint.empty()) throw refusal(assignment.name, complaint);
  return assignment;
}

std::vector<Assignment> assignments_of(const std::vector<std::string>& texts,
                                       const std::vector<ListedSetting>& settings) {
  std::vector<Assignment> all;
  for (const std::string& text : texts) {
    const Assignment one = assignment_of(text, settings);
    const bool is_second = std::any_of(all.begin(), all.end(), [&](const Assignment& a) { return a.name == one.name; });
    if (is_second) throw refusal(one.name, "is given twice");
    all.push_back(one);
  }
  return all;
}

}  // namespace

void GivenSettings::add_to(CLI::App& command, std::vector<ListedSetting> settings) {
  begin_rare_group(command, "experiments");
  const CLI::callback_t take = [this, settings](const CLI::results_t& texts) {
    all_ = assignments_of(texts, settings);
    return true;
  };
  command.add_option("--set", take, "Set one of the settings below; may be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1, CLI::detail::expected_max_vector_size)
      ->allow_extra_args(false);
  list_settings(command, std::move(settings));
}

std::optional<std::string> GivenSettings::value(std::string_view name) const {
  const auto one = std::find_if(all_.begin(), all_.end(), [&](const Assignment& a) { return a.name == name; });
  return one == all_.end() ? std::nullopt : std::optional(one->value);
}

void GivenSettings::refuse(std::string_view name, const std::string& why) const {
  if (has(name)) throw refusal(std::string(name), why);
}

void GivenSettings::refuse_subject(std::string_view subject, const std::string& why) const {
  for (const Assignment& one : all_) {
    if (one.name.starts_with(subject)) throw refusal(one.name, why);
  }
}

void GivenSettings::refuse_all(const std::string& why) const {
  refuse_subject("", why);
}

}  // namespace lumatlas
