// SPDX-License-Identifier: GPL-3.0-or-later
// Names that the writer and the reader of models share; atlas/README.md describes the fields.
#pragma once

#include <cstdint>

namespace lumatlas {

inline constexpr const char* kLumigraphExtension = "LUMATLAS_lumigraph";
inline constexpr const char* kUnlitExtension = "KHR_materials_unlit";
inline constexpr int kLumigraphVersion = 5;
inline constexpr const char* kEastNorthUpFrame = "east-north-up";  // frames of "georeference"
inline constexpr const char* kGeocentricFrame = "geocentric";
inline constexpr const char* kCellAttribute = "_CELL";
inline constexpr const char* kColorAttribute = "COLOR_0";
inline constexpr const char* kTexturedColorAttribute = "_COLOR";  // COLOR_0 would be multiplied with the texture
inline constexpr const char* kPlaceAttribute = "TEXCOORD_0";
inline constexpr const char* kZoneAttribute = "_ZONE";
inline constexpr const char* kSharesAttribute = "_SHARES";
inline constexpr std::uint32_t kMostCells = 1u << 24;  // whole numbers up to this are exact in _CELL, a float

}  // namespace lumatlas
