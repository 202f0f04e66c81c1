// SPDX-License-Identifier: GPL-3.0-or-later
// Plans which photographs COLMAP compares with which.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/capture/sources/captured_photographs.h"

namespace lumatlas {

enum class Matching {
  automatic,   // exhaustive up to kMostForExhaustive photographs; above, whatever tells neighbours, see plan_matching()
  exhaustive,  // each with each
  sequential,  // each with its neighbours by name: of a video or a walk
  spatial,     // each with those that were taken near it, as GPS tells
};
inline constexpr std::size_t kMostForExhaustive = 200;

struct MatchingOptions {
  Matching matching = Matching::automatic;
  // A vocabulary tree, as COLMAP's site offers them: each photograph is compared with those that look like it, too.
  std::optional<std::filesystem::path> vocabulary;
};

// The comparisons that COLMAP is asked for, one after the other; what was compared before is not compared again.
struct MatchingPlan {
  bool exhaustive = false;
  bool by_order = false;  // neighbours by name
  bool by_place = false;  // neighbours by GPS
  std::optional<std::filesystem::path> vocabulary;
  // Names of photographs that lie evenly among all and are compared each with each: where a walk comes back to its
  // beginning, or one video shows what another does, some of them show the same.
  std::vector<std::string> links;
};

// Plans automatic matching of many photographs by all that tells neighbours: by order; by GPS, where at least half of
// those that are no frames of a video tell their place; by the vocabulary where there is one, and without one by links.
// Names with a blank are no links, for COLMAP's list of pairs cannot hold them. Throws InputError where GPS is asked
// for by Matching::spatial and fewer than half tell it, and where there is no such vocabulary.
[[nodiscard]] MatchingPlan plan_matching(const CapturedPhotographs& captured, const MatchingOptions& options);

// Return what the plan compares, for people, and for the record of what is done.
[[nodiscard]] std::string text_of(const MatchingPlan& plan);
[[nodiscard]] nlohmann::json json_of(const MatchingPlan& plan);

// Returns COLMAP's list of all pairs of the plan's links.
[[nodiscard]] std::string list_of_links(const MatchingPlan& plan);

}  // namespace lumatlas
