// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/option_rules.h"

#include <catch2/catch.hpp>
#include <string>

namespace lumatlas {
namespace {

// What a rule makes of a value, or what it complains.
std::string judged(const CLI::Validator& rule, std::string value) {
  const std::string complaint = rule(value);
  return complaint.empty() ? value : complaint;
}

TEST_CASE("whole numbers are decimal digits within their bounds, and nothing else") {
  const CLI::Validator rule = whole_number(1, 12);
  CHECK(rule.get_description() == "1 to 12");
  CHECK(judged(rule, "12") == "12");
  CHECK(judged(rule, "010") == "10");  // which C would read as 8
  for (const std::string wrong : {"0", "13", "-1", "+1", "1.0", "1e1", "0x1", " 1", "", "99999999999999999999"}) {
    CHECK(judged(rule, wrong) == wrong + " is not a whole number from 1 to 12");
  }
  CHECK(judged(whole_number(0), "18446744073709551615") == "18446744073709551615");
  CHECK(judged(whole_number(0), "18446744073709551616") ==
        "18446744073709551616 is not a whole number from 0 to 18446744073709551615");
  CHECK(whole_number(2).get_description() == "2 or more");
  CHECK(whole_number(1).get_description().empty());
}

TEST_CASE("a count may be a word instead") {
  CHECK(judged(count_or({"auto", "keep"}), "keep") == "keep");
  CHECK(judged(count_or({"auto", "keep"}), "007") == "7");
  CHECK(judged(count_or({"auto", "keep"}), "0") == "0 is neither a whole number of 1 or more nor auto or keep");
}

TEST_CASE("numbers are finite and within their bounds, which are printed as they would be typed") {
  CHECK(number_between(1e-6, 0.5).get_description() == "1e-06 to 0.5");
  CHECK(judged(number_between(0, 1), "0.25") == "0.25");
  for (const std::string wrong : {"-1e-9", "1.01", "nan", "inf", "a"}) {
    CHECK(judged(number_between(0, 1), wrong) == wrong + " is not a number from 0 to 1");
  }
  CHECK(judged(finite_not_negative(), "1e300") == "1e300");
  CHECK(judged(finite_not_negative(), "inf") == "inf is not a finite number of 0 or more");
}

TEST_CASE("choices are listed as people list them") {
  CHECK(in_words({}).empty());
  CHECK(in_words({"one"}) == "one");
  CHECK(in_words({"one", "two", "three"}) == "one, two or three");
  CHECK(judged(one_of({"png", "jpeg"}), "jpeg") == "jpeg");
  CHECK(judged(one_of({"png", "jpeg"}), "0") == "0 is not png or jpeg");
}

TEST_CASE("sizes are whole and have a unit of bytes or texels") {
  CHECK(size_bound("97KiB").bytes == 97 * 1024);
  CHECK(size_bound("1mb").bytes == 1'000'000);
  CHECK(size_bound("40Mtexels").texels == 40'000'000);
  CHECK(size_bound("1texel").texels == 1);
  for (const char* const wrong : {"0", "-5", "MB", "1.5GiB", "12 parsecs", "99999999999TiB", "0texels", "3texts"}) {
    CAPTURE(wrong);
    CHECK(size_bound(wrong).bytes == 0);
    CHECK(size_bound(wrong).texels == 0);
  }
  CHECK(judged(byte_size(), "2kB") == "2000");
  CHECK(judged(byte_or_texel_size({"auto"}), "auto") == "auto");
}

}  // namespace
}  // namespace lumatlas
