// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "atlas/images/pixel_memory.h"
#include "mesh/base/errors.h"
#include "mesh/base/freed_memory.h"
#include "mesh/base/temporary_entry.h"
#include "mesh/base/whole_file.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/base/process/machine.h"
#include "tools/city/block_job.h"
#include "tools/city/block_jobs.h"
#include "tools/city/job_cost.h"
#include "tools/city/joining/join_blocks.h"
#include "tools/city/planning/plan_city.h"
#include "tools/city/workflow.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/cell_flags.h"
#include "tools/cli/flags/georeference_flag.h"
#include "tools/cli/flags/image_flags.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/pipeline/build_settings.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/surface/baked_texture.h"
#include "tools/scene/scene_list.h"
#include "tools/texture/layout/texture_layout.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct CityFlags {
  fs::path source, output, plan, mesh;
  CityOptions options;
  SettingFlags<BuildOptions> settings{build_settings()};
  GeoreferenceFlag georeference;
  PictureFlags pictures;
  HoldFlags hold;
  ImageFlags images;
  std::size_t jobs = std::max(1u, std::thread::hardware_concurrency());
  std::size_t job = 0, threads = 0;
  std::uint32_t max_views = 100, texture_px = 2048;
  bool mesh_as_given = false, as_posed = false, json_output = false, quiet = false;
  CLI::Option* job_option = nullptr;
  std::vector<CLI::Option*> of_scenes;  // options that a plan has the values of
};

BuildCallback progress_of(const CityFlags& flags) {
  return progress_on_standard_error(flags.quiet);
}

// Returns what the plan depends on, as text.
std::string stamp_of(const CityFlags& flags) {
  json inputs = {{"lumatlas", LUMATLAS_VERSION},
                 {"scene", fs::absolute(flags.source).lexically_normal().string()},
                 {"mesh", flags.mesh.string()},
                 {"georeference", flags.georeference.text},
                 {"images", flags.pictures.images.string()},
                 {"masks", flags.pictures.masks.string()},
                 {"settings", flags.settings.json(flags.options.build)},
                 {"max_views", flags.max_views},
                 {"cell_size", flags.options.build.cells.size},
                 {"block_faces", flags.options.block_faces},
                 {"block_memory", flags.options.memory},
                 {"mesh_as_given", flags.mesh_as_given},
                 {"as_posed", flags.as_posed},
                 {"hold", flags.hold.protocol() ? json(flags.hold.hold) : json()},
                 {"block", flags.hold.block}};
  std::vector<fs::path> files = files_of_list(flags.source);
  files.push_back(find_mesh(flags.source, flags.options.build.mesh));
  for (const fs::path& file : files) {
    const auto time = fs::last_write_time(file).time_since_epoch().count();
    inputs["files"].push_back({file.string(), fs::file_size(file), time});
  }
  return inputs.dump(-1, ' ', false, json::error_handler_t::replace);
}

void take_options(CityFlags& flags) {
  BuildOptions& build = flags.options.build;
  if (!flags.mesh.empty()) build.mesh = flags.mesh;
  build.georeference = flags.georeference.reference();
  build.pictures = flags.pictures.folders();
  build.hold_out = flags.hold.protocol();
  build.max_views = flags.max_views;
  build.refine = flags.as_posed ? RefineMode::none : RefineMode::joint;
  build.completion.surface = !flags.mesh_as_given;
  flags.settings.apply(build);
  check_usage(build);
}

CityPlan made_plan(CityFlags& flags, const fs::path& folder) {
  take_options(flags);
  flags.options.stamp = stamp_of(flags);
  if (is_city_plan(folder)) {
    CityPlan plan = read_city_plan(folder);
    if (plan.stamp == flags.options.stamp) return plan;
    throw InputError(folder.string() +
                     ": is the plan of other inputs or options: remove it, or give the options that it was made with");
  }
  CityPlan plan = plan_city(flags.source, flags.options, folder, progress_of(flags));
  write_job_cost(folder, "plan", cost_of_this_process());
  for (const std::string& warning : plan.warnings) std::cerr << "warning: " << warning << '\n';
  return plan;
}

