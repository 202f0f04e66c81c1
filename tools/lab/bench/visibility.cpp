// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of visibility: rays, and the GPU with and without frustum culling, for the same cameras in turn. A table in
// Markdown goes to stdout; exit status as of lumatlas itself.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <iomanip>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "blend/gl/egl_context.h"
#include "blend/gl_visibility.h"
#include "blend/tables/cell_runs.h"
#include "mesh/base/median.h"
#include "mesh/cells/cells.h"
#include "mesh/visibility/visibility.h"
#include "tools/base/elapsed.h"
#include "tools/lab/bench/program.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

constexpr std::size_t kMostCameras = 60;

struct Flags {
  std::vector<std::filesystem::path> scenes;
  std::vector<std::uint32_t> sphere_faces;
  std::vector<std::uint32_t> pixels{320, 640};
  std::uint32_t seed = 1;
};

// Unit sphere with bumps of a twentieth, as six sides of a cube with `quads` quads along each edge.
Mesh bumpy_sphere(std::uint32_t quads) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (std::uint32_t j = 0; j <= quads; ++j) {
        for (std::uint32_t i = 0; i <= quads; ++i) {
          glm::dvec3 at;
          at[axis] = side;
          at[(axis + 1) % 3] = side * (2.0 * i / quads - 1);
          at[(axis + 2) % 3] = 2.0 * j / quads - 1;
          at = glm::normalize(at);
          mesh.positions.emplace_back(at *
                                      (1 + 0.05 * std::sin(19 * at.x) * std::sin(17 * at.y) * std::sin(23 * at.z)));
        }
      }
      for (std::uint32_t j = 0; j < quads; ++j) {
        for (std::uint32_t i = 0; i < quads; ++i) {
          const std::uint32_t a = first + j * (quads + 1) + i;
          const std::uint32_t c = a + quads + 2;
          mesh.faces.insert(mesh.faces.end(), {{a, a + 1, c}, {a, c, c - 1}});
        }
      }
    }
  }
  return mesh;
}

// Inside of the sphere, in any direction.
std::vector<Camera> cameras_inside(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Camera> cameras(kMostCameras);
  for (Camera& camera : cameras) {
    camera.width = 1920;
    camera.height = 1440;
    camera.fx = camera.fy = 1700;
    camera.cx = 960;
    camera.cy = 720;
    const glm::dquat turn(uniform(random), uniform(random), uniform(random), uniform(random));
    camera.cam_from_world_rotation = glm::mat3_cast(glm::normalize(turn));
    camera.cam_from_world_translation = 0.4 * glm::dvec3(uniform(random), uniform(random), uniform(random));
  }
  return cameras;
}

double milliseconds(const Visibility& visibility, const Camera& camera, VisibilityBuffer& buffer) {
  const auto start = std::chrono::steady_clock::now();
  visibility.trace(camera, buffer);
  return ms_since(start);
}

double share_in_view(const CellRuns& runs, const Camera& camera) {
  std::size_t faces = 0;
  for (const FaceRun& run : runs.in_view(camera)) faces += run.count;
  return static_cast<double>(faces) / static_cast<double>(runs.order().size());
}

void measure(const std::string& name, const Mesh& mesh, const Cells& cells, const std::vector<Camera>& cameras,
             const std::vector<std::uint32_t>& sizes) {
  const std::array<std::unique_ptr<Visibility>, 3> ways{make_ray_visibility(mesh), make_gl_visibility(mesh, cells),
                                                        make_gl_visibility(mesh, cells, {.frustum_culling = false})};
  const CellRuns runs(cells, mesh.faces.size());
  for (const std::uint32_t pixels : sizes) {
    std::array<std::vector<double>, 3> times;
    std::vector<double> shares;
    VisibilityBuffer buffer;
    for (const auto& way : ways) way->trace(cameras.front().shrunk_to(pixels), buffer);  // the first call sets up
    for (const Camera& full : cameras) {
      const Camera camera = full.shrunk_to(pixels);
      shares.push_back(share_in_view(runs, camera));
      for (std::size_t way = 0; way < ways.size(); ++way) {
        times[way].push_back(milliseconds(*ways[way], camera, buffer));
      }
    }
    std::cout << "| " << name << " | " << std::fixed << std::setprecision(2)
              << 1e-6 * static_cast<double>(mesh.faces.size()) << " M | " << cells.cells.size() << " | " << pixels
              << " | " << std::setprecision(0) << 100 * percentile(shares, 0.5) << " %" << std::setprecision(1);
    for (const auto& way : times) std::cout << " | " << percentile(way, 0.5) << " / " << percentile(way, 0.95);
    std::cout << " |" << std::endl;
  }
}

void measure_scene(const std::filesystem::path& path, const std::vector<std::uint32_t>& sizes) {
  const SurfaceInput input = load_surface(path, std::nullopt, {});
  const SceneViews scene = read_scene_views(path, input.surface->offset);
  std::vector<Camera> cameras;
  const std::size_t taken = std::min(scene.views.size(), kMostCameras);
  for (std::size_t i = 0; i < taken; ++i) cameras.push_back(scene.views[i * scene.views.size() / taken].camera);
  measure(std::filesystem::weakly_canonical(path).filename().string(), input.surface->mesh, input.surface->cells,
          cameras, sizes);
}

void measure_sphere(std::uint32_t faces, const Flags& flags) {
  const Mesh mesh = bumpy_sphere(static_cast<std::uint32_t>(std::ceil(std::sqrt(faces / 12.0))));
  measure("sphere", mesh, make_cells(mesh, {}), cameras_inside(flags.seed), flags.pixels);
}

void run(const Flags& flags) {
  std::cerr << EglContext().description() << '\n';
  std::cout << "Milliseconds a view, median / 95th percentile.\n\n"
               "| surface | faces | cells | pixels | faces in view | rays | GPU | GPU, nothing culled |\n"
               "|---|---|---|---|---|---|---|---|\n";
  for (const std::filesystem::path& scene : flags.scenes) measure_scene(scene, flags.pixels);
  for (const std::uint32_t faces : flags.sphere_faces) measure_sphere(faces, flags);
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of lumatlas's visibility: rays against the GPU, with and without frustum culling");
  program.option_defaults()->always_capture_default();
  lumatlas::Flags flags;
  program.add_option("SCENE", flags.scenes, "COLMAP workspaces with a mesh; 60 evenly spaced views at most");
  program.add_option("--sphere", flags.sphere_faces, "A bumpy sphere of about this many faces, seen from inside")
      ->allow_extra_args(false)
      ->check(CLI::Range(12u, 400000000u));
  program.add_option("--pixels", flags.pixels, "Longer side of the image")
      ->allow_extra_args(false)
      ->check(CLI::Range(1u, 65536u));
  program.add_option("--seed", flags.seed, "Of the sphere's cameras");
  return lumatlas::run_program(program, "bench_visibility", argc, argv, [&] { lumatlas::run(flags); });
}
