// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of rendering: milliseconds a picture for several numbers of references per cell. It also measures each step
// that is there for speed, and each that costs some, beside the straightforward loops over a cell's references and over
// every stored view. With --load, it measures milliseconds to load the next snapshot of a store in which one view has
// taken another's place. With --changes, it measures how long the next snapshot keeps the thread that draws, loaded at
// once and in pieces. With --passes, it measures milliseconds of each pass, of the model with as many references as
// --references says. With --fetches, it counts the texels that the shader fetches at each pixel, which is the same
// on every driver, and times the pictures, of the model as it is. Needs saved models only, no photographs. A table in
// Markdown goes to stdout; exit status as of lumatlas itself.
#include <epoxy/gl.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "atlas/model/model_file.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/base/elapsed.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/timing/frame_time.h"
#include "tools/lab/timing/pass_time.h"
#include "tools/lab/timing/snapshot_time.h"

namespace lumatlas {

namespace {

struct Flags {
  std::vector<std::filesystem::path> models;
  std::vector<std::uint32_t> references{8, 16, 32, 60};
  std::uint32_t width = 1920;
  std::uint32_t height = 1080;
  std::uint32_t pictures = 9;
  std::uint32_t repeats = 3;
  double border_width = BlendOptions{}.border_width;
  std::string compare = "processor";
  bool load = false;
  bool changes = false;
  double upload_ms = 4;
  bool fetches = false;
  bool passes = false;
  std::uint32_t part_px = RendererOptions{}.part_px;
};

// Returns for each cell the stored views that see it, those with the most pixels on it first.
std::vector<std::vector<ViewSlot>> views_of_cells(const Snapshot& model) {
  const Cells& cells = model.surface->cells;
  const auto visibility = make_ray_visibility(model.surface->mesh);
  std::vector<std::vector<std::pair<std::int64_t, ViewSlot>>> seen(cells.cells.size());
  for (ViewSlot slot{0}; slot < model.views.size(); ++slot) {
    if (!model.views[slot]) continue;
    for (const CellPixels& cell : count_cell_pixels(visibility->trace(model.views[slot]->camera), cells)) {
      seen[cell.cell].emplace_back(-std::int64_t{cell.pixels}, slot);
    }
  }
  std::vector<std::vector<ViewSlot>> views(seen.size());
  for (std::size_t cell = 0; cell < seen.size(); ++cell) {
    std::sort(seen[cell].begin(), seen[cell].end());
    for (const auto& [pixels, slot] : seen[cell]) views[cell].push_back(slot);
  }
  return views;
}

ReferenceTable at_most(const std::vector<std::vector<ViewSlot>>& views, std::size_t references) {
  ReferenceTable table;
  for (const std::vector<ViewSlot>& of_cell : views) {
    const auto taken = static_cast<std::ptrdiff_t>(std::min(references, of_cell.size()));
    table.views.insert(table.views.end(), of_cell.begin(), of_cell.begin() + taken);
    table.offsets.push_back(static_cast<std::uint32_t>(table.views.size()));
  }
  return table;
}

// Returns the references of other lumigraph renderers: every cell tries every stored view.
ReferenceTable every_view(const Snapshot& model) {
  std::vector<ViewSlot> all;
  for (ViewSlot slot{0}; slot < model.views.size(); ++slot) {
    if (model.views[slot]) all.push_back(slot);
  }
  return at_most(std::vector<std::vector<ViewSlot>>(model.surface->cells.cells.size(), all), all.size());
}

// The last one has all steps: the renderer's defaults.
struct Way {
  const char* name;
  RendererOptions steps;
  BlendOptions::Sampling sampling;
  bool fading;                // cells into each other
  std::uint32_t supersample;  // at silhouettes
};

constexpr RendererOptions kSkipping{.skip_losers = true, .join_cells = false};
constexpr std::array kWays{
    Way{"straightforward loop", {false, false}, BlendOptions::Sampling::linear, false, 1},
    Way{"skipping", kSkipping, BlendOptions::Sampling::linear, false, 1},
    Way{"and cubic sampling", kSkipping, BlendOptions::Sampling::cubic, false, 1},
    Way{"and cells fading", kSkipping, BlendOptions::Sampling::cubic, true, 1},
    Way{"but those of the same references", {}, BlendOptions::Sampling::cubic, true, 1},
    Way{"and silhouettes", {}, BlendOptions::Sampling::cubic, true, BlendOptions{}.supersample},
};

// The mesh is copied for the way in which cells fade, so those of one copy are measured together.
constexpr bool of_one_copy(const Way& a, const Way& b) {
  return a.fading == b.fading && a.steps.join_cells == b.steps.join_cells;
}

// For each way, the times of the pictures, each as often as it was repeated. All ways draw the same picture one after
// another, so that other work on the machine falls on all of them.
using Times = std::array<std::vector<PictureTime>, kWays.size()>;

Times time_ways(Renderer& renderer, const std::vector<Camera>& cameras, const Flags& flags) {
  Times times;
  for (std::size_t first = 0; first < kWays.size(); ++first) {
    if (first > 0 && of_one_copy(kWays[first - 1], kWays[first])) continue;
    BlendOptions blend;
    blend.border_width = kWays[first].fading ? flags.border_width : 0;
    renderer.set_options(kWays[first].steps);
    (void)time_picture(renderer, cameras.front(), blend);  // which sets up
    for (std::uint32_t repeat = 0; repeat < flags.repeats; ++repeat) {
      for (const Camera& camera : cameras) {
        for (std::size_t way = first; way < kWays.size() && of_one_copy(kWays[first], kWays[way]); ++way) {
          renderer.set_options(kWays[way].steps);
          blend.sampling = kWays[way].sampling;
          blend.supersample = kWays[way].supersample;
          times[way].push_back(time_picture(renderer, camera, blend));
        }
      }
    }
  }
  return times;
}

double median(const std::vector<PictureTime>& times, double PictureTime::*clock) {
  std::vector<double> values;
  values.reserve(times.size());
  for (const PictureTime& time : times) values.push_back(time.*clock);
  return percentile(values, 0.5);
}

// The median over pictures of what one takes of another's time.
double ratio(const std::vector<PictureTime>& times, const std::vector<PictureTime>& others,
             double PictureTime::*clock) {
  std::vector<double> values;
  for (std::size_t i = 0; i < times.size(); ++i) values.push_back(times[i].*clock / (others[i].*clock));
  return percentile(values, 0.5);
}

struct Row {
  std::string references;
  double mean;  // per cell
  Times times;
};

Row measure(Snapshot model, const std::string& references, ReferenceTable table, const std::vector<Camera>& cameras,
            const Flags& flags) {
  const double mean = static_cast<double>(table.views.size()) / static_cast<double>(table.offsets.size() - 1);
  model.references = std::move(table);
  Renderer renderer;
  renderer.load(model);
  return {references, mean, time_ways(renderer, cameras, flags)};
}

void print(const std::string& name, const Row& row, const Row& every_view, double PictureTime::*clock) {
  const std::vector<PictureTime>& loop = row.times.front();
  const std::vector<PictureTime>& longest = every_view.times.front();
  std::cout << "| " << name << " | " << row.references << std::fixed << std::setprecision(1) << " | " << row.mean
            << " | " << median(loop, &PictureTime::wall) << " / " << median(loop, &PictureTime::processor) << " | "
            << median(row.times.back(), &PictureTime::wall) << " / "
            << median(row.times.back(), &PictureTime::processor) << std::setprecision(2);
  for (std::size_t way = 1; way < kWays.size(); ++way) std::cout << " | " << ratio(row.times[way], loop, clock);
  std::cout << " | " << ratio(loop, longest, clock) << " | " << ratio(row.times.back(), longest, clock) << " |"
            << std::endl;
}

void measure_model(const std::filesystem::path& path, const Flags& flags) {
  const Snapshot model = read_model(path).snapshot;
  const std::vector<Camera> cameras = cameras_between_views(model, flags.pictures, {flags.width, flags.height});
  if (cameras.empty()) throw std::invalid_argument(path.string() + ": stores no view, there is nothing to render");
  const std::string name = std::filesystem::weakly_canonical(path).filename().string();
  const auto clock = flags.compare == "wall" ? &PictureTime::wall : &PictureTime::processor;
  const auto views = views_of_cells(model);
  const Row every = measure(model, "every view", every_view(model), cameras, flags);
  for (const std::uint32_t references : flags.references) {
    print(name, measure(model, std::to_string(references), at_most(views, references), cameras, flags), every, clock);
  }
  print(name, every, every, clock);
}

// The model with nothing in the slots that are not kept, and averaged colours of its own.
Snapshot keeping(const Snapshot& model, const std::vector<bool>& kept) {
  Snapshot rest = model;
  rest.references = {};
  rest.references.offsets.assign(1, 0);
  for (CellId cell{0}; cell + 1 < model.references.offsets.size(); ++cell) {
    for (const ViewSlot slot : model.references.of_cell(cell)) {
      if (kept[slot]) rest.references.views.push_back(slot);
    }
    rest.references.offsets.push_back(static_cast<std::uint32_t>(rest.references.views.size()));
  }
  if (!rest.tiles.whole_views()) rest.tiles.places.clear();
  for (ViewSlot slot{0}; slot < model.views.size(); ++slot) {
    if (!kept[slot]) rest.views[slot].reset();
    if (rest.tiles.whole_views()) continue;
    const auto tiles = model.tiles.places.begin();
    if (kept[slot]) {
      rest.tiles.places.insert(rest.tiles.places.end(), tiles + model.tiles.first_tile[slot],
                               tiles + model.tiles.first_tile[slot + 1]);
    }
    rest.tiles.first_tile[slot + 1] = static_cast<std::uint32_t>(rest.tiles.places.size());
  }
  FallbackColors::Colors colors = model.vertex_colors.get();
  colors.front() = glm::u8vec3(std::hash<std::vector<bool>>{}(kept) % 256);
  rest.vertex_colors = std::move(colors);
  return rest;
}

std::vector<ViewSlot> slots_with_views(const Snapshot& model) {
  std::vector<ViewSlot> slots;
  for (ViewSlot slot{0}; slot < model.views.size(); ++slot) {
    if (model.views[slot]) slots.push_back(slot);
  }
  return slots;
}

PictureTime time_load(Renderer& renderer, const Snapshot& snapshot) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor_start = std::clock();
  renderer.load(snapshot);
  glFinish();
  return {ms_since(start), 1e3 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC};
}

struct Loads {
  std::vector<double> wall, processor;
};

void print_loads(const Loads& loads) {
  std::cout << " | " << percentile(loads.wall, 0.5) << " / " << percentile(loads.processor, 0.5) << " | "
            << percentile(loads.wall, 0.95) << " / " << percentile(loads.processor, 0.95);
}

// Measures a renderer that draws a picture after each snapshot, as one that follows a store does. The first snapshot
// copies everything, and after the second cells are not joined any more: these two are not counted. A view that comes
// is a new one, even if an earlier snapshot had it: the GPU's copy of it is of no use.
Loads time_loads(const std::vector<std::vector<bool>>& kept, Snapshot model, const Flags& flags) {
  const std::vector<Camera> cameras = cameras_between_views(model, 1, {flags.width, flags.height});
  Renderer renderer;
  Loads loads;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (std::size_t slot = 0; i > 0 && slot < kept[i].size(); ++slot) {
      if (kept[i][slot] && !kept[i - 1][slot])
        model.views[slot] = std::make_shared<const StoredView>(*model.views[slot]);
    }
    const Snapshot next = keeping(model, kept[i]);
    const PictureTime time = time_load(renderer, next);
    (void)time_picture(renderer, cameras.front(), {});
    if (i < 2) continue;
    loads.wall.push_back(time.wall);
    loads.processor.push_back(time.processor);
  }
  return loads;
}

