// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/extremes/extreme_scenes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <glm/glm.hpp>
#include <iomanip>
#include <set>

#include "atlas/images/srgb.h"
#include "blend/reference.h"
#include "mesh/base/errors.h"
#include "mesh/repair/repair.h"
#include "mesh/visibility/visibility.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kQuads = 8;  // along each side of a wall
constexpr double kSide = 4;

double on_grid(double value) {
  return std::round(value * 1024) / 1024;
}

// A wall of the court, its bumps along the axis that it stands on.
void add_wall(TriangleSoup& soup, int across, int along, int height) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  for (std::uint32_t j = 0; j <= kQuads; ++j) {
    for (std::uint32_t i = 0; i <= kQuads; ++i) {
      glm::dvec3 point(0);
      point[across] = kSide * i / kQuads;
      point[along] = kSide * j / kQuads;
      point[height] = i == 0 || j == 0 ? 0 : on_grid(0.1 * std::sin(2.1 * i + height) * std::sin(1.3 * j));
      soup.positions.push_back(point);
    }
  }
  for (std::uint32_t j = 0; j < kQuads; ++j) {
    for (std::uint32_t i = 0; i < kQuads; ++i) {
      const std::uint32_t a = first + j * (kQuads + 1) + i, b = a + kQuads + 1;
      soup.faces.emplace_back(a, a + 1, b + 1);
      soup.faces.emplace_back(a, b + 1, b);
    }
  }
}

// Nine significant digits would do for a float; these are doubles, and far from the origin.
void write_soup(const TriangleSoup& soup, const std::filesystem::path& path) {
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\nelement vertex " << soup.positions.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << soup.faces.size()
       << "\nproperty list uchar uint vertex_indices\nend_header\n"
       << std::setprecision(17);
  for (const glm::dvec3& p : soup.positions) file << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const glm::uvec3& f : soup.faces) file << "3 " << f.x << ' ' << f.y << ' ' << f.z << '\n';
}

Camera less_offset(Camera camera, const glm::dvec3& offset) {
  camera.cam_from_world_translation += camera.cam_from_world_rotation * offset;
  return camera;
}

void check_each_is_answered_for(const EdgeScene& scene, const BuildResult& result, std::size_t offered) {
  REQUIRE(result.planned.size() == offered);
  std::set<std::string> stored, names;
  for (const EdgeView& view : scene.views) names.insert(view.name);
  for (const PlannedView& view : result.planned) {
    CAPTURE(view.name);
    CHECK(names.erase(view.name) == 1);
    const bool taken = view.verdict.decision == Decision::kept || view.verdict.decision == Decision::replaced;
    CHECK(view.verdict.slot.has_value() == taken);
    CHECK(std::isfinite(view.verdict.gain));
    CHECK(std::isfinite(view.summed_coverage));
    for (const std::string& left : view.verdict.replaced) CHECK(stored.erase(left) == 1);
    // A stored view that sees nothing of the mesh has no tile that anything refers to, so the model does without it.
    if (taken && view.verdict.cells_seen > 0) stored.insert(view.name);
  }
  const std::vector<std::string> in_model = stored_names(result);
  if (result.options.bound.array_bytes() == 0) {
    CHECK(std::vector<std::string>(stored.begin(), stored.end()) == in_model);
  } else {  // nor do views all of whose tiles had to go
    CHECK(std::includes(stored.begin(), stored.end(), in_model.begin(), in_model.end()));
  }
  CHECK(count_of(result, Decision::kept) + count_of(result, Decision::replaced) + count_of(result, Decision::rejected) +
            count_of(result, Decision::outlier) ==
        offered);
}

void check_view(const StoredView& view) {
  CAPTURE(view.name);
  CHECK_NOTHROW(check(view.camera));
  view.mask->depth.for_each([](std::size_t, float z) { CHECK_FALSE((std::isnan(z) || z < 0)); });
}

