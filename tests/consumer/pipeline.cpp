// SPDX-License-Identifier: GPL-3.0-or-later
// Turns a COLMAP workspace into a model and scores it on the photographs that were held out. Ctrl-C stops it.
// Usage: consumer SCENE MODEL
#include <csignal>
#include <cstdio>
#include <exception>

#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/save_model.h"
#include "tools/score/validation.h"

volatile std::sig_atomic_t stopped = 0;

int main(int argc, char** argv) {
  using namespace lumatlas;
  if (argc < 3) return 2;
  std::signal(SIGINT, [](int) { stopped = 1; });
  try {
    BuildOptions options;
    options.hold_out = HoldOut{.hold = 8};  // every 8th photograph by name is left out, to be scored
    options.max_views = 12;
    const BuildResult result = build_model(argv[1], options, [](const BuildProgress& progress) {
      std::printf("%s: %zu of %zu\n", progress.stage, progress.done, progress.total);
      return stopped == 0;  // false: build_model() throws BuildStopped
    });
    save_model(result, argv[2], {.format = ImageFormat::jpeg});

    const SceneViews scene = read_scene_views(argv[1], result.snapshot.surface->offset);
    ValidationOptions scoring;
    scoring.protocol = options.hold_out;
    scoring.pictures = false;
    scoring.quiet = true;
    const EglContext gl;
    const Report report = validate_model(result.snapshot, scene, gl, scoring, argv[2]);
    const MeanScores scores = method_means(report).front().frame;
    std::printf("%zu photographs that were held out: %.2f dB, SSIM %.3f\n", scores.views, scores.fitted.psnr,
                scores.fitted.ssim);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
