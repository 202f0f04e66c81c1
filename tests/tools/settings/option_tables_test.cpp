// SPDX-License-Identifier: GPL-3.0-or-later
// Every field of an option struct has a row, or stands here with the reason why not; and every row does what it says.
#include "tools/settings/option_tables.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "tools/lab/timing/frame_size_settings.h"
#include "tools/picture/tour_settings.h"
#include "tools/pipeline/build_settings.h"

namespace lumatlas {
namespace {

template <typename... Fields>
constexpr std::size_t count_of(const Fields&... /*fields*/) {
  return sizeof...(Fields);
}

// A struct that gets a further field does not compile here any more: give the field a row, or say why it has none.
TEST_CASE("every field has a row, an option of a command, a table of its own, or is for callers alone") {
  {
    const auto [partition, size, normal_weight] = CellOptions();  // size: --cell-size
    CHECK(cell_settings().size() == count_of(partition, size, normal_weight) - 1);
  }
  {
    const auto [metric, departures, lambda, ideal_distance, distance_sigma, max_references, max_cell_coverage, demand,
                demand_prior, directions, direction_width, reference_width, reference_lambda, views_per_direction] =
        CoverageOptions();  // metric: in planner_settings(); departures: a table
    CHECK(coverage_settings().size() == count_of(metric, departures, lambda, ideal_distance, distance_sigma,
                                                 max_references, max_cell_coverage, demand, demand_prior, directions,
                                                 direction_width, reference_width, reference_lambda,
                                                 views_per_direction) -
                                            2);
  }
  {
    const auto [comparison, first_view, hemisphere, bounded_share, references] = CoverageDepartures();
    CHECK(departure_settings().size() == count_of(comparison, first_view, hemisphere, bounded_share, references));
  }
  {
    const auto [depth_edge, edge_radius_px, fade_px, edges] = ValidityOptions();
    CHECK(mask_settings().size() == count_of(depth_edge, edge_radius_px, fade_px, edges));
  }
  {
    const auto [pose, exposure, white_balance, max_move, least_improvement, least_move_px, prior, levels,
                max_iterations, correlation] =
        AlignmentOptions();  // pose, exposure: --refine; correlation: for callers
    CHECK(alignment_settings().size() == count_of(pose, exposure, white_balance, max_move, least_improvement,
                                                  least_move_px, prior, levels, max_iterations, correlation) -
                                             3);
  }
  {
    const auto [enabled, grid_px, least_difference, least_to_spread, least_views, comparable_deg, highlight_deg] =
        TrustOptions();
    CHECK(trust_settings().size() ==
          count_of(enabled, grid_px, least_difference, least_to_spread, least_views, comparable_deg, highlight_deg));
  }
  {
    const auto [trust, alignment, samples, sample_px, revisits, polish_levels, least_correlation, least_views,
                cancel_check, given_gain] = RefinementOptions();  // trust, alignment: tables; the last two: for callers
    CHECK(refinement_settings().size() == count_of(trust, alignment, samples, sample_px, revisits, polish_levels,
                                                   least_correlation, least_views, cancel_check) -
                                              3);
  }
  {
    const auto [coverage, validity, refinement, min_view_gain, min_exchange_gain, min_reference_gain, victims,
                max_bytes, max_loss_db, visibility_px] = PlannerOptions();  // max_bytes: --photograph-bytes;
                                                                            // max_loss_db: --loss; the first: tables
    const std::size_t own = count_of(coverage, validity, refinement, min_view_gain, min_exchange_gain,
                                     min_reference_gain, victims, max_bytes, max_loss_db, visibility_px) -
                            5;
    const std::size_t in_tables = coverage_settings().size() + departure_settings().size() + mask_settings().size() +
                                  refinement_settings().size() + alignment_settings().size() + trust_settings().size();
    CHECK(planner_settings().size() == own + in_tables + 1);  // coverage.metric
  }
  {
    const auto [tile_px, gutter_px, max_tiles, texels] = TileOptions();  // max_tiles: --budget; texels: in
                                                                         // build_settings(), which choose a format
    CHECK(tile_settings().size() == count_of(tile_px, gutter_px, max_tiles, texels) - 2 + 1);  // tiles.layout
  }
  {
    const auto [views, lambda, position, rims, fade_last, consistent, frame_fade, sampling, soften, soft_edges,
                outlines, prefilter, exposure, border_width, supersample, antialias, occlusion_tolerance] =
        BlendOptions();  // exposure, supersample: options
    CHECK(blend_settings().size() == count_of(views, lambda, position, rims, fade_last, consistent, frame_fade,
                                              sampling, soften, soft_edges, outlines, prefilter, exposure, border_width,
                                              supersample, antialias, occlusion_tolerance) -
                                         2 + 1);  // blend.weights
  }
  {
    const auto [width, height] = FrameSize();
    CHECK(frame_size_settings().size() == count_of(width, height));
  }
  {
    const auto [quality, sure_views, noise] = CutOptions();
    CHECK(cut_settings().size() == count_of(quality, sure_views, noise));
  }
  {
    const auto [sharpness, tolerance, exposure] = ColorOptions();  // exposure: --exposure
    CHECK(color_settings().size() == count_of(sharpness, tolerance, exposure) - 1);
  }
  {
    const auto [merge_degrees, most_degrees, reach] = ChartOptions();
    CHECK(chart_settings().size() == count_of(merge_degrees, most_degrees, reach));
  }
}

// Structs with fields that are options of commands for the most part.
TEST_CASE("the fields of structs that commands have options for are rows where they have none") {
  {
    const auto [charts, layout, color, texels_per_pixel, most_texels_at_once] = TextureOptions();  // --density
    const auto [most_side_px, most_pages, gutter_px] = LayoutOptions();                            // --texture, --pages
    const std::size_t own = count_of(charts, layout, color, texels_per_pixel, most_texels_at_once) - 4;
    const std::size_t of_layout = count_of(most_side_px, most_pages, gutter_px) - 2;
    CHECK(texture_settings().size() == own + of_layout + color_settings().size() + chart_settings().size());
  }
  {
    const auto [complete, complete_frame, from, points, pictures, spacing_px, most_points, longest_edge, cut, voxel,
                depth_unit, most_faces, stereo, block_px, stereo_folder, most_photographs, hold_out] =
        SceneMeshOptions();  // block_px alone is no option, no folder and no table
    CHECK(count_of(complete, complete_frame, from, points, pictures, spacing_px, most_points, longest_edge, cut, voxel,
                   depth_unit, most_faces, stereo, block_px, stereo_folder, most_photographs, hold_out) == 17);
    CHECK(mesh_settings().size() == 1 + cut_settings().size());
  }
  {
    const auto [kind, path, frames, width, height, fov_deg, hilbert_order, anywhere, cancel_check] =
        TourOptions();  // the first six: options; cancel_check: for callers
    CHECK(tour_settings().size() ==
          count_of(kind, path, frames, width, height, fov_deg, hilbert_order, anywhere, cancel_check) - 7);
  }
  {
    const auto [mesh, mesh_frame, georeference, pictures, cells, faces, completion, measure_deviation, close_holes,
                visibility_by, planner, refine, max_polish_steps, refine_lenses, refine_shutters, max_views, tiles,
                tight_tiles, bound, memory, least_scale, texture_px, hold_out, watch, any_mesh, order, sharp_first,
                choice, seed] = BuildOptions();
    CHECK(count_of(mesh, mesh_frame, georeference, pictures, cells, faces, completion, measure_deviation, close_holes,
                   visibility_by, planner, refine, max_polish_steps, refine_lenses, refine_shutters, max_views, tiles,
                   tight_tiles, bound, memory, least_scale, texture_px, hold_out, watch, any_mesh, order, sharp_first,
                   choice, seed) == 29);
    // measure_deviation, max_polish_steps, refine_lenses, refine_shutters, tight_tiles, least_scale, order,
    // sharp_first, choice, seed, and far_sphere of completion; the others are options, follow from --budget and --loss,
    // or have tables.
    CHECK(build_settings().size() == 11 + planner_settings().size() + cell_settings().size() + tile_settings().size());
  }
}

// Texts for a row: those it may allow, and some that no row does.
const std::vector<std::string> kCandidates{"0",     "1",   "2",      "0.5", "64",      "1e-3",    "3",
                                           "on",    "off", "both",   "far", "printed", "grid",    "layers",
                                           "ratio", "bc7", "linear", "all", "others",  "offline", "shuffled"};
const std::vector<std::string> kNeverAllowed{"nan", "inf", "-inf", "", " ", "-2", "1e999", "0x10", "sideways"};

template <typename Options>
void check_rows(const Settings<Options>& table, const Options& defaults) {
  std::set<std::string> names;
  for (const Setting<Options>& row : table) {
    CAPTURE(row.name);
    CHECK(names.insert(row.name).second);
    CHECK(row.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-.") == std::string::npos);
    CHECK_FALSE(row.meaning.empty());
    CHECK(row.rule.complaint != nullptr);
    std::size_t taken = 0;
    for (std::string text : kCandidates) {
      if (!row.rule.complaint(text).empty()) continue;
      ++taken;
      Options options = defaults;
      assign(table, options, row.name, text);
      const nlohmann::json value = row.get(options);
      CAPTURE(text, value);
      if (value.is_number()) {
        CHECK(value.get<double>() == Approx(std::stod(text)));
      } else {
        CHECK(setting_text(value) == text);
      }
    }
    CHECK(taken >= 1);
    for (const std::string& text : kNeverAllowed) {
      Options options = defaults;
      CAPTURE(text);
      CHECK_THROWS_WITH(assign(table, options, row.name, text), Catch::StartsWith(row.name + ": " + text + " is not "));
      CHECK(values_of(table, options) == values_of(table, defaults));
    }
    // A default is a value that may be typed.
    std::string by_default = setting_text(row.get(defaults));
    CHECK(row.rule.complaint(by_default).empty());
  }
}

TEST_CASE("each row takes what it allows, gives it back, and refuses all else by its name") {
  check_rows(build_settings(), BuildOptions());
  check_rows(cell_settings(), CellOptions());
  check_rows(blend_settings(), BlendOptions());
  check_rows(frame_size_settings(), FrameSize());
  check_rows(mesh_settings(), SceneMeshOptions());
  check_rows(texture_settings(), TextureOptions());
  check_rows(tour_settings(), TourOptions());
}

TEST_CASE("the printed measure and the printed weights set what the paper prints, and no more") {
  PlannerOptions planner;
  planner.coverage.lambda = 0.7;
  assign(planner_settings(), planner, "coverage.metric", "printed");
  CHECK(planner.coverage.metric == CoverageOptions::Metric::paper);
  CHECK_FALSE(planner.coverage.departures.hemisphere);
  CHECK(planner.min_view_gain == 0.1);
  CHECK(planner.min_reference_gain == 0.01);
  CHECK(planner.coverage.lambda == 0.7);
  planner.coverage.departures.hemisphere = true;
  CHECK(values_of(planner_settings(), planner)["coverage.metric"] == "departures");
  assign(planner_settings(), planner, "coverage.metric", "directions");
  CHECK(planner.min_view_gain == PlannerOptions().min_view_gain);

  BlendOptions blend;
  assign_all(blend_settings(), blend, {{"rims", "on"}, {"views", "2"}, {"weights", "printed"}});
  CHECK(blend.position == BlendOptions::Position::printed);
  CHECK(blend.occlusion_tolerance == 0);
  CHECK(blend.supersample == 1);
  CHECK(blend.rims);
  CHECK(blend.views == 2);
}

}  // namespace
}  // namespace lumatlas
