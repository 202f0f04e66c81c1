// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/number_text.h"

#include <catch2/catch.hpp>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <locale>
#include <random>

namespace lumatlas {
namespace {

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// Acts like a host with a decimal comma: C++'s own locale, and C's if such a one is installed.
class CommaLocale {
 public:
  CommaLocale() : cpp_(std::locale::global(std::locale(std::locale::classic(), new DecimalComma))) {
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8"}) {
      if (std::setlocale(LC_NUMERIC, name)) return;
    }
  }
  ~CommaLocale() {
    std::locale::global(cpp_);
    std::setlocale(LC_NUMERIC, "C");
  }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

 private:
  std::locale cpp_;
};

TEST_CASE("a number's text is the shortest that says which one it is") {
  CHECK(number_text(0.1) == "0.1");
  CHECK(number_text(0.1f) == "0.1");
  CHECK(number_text(0.0) == "0");
  CHECK(number_text(-0.5) == "-0.5");
  CHECK(number_text(1e-7) == "1e-07");
  CHECK(number_text(100000.0) == "100000");
  CHECK(number_text(1e9) == "1000000000");
  CHECK(number_text(1e300) == "1e+300");
  CHECK(number_text(std::numeric_limits<double>::infinity()) == "inf");
  CHECK(number_text(std::numeric_limits<double>::quiet_NaN()) == "nan");
}

TEST_CASE("a number's text reads back as the same number") {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const double number = std::uniform_real_distribution<double>(-1, 1)(random) *
                          std::pow(10.0, std::uniform_int_distribution<int>(-30, 30)(random));
    CHECK(std::strtod(number_text(number).c_str(), nullptr) == number);
  }
}

TEST_CASE("a number has as many decimals as are asked for") {
  CHECK(number_text(0.984807753, 6) == "0.984808");
  CHECK(number_text(4.0, 6) == "4.000000");
  CHECK(number_text(-1e300, 2).size() == 305);
}

TEST_CASE("numbers have a decimal point where the host has a comma") {
  const CommaLocale comma;
  CHECK(number_text(1234567.5) == "1234567.5");
  CHECK(number_text(1.4, 6) == "1.400000");
}

}  // namespace
}  // namespace lumatlas
