// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of rendering: milliseconds a picture for so many references per cell, with and without each step that is
// there for speed alone, beside the straightforward loops. Needs saved models only, no photographs. A table in Markdown
// goes to stdout; exit status as of lumatlas itself.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <numeric>
#include <string>
#include <vector>

#include "atlas/model_file.h"
#include "blend/renderer.h"
#include "tools/bench_program.h"
#include "tools/frame_time.h"
#include "tools/number_flags.h"

namespace lumatlas {

namespace {

struct Flags {
  std::vector<std::filesystem::path> models;
  std::vector<std::uint32_t> references{8, 16, 32, 60};
  std::uint32_t width = 1920;
  std::uint32_t height = 1080;
  std::uint32_t pictures = 9;
  double border_width = BlendOptions{}.border_width;
};

// By cell, the stored views that see it, those with the most pixels on it first.
std::vector<std::vector<std::uint32_t>> views_of_cells(const Snapshot& model) {
  const Cells& cells = model.surface->cells;
  const auto visibility = make_ray_visibility(model.surface->mesh);
  std::vector<std::vector<std::pair<std::int64_t, std::uint32_t>>> seen(cells.cells.size());
  for (std::uint32_t slot = 0; slot < model.views.size(); ++slot) {
    if (!model.views[slot]) continue;
    for (const CellPixels& cell : count_cell_pixels(visibility->trace(model.views[slot]->camera), cells)) {
      seen[cell.cell].emplace_back(-std::int64_t{cell.pixels}, slot);
    }
  }
  std::vector<std::vector<std::uint32_t>> views(seen.size());
  for (std::size_t cell = 0; cell < seen.size(); ++cell) {
    std::sort(seen[cell].begin(), seen[cell].end());
    for (const auto& [pixels, slot] : seen[cell]) views[cell].push_back(slot);
  }
  return views;
}

ReferenceTable at_most(const std::vector<std::vector<std::uint32_t>>& views, std::size_t references) {
  ReferenceTable table;
  for (const std::vector<std::uint32_t>& of_cell : views) {
    const auto taken = static_cast<std::ptrdiff_t>(std::min(references, of_cell.size()));
    table.views.insert(table.views.end(), of_cell.begin(), of_cell.begin() + taken);
    table.offsets.push_back(static_cast<std::uint32_t>(table.views.size()));
  }
  return table;
}

// What other lumigraph renderers do: every cell tries every stored view.
ReferenceTable every_view(const Snapshot& model) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t slot = 0; slot < model.views.size(); ++slot) {
    if (model.views[slot]) all.push_back(slot);
  }
  return at_most(std::vector<std::vector<std::uint32_t>>(model.surface->cells.cells.size(), all), all.size());
}

struct Way {
  const char* name;
  RendererOptions steps;
  bool fading;  // cells into each other
};

constexpr std::array kWays{
    Way{"straightforward loop", {.skip_losers = false, .order_references = false}, false},
    Way{"skipping", {.skip_losers = true, .order_references = false}, false},
    Way{"ordered, skipping", {.skip_losers = true, .order_references = true}, false},
    Way{"and cells fading", {.skip_losers = true, .order_references = true}, true},
};

void measure(const std::string& name, Snapshot model, const std::string& references, ReferenceTable table,
             const std::vector<Camera>& cameras, const EglContext& context, const Flags& flags) {
  const double mean = static_cast<double>(table.views.size()) / static_cast<double>(table.offsets.size() - 1);
  model.references = std::move(table);
  std::cout << "| " << name << " | " << references << " | " << std::fixed << std::setprecision(1) << mean;
  for (const Way& way : kWays) {
    Renderer renderer(context, way.steps);
    renderer.load(model);
    BlendOptions blend;
    blend.border_width = way.fading ? flags.border_width : 0;
    const FrameTime time = frame_time(renderer, cameras, blend);
    std::cout << " | " << time.wall << " / " << time.processor << std::flush;
  }
  std::cout << " |" << std::endl;
}

void measure_model(const std::filesystem::path& path, const EglContext& context, const Flags& flags) {
  const Snapshot model = read_model(path).snapshot;
  const std::vector<Camera> cameras = cameras_between_views(model, flags.pictures, {flags.width, flags.height});
  if (cameras.empty()) throw std::invalid_argument(path.string() + ": stores no view, there is nothing to render");
  const std::string name = std::filesystem::weakly_canonical(path).filename().string();
  const auto views = views_of_cells(model);
  for (const std::uint32_t references : flags.references) {
    measure(name, model, std::to_string(references), at_most(views, references), cameras, context, flags);
  }
  measure(name, model, "every view", every_view(model), cameras, context, flags);
}

void run(const Flags& flags) {
  const EglContext context;
  std::cerr << context.description() << '\n';
  std::cout << "Milliseconds a picture, wall / processor, of " << flags.width << "x" << flags.height << ", median of "
            << flags.pictures << ", on " << context.description() << ".\n\n| model | references at most | mean a cell";
  for (const Way& way : kWays) std::cout << " | " << way.name;
  std::cout << " |\n|---|---|---|---|---|---|---|\n";
  for (const std::filesystem::path& model : flags.models) measure_model(model, context, flags);
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
  program.add_option("--border-width", flags.border_width, "Of cells that fade into each other, of the cell size")
      ->check(lumatlas::number_between(0, 1));
  return lumatlas::run_program(program, "bench_render", argc, argv, [&] { lumatlas::run(flags); });
}
