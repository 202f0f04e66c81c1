// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/settings/setting.h"

#include <catch2/catch.hpp>

namespace lumatlas {
namespace {

enum class Shade { light, dark };

struct Inner {
  double weight = 0.5;
  std::uint32_t count = 3;
};

struct Outer {
  Inner inner;
  bool is_wet = false;
  bool is_off = true;
  Shade shade = Shade::light;
};

Settings<Outer> outer_table() {
  const Settings<Inner> inner{number_setting("weight", &Inner::weight, "W", number_rule(0, 1), "Weight of the inside"),
                              whole_setting("count", &Inner::count, "N", whole_number_rule(1, 8), "Number of insides")};
  Setting<Outer> dry = switch_setting("outer.dry", &Outer::is_wet, "Keep it dry, and the count at 8", false);
  dry.sets_others = true;
  dry.set = [](Outer& outer, const std::string& text) {
    outer.is_wet = text == "off";
    outer.inner.count = 8;
  };
  return joined<Outer>(
      {within<Outer>("inner.", inner, &Outer::inner),
       {dry, choice_setting("outer.shade", &Outer::shade, {{"light", Shade::light}, {"dark", Shade::dark}}, "Shade"),
        switch_setting("outer.off", &Outer::is_off, "Switch")}});
}

std::string refusal_of(const std::string& name, const std::string& value) {
  Outer outer;
  try {
    assign(outer_table(), outer, name, value);
  } catch (const std::invalid_argument& error) {
    CHECK(values_of(outer_table(), outer) == values_of(outer_table(), Outer()));
    return error.what();
  }
  return "taken";
}

TEST_CASE("settings of nested structs are set and read by their names") {
  Outer outer;
  assign(outer_table(), outer, "inner.weight", "0.25");
  assign(outer_table(), outer, "inner.count", "007");
  assign(outer_table(), outer, "outer.shade", "dark");
  assign(outer_table(), outer, "outer.off", "off");
  CHECK(outer.inner.weight == 0.25);
  CHECK(outer.inner.count == 7);
  CHECK(outer.shade == Shade::dark);
  CHECK_FALSE(outer.is_off);
  CHECK(values_of(outer_table(), outer) == nlohmann::json{{"inner.weight", 0.25},
                                                          {"inner.count", 7},
                                                          {"outer.dry", true},
                                                          {"outer.shade", "dark"},
                                                          {"outer.off", false}});
}

TEST_CASE("a refusal names the setting, the value and what is allowed, or the nearest name") {
  CHECK(refusal_of("inner.weight", "nan") == "inner.weight: nan is not a number from 0 to 1");
  CHECK(refusal_of("inner.count", "-1") == "inner.count: -1 is not a whole number from 1 to 8");
  CHECK(refusal_of("outer.shade", "grey") == "outer.shade: grey is not light or dark");
  CHECK(refusal_of("outer.off", "true") == "outer.off: true is not on or off");
  CHECK(refusal_of("inner.wait", "1") == "there is no setting inner.wait; did you mean inner.weight?");
  CHECK(refusal_of("shade", "dark") == "there is no setting shade; did you mean outer.shade?");
  CHECK(refusal_of("sideways", "dark") == "there is no setting sideways: --help-all lists them");
}

TEST_CASE("what sets other settings is set before them, whatever the order in which they are given") {
  for (const bool is_last : {false, true}) {
    std::vector<Assignment> all{{"outer.dry", "on"}, {"inner.count", "2"}};
    if (is_last) std::swap(all[0], all[1]);
    Outer outer;
    assign_all(outer_table(), outer, all);
    CHECK(outer.inner.count == 2);
  }
  Outer outer;
  CHECK_THROWS_AS(assign_all(outer_table(), outer, {{"outer.dri", "on"}}), std::invalid_argument);
}

TEST_CASE("a record of the values sets them again") {
  Outer outer;
  outer.inner = {1e-7, 8};
  outer.shade = Shade::dark;
  Outer again;
  assign_values(outer_table(), again, values_of(outer_table(), outer));
  CHECK(values_of(outer_table(), again) == values_of(outer_table(), outer));
  CHECK(again.inner.weight == 1e-7);
  CHECK_THROWS_AS(assign_values(outer_table(), again, nlohmann::json::object()), nlohmann::json::exception);
  nlohmann::json wrong = values_of(outer_table(), outer);
  wrong["inner.count"] = 9;
  CHECK_THROWS_AS(assign_values(outer_table(), again, wrong), std::invalid_argument);
}

TEST_CASE("what help lists has the defaults of the struct") {
  const std::vector<ListedSetting> rows = listed_settings(outer_table(), Outer());
  REQUIRE(rows.size() == 5);
  CHECK(rows[0].name == "inner.weight");
  CHECK(rows[0].rule.words == "0 to 1");
  CHECK(rows[0].default_text == "0.5");
  CHECK(rows[2].default_text == "on");
  CHECK(rows[3].default_text == "light");
}

}  // namespace
}  // namespace lumatlas
