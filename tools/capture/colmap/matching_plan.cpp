// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/matching_plan.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mesh/base/errors.h"
#include "tools/capture/step_record.h"

namespace lumatlas {

namespace {

constexpr std::size_t kMostLinks = 60;    // 1770 pairs: less than neighbours by order of 200 photographs
constexpr double kEnoughWithPlace = 0.5;  // share

// Returns the share of the photographs that are no frames of a video whose headers tell where they were taken.
double share_with_place(const CapturedPhotographs& captured) {
  std::size_t stills = 0, placed = 0;
  for (const CapturedPhotograph& photograph : captured.photographs) {
    if (!photograph.video.empty()) continue;
    ++stills;
    placed += photograph.note.gps ? 1 : 0;
  }
  return stills == 0 ? 0 : static_cast<double>(placed) / static_cast<double>(stills);
}

std::vector<std::string> evenly(const CapturedPhotographs& captured, std::size_t most) {
  std::vector<std::string> usable;
  for (const std::string& name : names_of(captured)) {
    if (name.find(' ') == std::string::npos) usable.push_back(name);
  }
  const std::size_t count = std::min(most, usable.size());
  std::vector<std::string> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(usable[i * usable.size() / count]);
  return chosen;
}

void require_vocabulary(const MatchingOptions& options) {
  std::error_code ignored;
  if (!options.vocabulary || std::filesystem::is_regular_file(*options.vocabulary, ignored)) return;
  throw InputError(options.vocabulary->string() +
                   ": no such file: --vocabulary is a vocabulary tree of COLMAP, which its site offers");
}

}  // namespace

MatchingPlan plan_matching(const CapturedPhotographs& captured, const MatchingOptions& options) {
  require_vocabulary(options);
  MatchingPlan plan;
  plan.vocabulary = options.vocabulary;
  const double with_place = share_with_place(captured);
  switch (options.matching) {
    case Matching::exhaustive:
      plan.exhaustive = true;
      break;
    case Matching::sequential:
      plan.by_order = true;
      break;
    case Matching::spatial:
      if (with_place < kEnoughWithPlace) {
        throw InputError(captured.folder.string() + ": GPS tells the place of " +
                         std::to_string(static_cast<int>(100 * with_place)) +
                         " % of the photographs, --matching spatial needs half: leave it out");
      }
      plan.by_place = true;
      break;
    case Matching::automatic:
      plan.exhaustive = captured.photographs.size() <= kMostForExhaustive;
      if (plan.exhaustive) break;
      plan.by_order = true;
      plan.by_place = with_place >= kEnoughWithPlace;
      if (!plan.vocabulary) plan.links = evenly(captured, kMostLinks);
  }
  if (plan.exhaustive) plan.vocabulary.reset();  // it would add nothing
  return plan;
}

std::string text_of(const MatchingPlan& plan) {
  if (plan.exhaustive) return "each photograph with each";
  std::vector<std::string> parts;
  if (plan.by_order) parts.emplace_back("by name");
  if (plan.by_place) parts.emplace_back("by GPS");
  if (plan.vocabulary) parts.emplace_back("by looks");
  std::string text = "each photograph with its neighbours ";
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  if (!plan.links.empty()) text += ", and " + std::to_string(plan.links.size()) + " photographs with each other";
  return text;
}

nlohmann::json json_of(const MatchingPlan& plan) {
  return {{"exhaustive", plan.exhaustive},
          {"by_order", plan.by_order},
          {"by_place", plan.by_place},
          {"vocabulary", plan.vocabulary ? nlohmann::json{plan.vocabulary->string(), file_state(*plan.vocabulary)}
                                         : nlohmann::json()},
          {"links", plan.links}};
}

std::string list_of_links(const MatchingPlan& plan) {
  std::string list;
  for (std::size_t a = 0; a < plan.links.size(); ++a) {
    for (std::size_t b = a + 1; b < plan.links.size(); ++b) list += plan.links[a] + " " + plan.links[b] + "\n";
  }
  return list;
}

}  // namespace lumatlas
