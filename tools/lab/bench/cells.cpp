// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of what a mesh goes through before views are planned on it: splitting and cells, on a generated surface. A
// table in Markdown goes to stdout; exit status as of lumatlas itself.
#include "mesh/cells/cells.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <glm/glm.hpp>
#include <iomanip>
#include <iostream>
#include <random>
#include <vector>

#include "mesh/cells/split_faces.h"
#include "tools/lab/bench/program.h"

namespace lumatlas {

namespace {

struct Flags {
  std::vector<std::uint32_t> faces{800'000};
  bool shuffled = false;
  std::uint32_t repeats = 3;
};

// A sheet of 2 * quads^2 faces over the unit square, with hills of a twentieth.
Mesh hilly_sheet(std::uint32_t quads) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= quads; ++j) {
    for (std::uint32_t i = 0; i <= quads; ++i) {
      const double x = static_cast<double>(i) / quads, y = static_cast<double>(j) / quads;
      mesh.positions.emplace_back(x, y, 0.05 * std::sin(31 * x) * std::sin(23 * y));
    }
  }
  for (std::uint32_t j = 0; j < quads; ++j) {
    for (std::uint32_t i = 0; i < quads; ++i) {
      const std::uint32_t a = j * (quads + 1) + i;
      const std::uint32_t c = a + quads + 2;
      mesh.faces.insert(mesh.faces.end(), {{a, a + 1, c}, {a, c, c - 1}});
    }
  }
  return mesh;
}

struct Seconds {
  double wall = 1e30;
  double processor = 1e30;  // all threads together, which other programs on the machine disturb less
};

template <typename Work>
Seconds least_seconds(std::uint32_t repeats, const Work& work) {
  Seconds least;
  for (std::uint32_t i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t processor_start = std::clock();
    work();
    least.processor = std::min(least.processor, static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
    least.wall = std::min(least.wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

void measure(std::uint32_t faces, const Flags& flags) {
  Mesh mesh = hilly_sheet(static_cast<std::uint32_t>(std::ceil(std::sqrt(faces / 2.0))));
  if (flags.shuffled) std::shuffle(mesh.faces.begin(), mesh.faces.end(), std::mt19937(1));
  std::size_t cells = 0;
  const Seconds making = least_seconds(flags.repeats, [&] { cells = make_cells(mesh, {}).cells.size(); });
  const double max_edge = 0.6 * std::sqrt(2.0 / faces);  // every edge is longer: each face becomes about eight
  std::size_t split_faces = 0;
  const Seconds splitting =
      least_seconds(1, [&] { split_faces = faces > 1'000'000 ? 0 : split_large_faces(mesh, max_edge).faces.size(); });
  std::cout << std::fixed << "| " << std::setprecision(2) << 1e-6 * static_cast<double>(mesh.faces.size()) << " M | "
            << cells << " | " << making.wall << " / " << making.processor << " | "
            << 1e-6 * static_cast<double>(split_faces) << " M | " << splitting.wall << " / " << splitting.processor
            << " |" << std::endl;
}

void run(const Flags& flags) {
  std::cout << "Seconds, by the clock / of the processors.\n\n| faces | cells | making cells | after splitting | "
               "splitting |\n|---|---|---|---|---|\n";
  for (const std::uint32_t faces : flags.faces) measure(faces, flags);
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of lumatlas's cells: of a hilly sheet, the least of some repeats");
  program.option_defaults()->always_capture_default();
  lumatlas::Flags flags;
  program.add_option("--faces", flags.faces, "About how many faces; splitting is timed up to a million")
      ->check(CLI::Range(2u, 100000000u));
  program.add_option("--repeats", flags.repeats, "Times that cells are made")->check(CLI::Range(1u, 100u));
  program.add_flag("--shuffled", flags.shuffled, "Faces in random order, as no file has them");
  return lumatlas::run_program(program, "bench_cells", argc, argv, [&] { lumatlas::run(flags); });
}
