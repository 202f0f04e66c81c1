// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/synth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/readers/mesh_file.h"
#include "tools/base/output_folder.h"
#include "tools/lab/synth/errors/disturbance.h"
#include "tools/lab/synth/errors/mesh_errors.h"
#include "tools/lab/synth/random.h"
#include "tools/lab/synth/scan.h"
#include "tools/lab/synth/stream.h"
#include "tools/lab/synth/tracer.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas {
namespace {

void require(bool holds, const char* field, double value, const char* rule) {
  if (holds) return;
  std::ostringstream text;
  text << "synth: " << field << " is " << value << ", must be " << rule;
  throw std::invalid_argument(text.str());
}

std::string photograph_name(std::size_t view) {
  std::ostringstream name;
  name << std::setw(4) << std::setfill('0') << view << ".png";
  return name.str();
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be created: " + error.message());
}

// Points spread over the mesh by area.
std::vector<glm::dvec3> sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  std::vector<double> area{0};
  for (const glm::uvec3& f : mesh.faces) {
    const glm::dvec3 a(mesh.positions[f.x]);
    const glm::dvec3 normal = glm::cross(glm::dvec3(mesh.positions[f.y]) - a, glm::dvec3(mesh.positions[f.z]) - a);
    area.push_back(area.back() + 0.5 * glm::length(normal));
  }
  synth::Random random(seed);
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double target = area.back() * (static_cast<double>(i) + random.uniform()) / static_cast<double>(count);
    const auto after = std::upper_bound(area.begin() + 1, area.end() - 1, target);
    const glm::uvec3& f = mesh.faces[static_cast<std::size_t>(after - area.begin()) - 1];
    const double root = std::sqrt(random.uniform());
    const double share = random.uniform();
    points.push_back((1 - root) * glm::dvec3(mesh.positions[f.x]) +
                     root * (1 - share) * glm::dvec3(mesh.positions[f.y]) +
                     root * share * glm::dvec3(mesh.positions[f.z]));
  }
  return points;
}

bool in_picture(const Camera& camera, const glm::dvec3& cam) {
  if (cam.z <= 0) return false;
  const glm::dvec2 at = camera.image_from_cam(cam);
  return at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height;
}

const synth::Visitor* visitor_of(const synth::Disturbance& disturbance) {
  return disturbance.passer_by ? &disturbance.passer_by->visitor : nullptr;
}

// Points on the surface that two views or more see, with the views that see them, at the true positions, and the colour
// in the first of those.
std::vector<TrackedPoint> sparse_points(const synth::Scene& scene, const synth::Tracer& tracer,
                                        const std::vector<Camera>& cameras,
                                        const std::vector<synth::Disturbance>& disturbances, std::uint64_t seed) {
  constexpr std::size_t kPoints = 4000;
  std::vector<TrackedPoint> points(kPoints);
  const std::vector<glm::dvec3> places = sample_surface(scene.geometry.mesh, kPoints, seed);
  tbb::parallel_for(std::size_t{0}, kPoints, [&](std::size_t i) {
    points[i].position = places[i];
    for (std::uint32_t view = 0; view < cameras.size(); ++view) {
      const glm::dvec3 cam = cameras[view].cam_from_world(places[i]);
      if (!in_picture(cameras[view], cam)) continue;
      if (!tracer.sees(cameras[view].center(), places[i], visitor_of(disturbances[view]))) continue;
      points[i].track.push_back({view, cameras[view].image_from_cam(cam)});
    }
  });
  std::erase_if(points, [](const TrackedPoint& point) { return point.track.size() < 2; });
  return points;
}

glm::u8vec3 color_at(const Photograph& photo, const glm::dvec2& position) {
  const std::size_t pixel = static_cast<std::size_t>(position.y) * photo.width + static_cast<std::size_t>(position.x);
  return {photo.rgb[3 * pixel], photo.rgb[3 * pixel + 1], photo.rgb[3 * pixel + 2]};
}

// Returns whether the written mesh is not the true surface.
bool has_other_mesh(const SynthOptions& options) {
  return options.kind == SynthKind::lab || options.disturbances.of_mesh();
}

Mesh reconstructed(const synth::Scene& scene, const synth::Tracer& tracer, const SynthOptions& options) {
  Mesh mesh = options.kind == SynthKind::lab ? synth::scanned(scene, tracer, options) : scene.geometry.mesh;
  return synth::with_mesh_errors(std::move(mesh), options);
}

std::vector<WrittenView> named(const std::vector<Camera>& cameras) {
  std::vector<WrittenView> views;
  views.reserve(cameras.size());
  for (const Camera& camera : cameras) views.push_back({photograph_name(views.size()), camera});
  return views;
}

