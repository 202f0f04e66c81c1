// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/base/output_folder.h"
#include "tools/cli/cell_flags.h"
#include "tools/cli/commands.h"
#include "tools/cli/coverage_flags.h"
#include "tools/cli/number_flags.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/build_summary.h"
#include "tools/pipeline/model_output.h"
#include "tools/pipeline/refinement_json.h"

namespace lumatlas {

namespace {

using nlohmann::json;

struct BuildFlags {
  std::filesystem::path scene, output, mesh;
  BuildOptions options;
  HoldFlags hold;
  CellFlags cells;
  bool verbose = false;
  CoverageFlags coverage;
  CLI::Option* views = nullptr;
  CLI::Option* budget = nullptr;
  CLI::Option* loss = nullptr;
  double loss_db = 0.1;
  CLI::Option* tile = nullptr;
  CLI::Option* photographs = nullptr;
  std::string layout = "tiles";
  std::string budget_size;             // empty: unbounded
  std::uint64_t photograph_bytes = 0;  // 0: unbounded
  CLI::Option* seed = nullptr;
  bool refine_intrinsics = false;
  ImageCoding photograph_coding;
  CLI::Option* quality = nullptr;
  bool json_output = false;

  [[nodiscard]] ImageCoding image_coding() const {
    if (quality->count() > 0 && photograph_coding.format == ImageFormat::png) {
      throw CLI::ValidationError("--quality", "needs --image jpeg: PNG is exact");
    }
    return photograph_coding;
  }
};

// Of --budget: as little as a bound on the loss allows.
constexpr const char* kAuto = "auto";

// Of tiles, so many texels of whole slots; of whole views, those of photographs as the planner holds them.
std::uint64_t bytes_of(const SizeBound& bound, const TileOptions& tiles) {
  if (bound.bytes > 0) return bound.bytes;
  Camera one;
  one.width = one.height = 1;
  if (tiles.whole_views()) return bound.texels * stored_bytes(one);
  const std::uint64_t slot_texels = std::uint64_t{tiles.slot_px()} * tiles.slot_px();
  return std::max<std::uint64_t>(bound.texels / slot_texels, 1) * slot_bytes(tiles);
}

// Of tiles, the budget bounds the texture array; the photographs that they are cut from are bounded by their number, or
// by bytes of their own.
void set_budget(const BuildFlags& flags, BuildOptions& options) {
  constexpr std::uint64_t kPhotographsPerArray = 4;
  const bool tiles = flags.layout == "tiles";
  if (!tiles) {
    if (flags.tile->count() > 0) throw CLI::ValidationError("--tile", "needs --layout tiles");
    if (flags.photographs->count() > 0) throw CLI::ValidationError("--photographs", "needs --layout tiles");
    options.tiles.tile_px = 0;
  }
  if (flags.budget_size == kAuto) {
    options.planner.max_bytes = flags.photograph_bytes;
    options.planner.max_loss_db = flags.loss_db;
    flags.coverage.apply_parsimony(options.planner);
    if (flags.views->count() == 0) options.max_views.reset();
    return;
  }
  if (flags.loss->count() > 0) throw CLI::ValidationError("--loss", "needs --budget auto");
  const std::uint64_t budget = flags.budget->count() > 0 ? bytes_of(size_bound(flags.budget_size), options.tiles) : 0;
  if (tiles && flags.budget->count() > 0 && budget < slot_bytes(options.tiles)) {
    throw CLI::ValidationError("--budget", "is " + std::to_string(budget) + " bytes, less than the " +
                                               std::to_string(slot_bytes(options.tiles)) +
                                               " of a single tile: give more, or smaller tiles (--tile)");
  }
  options.planner.max_bytes = tiles ? flags.photograph_bytes : budget;
  if (tiles) options.array_bytes = budget;
  if (flags.views->count() > 0) return;
  if (tiles && flags.budget->count() > 0 && flags.photographs->count() == 0) {
    options.planner.max_bytes = kPhotographsPerArray * budget;
  }
  if (options.planner.max_bytes > 0) options.max_views.reset();
}

BuildOptions options_of(const BuildFlags& flags) {
  BuildOptions options = flags.options;
  if (!flags.mesh.empty()) options.mesh = flags.mesh;
  options.hold_out = flags.hold.protocol();
  options.cells = flags.cells.options();
  flags.coverage.apply(options.planner);
  set_budget(flags, options);
  if (flags.seed->count() > 0 && options.order != StreamOrder::shuffled && options.choice != ViewChoice::random) {
    throw CLI::ValidationError("--seed", "needs --order shuffled or --choice random");
  }
  if (options.planner.max_loss_db && options.choice != ViewChoice::online) {
    throw CLI::ValidationError("--budget auto", "needs --choice online");
  }
  if (options.refine == RefineMode::joint) {
    options.intrinsics = flags.refine_intrinsics ? IntrinsicsUse::apply : IntrinsicsUse::report;
  } else if (flags.refine_intrinsics) {
    throw CLI::ValidationError("--refine-intrinsics", "needs --refine joint");
  }
  check_usage(options);
  return options;
}

void run(const BuildFlags& flags) {
  const BuildOptions options = options_of(flags);
  const ImageCoding photographs = flags.image_coding();
  check_apart(flags.output, std::array{flags.scene, flags.mesh});
  ModelOutput output(flags.output);
  const BuildResult result = build_model(flags.scene, options);
  if (!options.quiet && flags.mesh.empty()) std::cerr << "mesh: " << result.mesh_file.string() << '\n';
  for (const std::string& warning : result.mesh_warnings) std::cerr << "warning: " << warning << '\n';
  if (flags.verbose) std::cerr << refinement_log(result);
  if (result.intrinsics) {
    const std::string advice = intrinsics_advice(*result.intrinsics, result.intrinsics_applied);
    if (!advice.empty()) std::cerr << advice << '\n';
  }
  const json totals = summary(result, options);
  json plan = plan_json(result);
  plan["summary"] = totals;
  json effective = effective_options(result, options);
  effective["image"] = ending(photographs.format) + 1;
  effective["quality"] = photographs.format == ImageFormat::png ? json() : json(photographs.quality);
  output.commit(result.snapshot, options.planner.validity, photographs, {std::move(effective), std::move(plan)});
  if (flags.json_output) {
    std::cout << json_text(totals);
  } else {
    std::cout << summary_text(totals, flags.output.string());
  }
}

void add_stream_options(CLI::App& command, BuildFlags& flags) {
  const std::map<std::string, StreamOrder> orders = {
      {"given", StreamOrder::given}, {"reversed", StreamOrder::reversed}, {"shuffled", StreamOrder::shuffled}};
  const std::map<std::string, ViewChoice> choices = {{"online", ViewChoice::online},
                                                     {"offline", ViewChoice::offline},
                                                     {"uniform", ViewChoice::uniform},
                                                     {"random", ViewChoice::random}};
  command
      .add_option("--order", flags.options.order,
                  "Order in which photographs are offered: given (by name), reversed or shuffled")
      ->transform(CLI::CheckedTransformer(orders).description("{given,reversed,shuffled}"))
      ->default_str("given");
  command
      .add_option("--choice", flags.options.choice,
                  "Who chooses: online (the planner, one by one), or, to compare with: offline (sees all cameras "
                  "first), uniform (evenly spaced), random")
      ->transform(CLI::CheckedTransformer(choices).description("{online,offline,uniform,random}"))
      ->default_str("online");
  flags.seed = command.add_option("--seed", flags.options.seed, "Of --order shuffled and --choice random");
  flags.seed->check(CLI::NonNegativeNumber);
}

void add_planner_options(CLI::App& command, BuildFlags& flags) {
  PlannerOptions& planner = flags.options.planner;
  flags.views = command.add_option("--views", flags.options.max_views,
                                   "Photographs that the model may hold; with --budget alone as many as fit");
  flags.views->check(CLI::Range(1u, 1u << 20))->default_str(std::to_string(*flags.options.max_views));
  flags.budget =
      command.add_option("--budget", flags.budget_size,
                         "What the model may take on the GPU, with depth and masks: 512MiB, 300MB, 2GiB, 40Mtexels; or "
                         "auto: as few views as --loss allows, and --views only if it is given");
  flags.budget->check(CLI::IsMember({kAuto}) | byte_or_texel_size())->default_str("");
  flags.loss =
      command.add_option("--loss", flags.loss_db,
                         "With --budget auto: by how many dB of fitted PSNR the model may be worse than one of "
                         "all photographs, as predicted from coverage");
  flags.loss->check(finite_not_negative());
  command.add_option("--layout", flags.layout, "Parts of photographs that cells refer to, or whole photographs")
      ->check(CLI::IsMember({"tiles", "layers"}));
  flags.tile = command.add_option("--tile", flags.options.tiles.tile_px, "Side of a tile, pixels: 8, 16, ... 1024");
  flags.tile->check(CLI::Range(8u, 1024u) & divisible_by(8));
  command
      .add_option("--gutter", flags.options.tiles.gutter_px,
                  "Pixels around a tile; 2 to the number of its coarser levels")
      ->check(CLI::IsMember({1, 2, 4, 8}));
  flags.photographs = command.add_option("--photographs", flags.photograph_bytes,
                                         "Bytes of the photographs that tiles are cut from while the model is built; "
                                         "with --budget and without --views four times that");
  flags.photographs->transform(byte_size())->default_str("");
  flags.coverage.add_to(command);
  command
      .add_option("--min-exchange-gain", planner.min_exchange_gain,
                  "Coverage that a view must add to take another's place, as a share of what a stored view is worth on "
                  "average; at 1, with --min-gain 0, --metric directions, no --budget and no outliers, the store is "
                  "never worth "
                  "less than a quarter of the best")
      ->check(finite_not_negative());
  command
      .add_option("--victims", planner.victims,
                  "How many of the stored views that are missed least are considered for replacement; 0: all")
      ->check(CLI::Range(0u, 1u << 20));
  command
      .add_option("--visibility", planner.visibility_px, "Longer side, pixels, of the image that cells are counted in")
      ->check(CLI::Range(1u, 65536u));
  const std::map<std::string, VisibilityBy> ways = {{"rays", VisibilityBy::rays}, {"gl", VisibilityBy::gl}};
  command
      .add_option("--visibility-by", flags.options.visibility_by,
                  "What finds the visible surface: rays (on the processor) or gl (on the GPU, through OpenGL); default "
                  "rays")
      ->transform(CLI::CheckedTransformer(ways));
  command
      .add_option("--fade", planner.validity.fade_px,
                  "Pixels over which a photograph fades at its border and at depth edges")
      ->check(CLI::Range(0u, 16u));
  command
      .add_option(
          "--edges", planner.validity.edges,
          "Which side of a depth edge is not used: far (and the nearer one from about there only), or both, as in "
          "the paper; default far")
      ->transform(CLI::CheckedTransformer(kEdgesByName));
}

void add_refinement_options(CLI::App& command, BuildFlags& flags) {
  RefinementOptions& refinement = flags.options.planner.refinement;
  const std::map<std::string, RefineMode> modes = {{"none", RefineMode::none},
                                                   {"exposure", RefineMode::exposure},
                                                   {"pose", RefineMode::pose},
                                                   {"all", RefineMode::all},
                                                   {"joint", RefineMode::joint}};
  command
      .add_option("--refine", flags.options.refine,
                  "What is corrected in a view before it is stored: none, exposure, pose, all (and masks of what other "
                  "views contradict), or joint (all, then every stored view again until they rest)")
      ->transform(CLI::CheckedTransformer(modes).description("{none,exposure,pose,all,joint}"))
      ->default_str("joint");
  command.add_flag("--refine-intrinsics", flags.refine_intrinsics,
                   "With --refine joint: correct focal length and principal point where the photographs ask for it");
  command.add_flag("--white-balance", refinement.alignment.white_balance,
                   "Correct the exposure of each colour channel for itself");
  command.add_flag("!--no-masks", refinement.trust.enabled, "Trust every pixel of a stored photograph");
  command
      .add_option("--refine-points", refinement.samples, "Surface points at which a view is compared with the others")
      ->check(CLI::Range(std::size_t{100}, std::size_t{1000000}));
  command
      .add_option("--revisits", refinement.revisits,
                  "Stored views that are refined again after each one that is stored, while any moves")
      ->check(CLI::Range(0u, 1000u));
  command
      .add_option("--prior", refinement.alignment.prior,
                  "Strength of the pull towards the given poses; more for poses that are nearly right")
      ->check(finite_not_negative());
  command
      .add_option("--max-move", refinement.alignment.max_move,
                  "How far a pose may move its picture, as a share of the longer side")
      ->check(number_between(1e-6, 1));
  command
      .add_option("--outlier", refinement.least_correlation,
                  "Drop a view that agrees less than this with the others, [-1, 1]")
      ->check(number_between(-1, 1));
  command.add_flag("--verbose", flags.verbose, "Tell what was refined, a line a view");
}

void add_file_options(CLI::App& command, BuildFlags& flags) {
  const std::map<std::string, ImageFormat> formats = {{"png", ImageFormat::png}, {"jpeg", ImageFormat::jpeg}};
  command
      .add_option("--image", flags.photograph_coding.format,
                  "How photographs are kept in the file: png (exact) or jpeg; masks are always PNG")
      ->transform(CLI::CheckedTransformer(formats).description("{png,jpeg}"))
      ->default_str("png");
  flags.quality = command.add_option("--quality", flags.photograph_coding.quality, "Of --image jpeg");
  flags.quality->check(CLI::Range(1, 100));
}

}  // namespace

void add_build_command(CLI::App& program) {
  auto flags = std::make_shared<BuildFlags>();
  CLI::App* command = program.add_subcommand("build", "Plan, cross-reference and save a model: the main job");
  command->add_option("SCENE", flags->scene, "COLMAP workspace: sparse/ and images/, with a mesh")->required();
  command
      ->add_option("-o,--output", flags->output,
                   "Folder of the model, or one file that ends in .glb; an earlier model there is replaced")
      ->required();
  command->add_option("--mesh", flags->mesh, "PLY or OBJ; without it the usual names are looked for in SCENE");
  flags->cells.add_to(*command);
  add_stream_options(*command, *flags);
  add_planner_options(*command, *flags);
  add_refinement_options(*command, *flags);
  add_file_options(*command, *flags);
  flags->hold.add_to(*command, "Leave out every H-th view by name, to be scored by `validate`");
  command->add_flag("--json", flags->json_output, "Print what was built as JSON");
  command->add_flag("--quiet", flags->options.quiet, "No progress");
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