void measure_loads(const std::filesystem::path& path, const Flags& flags) {
  const Snapshot model = read_model(path).snapshot;
  const std::vector<ViewSlot> slots = slots_with_views(model);
  const std::size_t count = std::size_t{flags.pictures} * flags.repeats;
  if (slots.size() < count + 3) {
    throw std::invalid_argument(path.string() + ": stores " + std::to_string(slots.size()) + " views, for " +
                                std::to_string(count) + " snapshots it must be at least " + std::to_string(count + 3));
  }
  std::vector<std::vector<bool>> others, more;
  for (std::size_t i = 0; i < count + 2; ++i) {
    others.emplace_back(model.views.size(), true)[slots[i]] = false;
    std::vector<bool>& fewer = more.emplace_back(model.views.size(), true);
    for (std::size_t left_out = i + 1; left_out < count + 2; ++left_out) {
      fewer[slots[slots.size() - 1 - (left_out - i - 1)]] = false;
    }
  }
  const std::string name = std::filesystem::weakly_canonical(path).filename().string();
  std::cout << "| " << name << " | " << slots.size() << std::fixed << std::setprecision(1);
  print_loads(time_loads(others, model, flags));
  print_loads(time_loads(more, model, flags));
  std::cout << " |" << std::endl;
}

void run_loads(const Flags& flags, const std::string& context) {
  std::cout
      << "Loading the next snapshot of a store, medians and 95th percentiles over " << flags.pictures * flags.repeats
      << " of them on " << context
      << ". Milliseconds: wall / processor.\n\n| model | views | one in place of another, median | 95 % | one more, "
         "median | 95 % |\n|---|---|---|---|---|---|\n";
  for (const std::filesystem::path& model : flags.models) measure_loads(model, flags);
}

