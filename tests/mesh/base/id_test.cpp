// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/id.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

namespace lumatlas {
namespace {

template <typename A, typename B>
concept Equals = requires(A a, B b) {
  a == b;
};
template <typename A, typename B>
concept IsLess = requires(A a, B b) {
  a < b;
};

static_assert(Equals<FaceId, FaceId> && Equals<FaceId, std::uint32_t> && Equals<std::size_t, FaceId>);
static_assert(IsLess<FaceId, FaceId> && IsLess<FaceId, std::size_t>);
static_assert(!Equals<FaceId, CellId> && !IsLess<FaceId, CellId> && !IsLess<ViewSlot, TilePlace>);
static_assert(!std::is_constructible_v<FaceId, CellId> && !std::is_assignable_v<FaceId&, CellId>);
static_assert(!std::is_convertible_v<std::uint32_t, FaceId> && std::is_constructible_v<FaceId, std::uint32_t>);
static_assert(!std::is_assignable_v<FaceId&, std::uint32_t>);
static_assert(std::is_convertible_v<FaceId, std::uint32_t>);

}  // namespace

TEST_CASE("an id is none until it is given a number, and reads as that number") {
  CHECK(CellId() == CellId::none);
  CHECK(CellId::none == 0xffffffffu);
  const CellId cell{7};
  CHECK(cell != CellId::none);
  CHECK(cell == 7u);
  CHECK(std::vector<int>{0, 1, 2, 3, 4, 5, 6, 70}[cell] == 70);
  CHECK(cell < CellId::none);
}

TEST_CASE("a list of ids has the bytes of a list of their numbers") {
  const std::vector<TilePlace> ids{0, TilePlace::none, 3};
  const std::vector<std::uint32_t> numbers{0, 0xffffffffu, 3};
  CHECK(std::memcmp(ids.data(), numbers.data(), 3 * sizeof(std::uint32_t)) == 0);
}

}  // namespace lumatlas
