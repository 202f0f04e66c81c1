// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/metrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

namespace lumatlas {

namespace {

using nlohmann::json;

// The place of a figure: in which result, under which JSON pointer, times what.
struct Source {
  Metric metric;
  bool in_scores;
  std::string pointer;
  double scale;
};

std::vector<Source> sources_of_method(const std::string& method) {
  const std::string suffix = method == "store" ? "" : "." + method;
  const std::string of = method == "store" ? "" : " (" + method + ")";
  const std::string at = "/methods/" + method;
  std::vector<Source> sources;
  for (const std::string kind : {"frame/raw", "frame/fitted", "frame/aligned", "raw", "fitted", "aligned"}) {
    std::string name = kind, label = kind;
    std::replace(name.begin(), name.end(), '/', '.');
    std::replace(label.begin(), label.end(), '/', ' ');
    sources.push_back({{"psnr." + name + suffix, "PSNR " + label + of + ", dB", Better::more, 2},
                       true,
                       at + "/" + kind + "/psnr",
                       1});
    sources.push_back(
        {{"ssim." + name + suffix, "MSSIM " + label + of, Better::more, 4}, true, at + "/" + kind + "/ssim", 1});
  }
  sources.push_back({{"textured" + suffix, "textured" + of + ", %", Better::more, 1}, true, at + "/textured", 100});
  sources.push_back(
      {{"textured.frame" + suffix, "textured frame" + of + ", %", Better::more, 1}, true, at + "/frame/textured", 100});
  sources.push_back({{"seams" + suffix, "seams" + of + ", levels", Better::less, 2}, true, at + "/seams", 1});
  sources.push_back({{"flicker" + suffix, "flicker" + of + ", levels", Better::less, 2}, true, at + "/flicker/rms", 1});
  return sources;
}

std::vector<Source> all_sources() {
  std::vector<Source> sources;
  for (const char* const method : {"store", "unbounded", "vertex"}) {
    for (Source& source : sources_of_method(method)) sources.push_back(std::move(source));
  }
  const auto built = [&](const char* name, const char* label, Better better, int decimals, const char* pointer,
                         double scale = 1) {
    sources.push_back({{name, label, better, decimals}, false, pointer, scale});
  };
  const auto scored = [&](const char* name, const char* label, const char* pointer) {
    sources.push_back({{name, label, Better::less, 1}, true, pointer, 1});
  };
  built("time.visibility", "visibility, ms a view", Better::less, 2, "/time_ms/per_view/visibility/median");
  built("time.plan", "decision, ms a view", Better::less, 2, "/time_ms/per_view/plan/median");
  built("time.read", "reading, ms a view stored", Better::less, 1, "/time_ms/per_view/read/median");
  built("time.refine", "refinement, ms a view stored", Better::less, 1, "/time_ms/per_view/refine/median");
  built("time.store", "storing, ms a view stored", Better::less, 1, "/time_ms/per_view/store/median");
  built("time.build", "building, s", Better::less, 2, "/time_ms/total", 1e-3);
  scored("frame.wall", "frame, ms", "/speed/frame_ms/median");
  scored("frame.cpu", "frame, ms of processor time", "/speed/frame_cpu_ms/median");
  scored("load.read", "reading the model, ms", "/speed/read_ms");
  scored("load.upload", "loading it to the renderer, ms", "/speed/upload_ms");
  built("bytes.resident", "resident, MB", Better::less, 1, "/bytes/resident", 1e-6);
  built("bytes.peak", "peak memory of building, MB", Better::less, 0, "/bytes/peak_rss", 1e-6);
  built("bytes.gpu", "on the GPU, MB", Better::less, 1, "/gpu/sum", 1e-6);
  built("texels.resident", "resident, Mtexels", Better::less, 2, "/texels/resident", 1e-6);
  built("views.offered", "photographs offered", Better::neither, 0, "/views/offered");
  built("views.stored", "views stored", Better::less, 0, "/views/stored");
  built("views.outliers", "outliers", Better::neither, 0, "/views/outliers");
  built("cells", "cells", Better::less, 0, "/cells");
  built("references", "references", Better::less, 0, "/references");
  built("coverage", "coverage", Better::more, 1, "/summed_coverage");
  built("loss.predicted", "predicted loss, dB", Better::less, 3, "/parsimony/predicted_loss_db");
  return sources;
}

constexpr const char* kPlanning = "time.planning";  // before a view's photograph is looked at: the paper's Table 2
constexpr const char* kMeasuredLoss = "loss.measured";

const std::vector<Source>& sources() {
  static const std::vector<Source> all = all_sources();
  return all;
}

std::optional<double> number_at(const json& results, const std::string& pointer) {
  const json::json_pointer place(pointer);
  if (!results.contains(place) || !results.at(place).is_number()) return std::nullopt;
  const double number = results.at(place).get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

// A stage that no view went through has a median of 0, which is no measurement.
bool is_of_no_view(const Source& source, const json& build) {
  constexpr std::string_view kMedian = "/median";
  if (source.in_scores || !source.pointer.ends_with(kMedian)) return false;
  const std::string stage = source.pointer.substr(0, source.pointer.size() - kMedian.size());
  return number_at(build, stage + "/views") == 0.0;
}

}  // namespace

std::span<const Metric> all_metrics() {
  static const std::vector<Metric> metrics = [] {
    std::vector<Metric> all;
    for (const Source& source : sources()) {
      all.push_back(source.metric);
      if (source.metric.name == "time.plan") all.push_back({kPlanning, "planning, ms a view", Better::less, 2});
    }
    all.push_back({kMeasuredLoss, "measured loss, dB", Better::less, 3});
    return all;
  }();
  return metrics;
}

const Metric* find_metric(const std::string& name) {
  const auto all = all_metrics();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Metric& metric) { return metric.name == name; });
  return found == all.end() ? nullptr : &*found;
}

Figures figures_of(const json& build, const json& scores) {
  Figures figures;
  for (const Source& source : sources()) {
    const std::optional<double> number = number_at(source.in_scores ? scores : build, source.pointer);
    if (number && !is_of_no_view(source, build)) figures[source.metric.name] = *number * source.scale;
  }
  if (figures.contains("time.visibility") && figures.contains("time.plan")) {
    figures[kPlanning] = figures["time.visibility"] + figures["time.plan"];
  }
  return figures;
}

void add_measured_loss(Figures& figures, const Figures& of_whole) {
  constexpr const char* kScore = "psnr.fitted";
  if (!figures.contains("loss.predicted") || !figures.contains(kScore) || !of_whole.contains(kScore)) return;
  figures[kMeasuredLoss] = of_whole.at(kScore) - figures.at(kScore);
}

}  // namespace lumatlas
