// SPDX-License-Identifier: GPL-3.0-or-later
// The settings that a caller gave for a build by name, with the rules between them: the same for `--set` and for the
// Python module.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tools/pipeline/build_options.h"
#include "tools/pipeline/model_budget.h"
#include "tools/settings/setting.h"

namespace lumatlas {

// "tiles.tile: needs tiles.layout=tiles".
struct SettingError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

class GivenBuildSettings {
 public:
  // Throws SettingError for a name that build_settings() lacks, for one that comes twice, and for a value that its row
  // does not allow.
  explicit GivenBuildSettings(std::vector<Assignment> given);

  // Sets the fields, and the gutter and the compressed tiles that follow from them. Throws SettingError for a setting
  // that has no effect beside the others.
  void apply(BuildOptions& options) const;

  // Throws SettingError for a setting without effect with that budget or that refinement.
  void check_budget(const ModelBudget& budget, const BuildOptions& options) const;
  void check_refinement(RefineMode refine) const;

  // Sets again the fields that choose_by_loss() has changed.
  void choose_by_given(PlannerOptions& planner) const;

 private:
  [[nodiscard]] std::optional<std::string> value(std::string_view name) const;
  void refuse(std::string_view name, const std::string& why) const;
  void refuse_subject(std::string_view subject, const std::string& why) const;
  void check_coverage(const CoverageOptions& coverage) const;
  void check_tiles() const;
  void set_texels(BuildOptions& options) const;

  std::vector<Assignment> given_;
};

}  // namespace lumatlas
