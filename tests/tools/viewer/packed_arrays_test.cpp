// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/packed_arrays.h"

#include <zlib.h>

#include <catch2/catch.hpp>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace lumatlas {
namespace {

std::vector<std::uint8_t> inflated(const std::vector<std::uint8_t>& bytes, std::size_t size) {
  std::vector<std::uint8_t> result(size + 1);
  uLongf length = result.size();
  REQUIRE(uncompress(result.data(), &length, bytes.data(), bytes.size()) == Z_OK);
  result.resize(length);
  return result;
}

TEST_CASE("differences alternate in sign and are kept by the significance of their bytes") {
  PackedArrays arrays;
  const std::vector<std::uint32_t> values{5, 1000, 4, 1300, 4, 1299};
  arrays.add("pairs", values, 2, PackedCoding::difference);
  REQUIRE(arrays.description().size() == 1);
  CHECK(arrays.description()[0]["entries"] == 3);
  CHECK(arrays.description()[0]["bytes"] == 2);
  // 10, 1, 0 and 2000, 600, 1
  CHECK(inflated(arrays.deflated(), 12) ==
        std::vector<std::uint8_t>{10, 1, 0, 0, 0, 0, 2000 % 256, 600 % 256, 1, 2000 / 256, 600 / 256, 0});
}

TEST_CASE("corners are how far below the next new vertex") {
  PackedArrays arrays;
  const std::vector<std::uint32_t> corners{0, 1, 2, 2, 1, 3};
  arrays.add("corners", corners, 3, PackedCoding::corners);
  // One byte pair for each corner of a face: 0, 1; 0, 2; 0, 0
  CHECK(inflated(arrays.deflated(), 6) == std::vector<std::uint8_t>{0, 1, 0, 2, 0, 0});
  CHECK_THROWS_AS(PackedArrays().add("corners", std::vector<std::uint32_t>{1, 0, 2}, 3, PackedCoding::corners),
                  std::invalid_argument);
}

TEST_CASE("arrays that are empty or zero take no bytes, and values in parts of entries are refused") {
  PackedArrays arrays;
  arrays.add("nothing", {}, 3, PackedCoding::plain);
  arrays.add("zeros", std::vector<std::uint32_t>(100, 0), 1, PackedCoding::difference);
  CHECK(arrays.description()[1]["bytes"] == 0);
  CHECK(inflated(arrays.deflated(), 0).empty());
  CHECK_THROWS_AS(arrays.add("odd", std::vector<std::uint32_t>(5, 0), 3, PackedCoding::plain), std::invalid_argument);
}

TEST_CASE("what is larger than a buffer is deflated whole") {
  std::vector<std::uint8_t> bytes(300000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i >> 3);
  CHECK(inflated(deflated(bytes), bytes.size()) == bytes);
}

}  // namespace
}  // namespace lumatlas
