// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/coverage_names.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace lumatlas {
namespace {

using Names = std::vector<std::string>;

TEST_CASE("every departure goes by its name alone, and its name comes back") {
  for (const std::string& name : departure_names()) {
    CAPTURE(name);
    const CoverageDepartures departures = departures_named({name});
    CHECK(departure_names(departures) == Names{name});
    CHECK(departures.first_view == (name == "first-view"));
    CHECK(departures.hemisphere == (name == "hemisphere"));
    CHECK(departures.bounded_share == (name == "share"));
    CHECK(departures.references == (name == "references"));
  }
  CHECK(departures_named({"earlier"}).comparison == CoverageDepartures::Comparison::earlier);
  CHECK(departures_named({"others"}).comparison == CoverageDepartures::Comparison::others);
  CHECK(departures_named({}).comparison == CoverageDepartures::Comparison::everyone);
}

TEST_CASE("a departure that does not exist, and two comparisons at once, are refused") {
  CHECK_THROWS_WITH(departures_named({"first-view", "sideways"}), Catch::Contains("no departure called sideways"));
  CHECK_THROWS_WITH(departures_named({"earlier", "share", "others"}), Catch::Contains("earlier and others"));
  CHECK_NOTHROW(departures_named({"earlier", "earlier"}));
}

TEST_CASE("a measure is called printed only if nothing of it departs from the print") {
  CoverageOptions options;
  CHECK(metric_name(options) == "directions");
  options.metric = CoverageOptions::Metric::paper;
  CHECK(metric_name(options) == "departures");
  CHECK(departure_names(options.departures) == Names{"first-view", "hemisphere", "share", "references", "earlier"});
  options.departures = CoverageDepartures::none();
  CHECK(metric_name(options) == "printed");
  CHECK(departure_names(options.departures).empty());
  options.departures.bounded_share = true;
  CHECK(metric_name(options) == "departures");
}

}  // namespace
}  // namespace lumatlas