std::vector<Camera> written_cameras(const std::vector<synth::Disturbance>& disturbances) {
  std::vector<Camera> cameras;
  cameras.reserve(disturbances.size());
  for (const synth::Disturbance& disturbance : disturbances) cameras.push_back(disturbance.written);
  return cameras;
}

// The angle between the rotations of two cameras, degrees.
double rotation_between_deg(const Camera& a, const Camera& b) {
  const glm::dmat3 between = a.cam_from_world_rotation * glm::transpose(b.cam_from_world_rotation);
  const glm::dvec3 sine(between[1][2] - between[2][1], between[2][0] - between[0][2], between[0][1] - between[1][0]);
  const double cosine = between[0][0] + between[1][1] + between[2][2] - 1;
  return glm::degrees(std::atan2(glm::length(sine), cosine));
}

nlohmann::json described(const Camera& camera, const synth::Disturbance& disturbance) {
  const glm::vec3& gain = disturbance.exposure.gain;
  nlohmann::json view{{"gain", {gain.x, gain.y, gain.z}},
                      {"wrong", disturbance.wrong},
                      {"displacement_px", disturbance.displacement_px},
                      {"rotation_deg", rotation_between_deg(disturbance.written, camera)},
                      {"translation", glm::distance(disturbance.written.center(), camera.center())}};
  if (!std::isfinite(disturbance.displacement_px)) view["displacement_px"] = nullptr;
  if (disturbance.passer_by) view["passer_by"] = disturbance.passer_by->share;
  if (disturbance.blur_px > 0) view["blur_px"] = disturbance.blur_px;
  return view;
}

// Undisturbed views, in a workspace without mesh or points.
void write_true_views(const std::filesystem::path& folder, const SynthOptions& options,
                      const std::vector<Camera>& cameras, std::uint64_t use, const synth::Tracer& tracer,
                      const std::function<void()>& photograph_done) {
  constexpr std::uint32_t kPathsPerPhotographs = 4;  // paths of light, for a quarter of the noise's power
  make_folder(folder);
  make_folder(folder / "images");
  make_folder(folder / "sparse");
  tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t view) {
    write_image(folder / "images" / photograph_name(view),
                tracer.photograph(cameras[view], kPathsPerPhotographs * options.samples,
                                  synth::hashed(options.seed, use, view)));
    if (photograph_done) photograph_done();
  });
  write_colmap_model(folder / "sparse", named(cameras), {});
}

void write_truth(const std::filesystem::path& folder, const SynthOptions& options, const std::vector<Camera>& cameras,
                 const std::vector<TrackedPoint>& points, const std::vector<synth::Disturbance>& disturbances,
                 const synth::Tracer& tracer, const Mesh& mesh) {
  make_folder(folder);
  make_folder(folder / "sparse");
  write_colmap_model(folder / "sparse", named(cameras), points);
  nlohmann::json views;
  for (std::size_t view = 0; view < cameras.size(); ++view) {
    views[photograph_name(view)] = described(cameras[view], disturbances[view]);
    const synth::Visitor* visitor = visitor_of(disturbances[view]);
    if (visitor == nullptr) continue;
    make_folder(folder / "masks");
    write_image(folder / "masks" / photograph_name(view), tracer.mask(cameras[view], *visitor));
  }
  const SynthDisturbances& d = options.disturbances;
  write_json(folder / "disturbances.json", {{"vignetting", d.vignetting},
                                            {"noise", d.noise},
                                            {"mesh",
                                             {{"scanned", options.kind == SynthKind::lab},
                                              {"noise", d.mesh_noise},
                                              {"holes", d.holes},
                                              {"decimate", d.decimate}}},
                                            {"views", views}});
  if (has_other_mesh(options)) write_ply(folder / "mesh.ply", mesh);
}

}  // namespace

