// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/validation.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "blend/renderer.h"
#include "blend/sampling/supersampling.h"
#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/progress.h"
#include "tools/frame/background.h"
#include "tools/scene/photograph_stream.h"
#include "tools/score/align_to_model.h"
#include "tools/score/aligned_pictures.h"
#include "tools/score/measures/seam_contrast.h"
#include "tools/score/report/error_picture.h"
#include "tools/score/textured_picture.h"
#include "tools/score/unbounded.h"

namespace lumatlas {

namespace {

// Returns the views to learn from, by rank in the scene, and those to score, by rank in the test views if there are
// any.
Split parts_of(const SceneViews& scene, const ValidationOptions& options) {
  if (!options.test) return split_to_score(scene, options.protocol);
  if (std::filesystem::equivalent(options.test->root, scene.root)) {
    throw InputError(options.test->root.string() + ": is what the model was built from, name other views as a test");
  }
  if (options.test->views.empty()) throw InputError(options.test->root.string() + ": has no views to score");
  Split parts;
  parts.input = split(scene, options.protocol).input;
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
                 [](FaceId face) { return static_cast<std::uint8_t>(face != FaceId::none); });
  return mask;
}

// A method: its drawing function and what is measured over all its pictures.
struct Method {
  using Draw = std::function<Rendering(const Camera&, const BlendOptions&)>;
  ReportMethod report;
  Draw draw;
  SeamMeter seams;
  FlickerMeter flicker;

  Method(ReportMethod names, Draw function, const Surface& surface)
      : report(std::move(names)), draw(std::move(function)), seams(surface.mesh, surface.cells) {}
};

// A held-out photograph, and what every method is asked about it.
struct Scored {
  std::size_t index;  // among the scored views
  const Camera& camera;
  const Photograph& photograph;
  const Pyramid& pyramid;  // the photograph's; unused if nothing is aligned
  const VisibilityBuffer& visible;
};

// For pictures that are only looked at where surfaces do not end.
BlendOptions in_less_time(BlendOptions options) {
  options.sampling = BlendOptions::Sampling::linear;
  return at_middle(options);
}

// Fills what the model does not cover, as `lumatlas render` does by default.
Photograph whole_frame(const Rendering& rendering) {
  return with_background(rendering, Background()).picture;
}

Photograph with_fitted_gain(const Photograph& picture, const Photograph& photograph,
                            std::span<const std::uint8_t> mask) {
  return apply_gain(picture, fit_gain(picture, photograph, mask));
}

// Draws, compares and writes pictures.
class Scoring {
 public:
  Scoring(const Visibility& visibility, const ValidationOptions& options, const std::filesystem::path& folder)
      : visibility_(visibility), options_(options), folder_(folder) {}

  // One rendering per method, in their order. One tick of `progress` a method, of this many.
  [[nodiscard]] std::vector<ReportRendering> score(std::vector<Method>& methods, const Scored& view, std::size_t ticks,
                                                   Progress& progress) const {
    std::vector<ReportRendering> results;
    std::vector<AlignedPicture> aligned;
    for (Method& method : methods) {
      throw_if_interrupted();
      Rendering rendering = method.draw(view.camera, options_.blend);
      method.seams.add(view.visible, rendering.picture, view.photograph);
      results.push_back(as_given(method.report.name, view, rendering));
      if (options_.aligned) aligned.push_back(as_aligned(method, view, std::move(rendering)));
      progress.tick(ticks);
    }
    if (options_.aligned) add_aligned(methods, view, aligned, results);
    return results;
  }

 private:
  [[nodiscard]] ReportRendering as_given(const std::string& method, const Scored& view,
                                         const Rendering& rendering) const {
    std::vector<std::uint8_t> textured(rendering.state.size());
    std::transform(rendering.state.begin(), rendering.state.end(), textured.begin(),
                   [](PixelState state) { return static_cast<std::uint8_t>(state == PixelState::textured); });
    ReportRendering result;
    const Photograph frame = whole_frame(rendering);
    result.scores.frame = score_region(frame, view.photograph, {}, textured);
    result.scores.mesh = score_region(rendering.picture, view.photograph, seen_mask(view.visible), textured);
    if (!options_.pictures) return result;
    result.picture = folder_name(view.index) + "/" + method + ".png";
    result.error = folder_name(view.index) + "/" + method + "-error.png";
    write_image(folder_ / result.picture, frame);
    write_image(folder_ / result.error,
                error_picture(apply_gain(frame, result.scores.frame.gain), view.photograph, {}));
    return result;
  }

