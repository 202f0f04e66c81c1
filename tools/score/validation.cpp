// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/validation.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>

#include "blend/renderer.h"
#include "mesh/base/errors.h"
#include "tools/base/progress.h"
#include "tools/scene/photograph_stream.h"
#include "tools/score/align_to_model.h"
#include "tools/score/error_picture.h"
#include "tools/score/seam_contrast.h"
#include "tools/score/textured_picture.h"
#include "tools/score/unbounded.h"

namespace lumatlas {

namespace {

// What to learn from, by rank in the scene, and what to score, by rank in the test views if there are any.
Split parts_of(const SceneViews& scene, const ValidationOptions& options) {
  if (!options.test) {
    if (!options.protocol) throw std::invalid_argument("validation: protocol is missing, must be given without test");
    return split_to_score(scene, *options.protocol);
  }
  if (std::filesystem::equivalent(options.test->root, scene.root)) {
    throw InputError(options.test->root.string() + ": is what the model was built from, name other views as a test");
  }
  if (options.test->views.empty()) throw InputError(options.test->root.string() + ": has no views to score");
  Split parts;
  if (options.protocol) parts.input = split(scene.views.size(), *options.protocol).input;
  for (std::size_t rank = 0; !options.protocol && rank < scene.views.size(); ++rank) parts.input.push_back(rank);
  leave_out_bad(scene, parts.input);
  parts.scored.resize(options.test->views.size());
  std::iota(parts.scored.begin(), parts.scored.end(), std::size_t{0});
  leave_out_bad(*options.test, parts.scored);
  return parts;
}

// A held-out view that shows up in the model would be scored against itself.
void require_unseen(const Snapshot& model, const SceneViews& scene, const Split& parts) {
  std::set<std::string> input;
  for (const std::size_t rank : parts.input) input.insert(scene.views[rank].name);
  for (const auto& view : model.views) {
    if (view && !input.contains(view->name)) {
      throw InputError("the model holds the view " + view->name +
                       ", which this protocol leaves out: build it with the same --hold and --block, from this scene");
    }
  }
}

std::string folder_name(std::size_t index) {
  std::string number = std::to_string(index);
  return number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
}

std::vector<std::uint8_t> seen_mask(const VisibilityBuffer& visible) {
  std::vector<std::uint8_t> mask(visible.face.size());
  std::transform(visible.face.begin(), visible.face.end(), mask.begin(),
                 [](std::uint32_t face) { return static_cast<std::uint8_t>(face != kNoFace); });
  return mask;
}

// Runs one method after another on every scored view and on the path, and adds what it finds to the report.
class MethodRun {
 public:
  MethodRun(const Surface& surface, const SceneViews& scene, const std::vector<std::size_t>& scored,
            const ValidationOptions& options, const std::filesystem::path& folder)
      : surface_(surface), scene_(scene), scored_(scored), options_(options), folder_(folder) {}

  using Render = std::function<Rendering(const Camera&)>;
  void run(ReportMethod method, const Render& render, Report& report) const {
    method.seams = score_views(method.name, render, report.views);
    if (options_.path) method.flicker = flicker_along(*options_.path, method.name, render);
    report.methods.push_back(std::move(method));
  }

 private:
  // Returns their seam contrast.
  double score_views(const std::string& method, const Render& render, std::vector<ReportView>& views) const {
    Progress progress("scoring: " + method, scored_.size(), ProgressOptions::standard_error(options_.quiet));
    PhotographStream photographs(scene_.views, scored_);
    SeamMeter seams(surface_.mesh, surface_.cells);
    for (std::size_t i = 0; i < scored_.size(); ++i) {
      const Camera& camera = scene_.views[scored_[i]].camera;
      const Photograph photograph = photographs.next();
      const VisibilityBuffer visible = visibility_->trace(camera);
      const Rendering rendering = render(camera);
      seams.add(visible, rendering.picture, photograph);
      views[i].renderings.push_back(score(method, i, rendering, photograph, seen_mask(visible)));
      if (options_.aligned) score_aligned(method, i, render, camera, photograph, views[i].renderings.back());
      progress.tick();
    }
    return seams.contrast();
  }

  Flicker flicker_along(const SceneViews& path, const std::string& method, const Render& render) const {
    Progress progress("moving: " + method, path.views.size(), ProgressOptions::standard_error(options_.quiet));
    std::vector<std::size_t> frames(path.views.size());
    std::iota(frames.begin(), frames.end(), std::size_t{0});
    PhotographStream photographs(path.views, frames);
    FlickerMeter meter;
    for (const std::size_t frame : frames) {
      const Camera& camera = path.views[frame].camera;
      meter.add(camera, visibility_->trace(camera), render(camera).picture, photographs.next());
      progress.tick();
    }
    return meter.flicker();
  }

