// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/pass_time.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <stdexcept>

#include "mesh/base/median.h"
#include "tools/base/elapsed.h"

namespace lumatlas {

namespace {

constexpr double kMsPerNs = 1e-6;

struct Sample {
  std::string pass;
  std::vector<double> wall, processor, gpu;  // one for each picture
};

// Returns the samples of a pass, which has 0 for a picture until something is added.
Sample& samples_of(std::vector<Sample>& all, const char* pass, std::size_t pictures) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Sample& sample) { return sample.pass == pass; });
  if (found != all.end()) return *found;
  const std::vector<double> none(pictures);
  return all.emplace_back(Sample{pass, none, none, none});
}

bool has_gpu_clock() {
  if (!epoxy_is_desktop_gl()) return false;
  GLint bits = 0;
  glGetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
  return bits > 0;
}

// Times of the GPU, each asked for when it has done what came before.
class Timestamps {
 public:
  Timestamps() = default;
  ~Timestamps() { glDeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data()); }
  Timestamps(const Timestamps&) = delete;
  Timestamps& operator=(const Timestamps&) = delete;

  void ask() {
    GLuint query = 0;
    glGenQueries(1, &query);
    queries_.push_back(query);
    glQueryCounter(query, GL_TIMESTAMP);
  }

  // Returns the milliseconds from the number-th time to the next one. Waits for the GPU.
  [[nodiscard]] double after(std::size_t number) const {
    GLuint64 from = 0, to = 0;
    glGetQueryObjectui64v(queries_.at(number), GL_QUERY_RESULT, &from);
    glGetQueryObjectui64v(queries_.at(number + 1), GL_QUERY_RESULT, &to);
    return kMsPerNs * static_cast<double>(to - from);
  }

 private:
  std::vector<GLuint> queries_;
};

void time_finished_passes(Renderer& renderer, const Camera& camera, const BlendOptions& blend, std::size_t picture,
                          std::size_t pictures, std::vector<Sample>& samples) {
  glFinish();
  auto start = std::chrono::steady_clock::now();
  std::clock_t processor_start = std::clock();
  renderer.set_listener([&](const char* pass) {
    glFinish();
    Sample& sample = samples_of(samples, pass, pictures);
    sample.wall[picture] += ms_since(start);
    sample.processor[picture] += 1e3 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC;
    start = std::chrono::steady_clock::now();
    processor_start = std::clock();
  });
  renderer.draw(camera, blend);
}

void time_gpu_passes(Renderer& renderer, const Camera& camera, const BlendOptions& blend, std::size_t picture,
                     std::size_t pictures, std::vector<Sample>& samples) {
  Timestamps times;
  std::vector<std::string> passes;
  glFinish();
  times.ask();
  renderer.set_listener([&](const char* pass) {
    times.ask();
    passes.emplace_back(pass);
  });
  renderer.draw(camera, blend);
  for (std::size_t i = 0; i < passes.size(); ++i) {
    samples_of(samples, passes[i].c_str(), pictures).gpu[picture] += times.after(i);
  }
}

}  // namespace

std::vector<PassTime> pass_times(Renderer& renderer, const std::vector<Camera>& cameras, const BlendOptions& blend) {
  if (cameras.empty()) throw std::invalid_argument("pass times: there are no cameras, must be at least 1");
  renderer.draw(cameras.front(), blend);
  const bool on_gpu = has_gpu_clock();
  std::vector<Sample> samples;
  for (std::size_t picture = 0; picture < cameras.size(); ++picture) {
    time_finished_passes(renderer, cameras[picture], blend, picture, cameras.size(), samples);
    if (on_gpu) time_gpu_passes(renderer, cameras[picture], blend, picture, cameras.size(), samples);
  }
  renderer.set_listener({});
  std::vector<PassTime> times;
  times.reserve(samples.size());
  for (const Sample& sample : samples) {
    times.push_back({sample.pass, percentile(sample.wall, 0.5), percentile(sample.processor, 0.5), std::nullopt});
    if (on_gpu) times.back().gpu = percentile(sample.gpu, 0.5);
  }
  return times;
}

}  // namespace lumatlas
