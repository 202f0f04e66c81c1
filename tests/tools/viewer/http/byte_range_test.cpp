// SPDX-License-Identifier: GPL-3.0-or-later
// The bytes for a Range header: always bytes of the file, and those that RFC 9110 says.
#include "tools/viewer/http/byte_range.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <ostream>
#include <random>
#include <string>
#include <vector>

namespace lumatlas {

bool operator==(const ByteRange& a, const ByteRange& b) {
  return a.answer == b.answer && a.offset == b.offset && a.length == b.length;
}

std::ostream& operator<<(std::ostream& stream, const ByteRange& range) {
  return stream << (range.answer == ByteRange::Answer::whole  ? "whole"
                    : range.answer == ByteRange::Answer::part ? "part"
                                                              : "unsatisfiable")
                << ' ' << range.offset << '+' << range.length;
}

namespace {

constexpr ByteRange kWhole{};
constexpr ByteRange kNone{ByteRange::Answer::unsatisfiable, 0, 0};

ByteRange bytes(std::uint64_t offset, std::uint64_t length) {
  return {ByteRange::Answer::part, offset, length};
}

TEST_CASE("a range is cut off at the end of the file") {
  CHECK(byte_range("bytes=0-0", 10) == bytes(0, 1));
  CHECK(byte_range("bytes=3-5", 10) == bytes(3, 3));
  CHECK(byte_range("bytes=3-", 10) == bytes(3, 7));
  CHECK(byte_range("bytes=9-99999", 10) == bytes(9, 1));
  CHECK(byte_range("bytes=-4", 10) == bytes(6, 4));
  CHECK(byte_range("bytes=-40", 10) == bytes(0, 10));
  CHECK(byte_range("BYTES= 3-5 ", 10) == bytes(3, 3));
  CHECK(byte_range("bytes=,3-5,", 10) == bytes(3, 3));
  CHECK(byte_range("bytes=1-99999999999999999999999999", 10) == bytes(1, 9));
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  CHECK(byte_range("bytes=18446744073709551614-18446744073709551615", kMost) == bytes(kMost - 1, 1));
}

TEST_CASE("a range without a byte of the file is refused") {
  for (const char* header :
       {"bytes=10-", "bytes=10-20", "bytes=-0", "bytes=5-4", "bytes=", "bytes=-", "bytes=--1", "bytes=x-y", "bytes=1",
        "bytes=1-2-3", "bytes=1 - 2", "bytes=+1-2", "bytes=10-,11-12", "bytes=18446744073709551616-", "bytes=0-0,x"}) {
    INFO(header);
    CHECK(byte_range(header, 10) == kNone);
  }
  CHECK(byte_range("bytes=0-", 0) == kNone);
}

TEST_CASE("several ranges, and other units, are answered with the whole file") {
  for (const char* header :
       {"bytes=0-0,2-3", "bytes=0-0,99-", "bytes=-1,-1", "pages=1-2", "bytes", "", "=0-1", "byte=0-1"}) {
    INFO(header);
    CHECK(byte_range(header, 10) == kWhole);
  }
  CHECK(byte_range("bytes=-1", 0) == kWhole);
}

TEST_CASE("whatever is asked for, the answer lies within the file") {
  std::mt19937_64 random(5);
  const std::string letters = "0123456789-,= \t";
  for (int round = 0; round < 200000; ++round) {
    std::string header = "bytes=";
    for (std::uint64_t i = random() % 30; i > 0; --i) header += letters[random() % letters.size()];
    const std::uint64_t size = random() >> (random() % 64);
    const ByteRange range = byte_range(header, size);
    CAPTURE(header, size, range);
    if (range.answer == ByteRange::Answer::part) {
      REQUIRE(range.length > 0);
      REQUIRE(range.offset < size);
      REQUIRE(range.length <= size - range.offset);
    } else {
      REQUIRE((range.offset == 0 && range.length == 0));
    }
  }
}

}  // namespace
}  // namespace lumatlas
