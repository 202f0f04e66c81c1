// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/coverage_names.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace lumatlas {

namespace {

using Comparison = CoverageDepartures::Comparison;

struct Switch {
  const char* name;
  bool CoverageDepartures::*field;
};
constexpr std::array<Switch, 4> kSwitches{{{"first-view", &CoverageDepartures::first_view},
                                           {"hemisphere", &CoverageDepartures::hemisphere},
                                           {"share", &CoverageDepartures::bounded_share},
                                           {"references", &CoverageDepartures::references}}};

struct NamedComparison {
  const char* name;
  Comparison value;
};
constexpr std::array<NamedComparison, 2> kComparisons{
    {{"earlier", Comparison::earlier}, {"others", Comparison::others}}};

void depart(CoverageDepartures& departures, const std::string& name) {
  for (const Switch& known : kSwitches) {
    if (name != known.name) continue;
    departures.*known.field = true;
    return;
  }
  for (const NamedComparison& known : kComparisons) {
    if (name != known.name) continue;
    if (departures.comparison != Comparison::everyone && departures.comparison != known.value) {
      throw std::invalid_argument("coverage: departures name both earlier and others, must name one of them at most");
    }
    departures.comparison = known.value;
    return;
  }
  throw std::invalid_argument("coverage: there is no departure called " + name);
}

}  // namespace

std::string metric_name(const CoverageOptions& options) {
  if (options.metric == CoverageOptions::Metric::directions) return "directions";
  return departure_names(options.departures).empty() ? "printed" : "departures";
}

const std::vector<std::string>& departure_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Switch& known : kSwitches) all.emplace_back(known.name);
    for (const NamedComparison& known : kComparisons) all.emplace_back(known.name);
    return all;
  }();
  return names;
}

std::vector<std::string> departure_names(const CoverageDepartures& departures) {
  std::vector<std::string> names;
  for (const Switch& known : kSwitches) {
    if (departures.*known.field) names.emplace_back(known.name);
  }
  for (const NamedComparison& known : kComparisons) {
    if (departures.comparison == known.value) names.emplace_back(known.name);
  }
  return names;
}

CoverageDepartures departures_named(const std::vector<std::string>& names) {
  CoverageDepartures departures = CoverageDepartures::none();
  for (const std::string& name : names) depart(departures, name);
  return departures;
}

}  // namespace lumatlas
