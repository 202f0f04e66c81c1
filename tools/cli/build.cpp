// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include "tools/base/interrupt.h"
#include "tools/base/output_folder.h"
#include "tools/cli/cell_flags.h"
#include "tools/cli/commands.h"
#include "tools/cli/coverage_flags.h"
#include "tools/cli/json_output.h"
#include "tools/cli/mesh_frame_flags.h"
#include "tools/cli/next_steps.h"
#include "tools/cli/option_rules.h"
#include "tools/cli/print_address.h"
#include "tools/pipeline/budget/model_budget.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/build_summary.h"
#include "tools/pipeline/model_inspection.h"
#include "tools/pipeline/model_output.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/refinement/refinement_json.h"
#include "tools/pipeline/save_model.h"
#include "tools/stereo/scene_stereo.h"
#include "tools/viewer/live_site.h"
#include "tools/viewer/open_browser.h"

namespace lumatlas {

namespace {

using nlohmann::json;

struct BuildFlags {
  std::filesystem::path scene, output, mesh;
  BuildOptions options;
  PictureFlags pictures;
  HoldFlags hold;
  CellFlags cells;
  MeshFrameFlags mesh_frame;
  CoverageFlags coverage;
  double loss_db = 0.1;
  bool whole_views = false;
  std::string budget_size;  // empty: unbounded
  std::string texels = "auto";
  std::string faces;  // empty: none was given
  std::string texture = std::to_string(*BuildOptions{}.texture_px);
  std::uint64_t photograph_bytes = 0;  // 0: unbounded
  bool skip_bad = false;
  bool keep_lenses = false;
  bool paper = false;
  ImageCoding photograph_coding;
  bool watch = false;
  std::uint32_t idle_s = 0;  // 0: it ends by Ctrl-C alone
  bool mesh_as_given = false;
  bool no_far_sphere = false;
  bool exact_surface = false;
  bool view = false;
  bool no_browser = false;
  ServerOptions server;
  bool json_output = false;
  bool quiet = false;
  bool verbose = false;
  CLI::Option* max_views = nullptr;
  CLI::Option* budget = nullptr;
  CLI::Option* loss = nullptr;
  CLI::Option* tile = nullptr;
  CLI::Option* gutter = nullptr;
  CLI::Option* texels_option = nullptr;
  CLI::Option* white_balance = nullptr;
  CLI::Option* prior = nullptr;
  CLI::Option* max_move = nullptr;
  CLI::Option* photographs = nullptr;
  CLI::Option* least_scale = nullptr;
  CLI::Option* seed = nullptr;
  CLI::Option* refine = nullptr;
  CLI::Option* edges = nullptr;
  CLI::Option* quality = nullptr;

