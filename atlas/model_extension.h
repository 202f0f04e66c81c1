// SPDX-License-Identifier: GPL-3.0-or-later
// What the writer and the reader of models must agree on; the fields are described in docs/model-format.md.
#pragma once

namespace lumatlas {

inline constexpr const char* kLumigraphExtension = "LUMATLAS_lumigraph";
inline constexpr const char* kUnlitExtension = "KHR_materials_unlit";
inline constexpr int kLumigraphVersion = 2;

}  // namespace lumatlas