// The model with one view in place of another, and with the other half of its views on another surface.
struct Changes {
  Snapshot before, after;
};

Changes one_view(const Snapshot& model, const std::vector<ViewSlot>& slots) {
  std::vector<bool> first(model.views.size(), true), second = first;
  first[slots[0]] = second[slots[1]] = false;
  return {keeping(model, first), keeping(model, second)};
}

Changes everything(const Snapshot& model, const std::vector<ViewSlot>& slots) {
  std::vector<bool> first(model.views.size(), false), second = first;
  for (std::size_t i = 0; i < slots.size(); ++i) (i < slots.size() / 2 ? first : second)[slots[i]] = true;
  Changes changes{keeping(model, first), keeping(model, second)};
  changes.after.surface = std::make_shared<const Surface>(*model.surface);
  return changes;
}

void measure_changes(const std::filesystem::path& path, const Flags& flags) {
  const Snapshot model = read_model(path).snapshot;
  const std::vector<ViewSlot> slots = slots_with_views(model);
  if (slots.size() < 2) throw std::invalid_argument(path.string() + ": stores fewer than 2 views");
  const Camera camera = cameras_between_views(model, 1, {flags.width, flags.height}).front();
  const std::string name = std::filesystem::weakly_canonical(path).filename().string();
  const auto measure_one = [&](const char* what, const Changes& changes) {
    std::vector<double> once_wall, once_processor, pieces_wall, pieces_processor, frames;
    for (std::uint32_t repeat = 0; repeat < flags.repeats; ++repeat) {
      Renderer at_once, in_pieces;
      for (Renderer* renderer : {&at_once, &in_pieces}) {
        renderer->load(changes.before);
        renderer->make_ready({});
        (void)time_picture(*renderer, camera, {});
      }
      const SnapshotTime once = time_at_once(at_once, changes.after, {});
      const SnapshotTime pieces = time_in_pieces(in_pieces, changes.after, camera, {}, flags.upload_ms);
      once_wall.push_back(once.wall);
      once_processor.push_back(once.processor);
      pieces_wall.push_back(pieces.wall);
      pieces_processor.push_back(pieces.processor);
      frames.push_back(pieces.frames);
    }
    std::cout << "| " << name << " | " << what << " | " << std::fixed << std::setprecision(1)
              << percentile(once_wall, 0.5) << " / " << percentile(once_processor, 0.5) << " | "
              << percentile(pieces_wall, 0.5) << " / " << percentile(pieces_processor, 0.5) << " | "
              << std::setprecision(0) << percentile(frames, 0.5) << " |" << std::endl;
  };
  measure_one("one view in place of another", one_view(model, slots));
  measure_one("other views on another surface", everything(model, slots));
}