  // If the given pose agrees best, its picture is the aligned one too.
  [[nodiscard]] AlignedPicture as_aligned(const Method& method, const Scored& view, Rendering rendering) const {
    Photograph frame = whole_frame(rendering);
    Photograph frame_from_there;  // the picture that was drawn last
    const ModelPictures pictures{
        [&](const Camera& at) {
          Rendering drawn = method.draw(at, options_.blend);
          frame_from_there = whole_frame(drawn);
          return std::move(drawn.picture);
        },
        [&](const Camera& at) { return method.draw(at, in_less_time(options_.blend)).picture; }, visibility_};
    Seen at_given{std::move(rendering.picture), view.visible};
    std::optional<AlignedView> aligned = align_to_model(pictures, view.camera, at_given, view.pyramid);
    if (!aligned) return {std::move(at_given.picture), std::move(frame), seen_mask(at_given.visible)};
    return {std::move(aligned->seen.picture), std::move(frame_from_there), seen_mask(aligned->seen.visible)};
  }

  // Adds the aligned scores of the whole frame, and of the mesh's pixels that all methods have in common.
  void add_aligned(const std::vector<Method>& methods, const Scored& view, std::span<const AlignedPicture> aligned,
                   std::vector<ReportRendering>& results) const {
    const std::vector<std::uint8_t> common = seen_by_all(seen_mask(view.visible), aligned);
    for (std::size_t i = 0; i < methods.size(); ++i) {
      ReportRendering& result = results[i];
      const Photograph frame = with_fitted_gain(aligned[i].frame, view.photograph, {});
      add_aligned_scores(with_fitted_gain(aligned[i].picture, view.photograph, common), view.photograph, common,
                         result.scores.mesh);
      add_aligned_scores(frame, view.photograph, {}, result.scores.frame);
      if (!options_.pictures) continue;
      const std::string name = folder_name(view.index) + "/" + methods[i].report.name;
      result.aligned_picture = name + "-aligned.png";
      result.aligned_error = name + "-aligned-error.png";
      write_image(folder_ / result.aligned_picture, frame);
      write_image(folder_ / result.aligned_error, error_picture(frame, view.photograph, {}));
    }
  }

  const Visibility& visibility_;
  const ValidationOptions& options_;
  const std::filesystem::path& folder_;
};

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
    if (!options.pictures) continue;
    entry.photograph = folder_name(views.size() - 1) + "/photograph.png";
    std::filesystem::create_directories(folder / folder_name(views.size() - 1));
  }
  return views;
}

// Each drawn from a renderer of its own, because a photograph is shown to one after the other.
Method::Draw blended(const Snapshot& snapshot) {
  const auto renderer = std::make_shared<Renderer>();
  renderer->load(snapshot);
  return [renderer](const Camera& camera, const BlendOptions& blend) { return renderer->render(camera, blend); };
}

// Pictures that are drawn only to separate the effect of moved poses from that of the budget.
struct GivenPoses {
  Method::Draw draw;
  std::vector<RegionScores> scores;  // over the mesh's pixels
};

std::optional<GivenPoses> given_poses(const Snapshot& model, const std::vector<SceneView>& views,
                                      const Visibility& visibility, const ValidityOptions& validity) {
  const std::optional<Snapshot> unmoved = with_given_poses(model, views, visibility, validity);
  if (!unmoved) return std::nullopt;
  return GivenPoses{blended(*unmoved), {}};
}

Method::Draw textured(const Snapshot& snapshot, const OfferedPhotographs& offered = {}) {
  const auto mesh = std::make_shared<const TexturedMesh>(snapshot, TextureOptions(), offered);
  const auto picture = std::make_shared<const TexturedPicture>(*mesh);
  return [mesh, picture](const Camera& camera, const BlendOptions& /*blend*/) { return picture->render(camera); };
}

// The progress ticks of a validation. A tick is about the time in which a view is taken into the unbounded baseline.
struct Ticks {
  std::size_t scoring = 0;  // one view by one method
  std::size_t given = 0;    // one view, at the poses that the stored photographs were given with
  std::size_t moving = 3;   // a frame of a path by one method
  std::size_t all = 0;

  Ticks(const ValidationOptions& options, const Split& parts) : scoring(options.aligned ? 8 : 4) {
    const std::size_t methods = 1u + (options.texture ? 1 : 0) + (options.texture_all.list.empty() ? 0 : 1) +
                                (options.unbounded ? 1 : 0) + (options.vertex ? 1 : 0);
    const std::size_t taken = options.unbounded || options.vertex ? parts.input.size() : 0;
    const std::size_t frames = options.path ? options.path->views.size() : 0;
    if (options.unbounded) given = 3;
    all = taken + methods * (parts.scored.size() * scoring + frames * moving) + +parts.scored.size() * given;
  }
};

ProgressOptions of_whole_run(const ValidationOptions& validation) {
  ProgressOptions options = ProgressOptions::standard_error(validation.quiet);
  options.as_share = true;
  options.told = validation.told;
  return options;
}

