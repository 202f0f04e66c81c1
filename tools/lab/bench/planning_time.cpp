// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/bench/planning_time.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <glm/glm.hpp>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "mesh/base/median.h"
#include "planner/surface_distance.h"
#include "tools/base/progress.h"
#include "tools/lab/synth/synth.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

// Waves of a centimetre, some decimetres long, that depend on the place alone, so that no seam opens. Flat walls
// along the axes would be the easiest case there is for a tree of boxes.
void make_uneven(Mesh& mesh) {
  constexpr double kHeight = 0.01;  // the apartment is in metres
  for (glm::vec3& position : mesh.positions) {
    const glm::dvec3 p(position);
    const glm::dvec3 phase(23 * p.y + 17 * p.z, 29 * p.z + 19 * p.x, 31 * p.x + 13 * p.y);
    position += glm::vec3(kHeight * glm::sin(phase));
  }
}

// From sample `lap` on, every `laps`-th: each lap takes its steps a little further than the one before.
std::vector<Camera> in_laps(const std::vector<Camera>& samples, std::size_t laps) {
  std::vector<Camera> cameras;
  cameras.reserve(samples.size());
  for (std::size_t lap = 0; lap < laps; ++lap) {
    for (std::size_t i = lap; i < samples.size(); i += laps) cameras.push_back(samples[i]);
  }
  return cameras;
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all_pages = 0;
  std::uint64_t resident_pages = 0;
  file >> all_pages >> resident_pages;
  return resident_pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

double cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

Photograph blank(const Camera& camera) {
  return {camera.width, camera.height, std::vector<std::uint8_t>(std::size_t{3} * camera.width * camera.height), {}};
}

}  // namespace

PlanningScene load_planning_scene(const std::filesystem::path& folder, std::size_t most_views) {
  std::cerr << "reading " << folder.string() << '\n';
  const std::string name = std::filesystem::weakly_canonical(folder).filename().string();
  PlanningScene scene{name, load_surface(folder, {}, {}).surface, {}};
  const std::vector<SceneView> views = read_scene_views(folder, scene.surface->offset).views;
  const std::size_t taken = std::min(views.size(), most_views);
  for (std::size_t i = 0; i < taken; ++i) scene.cameras.push_back(views[i * views.size() / taken].camera);
  return scene;
}

PlanningScene make_planning_scene(const ApartmentOptions& options) {
  constexpr std::uint64_t kSeed = 1;
  std::cerr << "making an apartment of " << options.triangles << " triangles\n";
  synth::Scene apartment = synth::make_apartment(kSeed, options.triangles);
  SynthOptions walk;
  walk.seed = kSeed;
  walk.views = options.views_per_lap * options.laps;
  walk.width = options.width;
  walk.height = options.height;
  const std::vector<Camera> samples = synth::cameras_on_walk(apartment, walk);
  const auto surface = std::make_shared<Surface>();
  surface->mesh = std::move(apartment.geometry.mesh);
  const std::size_t faces = surface->mesh.faces.size();
  if (std::abs(static_cast<double>(faces) / options.triangles - 1) > 0.01) {
    throw std::runtime_error("the apartment has " + std::to_string(faces) + " triangles, not the " +
                             std::to_string(options.triangles) + " asked for: ask for more");
  }
  make_uneven(surface->mesh);
  std::cerr << "making cells of " << faces << " triangles\n";
  surface->cells = make_cells(surface->mesh, {});
  return {"apartment", surface, in_laps(samples, options.laps)};
}

std::vector<PlannedTime> time_planning(const PlanningScene& scene, const Visibility& visibility, PlannerOptions options,
                                       std::uint32_t max_views) {
  options.refinement.alignment.exposure = false;
  options.refinement.alignment.pose = false;
  options.refinement.trust.enabled = false;
  options.coverage.ideal_distance = median_surface_distance(scene.cameras, visibility);
  Atlas atlas(scene.surface, max_views);
  Planner planner(atlas, visibility, options);
  std::vector<PlannedTime> times;
  times.reserve(scene.cameras.size());
  Progress progress(scene.name + ", " + std::to_string(options.coverage.max_references) + " references",
                    scene.cameras.size());
  for (const Camera& camera : scene.cameras) {
    const double before_ms = cpu_ms();
    const Verdict verdict = planner.offer(std::to_string(times.size()), camera, [&] { return blank(camera); });
    times.push_back({verdict.visibility_ms, verdict.plan_ms, cpu_ms() - before_ms, verdict.decision, resident_bytes()});
    progress.tick();
  }
  return times;
}

Spread spread(std::span<const PlannedTime> times, double (*value)(const PlannedTime&)) {
  std::vector<double> values;
  values.reserve(times.size());
  for (const PlannedTime& time : times) values.push_back(value(time));
  return {percentile(values, 0.5), percentile(values, 0.95)};
}

}  // namespace lumatlas