  [[nodiscard]] ImageCoding image_coding() const {
    if (quality->count() > 0 && photograph_coding.format == ImageFormat::png) {
      throw CLI::ValidationError("--quality", "needs --image jpeg: PNG is exact");
    }
    return photograph_coding;
  }
};

const Names<ValidityOptions::Edges> kEdges(kEdgesByName.begin(), kEdgesByName.end());

// Of --budget: as little as a bound on the loss allows. Of --faces: as few as move no picture by more than
// kFacesPixels.
constexpr const char* kAuto = "auto";
constexpr const char* kKeep = "keep";
constexpr const char* kNoTexture = "none";

void set_gutter(const BuildFlags& flags, TileOptions& tiles) {
  if (tiles.texels == TexelFormat::rgb8) return;
  if (flags.gutter->count() == 0) tiles.gutter_px = kGutterOfBlocks;
  if (tiles.gutter_px < 2) throw CLI::ValidationError("--gutter", "must be 2, 4 or 8 with --texels bc7");
  if (tiles.gutter_px == 8 && tiles.tile_px % 16 != 0) {
    throw CLI::ValidationError("--tile", "must be a multiple of 16 with --texels bc7 and --gutter 8");
  }
}

// Tiles are compressed only where a budget asks for it, and their gutter allows it.
void set_texels(const BuildFlags& flags, BuildOptions& options) {
  const bool automatic = flags.texels == kAuto;
  options.tiles.texels = automatic ? TexelFormat::rgb8 : kTexelFormatsByName.at(flags.texels);
  set_gutter(flags, options.tiles);
  const bool fit_for_blocks =
      flags.gutter->count() == 0 || options.tiles.gutter_px == 2 || options.tiles.gutter_px == 4;
  if (!automatic || options.tiles.whole_views() || !fit_for_blocks) return;
  options.tight_tiles = compressed_tiles(options.tiles);
  set_gutter(flags, *options.tight_tiles);
}

ModelBudget budget_of(const BuildFlags& flags) {
  ModelBudget budget;
  budget.loss_db = flags.loss_db;
  if (flags.budget->count() == 0) return budget;
  budget.automatic = flags.budget_size == kAuto;
  if (budget.automatic) return budget;
  const SizeBound bound = size_bound(flags.budget_size);
  budget.gpu_bytes = bound.bytes;
  budget.texels = bound.texels;
  return budget;
}

// Of tiles, a budget in bytes bounds all that the model takes on the GPU, one in texels the texture array; the
// photographs that they are cut from are bounded by their number, or by bytes of their own.
void set_budget(const BuildFlags& flags, BuildOptions& options) {
  const bool tiles = !flags.whole_views;
  if (!tiles) {
    if (flags.tile->count() > 0) throw CLI::ValidationError("--tile", "needs --layout tiles");
    for (const CLI::Option* option : {flags.photographs, flags.gutter, flags.texels_option}) {
      if (option->count() > 0) throw CLI::ValidationError(option->get_name(), "needs --layout tiles");
    }
    options.tiles.tile_px = 0;
  }
  set_texels(flags, options);
  const ModelBudget budget = budget_of(flags);
  if (flags.least_scale->count() > 0 && (!tiles || (budget.gpu_bytes == 0 && !budget.automatic))) {
    throw CLI::ValidationError("--least-scale", "needs --layout tiles and a --budget of auto or in bytes");
  }
  if (flags.loss->count() > 0 && !budget.automatic) throw CLI::ValidationError("--loss", "needs --budget auto");
  options.planner.max_bytes = flags.photograph_bytes;
  try {
    apply_budget(budget, flags.max_views->count() > 0, options);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError(error.what());
  }
  if (budget.automatic) flags.coverage.keep_given(options.planner);
}

// The measure, its thresholds and the masks as printed; and views refined while they come, as in section 3.3, their
// lenses as given, unless --refine says otherwise: poses that are exact need none.
void follow_paper(BuildFlags& flags) {
  flags.coverage.follow_paper();
  ValidityOptions::Edges& edges = flags.options.planner.validity.edges;
  agree_with_paper(*flags.edges, edges == ValidityOptions::Edges::both_sides, "both");
  edges = ValidityOptions::Edges::both_sides;
  if (flags.refine->count() > 0) return;
  flags.options.refine = RefineMode::all;
  flags.keep_lenses = true;
}

// A model whose mesh counts is to have few faces, unless the user wants all of them. With --watch the mesh is there
// before most cameras are known, by which pictures are judged.
FaceOptions faces_of(const BuildFlags& flags) {
  TileOptions layout;
  if (flags.whole_views) layout.tile_px = 0;
  const bool few = !flags.watch && wants_few_faces(budget_of(flags), layout);
  FaceOptions faces;
  if (flags.faces == kAuto || (flags.faces.empty() && few)) {
    faces.pixels = kFacesPixels;
  } else if (!flags.faces.empty() && flags.faces != kKeep) {
    faces.faces = std::stoull(flags.faces);
  }
  return faces;
}

std::optional<std::uint32_t> texture_of(const std::string& text) {
  if (text == kNoTexture) return std::nullopt;
  const std::uint64_t side_px = std::stoull(text);
  if (side_px < kLeastTexturePx || side_px > kMostTexturePx) {
    throw CLI::ValidationError("--texture", "must be " + std::to_string(kLeastTexturePx) + " to " +
                                                std::to_string(kMostTexturePx) + ", or " + kNoTexture);
  }
  return static_cast<std::uint32_t>(side_px);
}

void watch_scene(const BuildFlags& flags, BuildOptions& options) {
  const auto refuse = [](const char* option, const char* why) { throw CLI::ValidationError(option, why); };
  if (options.hold_out) refuse("--hold", "goes by the names of all photographs, which --watch does not know yet");
  if (options.choice != ViewChoice::online) refuse("--choice", "must be online with --watch, which cannot look ahead");
  if (options.order != StreamOrder::given) refuse("--order", "must be given with --watch: they come as they come");
  if (!options.max_views && options.planner.max_bytes + options.gpu_bytes == 0) {
    refuse("--budget auto",
           "needs --max-views or --photograph-bytes with --watch, for nobody knows how many will come");
  }
  options.pictures.skip_bad = true;  // for validate, which reads this scene again
  WatchOptions& watch = options.watch.emplace();
  watch.end = [] { return false; };
  if (flags.idle_s > 0) watch.idle = std::chrono::seconds(flags.idle_s);
  watch.warn = [](const std::string& sentence) { std::cerr << "warning: " << sentence << '\n'; };
}

// With --quiet the address is a result: see Shown.
void require_address_known(const BuildFlags& flags) {
  if (!flags.view || !flags.quiet || !flags.json_output || flags.server.port != 0) return;
  throw CLI::ValidationError("--view", "needs --port with --quiet and --json, for nothing else would say its address");
}

// Of what --refine leaves out.
void check_refinement_is_used(const BuildFlags& flags, RefineMode refine) {
  if (refine == RefineMode::none && flags.white_balance->count() > 0) {
    throw CLI::ValidationError("--white-balance", "needs --refine exposure, pose, all or joint");
  }
  if (refine != RefineMode::none && refine != RefineMode::exposure) return;
  for (const CLI::Option* option : {flags.prior, flags.max_move}) {
    if (option->count() > 0) throw CLI::ValidationError(option->get_name(), "needs --refine pose, all or joint");
  }
}

BuildOptions options_of(BuildFlags flags) {
  if (flags.paper) follow_paper(flags);
  BuildOptions options = flags.options;
  if (!flags.mesh.empty()) options.mesh = flags.mesh;
  options.mesh_frame = flags.mesh_frame.frame();
  options.pictures = flags.pictures.folders();
  options.pictures.skip_bad = flags.skip_bad;
  options.hold_out = flags.hold.protocol();
  options.cells = flags.cells.options();
  options.faces = faces_of(flags);
  options.texture_px = texture_of(flags.texture);
  flags.coverage.apply(options.planner);
  set_budget(flags, options);
  if (flags.seed->count() > 0 && options.order != StreamOrder::shuffled && options.choice != ViewChoice::random) {
    throw CLI::ValidationError("--seed", "needs --order shuffled or --choice random");
  }
  if (options.planner.max_loss_db && options.choice != ViewChoice::online) {
    throw CLI::ValidationError("--budget auto", "needs --choice online");
  }
  if (flags.keep_lenses && options.refine != RefineMode::all && options.refine != RefineMode::joint) {
    throw CLI::ValidationError("--keep-lenses", "needs --refine all or joint");
  }
  options.refine_lenses = !flags.keep_lenses;
  check_refinement_is_used(flags, options.refine);
  if (flags.watch) watch_scene(flags, options);
  require_address_known(flags);
  check_usage(options);
  return options;
}

// Of --watch: from the time that photographs are waited for, the first Ctrl-C ends the stream, and the model is saved.
void take_end_requests(const BuildFlags& flags, BuildOptions& options, std::optional<EndRequest>& request) {
  if (!options.watch) return;
  options.watch->end = [&request, said = flags.quiet]() mutable {
    if (!request) request.emplace();
    if (!std::exchange(said, true)) std::cerr << "waiting for photographs\n";
    return request->made();
  };
}

BuildCallback progress_of(const BuildFlags& flags) {
  BuildCallback progress = progress_on_standard_error(flags.quiet);
  if (!flags.watch || flags.quiet) return progress;
  return [progress = std::move(progress), said = false](const BuildProgress& build) mutable {
    const bool is_first = build.done == 1 && std::string_view(build.stage) == "planning views";
    if (is_first && !std::exchange(said, true)) std::cerr << "the first is there; Ctrl-C saves the model\n";
    return progress(build);
  };
}

// A line that counts them, and one for each.
std::string skipped_text(const BuildResult& result) {
  if (result.skipped.empty()) return "";
  std::string lines = "warning: " + std::to_string(result.skipped.size()) + " of " + std::to_string(result.views) +
                      " photographs are left out\n";
  for (const SkippedView& view : result.skipped) lines += "  " + view.why + '\n';
  return lines;
}

// The model in the browser while it is built, and afterwards until Ctrl-C.
class Shown {
 public:
  explicit Shown(const BuildFlags& flags)
      : flags_(flags), server_(flags.server), site_(server_, title_of(flags.output)) {
    if (!flags.quiet) {
      std::cerr << "see it: " << server_.address() << '\n';
    } else if (!flags.json_output) {
      print_address(server_.address(), false);
    }
    if (!flags.no_browser) open_browser(server_.address());
    serving_ = std::thread([this] { server_.serve([this] { return stop_.load(); }); });
  }
  ~Shown() {
    stop_ = true;
    serving_.join();
  }
  Shown(const Shown&) = delete;
  Shown& operator=(const Shown&) = delete;