void run_changes(const Flags& flags, const std::string& context) {
  std::cout
      << "The longest time in one frame, beside its picture of " << flags.width << "x" << flags.height
      << ", that the next snapshot takes on the thread that draws, loaded at once and in pieces of "
      << number_text(flags.upload_ms) << " ms; medians over " << flags.repeats << " on " << context
      << ". Milliseconds: wall / this thread's processor time.\n\n| model | change | at once | in pieces | frames "
         "|\n|---|---|---|---|---|\n";
  for (const std::filesystem::path& model : flags.models) measure_changes(model, flags);
}

// Returns the counts of the pixels that see a surface, in pairs of texels as on a GPU or texel by texel.
std::vector<double> fetches_of(Renderer& renderer, const Camera& camera, bool in_pairs) {
  std::vector<double> counts;
  renderer.set_options({.filtered_taps = in_pairs});
  for (const std::uint32_t count : renderer.count_fetches(camera, {})) {
    if (count > 0) counts.push_back(count);
  }
  return counts;
}

void measure_fetches(const std::filesystem::path& path, const Flags& flags) {
  const Snapshot model = read_model(path).snapshot;
  const std::vector<Camera> cameras = cameras_between_views(model, flags.pictures, {flags.width, flags.height});
  const std::string name = std::filesystem::weakly_canonical(path).filename().string();
  Renderer renderer;
  renderer.load(model);
  std::vector<double> all, all_pairs;
  const auto counts_text = [](const std::vector<double>& counts, const std::vector<double>& pairs) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(0) << percentile(pairs, 0.5) << " | " << percentile(pairs, 0.95) << " | "
         << percentile(counts, 0.5) << " | " << percentile(counts, 0.95);
    return text.str();
  };
  for (std::size_t picture = 0; picture < cameras.size(); ++picture) {
    const std::vector<double> pairs = fetches_of(renderer, cameras[picture], true);
    const std::vector<double> counts = fetches_of(renderer, cameras[picture], false);
    all_pairs.insert(all_pairs.end(), pairs.begin(), pairs.end());
    all.insert(all.end(), counts.begin(), counts.end());
    renderer.set_options({});
    std::vector<PictureTime> times;
    times.reserve(flags.repeats);
    for (std::uint32_t repeat = 0; repeat < flags.repeats; ++repeat) {
      times.push_back(time_picture(renderer, cameras[picture], {}));
    }
    if (counts.empty()) continue;
    std::cout << "| " << name << " | " << picture << " | " << counts_text(counts, pairs) << " | " << std::fixed
              << std::setprecision(0) << median(times, &PictureTime::wall) << " / "
              << median(times, &PictureTime::processor) << " |" << std::endl;
  }
  if (all.empty()) return;
  std::cout << "| " << name << " | all | " << counts_text(all, all_pairs) << " | |" << std::endl;
}

