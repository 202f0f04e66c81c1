// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/report.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mesh/base/number_text.h"
#include "tools/base/output_folder.h"
#include "tools/score/report/json_fields.h"

namespace lumatlas {

namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& rule) {
  throw std::invalid_argument("report: " + what + " is " + value + ", must be " + rule);
}

void check_path(const std::string& view, const std::string& path) {
  if (!path.empty() && path.front() == '/') {
    refuse("a picture of view " + view, path, "a path relative to the page");
  }
}

nlohmann::json json_method(const ReportMethod& method, const MethodScores& means) {
  nlohmann::json json = json_scores(means);
  if (method.seams) json["seams"] = json_number(*method.seams);
  if (method.flicker) {
    json["flicker"] = {{"rms", json_number(method.flicker->rms)},
                       {"worst", json_number(method.flicker->worst)},
                       {"followed", method.flicker->followed}};
  }
  return json;
}

}  // namespace

void check(const Report& report) {
  if (report.methods.empty()) {
    refuse("the number of methods", "0", "at least 1");
  }
  for (const ReportView& view : report.views) {
    if (view.renderings.size() != report.methods.size()) {
      refuse("the number of renderings of view " + view.name, std::to_string(view.renderings.size()),
             std::to_string(report.methods.size()) + ", one per method");
    }
    if (view.width == 0 || view.height == 0) {
      refuse("the size of view " + view.name, size_text(view.width, view.height), "at least 1x1");
    }
    check_path(view.name, view.photograph);
    for (const ReportRendering& rendering : view.renderings) {
      check_path(view.name, rendering.picture);
      check_path(view.name, rendering.error);
      check_path(view.name, rendering.aligned_picture);
      check_path(view.name, rendering.aligned_error);
    }
  }
}

std::vector<MethodScores> method_means(const Report& report) {
  std::vector<MethodScores> means;
  for (std::size_t method = 0; method < report.methods.size(); ++method) {
    std::vector<ViewScores> scores;
    for (const ReportView& view : report.views) {
      scores.push_back(view.renderings[method].scores);
    }
    means.push_back(method_scores(scores));
  }
  return means;
}

std::string shortfall_sentence(const Report& report) {
  constexpr double kLeastTold = 0.005;  // dB, what the table rounds to 0
  if (!report.shortfall) return "";
  const auto [moved, budget] = *report.shortfall;
  if (!(moved + budget >= kLeastTold)) return "";
  char text[400];
  std::snprintf(text, sizeof(text), "The store is %.2f dB (fitted) below the unbounded baseline: ", moved + budget);
  std::string sentence = text;
  if (std::abs(moved) < kLeastTold) {
    return sentence.append("the budget costs all of it, refined poses nothing.");
  }
  std::snprintf(text, sizeof(text), "the budget %s %.2f dB, refined poses %s %.2f dB%s.",
                budget < 0 ? "gains" : "costs", std::abs(budget), moved < 0 ? "gain" : "cost", std::abs(moved),
                moved < 0 ? "" : ", for those of the photographs left out stay as they were given");
  return sentence.append(text);
}

void write_report(const std::filesystem::path& path, const Report& report) {
  const std::string page = report_page(report);
  AtomicFile file(path);
  file.stream() << page;
  file.commit();
}

nlohmann::json report_json(const Report& report) {
  check(report);
  nlohmann::json protocol = nlohmann::json::object();
  if (report.protocol) protocol = {{"hold", report.protocol->hold}, {"block", report.protocol->block}};
  if (!report.test.empty()) protocol["test"] = report.test;
  nlohmann::json json = {{"protocol", protocol}, {"held", report.views.size()}};
  const std::vector<MethodScores> means = method_means(report);
  json["methods"] = nlohmann::json::object();
  for (std::size_t method = 0; method < means.size(); ++method) {
    json["methods"][report.methods[method].name] = json_method(report.methods[method], means[method]);
  }
  if (report.shortfall) {
    json["shortfall"] = {{"moved", json_number(report.shortfall->moved)},
                         {"budget", json_number(report.shortfall->budget)}};
  }
  json["views"] = nlohmann::json::array();
  for (const ReportView& view : report.views) {
    nlohmann::json scores = nlohmann::json::object();
    for (std::size_t method = 0; method < means.size(); ++method) {
      scores[report.methods[method].name] = json_scores(view.renderings[method].scores);
    }
    json["views"].push_back({{"name", view.name}, {"methods", scores}});
  }
  return json;
}

}  // namespace lumatlas