  [[nodiscard]] AtlasWatch watch() {
    return [this](const Atlas& atlas) {
      return show_while_it_changes(
          site_,
          [this, &atlas]() -> std::shared_ptr<const Snapshot> {
            auto next = std::make_shared<const Snapshot>(atlas.snapshot());
            if (snapshot_ && look_alike(*next, *snapshot_)) return nullptr;
            snapshot_ = next;
            return next;
          },
          [this](const std::string& why) {
            if (!flags_.quiet) std::cerr << "warning: the page is not up to date: " << why << '\n';
          });
    };
  }
  void show_until_interrupted(const Snapshot& snapshot) {
    site_.update(snapshot, true, throw_if_interrupted);
    if (!flags_.quiet) std::cerr << "the page shows it until Ctrl-C: " << server_.address() << '\n';
    for (;; std::this_thread::sleep_for(std::chrono::milliseconds(50))) throw_if_interrupted();
  }

 private:
  const BuildFlags& flags_;
  SiteServer server_;
  LiveSite site_;
  std::shared_ptr<const Snapshot> snapshot_;  // the last one that was to be shown
  std::atomic<bool> stop_ = false;
  std::thread serving_;
};

void run(const BuildFlags& flags) {
  BuildOptions options = options_of(flags);
  const bool as_printed = flags.paper;
  options.measure_deviation = !flags.exact_surface && !as_printed;
  options.completion = {!flags.mesh_as_given && !as_printed, !flags.no_far_sphere && !as_printed,
                        stereo_folder_of(flags.output)};
  std::optional<EndRequest> end_request;
  take_end_requests(flags, options, end_request);
  const ImageCoding photographs = flags.image_coding();
  check_apart(flags.output, std::array{flags.scene, flags.mesh, flags.pictures.images, flags.pictures.masks});
  ModelOutput output(flags.output);
  const auto shown = flags.view ? std::make_unique<Shown>(flags) : nullptr;
  const BuildResult result =
      build_model(flags.scene, options, progress_of(flags), shown ? shown->watch() : AtlasWatch());
  if (!flags.quiet && flags.mesh.empty()) std::cerr << "mesh: " << result.mesh_file.string() << '\n';
  for (const std::string& note : result.scene_notes) {
    if (!flags.quiet) std::cerr << "scene: " << note << '\n';
  }
  if (!flags.quiet && result.masked_views > 0) {
    std::cerr << "masks: of " << result.masked_views << " of " << result.views << " photographs\n";
  }
  if (!flags.quiet && flags.options.close_holes > 0) {
    std::cerr << "mesh: closed " << result.closed_holes << " of its holes\n";
  }
  if (!flags.watch) std::cerr << skipped_text(result);  // with it, each was named as it was found
  for (const std::string& warning : result.warnings) std::cerr << "warning: " << warning << '\n';
  if (flags.verbose) std::cerr << refinement_log(result);
  if (!flags.quiet) std::cerr << lenses_text(result.lenses);
  json totals = save_model(result, output, photographs);
  remove_stereo_work(options.completion.stereo_folder);
  totals["file"] = file_bytes_json(flags.output);
  if (flags.json_output) {
    print_result(totals, flags.output);
  } else {
    print_result(summary_text(totals, flags.output.string()) + "  on disk " + file_bytes_text(totals["file"]) + '\n',
                 flags.output);
  }
  if (!flags.quiet) {
    std::cerr << next_steps(flags.output, flags.hold.protocol() ? flags.scene : std::filesystem::path());
  }
  const bool asked_to_end = end_request && end_request->made();
  end_request.reset();
  if (shown && !asked_to_end) shown->show_until_interrupted(result.snapshot);
}

const Names<StreamOrder> kOrders{
    {"given", StreamOrder::given}, {"reversed", StreamOrder::reversed}, {"shuffled", StreamOrder::shuffled}};
const Names<ViewChoice> kChoices{{"online", ViewChoice::online},
                                 {"offline", ViewChoice::offline},
                                 {"uniform", ViewChoice::uniform},
                                 {"random", ViewChoice::random}};
const Names<RefineMode> kRefinements{{"none", RefineMode::none},
                                     {"exposure", RefineMode::exposure},
                                     {"pose", RefineMode::pose},
                                     {"all", RefineMode::all},
                                     {"joint", RefineMode::joint}};

void add_file_options(CLI::App& command, BuildFlags& flags) {
  add_file(command, "SCENE", flags.scene, "SCENE",
           "COLMAP workspace or other capture with a mesh; --watch: one that fills up")
      ->required();
  begin_group(command, "Files");
  add_model_output(command, flags.output);
  add_file(command, "--mesh", flags.mesh, "FILE",
           "PLY, OBJ, STL or GLB, else looked for in SCENE; in other units, axes or shifted: see "
           "--mesh-scale, --mesh-axes and --mesh-shift in --help-all");
  command.add_flag("--mesh-as-given", flags.mesh_as_given, "Neither add surface that the mesh lacks nor remove faces");
  add_choice(command, "--image", flags.photograph_coding.format,
             {{"png", ImageFormat::png}, {"jpeg", ImageFormat::jpeg}}, "How photographs are kept in the model")
      ->transform(other_name("jpg", "jpeg"));
  flags.quality = command.add_option("--quality", flags.photograph_coding.quality, "With --image jpeg, how well")
                      ->type_name("Q")
                      ->transform(whole_number(1, 100));
}

void add_stream_options(CLI::App& command, BuildFlags& flags) {
  begin_group(command, "Photographs");
  flags.pictures.add_to(command);
  command.add_flag("--skip-bad", flags.skip_bad, "Go on without those that are missing or damaged, and name them");
  command.add_flag("--watch", flags.watch, "Go on as photographs and poses come into SCENE; Ctrl-C saves the model");
  flags.hold.add_to(command, "Leave out every H-th by name, for `lumatlas validate` to score");
}

void add_model_options(CLI::App& command, BuildFlags& flags) {
  begin_group(command, "Model");
  flags.max_views = command.add_option("--max-views", flags.options.max_views, "Photographs that it may hold")
                        ->type_name("N")
                        ->transform(whole_number(1, 1u << 20))
                        ->default_str(std::to_string(*flags.options.max_views) + ", with --budget as many as fit");
  flags.budget = command
                     .add_option("--budget", flags.budget_size,
                                 "What it may take on the GPU, mesh included: 512MiB, 300MB; its photographs alone: "
                                 "40Mtexels; auto: as little as --loss allows")
                     ->type_name("SIZE")
                     ->check(byte_or_texel_size({kAuto}))
                     ->default_str("");
  flags.loss = command
                   .add_option("--loss", flags.loss_db,
                               "With --budget auto, loss of PSNR against all photographs, as measured while building")
                   ->type_name("DB")
                   ->check(finite_not_negative());
  flags.cells.add_size_to(command);
  command.add_option("--faces", flags.faces, "Of the mesh: keep (all), auto (as many as pictures show) or so many")
      ->type_name("N")
      ->transform(count_or({kAuto, kKeep}))
      ->default_str("keep; auto with --budget but in texels");
  flags.refine = add_choice(command, "--refine", flags.options.refine, kRefinements,
                            "What is corrected: gain, pose, lens, masks; joint: all of it, then all photographs "
                            "together");
  command.add_flag("--paper", flags.paper, "As in the paper: measure, masks, mesh as given; --refine all unless given");
}

void add_message_options(CLI::App& command, BuildFlags& flags) {
  begin_group(command, "Messages");
  add_json(command, flags.json_output);
  command.add_flag("--verbose", flags.verbose, "Tell what was refined, a line a view");
  command.add_flag("--view", flags.view, "Show the model in the browser while it is built, and until Ctrl-C");
  add_quiet(command, flags.quiet);
}

void add_planning_experiments(CLI::App& command, BuildFlags& flags) {
  PlannerOptions& planner = flags.options.planner;
  command
      .add_option("--min-exchange-gain", planner.min_exchange_gain,
                  "Coverage that a view must add to take another's place, as a share of what a stored view is worth on "
                  "average; at 1, with --min-gain 0, --metric directions, no --budget and no outliers, the store is "
                  "never worth less than a quarter of the best")
      ->type_name("GAIN")
      ->check(finite_not_negative());
  command
      .add_option("--victims", planner.victims,
                  "How many of the stored views that are missed least are considered for replacement; 0: all")
      ->type_name("N")
      ->transform(whole_number(0, 1u << 20));
  flags.coverage.add_references_to(command);
  begin_experiments(command, "who chooses, and what is seen");
  command.add_flag("--any-mesh", flags.options.any_mesh,
                   "Build also where most photographs see next to nothing of the mesh, or it is certainly in another "
                   "frame, rather than refuse");
  add_choice(command, "--choice", flags.options.choice, kChoices,
             "The planner, photograph by photograph, or, to compare with, one that sees all cameras first, even "
             "spacing, chance");
  add_choice(command, "--order", flags.options.order, kOrders, "In which photographs are offered; given: by name");
  flags.seed = command.add_option("--seed", flags.options.seed, "Of --order shuffled and --choice random")
                   ->type_name("N")
                   ->transform(whole_number(0));
  command.add_option("--visibility", planner.visibility_px, "Longer side of the image that cells are counted in")
      ->type_name("PX")
      ->transform(whole_number(1, 65536));
  add_choice(command, "--visibility-by", flags.options.visibility_by,
             {{"rays", VisibilityBy::rays}, {"gl", VisibilityBy::gl}},
             "What finds the visible surface: rays on the processor, or OpenGL on the GPU");
}

void add_mesh_frame(CLI::App& command, BuildFlags& flags) {
  begin_experiments(command, "a mesh in another frame than the poses");
  flags.mesh_frame.add_to(command);
}

void add_storage_experiments(CLI::App& command, BuildFlags& flags) {
  begin_experiments(command, "mesh, cells, texture and tiles");
  command.add_flag("--no-far-sphere", flags.no_far_sphere,
                   "Fill sky and distant surroundings like holes, from what is beside them");
  command.add_flag("--exact-surface", flags.exact_surface,
                   "Take the surface as exact: pictures are sharp also where photographs disagree on it");
  command
      .add_option("--close-holes", flags.options.close_holes, "Close holes of the mesh up to this across, scene units")
      ->type_name("LENGTH")
      ->check(finite_not_negative());
  flags.cells.add_partition_to(command);
  command
      .add_option(
          "--texture", flags.texture,
          "The longest side of the texture that other programs show in place of averaged colours; none: without")
      ->type_name("PX")
      ->transform(count_or({kNoTexture}));
  add_choice(command, "--layout", flags.whole_views, {{"tiles", false}, {"layers", true}},
             "Keep the parts of photographs that cells refer to, or whole photographs");
  flags.tile = command.add_option("--tile", flags.options.tiles.tile_px, "Side of a tile")
                   ->type_name("PX")
                   ->transform(whole_number(8, 1024))
                   ->check(divisible_by(8));
  flags.gutter = command
                     .add_option("--gutter", flags.options.tiles.gutter_px,
                                 "Around a tile; 2 to the number of its coarser levels, with --texels bc7 of its "
                                 "levels, and 4 unless given")
                     ->type_name("PX")
                     ->transform(one_of({"1", "2", "4", "8"}));
  flags.least_scale =
      command
          .add_option("--least-scale", flags.options.least_scale,
                      "With --budget auto or in bytes, share of a photograph's width and height that all may be "
                      "downscaled to")
          ->type_name("SHARE")
          ->check(number_between(0.1, 1));
  flags.texels_option =
      command
          .add_option(
              "--texels", flags.texels,
              "How photographs are held on the GPU: rgb8, as they are, bc7, compressed to a third of the bytes; "
              "auto: bc7 where a budget in bytes has no room for them whole, or where --budget auto measures "
              "that at most half of --loss is lost")
          ->type_name("NAME")
          ->transform(one_of({kAuto, "rgb8", "bc7"}));
  flags.photographs = command
                          .add_option("--photograph-bytes", flags.photograph_bytes,
                                      "Memory for photographs that tiles are cut from while the model is built; with "
                                      "--budget and without --max-views four times that")
                          ->type_name("SIZE")
                          ->transform(byte_size())
                          ->default_str("");
}

void add_refinement_experiments(CLI::App& command, BuildFlags& flags) {
  RefinementOptions& refinement = flags.options.planner.refinement;
  begin_experiments(command, "refinement");
  command.add_flag("--keep-lenses", flags.keep_lenses,
                   "With --refine all or joint, believe the given lenses, also where the photographs contradict them");
  flags.white_balance = command.add_flag("--white-balance", refinement.alignment.white_balance,
                                         "Correct the exposure of each colour channel for itself");
  flags.prior = command
                    .add_option("--prior", refinement.alignment.prior,
                                "Strength of the pull towards the given poses; more for poses that are nearly right")
                    ->type_name("P")
                    ->check(finite_not_negative());
  flags.max_move = command
                       .add_option("--max-move", refinement.alignment.max_move,
                                   "How far a pose may move its picture, as a share of the longer side")
                       ->type_name("SHARE")
                       ->check(number_between(1e-6, 1));
  begin_experiments(command, "masks");
  command
      .add_option("--fade", flags.options.planner.validity.fade_px,
                  "Over which a photograph fades at its border and at depth edges")
      ->type_name("PX")
      ->transform(whole_number(0, 16));
  flags.edges = add_choice(command, "--edges", flags.options.planner.validity.edges, kEdges,
                           "Which sides of a depth edge are masked; far shows the nearer side from about where the "
                           "photograph was taken, both is the paper's");
}

void add_live_experiments(CLI::App& command, BuildFlags& flags) {
  begin_experiments(command, "scenes that fill up, and a page that shows it");
  CLI::Option* const watch = command.get_option("--watch");
  CLI::Option* const view = command.get_option("--view");
  command
      .add_option("--idle", flags.idle_s,
                  "With --watch, end and save once nothing has changed for so long; 0: by Ctrl-C alone")
      ->type_name("SECONDS")
      ->transform(whole_number(0, 1u << 20))
      ->needs(watch);
  command.add_option("--port", flags.server.port, "With --view, listen at this port; 0: any that is free")
      ->type_name("N")
      ->transform(whole_number(0, 65535))
      ->needs(view);
  command.add_flag("--no-browser", flags.no_browser, "With --view, only say the address")->needs(view);
}

}  // namespace

void add_build_command(CLI::App& program) {
  auto flags = std::make_shared<BuildFlags>();
  CLI::App* command = program.add_subcommand("build", "Choose photographs of a scene and pack them: the main job");
  add_file_options(*command, *flags);
  add_stream_options(*command, *flags);
  add_model_options(*command, *flags);
  add_message_options(*command, *flags);
  add_mesh_frame(*command, *flags);
  flags->coverage.add_experiments_to(*command);
  add_planning_experiments(*command, *flags);
  add_storage_experiments(*command, *flags);
  add_refinement_experiments(*command, *flags);
  add_live_experiments(*command, *flags);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
