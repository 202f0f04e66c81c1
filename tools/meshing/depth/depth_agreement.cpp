// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/depth/depth_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lumatlas {
namespace {

constexpr std::size_t kMostCompared = 20'000;  // samples, with each image

void add_samples(const DepthImage& image, std::uint32_t index, std::size_t step, DepthSamples& samples) {
  const Camera& camera = image.camera;
  const glm::dvec3 center = camera.center();
  std::size_t measured = 0;
  for (std::size_t pixel = 0; pixel < image.depth.size(); ++pixel) {
    const double depth = image.depth[pixel];
    if (!(depth > 0) || measured++ % step != 0) continue;
    const glm::dvec2 middle(static_cast<double>(pixel % camera.width) + 0.5,
                            static_cast<double>(pixel / camera.width) + 0.5);
    samples.positions.push_back(center + depth * camera.ray(middle));
    samples.image.push_back(index);
    samples.pixel_width.push_back(depth / camera.fx);
    samples.depth.push_back(depth);
  }
  samples.measured += measured;
}

void compare(const DepthSamples& samples, std::size_t sample, const DepthImage& image, DepthAgreement& agreement) {
  const Camera& camera = image.camera;
  const glm::dvec3 cam = camera.cam_from_world(samples.positions[sample]);
  if (!(cam.z > 0)) return;
  const glm::dvec2 at = camera.image_from_cam(cam);
  if (!(at.x >= 0 && at.y >= 0 && at.x < camera.width && at.y < camera.height)) return;
  const double depth = image.depth[static_cast<std::size_t>(at.y) * camera.width + static_cast<std::size_t>(at.x)];
  if (!(depth > 0)) return;
  const double tolerance =
      kSameDepthPixels * std::max(samples.pixel_width[sample], depth / camera.fx) + kSameDepthShare * depth;
  if (depth > cam.z + tolerance) {
    ++agreement.seen_through;
  } else if (depth < cam.z - tolerance) {
    ++agreement.hidden;
  } else {
    ++agreement.confirmed;
  }
}

}  // namespace

DepthSamples sample_depths(std::size_t count, const DepthSource& image, std::size_t most,
                           const std::function<void(std::size_t)>& progress) {
  const std::size_t of_image = std::max<std::size_t>(1, most / std::max<std::size_t>(1, count));
  DepthSamples samples;
  for_each_depth_image(count, image, [&](std::size_t first, std::span<const DepthImage> images) {
    for (std::size_t i = 0; i < images.size(); ++i) {
      const std::size_t step = images[i].depth.size() / of_image + 1;
      add_samples(images[i], static_cast<std::uint32_t>(first + i), step, samples);
    }
    progress(images.size());
  });
  return samples;
}

DepthAgreement depth_agreement(const DepthSamples& samples, std::size_t count, const DepthSource& image,
                               const std::function<void(std::size_t)>& progress) {
  DepthAgreement agreement;
  const std::size_t image_step = (count + kMostAgreementImages - 1) / kMostAgreementImages;
  const std::size_t looked_through = image_step == 0 ? 0 : (count + image_step - 1) / image_step;
  const std::size_t sample_step = samples.positions.size() / kMostCompared + 1;
  for_each_depth_image(
      looked_through, [&](std::size_t i) { return image(i * image_step); },
      [&](std::size_t first, std::span<const DepthImage> images) {
        for (std::size_t i = 0; i < images.size(); ++i) {
          const std::size_t index = (first + i) * image_step;
          for (std::size_t sample = 0; sample < samples.positions.size(); sample += sample_step) {
            if (samples.image[sample] != index) compare(samples, sample, images[i], agreement);
          }
        }
        progress(images.size());
      });
  return agreement;
}

}  // namespace lumatlas