void check(const SynthOptions& options) {
  require(options.views >= 1 && options.views <= 100000, "views", options.views, "in [1, 100000]");
  require(options.width >= 16 && options.width <= 8192, "width", options.width, "in [16, 8192]");
  require(options.height >= 16 && options.height <= 8192, "height", options.height, "in [16, 8192]");
  require(options.fov_deg > 0 && options.fov_deg <= 170, "fov_deg", options.fov_deg, "in (0, 170]");
  require(options.samples >= 1 && options.samples <= 1024, "samples", options.samples, "in [1, 1024]");
  require(options.triangles >= 1 && options.triangles <= 20000000, "triangles", options.triangles, "in [1, 20000000]");
  for (const std::uint32_t villages : options.district) {
    require(villages >= 1 && villages <= 100, "district", villages, "in [1, 100]");
    require(villages == 1 || options.kind == SynthKind::village, "district", villages, "1, for this is no village");
  }
  require(options.path_frames <= 100000, "path_frames", options.path_frames, "in [0, 100000]");
  require(options.test_views <= 100000, "test_views", options.test_views, "in [0, 100000]");
  require(std::isfinite(options.stream_rate) && options.stream_rate >= 0, "stream_rate", options.stream_rate,
          "finite and not negative");
  require(std::isfinite(options.path_step) && options.path_step > 0, "path_step", options.path_step,
          "finite and above 0");
  const SynthDisturbances& d = options.disturbances;
  require(d.pose_noise >= 0 && d.pose_noise <= options.width / 8.0, "pose_noise", d.pose_noise,
          "at least 0 and at most an eighth of the width");
  require(d.exposure_noise >= 0 && d.exposure_noise <= 10, "exposure_noise", d.exposure_noise, "in [0, 10]");
  require(d.white_balance_noise >= 0 && d.white_balance_noise <= 10, "white_balance_noise", d.white_balance_noise,
          "in [0, 10]");
  require(d.wrong_poses >= 0 && d.wrong_poses <= 1, "wrong_poses", d.wrong_poses, "in [0, 1]");
  require(d.passers_by >= 0 && d.passers_by <= 1, "passers_by", d.passers_by, "in [0, 1]");
  require(d.vignetting >= 0 && d.vignetting < 1, "vignetting", d.vignetting, "in [0, 1)");
  require(d.noise >= 0 && d.noise <= 64, "noise", d.noise, "in [0, 64]");
  require(d.blur >= 0 && d.blur <= options.width / 8.0, "blur", d.blur,
          "at least 0 and at most an eighth of the width");
  require(d.mesh_noise >= 0 && d.mesh_noise <= 1, "mesh_noise", d.mesh_noise, "in [0, 1]");
  require(d.holes >= 0 && d.holes <= 0.95, "holes", d.holes, "in [0, 0.95]");
  require(d.decimate >= 0.001 && d.decimate <= 1, "decimate", d.decimate, "in [0.001, 1]");
}

bool SynthDisturbances::any() const {
  return pose_noise > 0 || exposure_noise > 0 || white_balance_noise > 0 || wrong_poses > 0 || passers_by > 0 ||
         vignetting > 0 || noise > 0 || blur > 0 || of_mesh();
}

bool SynthDisturbances::of_mesh() const {
  return mesh_noise > 0 || holes > 0 || decimate < 1;
}

void write_synthetic_scene(const SynthOptions& options, const std::filesystem::path& folder,
                           const std::function<void()>& photograph_done) {
  check(options);
  const synth::Scene scene = synth::make_scene(options);
  const synth::Tracer tracer(scene);
  const std::vector<Camera> cameras = synth::cameras_on_trajectory(scene, tracer, options);
  make_folder(folder / "images");
  make_folder(folder / "sparse");
  const std::vector<synth::Disturbance> disturbances = synth::disturb(scene, tracer, cameras, options);
  std::vector<TrackedPoint> points =
      sparse_points(scene, tracer, cameras, disturbances, synth::hashed(options.seed, 1));
  tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t view) {
    const Photograph photo = tracer.photograph(cameras[view], options.samples, synth::hashed(options.seed, 2, view),
                                               disturbances[view].exposure, visitor_of(disturbances[view]));
    write_image(folder / "images" / photograph_name(view), photo);
    for (TrackedPoint& point : points) {  // each point belongs to the one view that saw it first
      if (point.track[0].image == view) point.color = color_at(photo, point.track[0].position);
    }
    if (photograph_done) photograph_done();
  });
  write_colmap_model(folder / "sparse", named(written_cameras(disturbances)), points);
  if (options.disturbances.any() || has_other_mesh(options))
    write_truth(folder / "truth", options, cameras, points, disturbances, tracer, scene.geometry.mesh);
  if (options.path_frames > 0) {
    write_true_views(folder / "path", options, synth::cameras_on_path(scene, options), 3, tracer, photograph_done);
  }
  if (options.test_views > 0) {
    write_true_views(folder / "test", options, synth::test_cameras(scene, tracer, options), 4, tracer, photograph_done);
  }
  if (options.stream_rate > 0) {
    std::vector<synth::StreamFrame> frames;
    for (std::size_t view = 0; view < cameras.size(); ++view) {
      frames.push_back({folder / "images" / photograph_name(view), cameras[view], disturbances[view].written});
    }
    make_folder(folder / "stream");
    synth::write_stream(folder / "stream", frames, tracer, options.stream_rate, options.seed);
  }
  write_ply(folder / "mesh.ply", reconstructed(scene, tracer, options));
}

}  // namespace lumatlas
