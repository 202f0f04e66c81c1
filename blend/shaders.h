// SPDX-License-Identifier: GPL-3.0-or-later
// The texts of the files in blend/shaders, built into the library.
#pragma once

#include <string_view>

namespace lumatlas {

extern const std::string_view k_surface_vert;
extern const std::string_view k_surface_frag;
extern const std::string_view k_screen_vert;
extern const std::string_view k_blend_frag;
extern const std::string_view k_diagnose_frag;
extern const std::string_view k_silhouettes_frag;
extern const std::string_view k_outline_rows_frag;
extern const std::string_view k_outlines_frag;
extern const std::string_view k_edges_frag;
extern const std::string_view k_edge_rows_frag;
extern const std::string_view k_soft_edges_frag;
extern const std::string_view k_present_frag;
extern const std::string_view k_mask_vert;
extern const std::string_view k_mask_frag;
extern const std::string_view k_visibility_vert;
extern const std::string_view k_visibility_frag;

}  // namespace lumatlas