  void score_aligned(const std::string& method, std::size_t index, const Render& render, const Camera& given,
                     const Photograph& photograph, ReportRendering& result) const {
    const auto picture_at = [&](const Camera& at) { return render(at).picture; };
    const Camera camera = align_to_model(picture_at, *visibility_, given, photograph);
    const Photograph picture = render(camera).picture;
    const std::vector<std::uint8_t> mask = seen_mask(visibility_->trace(camera));
    const double gain = fit_gain(picture, photograph, mask);
    const Photograph fitted = apply_gain(picture, gain);
    result.scores.aligned = Scores{psnr(fitted, photograph, mask), ssim(fitted, photograph, mask)};
    if (!options_.pictures) return;
    result.aligned_picture = folder_name(index) + "/" + method + "-aligned.png";
    result.aligned_error = folder_name(index) + "/" + method + "-aligned-error.png";
    write_image(folder_ / result.aligned_picture, fitted);
    write_image(folder_ / result.aligned_error, error_picture(fitted, photograph, mask));
  }

  ReportRendering score(const std::string& method, std::size_t index, const Rendering& rendering,
                        const Photograph& photograph, const std::vector<std::uint8_t>& mask) const {
    std::vector<std::uint8_t> textured(rendering.state.size());
    std::transform(rendering.state.begin(), rendering.state.end(), textured.begin(),
                   [](PixelState state) { return static_cast<std::uint8_t>(state == PixelState::textured); });
    ReportRendering result;
    result.scores = score_view(rendering.picture, photograph, mask, textured);
    if (!options_.pictures) return result;
    result.picture = folder_name(index) + "/" + method + ".png";
    result.error = folder_name(index) + "/" + method + "-error.png";
    write_image(folder_ / result.picture, rendering.picture);
    write_image(folder_ / result.error,
                error_picture(apply_gain(rendering.picture, result.scores.gain), photograph, mask));
    return result;
  }

  const Surface& surface_;
  const SceneViews& scene_;
  const std::vector<std::size_t>& scored_;
  const std::unique_ptr<Visibility> visibility_ = make_ray_visibility(surface_.mesh);
  const ValidationOptions& options_;
  const std::filesystem::path& folder_;
};

void write_photographs(const SceneViews& scene, const std::vector<std::size_t>& scored, bool quiet,
                       const std::filesystem::path& folder, std::vector<ReportView>& views) {
  Progress progress("copying photographs", scored.size(), ProgressOptions::standard_error(quiet));
  PhotographStream photographs(scene.views, scored);
  for (std::size_t i = 0; i < scored.size(); ++i) {
    views[i].photograph = folder_name(i) + "/photograph.png";
    std::filesystem::create_directories(folder / folder_name(i));
    write_image(folder / views[i].photograph, photographs.next());
    progress.tick();
  }
}

// The report's views with their photographs, still without renderings.
std::vector<ReportView> report_views(const SceneViews& scene, const std::vector<std::size_t>& scored,
                                     const ValidationOptions& options, const std::filesystem::path& folder) {
  std::vector<ReportView> views;
  for (const std::size_t rank : scored) {
    const SceneView& view = scene.views[rank];
    ReportView& entry = views.emplace_back();
    entry.name = view.name;
    entry.width = view.camera.width;
    entry.height = view.camera.height;
  }
  if (options.pictures) write_photographs(scene, scored, options.quiet, folder, views);
  return views;
}

}  // namespace

Report validate_model(const Snapshot& model, const SceneViews& scene, const EglContext& /*current*/,
                      const ValidationOptions& options, const std::filesystem::path& folder) {
  const Split parts = parts_of(scene, options);
  const SceneViews& unknown = options.test ? *options.test : scene;
  require_unseen(model, scene, parts);
  Report report;
  report.title = std::filesystem::canonical(scene.root).filename().string();  // also of "." and "scene/"
  report.protocol = options.protocol;
  if (options.test) report.test = options.test->root.string();
  report.input_views = parts.input.size();
  report.views = report_views(unknown, parts.scored, options, folder);
  const MethodRun methods(*model.surface, unknown, parts.scored, options, folder);
  Renderer renderer;
  const auto blended = [&](const Camera& camera) { return renderer.render(camera, options.blend); };
  renderer.load(model);
  methods.run({"store", "the model: the views that the planner kept"}, blended, report);
  if (options.texture) {
    const TexturedMesh mesh(model, TextureOptions());
    const TexturedPicture texture(mesh);
    methods.run(
        {"texture", "the mesh with one conventional texture, as `lumatlas export` writes it"},
        [&](const Camera& camera) { return texture.render(camera); }, report);
  }
  if (!options.unbounded && !options.vertex) return report;
  const Snapshot all =
      unbounded_lumigraph(model.surface, scene.views, parts.input, options.validity, options.quiet, options.unbounded);
  if (options.unbounded) {
    renderer.load(all);
    methods.run({"unbounded", "every input view, without a budget"}, blended, report);
  }
  if (options.vertex) {
    renderer.load(without_views(all));
    methods.run({"vertex", "the mean of all input views at each vertex of the mesh"}, blended, report);
  }
  return report;
}

}  // namespace lumatlas
