// SPDX-License-Identifier: GPL-3.0-or-later
// The files of page/, built into the program.
#pragma once

#include <string_view>

namespace lumatlas {

extern const std::string_view k_page_html;  // with places for attributes, policy, generator, title, style and script
extern const std::string_view k_page_style;
extern const std::string_view k_page_script;  // one module: all of page/*.js

// Shaders of the page's own, beside those of blend/shaders.h.
extern const std::string_view k_photograph_frag;
extern const std::string_view k_bc7_frag;
extern const std::string_view k_etc2_frag;
extern const std::string_view k_depth_frag;
extern const std::string_view k_page_frag;
extern const std::string_view k_modes_frag;
extern const std::string_view k_fade_frag;
extern const std::string_view k_glance_frag;
extern const std::string_view k_needs_frag;
extern const std::string_view k_surroundings_frag;

}  // namespace lumatlas