void check_snapshot(const Snapshot& snapshot) {
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) check_view(*snapshot.views[slot]);
    for (int channel = 0; channel < 3; ++channel) {
      CHECK(snapshot.gains[slot][channel] >= kLeastExposureGain);
      CHECK(snapshot.gains[slot][channel] <= kMostExposureGain);
    }
  }
  const auto& slots = snapshot.references.views;
  CHECK(std::all_of(slots.begin(), slots.end(), [&](ViewSlot slot) { return snapshot.views[slot] != nullptr; }));
  CHECK(std::all_of(snapshot.cell_coverage.begin(), snapshot.cell_coverage.end(),
                    [](float coverage) { return std::isfinite(coverage) && coverage >= 0; }));
}

}  // namespace

TriangleSoup court() {
  TriangleSoup soup;
  add_wall(soup, 0, 1, 2);
  add_wall(soup, 1, 2, 0);
  add_wall(soup, 2, 0, 1);
  return soup;
}

Camera camera_towards(const glm::dvec3& center, const glm::dvec3& target, std::uint32_t width, std::uint32_t height,
                      double focal_px) {
  const glm::dvec3 forward = glm::normalize(target - center);
  const glm::dvec3 up = std::abs(forward.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  Camera camera = centered_camera(width, height, focal_px);
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

Camera court_camera(double place) {
  const double angle = 0.2 + 1.17 * place;
  const double height = 2 + std::sin(9 * place);
  return camera_towards({5 * std::cos(angle), 5 * std::sin(angle), height}, {1, 1, 1}, 96, 72, 80);
}

glm::dvec3 court_color(const glm::dvec3& point) {
  const auto wave = [&](double x, double y, double z) {
    return 0.275 + 0.225 * std::sin(x * point.x + y * point.y + z * point.z);
  };
  return {wave(2.9, 1.7, 2.1), wave(-1.3, 3.1, 1.9), wave(2.3, -1.1, -2.7)};
}

EdgeShading court_shading() {
  return [](const glm::dvec3& point, const glm::dvec3&) { return court_color(point); };
}

Photograph photographed(const TriangleSoup& soup, const Camera& camera, const EdgeShading& shading, double exposure) {
  const Mesh mesh = repair(soup, glm::dvec3(0)).mesh;
  const VisibilityBuffer visible = make_ray_visibility(mesh)->trace(camera);
  Photograph photograph = plain_photograph(camera, 0);
  for (std::size_t pixel = 0; pixel < visible.face.size(); ++pixel) {
    if (visible.face[pixel] == FaceId::none) continue;
    const glm::dvec2 image(static_cast<double>(pixel % camera.width) + 0.5,
                           static_cast<double>(pixel / camera.width) + 0.5);
    const glm::dvec3 point = camera.center() + static_cast<double>(visible.depth[pixel]) * camera.ray(image);
    const glm::dvec3 light = exposure * shading(point, camera.center());
    for (int channel = 0; channel < 3; ++channel) {
      photograph.rgb[3 * pixel + static_cast<std::size_t>(channel)] = srgb8_from_linear(light[channel]);
    }
  }
  return photograph;
}

Photograph plain_photograph(const Camera& camera, int level) {
  Photograph photograph{camera.width, camera.height, {}, {}};
  photograph.rgb.assign(3 * std::size_t{camera.width} * camera.height, static_cast<std::uint8_t>(level));
  return photograph;
}

void add_view(EdgeScene& scene, const Camera& camera) {
  const std::string number = std::to_string(scene.views.size());
  scene.views.push_back(
      {std::string(4 - number.size(), '0') + number + ".png", camera, photographed(scene.soup, camera)});
}

EdgeScene court_scene(std::size_t views) {
  EdgeScene scene{court(), {}};
  for (std::size_t view = 0; view < views; ++view) {
    add_view(scene, court_camera((static_cast<double>(view) + 0.5) / static_cast<double>(views)));
  }
  return scene;
}

const EdgeScene& six_views() {
  static const EdgeScene scene = court_scene(6);
  return scene;
}

Camera novel_camera() {
  return camera_towards({2.6, 3.1, 2.2}, {0.6, 0.8, 0.9}, 80, 60, 60);
}

void write_scene(const EdgeScene& scene, const std::filesystem::path& folder) {
  write_soup(scene.soup, folder / "mesh.ply");
  std::filesystem::create_directory(folder / "sparse");
  std::vector<WrittenView> written;
  for (const EdgeView& view : scene.views) {
    written.push_back({view.name, view.camera});
    const std::filesystem::path image = folder / "images" / view.name;
    std::filesystem::create_directories(image.parent_path());
    write_image(image, view.photograph);
  }
  write_colmap_model(folder / "sparse", written, {});
}

BuildOptions plain_build() {
  BuildOptions options = default_build();
  options.refine = RefineMode::none;
  options.planner.min_view_gain = 0;
  return options;
}

BuildOptions default_build() {
  BuildOptions options;
  return options;
}

BuildResult built(const EdgeScene& scene, const BuildOptions& options) {
  const TemporaryFolder folder;
  write_scene(scene, folder.path());
  BuildResult result = build_model(folder.path(), options);
  const std::size_t offered =
      options.hold_out ? split(scene.views.size(), *options.hold_out).input.size() : scene.views.size();
  check_each_is_answered_for(scene, result, offered);
  check_snapshot(result.snapshot);
  CHECK(std::isfinite(result.summed_coverage));
  return result;
}

std::string refused(const EdgeScene& scene, const BuildOptions& options) {
  const TemporaryFolder folder;
  write_scene(scene, folder.path());
  try {
    (void)build_model(folder.path(), options);
  } catch (const InputError& error) {
    std::string sentence = error.what();
    CHECK(sentence.find('\n') == std::string::npos);
    const std::string root = folder.path().string();
    if (sentence.starts_with(root)) sentence.erase(0, root.size() + 1);
    return sentence;
  }
  return {};
}

std::size_t count_of(const BuildResult& result, Decision decision) {
  return static_cast<std::size_t>(
      std::count_if(result.planned.begin(), result.planned.end(),
                    [decision](const PlannedView& view) { return view.verdict.decision == decision; }));
}

std::vector<std::string> stored_names(const BuildResult& result) {
  std::vector<std::string> names;
  for (const auto& view : result.snapshot.views) {
    if (view) names.push_back(view->name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

Rendering pictured(const BuildResult& result, const Camera& camera, const BlendOptions& options) {
  const Surface& surface = *result.snapshot.surface;
  const Camera novel = less_offset(camera, surface.offset);
  return render_reference(result.snapshot, novel, make_ray_visibility(surface.mesh)->trace(novel), options);
}

double textured_share(const Rendering& rendering) {
  const auto textured = std::count(rendering.state.begin(), rendering.state.end(), PixelState::textured);
  return static_cast<double>(textured) / static_cast<double>(rendering.state.size());
}

double textured_error(const Rendering& rendering, const Photograph& truth) {
  REQUIRE(rendering.picture.rgb.size() == truth.rgb.size());
  double sum = 0;
  std::size_t values = 0;
  for (std::size_t value = 0; value < truth.rgb.size(); ++value) {
    if (rendering.state[value / 3] != PixelState::textured) continue;
    const double off = static_cast<double>(rendering.picture.rgb[value]) - static_cast<double>(truth.rgb[value]);
    sum += off * off;
    ++values;
  }
  return values > 0 ? std::sqrt(sum / static_cast<double>(values)) : 0;
}

Camera transformed(Camera camera, double scale, const glm::dmat3& rotation, const glm::dvec3& translation) {
  camera.cam_from_world_rotation = camera.cam_from_world_rotation * glm::transpose(rotation);
  camera.cam_from_world_translation =
      scale * camera.cam_from_world_translation - camera.cam_from_world_rotation * translation;
  return camera;
}

EdgeScene transformed(EdgeScene scene, double scale, const glm::dmat3& rotation, const glm::dvec3& translation) {
  for (glm::dvec3& point : scene.soup.positions) point = rotation * (scale * point) + translation;
  for (EdgeView& view : scene.views) view.camera = transformed(view.camera, scale, rotation, translation);
  return scene;
}

}  // namespace lumatlas
