// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/scene_stereo.h"

#include <algorithm>
#include <list>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/model/content_digest.h"
#include "mesh/base/errors.h"
#include "tools/scene/for_each_index.h"
#include "tools/stereo/luma_image.h"
#include "tools/stereo/plane_file.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kCoarsestPx = 80;        // a pyramid's last level
constexpr std::uint64_t kAlgorithm = 1;          // grows when other planes come of the same photographs
constexpr std::size_t kLumaBytes = 256U << 20U;  // photographs that are kept for the next ones

constexpr const char* kFirstEnding = ".matched";  // planes from each photograph's matching
constexpr const char* kSecondEnding = ".planes";  // planes that are consistent with the neighbors'

// A digest of all inputs that planes depend on.
class Digest {
 public:
  template <typename Value>
  Digest& add(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  Digest& add_file(const fs::path& file) {
    const std::string name = file.string();
    for (const char c : name) add(c);
    std::error_code none;
    return add(fs::file_size(file, none)).add(fs::last_write_time(file, none).time_since_epoch().count());
  }
  [[nodiscard]] std::uint64_t value() const { return content_digest(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

// A photograph by itself: what it shows, where it was taken, and how it is undistorted.
std::uint64_t digest_of(const SceneView& view) {
  const Camera& camera = view.camera;
  Digest digest;
  digest.add_file(view.image).add(camera.width).add(camera.height);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) digest.add(value);
  digest.add(camera.cam_from_world_rotation).add(camera.cam_from_world_translation);
  digest.add(view.lens.model).add(view.lens.width).add(view.lens.height).add(view.lens.parameters);
  digest.add(view.orientation).add(view.black_rim).add(view.mask.has_value());
  if (view.mask) digest.add_file(*view.mask);
  return digest.value();
}

// The photographs that were used last.
class LumaCache {
 public:
  LumaCache(const std::vector<SceneView>& views, std::uint32_t longest_px) : views_(views), longest_px_(longest_px) {}

  // In the order of `wanted`. They stay until the next call.
  std::vector<const LumaPyramid*> get(const std::vector<std::size_t>& wanted) {
    std::vector<std::size_t> missing;
    for (const std::size_t view : wanted) {
      if (!pyramids_.contains(view)) missing.push_back(view);
    }
    std::vector<LumaPyramid> read(missing.size());
    for_each_index(missing.size(), [&](std::size_t i) {
      const SceneView& view = views_[missing[i]];
      read[i] = luma_pyramid(load_photograph(view), view.camera, longest_px_, std::min(kCoarsestPx, longest_px_));
    });
    for (std::size_t i = 0; i < missing.size(); ++i) keep(missing[i], std::move(read[i]));
    std::vector<const LumaPyramid*> result;
    for (const std::size_t view : wanted) {
      used_.remove(view);
      used_.push_back(view);
      result.push_back(&pyramids_.at(view));
    }
    while (bytes_ > kLumaBytes && used_.size() > wanted.size()) drop_oldest();
    return result;
  }

 private:
  static std::size_t bytes_of(const LumaPyramid& pyramid) {
    std::size_t bytes = 0;
    for (const LumaImage& image : pyramid) bytes += 4 * image.quads.size() + image.valid.size();
    return bytes;
  }

  void keep(std::size_t view, LumaPyramid pyramid) {
    bytes_ += bytes_of(pyramid);
    pyramids_.emplace(view, std::move(pyramid));
  }

  void drop_oldest() {
    const auto oldest = pyramids_.find(used_.front());
    bytes_ -= bytes_of(oldest->second);
    pyramids_.erase(oldest);
    used_.pop_front();
  }

  const std::vector<SceneView>& views_;
  std::uint32_t longest_px_;
  std::map<std::size_t, LumaPyramid> pyramids_;
  std::list<std::size_t> used_;  // the oldest first
  std::size_t bytes_ = 0;
};

// Returns whether a file is named like those of the work: by the number of its photograph.
bool is_plane_file(const fs::path& file) {
  const fs::path ending = file.extension();
  const std::string stem = file.stem().string();
  return (ending == kFirstEnding || ending == kSecondEnding) && !stem.empty() &&
         stem.find_first_not_of("0123456789") == std::string::npos;
}

std::vector<Camera> cameras_of(const std::vector<SceneView>& views) {
  std::vector<Camera> cameras;
  cameras.reserve(views.size());
  for (const SceneView& view : views) cameras.push_back(view.camera);
  return cameras;
}

}  // namespace

class SceneStereo::Work {
 public:
  Work(std::vector<SceneView> views, const ScenePoints& points, const StereoOptions& options, fs::path folder)
      : views_(std::move(views)),
        options_(options),
        folder_(std::move(folder)),
        plans_(plan_stereo(cameras_of(views_), points.positions, points.views, 2 * options.neighbors)) {
    for (StereoPlan& plan : plans_) {
      confirming_.push_back(plan.neighbors);
      plan.neighbors.resize(std::min(plan.neighbors.size(), options.neighbors));
    }
    for (std::size_t view = 0; view < views_.size(); ++view) first_inputs_.push_back(inputs_of_first(view));
    for (std::size_t view = 0; view < views_.size(); ++view) second_inputs_.push_back(inputs_of_second(view));
  }

  [[nodiscard]] std::size_t steps() const { return 2 * views_.size(); }
  [[nodiscard]] const std::vector<SceneView>& views() const { return views_; }
  [[nodiscard]] const std::vector<std::size_t>& confirming(std::size_t view) const { return confirming_[view]; }
  [[nodiscard]] Camera camera(std::size_t view) const { return views_[view].camera.shrunk_to(options_.longest_px); }

  void match(const std::function<void(std::size_t)>& progress) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw InputError(folder_.string() + ": cannot be made: " + error.message());
    LumaCache cache(views_, options_.longest_px);
    for (std::size_t view = 0; view < views_.size(); ++view) {
      if (!plans_[view].neighbors.empty() && !read_planes(first_file(view), first_inputs_[view])) {
        write_planes(first_file(view), first_inputs_[view],
                     match_patches(matched(cache, view), plans_[view].range, plans_[view].seeds));
      }
      progress(1);
    }
    for (std::size_t view = 0; view < views_.size(); ++view) {
      if (!plans_[view].neighbors.empty() && !read_planes(second_file(view), second_inputs_[view])) {
        write_planes(second_file(view), second_inputs_[view], consistent(cache, view));
      }
      progress(1);
    }
  }

  [[nodiscard]] StereoDepth depth(std::size_t view) const {
    const PlaneMap own = planes_of(second_file(view), view, second_inputs_[view]);
    std::vector<PlaneMap> maps;
    for (const std::size_t other : confirming_[view]) {
      maps.push_back(planes_of(second_file(other), other, second_inputs_[other]));
    }
    std::vector<PosedPlanes> others;
    for (std::size_t i = 0; i < maps.size(); ++i) others.push_back({camera(confirming_[view][i]), &maps[i]});
    return agreeing_depths({camera(view), &own}, others, AgreementOptions{});
  }

 private:
  [[nodiscard]] fs::path first_file(std::size_t view) const { return folder_ / (std::to_string(view) + kFirstEnding); }
  [[nodiscard]] fs::path second_file(std::size_t view) const {
    return folder_ / (std::to_string(view) + kSecondEnding);
  }

  [[nodiscard]] std::uint64_t inputs_of_first(std::size_t view) const {
    Digest digest;
    digest.add(kAlgorithm).add(options_.longest_px).add(digest_of(views_[view])).add(plans_[view].range);
    for (const std::size_t other : plans_[view].neighbors) digest.add(digest_of(views_[other]));
    for (const DepthSeed& seed : plans_[view].seeds) digest.add(seed);
    return digest.value();
  }

  [[nodiscard]] std::uint64_t inputs_of_second(std::size_t view) const {
    Digest digest;
    digest.add(first_inputs_[view]);
    for (const std::size_t other : plans_[view].neighbors) digest.add(first_inputs_[other]);
    return digest.value();
  }

  [[nodiscard]] MatchedViews matched(LumaCache& cache, std::size_t view) const {
    std::vector<std::size_t> wanted{view};
    wanted.insert(wanted.end(), plans_[view].neighbors.begin(), plans_[view].neighbors.end());
    std::vector<const LumaPyramid*> pyramids = cache.get(wanted);
    return {pyramids.front(), {pyramids.begin() + 1, pyramids.end()}};
  }

  // Returns empty planes for a photograph without neighbors.
  [[nodiscard]] PlaneMap planes_of(const fs::path& file, std::size_t view, std::uint64_t inputs) const {
    if (plans_[view].neighbors.empty()) {
      const Camera size = camera(view);
      const std::size_t pixels = std::size_t{size.width} * size.height;
      return {size.width, size.height, std::vector<SlantedPlane>(pixels),
              std::vector<float>(pixels, kLargestPatchCost)};
    }
    std::optional<PlaneMap> map = read_planes(file, inputs);
    if (!map) throw InputError(file.string() + ": was removed or changed while it was needed");
    return *std::move(map);
  }

  [[nodiscard]] PlaneMap consistent(LumaCache& cache, std::size_t view) const {
    std::vector<PlaneMap> maps;
    for (const std::size_t other : plans_[view].neighbors) {
      maps.push_back(planes_of(first_file(other), other, first_inputs_[other]));
    }
    std::vector<const PlaneMap*> others;
    others.reserve(maps.size());
    for (const PlaneMap& map : maps) others.push_back(&map);
    return match_consistently(matched(cache, view), plans_[view].range,
                              planes_of(first_file(view), view, first_inputs_[view]), others);
  }

  std::vector<SceneView> views_;
  StereoOptions options_;
  fs::path folder_;
  std::vector<StereoPlan> plans_;  // with the neighbors that are matched
  std::vector<std::vector<std::size_t>> confirming_;
  std::vector<std::uint64_t> first_inputs_, second_inputs_;
};

void check(const StereoOptions& options) {
  const auto require = [](bool holds, const char* field, std::size_t value, const char* rule) {
    if (!holds) {
      throw std::invalid_argument(std::string(field) + ": " + std::to_string(value) + ", must be in " + rule);
    }
  };
  require(options.longest_px >= 64 && options.longest_px <= 8192, "longest_px", options.longest_px, "[64, 8192]");
  require(options.neighbors >= 1 && options.neighbors <= 16, "neighbors", options.neighbors, "[1, 16]");
}

SceneStereo::SceneStereo(std::vector<SceneView> views, const ScenePoints& points, const StereoOptions& options,
                         fs::path folder) {
  check(options);
  work_ = std::make_unique<Work>(std::move(views), points, options, std::move(folder));
}
SceneStereo::~SceneStereo() = default;

std::size_t SceneStereo::steps() const {
  return work_->steps();
}
void SceneStereo::match(const std::function<void(std::size_t)>& progress) {
  work_->match(progress);
}
const std::vector<SceneView>& SceneStereo::views() const {
  return work_->views();
}
Camera SceneStereo::camera(std::size_t view) const {
  return work_->camera(view);
}
const std::vector<std::size_t>& SceneStereo::confirming(std::size_t view) const {
  return work_->confirming(view);
}
StereoDepth SceneStereo::depth(std::size_t view) const {
  return work_->depth(view);
}

void remove_stereo_work(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(fs::symlink_status(folder, ignored))) return;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end; entry.increment(ignored)) {
    if (is_plane_file(entry->path())) files.push_back(entry->path());
  }
  for (const fs::path& file : files) fs::remove(file, ignored);
  fs::remove(folder, ignored);  // does nothing where something is left
}

ScenePoints points_of_views(ScenePoints points, std::span<const std::size_t> ranks) {
  for (std::vector<std::uint32_t>& views : points.views) {
    std::vector<std::uint32_t> kept;
    for (const std::uint32_t view : views) {
      const auto found = std::lower_bound(ranks.begin(), ranks.end(), view);
      if (found != ranks.end() && *found == view) kept.push_back(static_cast<std::uint32_t>(found - ranks.begin()));
    }
    views = std::move(kept);
  }
  return points;
}

}  // namespace lumatlas