std::vector<Method> methods_of(const Snapshot& model, const SceneViews& scene, const Split& parts,
                               const ValidationOptions& options, Progress& progress) {
  const Surface& surface = *model.surface;
  std::vector<Method> methods;
  methods.emplace_back(ReportMethod{"store", "the model: the views that the planner kept"}, blended(model), surface);
  if (options.texture) {
    methods.emplace_back(
        ReportMethod{"texture", "the mesh with one conventional texture, as `lumatlas export` writes it"},
        textured(model), surface);
  }
  if (!options.texture_all.list.empty()) {
    methods.emplace_back(ReportMethod{"texture-all", "the same texture from every input view, as `--from` makes it"},
                         textured(model, options.texture_all), surface);
  }
  if (!options.unbounded && !options.vertex) return methods;
  Snapshot all =
      unbounded_lumigraph(model.surface, scene.views, parts.input, options.validity, progress, options.unbounded);
  all.cell_deviation = model.cell_deviation;  // the two then differ only in what is stored
  if (options.unbounded) {
    methods.emplace_back(ReportMethod{"unbounded", "every input view, without a budget"}, blended(all), surface);
  }
  if (options.vertex) {
    methods.emplace_back(ReportMethod{"vertex", "the mean of all input views at each vertex of the mesh"},
                         blended(without_views(all)), surface);
  }
  return methods;
}

struct Methods {
  std::vector<Method> shown;
  std::optional<GivenPoses> given;
};

void score_views(Methods& methods, const Scoring& scoring, const Visibility& visibility, const BlendOptions& blend,
                 const std::vector<SceneView>& views, const std::vector<std::size_t>& scored,
                 const std::filesystem::path& folder, const Ticks& ticks, Progress& progress,
                 std::vector<ReportView>& report) {
  PhotographStream photographs(views, scored);
  for (std::size_t i = 0; i < scored.size(); ++i) {
    const Camera& camera = views[scored[i]].camera;
    const Photograph photograph = photographs.next();
    if (!report[i].photograph.empty()) write_image(folder / report[i].photograph, photograph);
    const Pyramid pyramid(photograph);
    const VisibilityBuffer visible = visibility.trace(camera);
    report[i].renderings =
        scoring.score(methods.shown, {i, camera, photograph, pyramid, visible}, ticks.scoring, progress);
    if (methods.given) {
      const Rendering rendering = methods.given->draw(camera, blend);
      methods.given->scores.push_back(score_region(rendering.picture, photograph, seen_mask(visible), {}));
    }
    progress.tick(ticks.given);
  }
}

void follow_path(std::vector<Method>& methods, const Visibility& visibility, const SceneViews& path,
                 const BlendOptions& blend, std::size_t ticks, Progress& progress) {
  std::vector<std::size_t> frames(path.views.size());
  std::iota(frames.begin(), frames.end(), std::size_t{0});
  PhotographStream photographs(path.views, frames);
  for (const std::size_t frame : frames) {
    const Camera& camera = path.views[frame].camera;
    const Photograph truth = photographs.next();
    const VisibilityBuffer visible = visibility.trace(camera);
    for (Method& method : methods) {
      method.flicker.add(camera, visible, method.draw(camera, blend).picture, truth);
      progress.tick(ticks);
    }
  }
  for (Method& method : methods) method.report.flicker = method.flicker.flicker();
}

double mean_of(const Report& report, const std::string& method) {
  const std::vector<MethodScores> means = method_means(report);
  for (std::size_t i = 0; i < means.size(); ++i) {
    if (report.methods[i].name == method) return means[i].mesh.fitted.psnr;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

ReportShortfall shortfall(const Report& report, const std::optional<GivenPoses>& given) {
  const double store = mean_of(report, "store");
  const double unmoved = given ? mean_scores(given->scores).fitted.psnr : store;
  return {unmoved - store, mean_of(report, "unbounded") - unmoved};
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
  const Ticks ticks(options, parts);
  Progress progress("validating", ticks.all, of_whole_run(options));
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(near_surface(*model.surface).mesh);
  Methods methods{methods_of(model, scene, parts, options, progress), std::nullopt};
  if (options.unbounded)
    methods.given = given_poses(model, scene.views, *make_ray_visibility(model.surface->mesh), options.validity);
  const Scoring scoring(*visibility, options, folder);
  score_views(methods, scoring, *visibility, options.blend, unknown.views, parts.scored, folder, ticks, progress,
              report.views);
  if (options.path) follow_path(methods.shown, *visibility, *options.path, options.blend, ticks.moving, progress);
  for (Method& method : methods.shown) {
    method.report.seams = method.seams.contrast();
    report.methods.push_back(std::move(method.report));
  }
  if (options.unbounded) report.shortfall = shortfall(report, methods.given);
  return report;
}

}  // namespace lumatlas