void write_workflow(const CityPlan& plan, const fs::path& folder) {
  AtomicFile file(folder / "Snakefile");
  file.stream() << snakefile(plan, program_file());
  file.commit();
}

std::string plan_text(const CityPlan& plan, const fs::path& folder) {
  std::size_t faces = 0, views = 0;
  for (const CityBlock& block : plan.blocks) {
    faces += block.far ? 0 : block.size.faces;
    views += block.views.size();
  }
  return folder.string() + ": " + std::to_string(plan.blocks.size()) + " blocks of " + std::to_string(faces) +
         " faces, " + std::to_string(plan.views.size()) + " photographs, each seen by " +
         std::to_string(plan.views.empty() ? 0 : (views + plan.views.size() / 2) / plan.views.size()) + " blocks; " +
         std::to_string(plan.left_out.size()) + " left out\n";
}

void run_job(const CityFlags& flags) {
  const CityPlan plan = read_city_plan(flags.source);
  if (flags.job >= plan.blocks.size()) {
    throw CLI::ValidationError("--job", std::to_string(flags.job) + " must be below the plan's " +
                                            std::to_string(plan.blocks.size()) + " blocks");
  }
  std::optional<tbb::global_control> limit;
  if (flags.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, flags.threads);
  const BlockFacts facts = build_block(flags.source, plan, flags.job, progress_of(flags));
  write_job_cost(flags.source, std::to_string(flags.job), cost_of_this_process());
  const fs::path folder = block_folder(flags.source, flags.job);
  if (flags.json_output) {
    print_result({{"block", flags.job},
                  {"offered", facts.offered},
                  {"stored", facts.stored},
                  {"resident_tiles", facts.resident_tiles},
                  {"total_ms", facts.total_ms}},
                 folder);
    return;
  }
  print_result(folder.string() + ": " + std::to_string(facts.stored) + " of " + std::to_string(facts.offered) +
                   " photographs kept, " + std::to_string(facts.resident_tiles) + " tiles\n",
               folder);
}

[[noreturn]] void refuse_failed(const std::vector<FailedBlock>& failed, const fs::path& folder) {
  std::string text = folder.string() + ": " + std::to_string(failed.size()) +
                     (failed.size() == 1 ? " block failed" : " blocks failed") +
                     "; the same command goes on from those that are done";
  for (const FailedBlock& one : failed) text += "\n  block " + std::to_string(one.block) + ": " + one.why;
  throw InputError(text);
}

json notes_of(const CityPlan& plan, const ImageCoding& photographs) {
  json options = {{"city", true},
                  {"blocks", plan.blocks.size()},
                  {"scene", plan.scene.string()},
                  {"image", ending(photographs.format) + 1},
                  {"quality", photographs.format == ImageFormat::png ? json() : json(photographs.quality)},
                  {"hold_out", json()},
                  {"skip_bad", plan.build.pictures.skip_bad}};
  if (plan.hold_out) options["hold_out"] = {{"hold", plan.hold_out->hold}, {"block", plan.hold_out->block}};
  return options;
}

void warn_of_textures(const JoinedCity& city) {
  const std::size_t without = city.chunks_without_texture();
  if (without == 0) return;
  std::cerr << "warning: other programs show averaged colours instead of a texture on " << without
            << (without == 1 ? " chunk" : " chunks")
            << ", whose charts do not fit: allow a larger texture (--texture)\n";
}

// Returns no texture where the surface has more charts than it has room for.
std::optional<BakedTexture> texture_of(const CityFlags& flags, const Snapshot& snapshot) {
  if (flags.texture_px == 0) return std::nullopt;
  try {
    return bake_texture(snapshot, flags.texture_px, progress_of(flags));
  } catch (const ChartsDoNotFit& error) {
    std::cerr << "warning: other programs show averaged colours instead of a texture: " << error.what() << '\n';
    return std::nullopt;
  }
}

