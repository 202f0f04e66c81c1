// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers that name one entry of a list, with a type for each kind of list, so that the number of a cell is not taken
// for that of a face.
//
//   std::vector<FaceId> face = visible.face;
//   if (face[pixel] != FaceId::none) ++pixels[cells.cell_of_face[face[pixel]]];
#pragma once

#include <compare>
#include <cstdint>
#include <type_traits>

namespace lumatlas {

// Has the size and the layout of std::uint32_t, so that a list of them can be written to a file or to the GPU as it
// is. Reads as a number where one is needed: to index, to compare with a number, to print. A number becomes an Id only
// where the caller says so; whole literals such as the 0 and 3 of `{0, 3}` need no saying. Ids of different kinds
// neither convert to one another nor compare.
template <typename Kind>
class Id {
 public:
  static const Id none;  // 0xffffffff: names no entry

  constexpr Id() = default;  // none
  explicit constexpr Id(std::uint32_t number) : number_(number) {}
  template <typename Literal>
  requires std::is_same_v<Literal, int>
  consteval Id(Literal number)  // NOLINT(google-explicit-constructor): see above
      : number_(number >= 0 ? static_cast<std::uint32_t>(number) : throw "an Id is not negative") {}
  template <typename Other>
  Id(Id<Other>) = delete;

  constexpr operator std::uint32_t() const { return number_; }  // NOLINT(google-explicit-constructor): see above

  constexpr Id& operator++() {  // to the next entry
    ++number_;
    return *this;
  }

 private:
  std::uint32_t number_ = 0xffffffffu;
};

template <typename Kind>
inline constexpr Id<Kind> Id<Kind>::none{};

// Templates, so that a comparison with a number compares numbers.
template <typename Kind>
[[nodiscard]] constexpr bool operator==(Id<Kind> a, Id<Kind> b) {
  return std::uint32_t{a} == std::uint32_t{b};
}
template <typename Kind, typename Other>
requires(!std::is_same_v<Kind, Other>) bool operator==(Id<Kind>, Id<Other>) = delete;
template <typename Kind, typename Other>
requires(!std::is_same_v<Kind, Other>) std::strong_ordering operator<=>(Id<Kind>, Id<Other>) = delete;

using FaceId = Id<struct FaceKind>;      // of a mesh
using VertexId = Id<struct VertexKind>;  // of a mesh
using CellId = Id<struct CellKind>;      // of a surface
using ViewSlot = Id<struct ViewKind>;    // of a store of views
using TilePlace = Id<struct TileKind>;   // of a texture array

static_assert(sizeof(FaceId) == sizeof(std::uint32_t));
static_assert(alignof(FaceId) == alignof(std::uint32_t));
static_assert(std::is_trivially_copyable_v<FaceId> && std::is_standard_layout_v<FaceId>);

}  // namespace lumatlas