void run_fetches(const Flags& flags, const std::string& context) {
  std::cout << "Fetches at a pixel's middle, with pairs of texels as one, as on a GPU, and texel by texel; and "
               "milliseconds a picture of "
            << flags.width << "x" << flags.height << ", medians over " << flags.repeats << ", on " << context
            << ".\n\n| model | picture | pairs, median | 95 % | texels, median | 95 % | wall / processor, ms "
               "|\n|---|---|---|---|---|---|---|\n";
  for (const std::filesystem::path& model : flags.models) measure_fetches(model, flags);
}

void print_passes(const std::string& row, const std::vector<PassTime>& times) {
  PassTime all{"all", 0, 0, std::nullopt};
  for (const PassTime& time : times) {
    all.wall += time.wall;
    all.processor += time.processor;
    if (time.gpu) all.gpu = all.gpu.value_or(0) + *time.gpu;
  }
  const auto print_one = [&](const PassTime& time) {
    std::cout << row << " | " << time.pass << std::fixed << std::setprecision(2) << " | " << time.wall << " / "
              << time.processor << " | ";
    if (time.gpu) std::cout << *time.gpu;
    std::cout << " |" << std::endl;
  };
  for (const PassTime& time : times) print_one(time);
  print_one(all);
}

void measure_passes(const std::filesystem::path& path, const Flags& flags) {
  Snapshot model = read_model(path).snapshot;
  const std::vector<Camera> cameras = cameras_between_views(model, flags.pictures, {flags.width, flags.height});
  if (cameras.empty()) throw std::invalid_argument(path.string() + ": stores no view, there is nothing to render");
  const auto views = views_of_cells(model);
  const std::string name = std::filesystem::weakly_canonical(path).filename().string();
  Renderer renderer({.part_px = flags.part_px});
  for (const std::uint32_t references : flags.references) {
    model.references = at_most(views, references);
    renderer.load(model);
    print_passes("| " + name + " | " + std::to_string(references), pass_times(renderer, cameras, {}));
  }
  std::cout << "\n"
            << name << ": pictures are drawn into "
            << number_text(1e-6 * static_cast<double>(renderer.work().targets), 1) << " MB.\n";
}