// Writes one file, which needs the whole model in memory, from a folder of it within the plan's.
void commit_one_file(const CityFlags& flags, JoinedCity& city, const ModelNotes& notes, const fs::path& plan,
                     ModelOutput& output) {
  const TemporaryEntry folder(TemporaryEntry::Kind::folder, plan, [] { return random_temporary_name(); });
  FormOptions form;
  form.coarse_faces = 0;
  write_model(folder.path(), city.model(), city.validity(), form);
  const Model model = read_model(folder.path());
  const std::optional<BakedTexture> texture = texture_of(flags, model.snapshot);
  output.commit(model.snapshot, model.validity, flags.images.coding(), notes, texture ? &texture->texture : nullptr);
}

std::uintmax_t bytes_on_disk(const fs::path& model) {
  if (!fs::is_directory(model)) return fs::file_size(model);
  std::uintmax_t bytes = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(model)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

void join(const CityFlags& flags, const CityPlan& plan, const fs::path& folder, ModelOutput& output) {
  const ImageCoding photographs = flags.images.coding();
  // Tables of the whole city take memory beside pixels, which jobs do not have.
  const PixelMemoryBound memory(std::min(usual_pixel_memory(), plan.memory / (2 * kPixelShare)),
                                scratch_folder_for(output.target()));
  return_freed_memory();
  const ModelNotes notes{notes_of(plan, photographs), json::object()};
  JoinOptions options;
  if (!output.is_one_file()) options.texture_px = flags.texture_px;
  JoinedCity city(folder, plan, options, progress_of(flags));
  if (output.is_one_file()) {
    commit_one_file(flags, city, notes, folder, output);
  } else {
    output.commit(city.model(), city.validity(), photographs, notes);
    warn_of_textures(city);
  }
  const json totals = {{"blocks", plan.blocks.size()},
                       {"faces", city.faces()},
                       {"cells", city.cells()},
                       {"views", city.views()},
                       {"resident_tiles", city.resident_tiles()},
                       {"bytes", bytes_on_disk(output.target())}};
  if (flags.json_output) {
    print_result(totals, output.target());
    return;
  }
  print_result(output.target().string() + ": " + std::to_string(city.views()) + " photographs on " +
                   std::to_string(city.faces()) + " faces, joined from " + std::to_string(plan.blocks.size()) +
                   " blocks, on disk " + std::to_string((bytes_on_disk(output.target()) + 500'000) / 1'000'000) +
                   " MB\n",
               output.target());
}

void run(CityFlags& flags) {
  const bool planned = is_city_plan(flags.source);
  if (planned) {
    for (const CLI::Option* option : flags.of_scenes) {
      if (option->count() > 0) {
        throw CLI::ValidationError(option->get_name(), "is for a SCENE, and this is a plan, which has its own");
      }
    }
  } else if (flags.job_option->count() > 0) {
    throw CLI::ValidationError("--job", flags.source.string() + " is no plan that was finished");
  }
  if (flags.job_option->count() > 0) return run_job(flags);
  if (flags.output.empty() == flags.plan.empty()) {
    throw CLI::ValidationError("city", "give one of --output, --plan and --job");
  }
  if (!flags.plan.empty()) {
    const CityPlan plan = made_plan(flags, flags.plan);
    write_workflow(plan, flags.plan);
    print_result(plan_text(plan, flags.plan), flags.plan);
    return;
  }
  (void)flags.images.coding();  // refuses a quality that the format does not have
  check_apart(flags.output, std::array{flags.source, flags.mesh, flags.pictures.images, flags.pictures.masks});
  ModelOutput output(flags.output);
  const fs::path folder = planned ? flags.source : fs::path(flags.output.string() + ".city");
  const CityPlan plan = planned ? read_city_plan(folder) : made_plan(flags, folder);
  if (!flags.quiet) std::cerr << plan_text(plan, folder);
  const std::vector<FailedBlock> failed = run_block_jobs(program_file(), folder, plan, flags.jobs, progress_of(flags));
  if (!failed.empty()) refuse_failed(failed, folder);
  join(flags, plan, folder, output);
  if (planned) {
    write_job_cost(folder, "join", cost_of_this_process());
  } else {
    remove_plan(folder);
  }
}

// Runs after byte_size().
CLI::Validator at_least_block_memory() {
  const auto check = [](const std::string& bytes) -> std::string {
    if (std::stoull(bytes) >= kLeastBlockMemory) return {};
    return bytes + " bytes are too few, give " + std::to_string(kLeastBlockMemory >> 20) + "MiB or more";
  };
  return {check, ""};
}

void add_scene_options(CLI::App& command, CityFlags& flags) {
  const std::vector<CLI::Option*> before = command.get_options();
  begin_group(command, "Files of the scene");
  add_file(command, "--mesh", flags.mesh, "FILE", "Mesh, if not one beside SCENE");
  flags.georeference.add_to(command);
  flags.pictures.add_to(command);
  flags.hold.add_to(command, "Leave out every H-th photograph, to validate with");
  begin_group(command, "Blocks");
  command.add_option("--block-faces", flags.options.block_faces, "Faces in a block at most")
      ->type_name("N")
      ->transform(whole_number(1000, 100'000'000));
  command
      .add_option("--block-memory", flags.options.memory,
                  "Memory that the job of a block takes at most, and joining: blocks are cut smaller for it")
      ->type_name("SIZE")
      ->transform(byte_size())
      ->check(at_least_block_memory())
      ->default_str("2GiB");
  add_cell_size(command, flags.options.build.cells)->description("Diameter of a cell, scene units; 0: by distance");
  command.add_option("--max-views", flags.max_views, "Photographs that a block keeps at most")
      ->type_name("N")
      ->transform(whole_number(1, 1'000'000));
  command.add_flag("--mesh-as-given", flags.mesh_as_given, "Add no surface that photographs show beside the mesh");
  command.add_flag("--as-posed", flags.as_posed,
                   "Keep poses, lenses and exposures as they are given, and read each photograph in its blocks alone");
  flags.settings.add_to(command);
  for (CLI::Option* option : command.get_options()) {
    if (std::find(before.begin(), before.end(), option) == before.end()) flags.of_scenes.push_back(option);
  }
}

}  // namespace

void add_city_command(CLI::App& program) {
  auto flags = std::make_shared<CityFlags>();
  CLI::App* command = program.add_subcommand("city", "Build a large scene in blocks, and join them to one model");
  add_file(*command, "SCENE", flags->source, "SCENE", "COLMAP workspace, another capture, or a plan of --plan")
      ->required();
  begin_group(*command, "Files");
  add_file(
      *command, "-o,--output", flags->output, "MODEL",
      "Folder, or one file that ends in .glb. MODEL.city/ beside it keeps plan and blocks until the model is there")
      ->check(model_name());
  add_file(*command, "--plan", flags->plan, "DIR",
           "Only plan: DIR gets the plan, and a Snakefile that runs its jobs on any machines");
  flags->job_option = command->add_option("--job", flags->job, "Build block K of a plan, as its Snakefile asks")
                          ->type_name("K")
                          ->transform(whole_number(0, 1'000'000));
  CLI::Option* const threads =
      command->add_option("--threads", flags->threads, "With --job, threads to use; without it as many as processors")
          ->type_name("N")
          ->transform(whole_number(1, 1024))
          ->needs(flags->job_option);
  threads->default_str("");
  command->add_option("--jobs", flags->jobs, "Blocks to build at once, each in a process of its own")
      ->type_name("N")
      ->transform(whole_number(1, 1024));
  add_scene_options(*command, *flags);
  begin_group(*command, "Model");
  flags->images.add_to(*command);
  command->add_option("--texture", flags->texture_px, "Longest side of the texture for other programs, 0: none")
      ->type_name("PX")
      ->transform(whole_number(0, kMostTexturePx));
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
