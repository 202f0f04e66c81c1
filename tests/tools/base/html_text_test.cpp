// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/html_text.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace lumatlas {
namespace {

TEST_CASE("a template's places are filled once, and values are not searched for places") {
  CHECK(filled_template("<{{a}}|{{b}}>", {{"a", "{{b}}"}, {"b", "{{a}}{{data}}"}}) == "<{{b}}|{{a}}{{data}}>");
  CHECK(filled_template("{{a}}{{a}}", {{"a", "x"}}) == "xx");
  CHECK(filled_template("{ { } }} plain", {}) == "{ { } }} plain");
  CHECK(filled_template("", {}).empty());
}

TEST_CASE("a template and its values must fit each other") {
  CHECK_THROWS_AS(filled_template("{{a}}", {}), std::logic_error);
  CHECK_THROWS_AS(filled_template("", {{"a", "x"}}), std::logic_error);
  CHECK_THROWS_AS(filled_template("{{a", {{"a", "x"}}), std::logic_error);
}

}  // namespace
}  // namespace lumatlas