void run_passes(const Flags& flags, const std::string& context) {
  std::cout << "Milliseconds of each pass of a picture of " << flags.width << "x" << flags.height << ", medians over "
            << flags.pictures << ", in parts of at most " << flags.part_px << " pixels a side, on " << context
            << ". Wall and processor: where each pass is finished before the next one begins. GPU: by its own clock, "
               "without waiting.\n\n| model | references at most | pass | wall / processor, ms | GPU, ms "
               "|\n|---|---|---|---|---|\n";
  for (const std::filesystem::path& model : flags.models) measure_passes(model, flags);
}

void run(const Flags& flags) {
  const EglContext context;
  std::cerr << context.description() << '\n';
  if (flags.load) return run_loads(flags, context.description());
  if (flags.changes) return run_changes(flags, context.description());
  if (flags.fetches) return run_fetches(flags, context.description());
  if (flags.passes) return run_passes(flags, context.description());
  std::cout << "Pictures of " << flags.width << "x" << flags.height << ", medians over " << flags.pictures
            << " of them, " << flags.repeats << " times each, on " << context.description()
            << ". Milliseconds: wall / processor. Shares of " << flags.compare
            << " time: each way's of the straightforward loop's over the same references, and of that over every "
               "stored view.\n\n| model | references at most | mean a cell | "
            << kWays.front().name << ", ms | all steps, ms";
  for (std::size_t way = 1; way < kWays.size(); ++way) std::cout << " | " << kWays[way].name;
  std::cout << " | loop, of every view's | all steps, of every view's |\n|";
  for (std::size_t column = 0; column < kWays.size() + 6; ++column) std::cout << "---|";
  std::cout << '\n';
  for (const std::filesystem::path& model : flags.models) measure_model(model, flags);
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of lumatlas's renderer: what references per cell and each step for speed are worth");
  program.option_defaults()->always_capture_default();
  lumatlas::Flags flags;
  program.add_option("MODEL", flags.models, "Folders or .glb files that `lumatlas build` wrote")->required();
  program.add_option("--references", flags.references, "R, per cell, of the views that see it")
      ->allow_extra_args(false)
      ->check(CLI::Range(1u, 100000u));
  program.add_option("--width", flags.width, "Pixels")->check(CLI::Range(1u, 65536u));
  program.add_option("--height", flags.height, "Pixels")->check(CLI::Range(1u, 65536u));
  program.add_option("--pictures", flags.pictures, "How many are timed")->check(CLI::Range(1u, 100000u));
  program.add_option("--repeats", flags.repeats, "Of each picture, the ways one after another")
      ->check(CLI::Range(1u, 100000u));
  program.add_option("--compare", flags.compare, "Which time the shares are of: processor, or wall, for a GPU")
      ->check(CLI::IsMember({"processor", "wall"}));
  program.add_flag("--load", flags.load,
                   "Time no pictures but --pictures times --repeats snapshots, each with another view");
  program.add_flag("--changes", flags.changes,
                   "Time --repeats times what the next snapshot takes of a frame, at once and in pieces");
  program.add_option("--upload-ms", flags.upload_ms, "Milliseconds a frame that may be uploaded, with --changes")
      ->check(lumatlas::number_between(0, 1e6));
  program.add_flag("--fetches", flags.fetches,
                   "Count the texels that the shader fetches at each pixel, and time pictures, of the model as it is");
  program.add_flag("--passes", flags.passes, "Time each pass of a picture, with as many --references");
  program.add_option("--part", flags.part_px, "Longest side of the parts of a picture, pixels, with --passes")
      ->check(CLI::Range(64u, 4000u));
  program.add_option("--border-width", flags.border_width, "Of cells that fade into each other, of the cell size")
      ->check(lumatlas::number_between(0, 1));
  return lumatlas::run_program(program, "bench_render", argc, argv, [&] { lumatlas::run(flags); });
}
