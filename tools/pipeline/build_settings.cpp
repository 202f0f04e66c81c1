// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/build_settings.h"

#include "tools/pipeline/model_budget.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

// The format of texels: one of two, or compressed where `tight_tiles` allow it.
enum class HeldTexels { automatic, rgb8, bc7 };

HeldTexels held_texels(const BuildOptions& options) {
  if (options.tight_tiles) return HeldTexels::automatic;
  return options.tiles.texels == TexelFormat::bc7 ? HeldTexels::bc7 : HeldTexels::rgb8;
}

void hold_texels(BuildOptions& options, HeldTexels held) {
  options.tiles.texels = held == HeldTexels::bc7 ? TexelFormat::bc7 : TexelFormat::rgb8;
  options.tight_tiles.reset();
  if (held == HeldTexels::automatic) options.tight_tiles = compressed_tiles(options.tiles);
}

Settings<BuildOptions> stream_settings() {
  using Options = BuildOptions;
  return {
      choice_setting(
          "stream.order", &Options::order,
          {{"given", StreamOrder::given}, {"reversed", StreamOrder::reversed}, {"shuffled", StreamOrder::shuffled}},
          "Order in which photographs are offered; given: by name"),
      choice_setting(
          "stream.choice", &Options::choice,
          {{"online", ViewChoice::online},
           {"offline", ViewChoice::offline},
           {"uniform", ViewChoice::uniform},
           {"random", ViewChoice::random}},
          "Choice of the photographs: by the planner, one after the other; to compare with, by one that knows all "
          "cameras, evenly spaced, at random"),
      switch_setting("stream.sharp-first", &Options::sharp_first,
                     "Store sharp photographs rather than blurred ones of the same; reads all of them"),
      whole_setting("stream.seed", &Options::seed, "N", whole_number_rule(0),
                    "Seed of stream.order shuffled and stream.choice random"),
  };
}

Settings<BuildOptions> surface_settings() {
  const auto far_sphere = [](auto& options) -> auto& {
    return options.completion;
  };
  return joined<BuildOptions>(
      {within<BuildOptions>("surface.",
                            Settings<CompletionOptions>{switch_setting(
                                "far-sphere", &CompletionOptions::far_sphere,
                                "Show sky and distant surroundings; off: fill them like holes, from their "
                                "surroundings in the picture")},
                            far_sphere),
       {switch_setting("surface.exact", &BuildOptions::measure_deviation,
                       "Take the surface as exact, and draw it sharp also where photographs disagree on it", false)}});
}

Settings<BuildOptions> tight_settings() {
  return {named_setting<BuildOptions, HeldTexels>(
              "tiles.texels", {{"auto", HeldTexels::automatic}, {"rgb8", HeldTexels::rgb8}, {"bc7", HeldTexels::bc7}},
              held_texels, hold_texels,
              "Format of photographs on the GPU: rgb8, exact; bc7, compressed to a third of the bytes; auto: bc7 if a "
              "budget in bytes needs it, or if --budget auto measures that it loses at most half of --loss"),
          number_setting("budget.least-scale", &BuildOptions::least_scale, "SHARE", number_rule(0.1, 1),
                         "Smallest scale, of width and height, to which --budget auto or in bytes may downscale "
                         "photographs")};
}

Settings<BuildOptions> further_refinement_settings() {
  return {switch_setting("refinement.lenses", &BuildOptions::refine_lenses,
                         "With --refine all or joint, correct lenses that the photographs contradict"),
          switch_setting("refinement.shutters", &BuildOptions::refine_shutters,
                         "With --refine joint, straighten photographs that a rolling shutter read while the camera "
                         "moved"),
          whole_setting("refinement.polish-steps", &BuildOptions::max_polish_steps, "N", whole_number_rule(1, 10000),
                        "With --refine joint, steps of polishing all stored views together")};
}

}  // namespace

Settings<BuildOptions> build_settings() {
  using Options = BuildOptions;
  return joined<Options>({within<Options>("", planner_settings(), &Options::planner), further_refinement_settings(),
                          stream_settings(), surface_settings(),
                          within<Options>("cells.", cell_settings(), &Options::cells),
                          within<Options>("tiles.", tile_settings(), &Options::tiles), tight_settings()});
}

}  // namespace lumatlas
