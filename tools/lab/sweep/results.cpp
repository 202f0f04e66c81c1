// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/results.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <tuple>

#include "tools/lab/sweep/pareto_front.h"

namespace lumatlas {

namespace {

using nlohmann::json;

const char* name_of(SweepSeries::Mark mark) {
  switch (mark) {
    case SweepSeries::Mark::is_default:
      return "default";
    case SweepSeries::Mark::printed:
      return "printed";
    case SweepSeries::Mark::none:
      break;
  }
  return "";
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of("\",\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_row(const std::vector<std::string>& fields) {
  std::string row;
  for (std::size_t i = 0; i < fields.size(); ++i) row += (i == 0 ? "" : ",") + csv_field(fields[i]);
  return row + "\r\n";
}

// The shortest that reads back as the same number.
std::string number_text(double number) {
  return json(number).dump();
}

Figures figures_of_point(const PointResult& result) {
  return result.status == PointResult::Status::done ? figures_of(result.build, result.scores) : Figures();
}

// Returns the figures of each result. A loss is measured against the first value of the same scene, series and seed.
std::vector<Figures> figures_of_points(const std::vector<PointResult>& results) {
  const auto run_of = [](const SweepPoint& point) { return std::tuple(point.scene, point.series, point.seed); };
  std::vector<Figures> all;
  std::map<decltype(run_of(SweepPoint())), std::size_t> first;
  for (const PointResult& result : results) {
    if (result.point.value == 0) first[run_of(result.point)] = all.size();
    all.push_back(figures_of_point(result));
  }
  for (std::size_t i = 0; i < results.size(); ++i) {
    const auto found = first.find(run_of(results[i].point));
    if (found != first.end()) add_measured_loss(all[i], all[found->second]);
  }
  return all;
}

json json_of(const Repeated& figure) {
  return {{"mean", figure.mean},
          {"least", figure.least},
          {"most", figure.most},
          {"deviation", figure.deviation},
          {"runs", figure.runs}};
}

json json_of(const OptionValues& options) {
  return arguments_of(options);
}

json json_of(const CommandOptions& options) {
  return {
      {"synth", json_of(options.synth)}, {"build", json_of(options.build)}, {"validate", json_of(options.validate)}};
}

json sweep_json(const Sweep& sweep) {
  json scenes = json::array(), series = json::array();
  for (const SweepScene& scene : sweep.scenes) {
    scenes.push_back(
        {{"name", scene.name}, {"kind", scene.kind}, {"folder", scene.folder}, {"options", json_of(scene.options)}});
  }
  for (const SweepSeries& one : sweep.series) {
    series.push_back({{"label", one.label}, {"mark", name_of(one.mark)}, {"options", json_of(one.options)}});
  }
  return {{"name", sweep.name},
          {"title", sweep.title},
          {"source", sweep.source},
          {"expected", sweep.expected},
          {"label", sweep.label},
          {"repeats", sweep.repeats},
          {"scored_on", sweep.scored_undisturbed ? "undisturbed" : "same"},
          {"options", json_of(sweep.options)},
          {"scenes", scenes},
          {"series", series}};
}

json point_json(const Sweep& sweep, const PointResult& result, const Figures& figures) {
  const SweepPoint& point = result.point;
  const SweepSeries& series = sweep.series[point.series];
  const SweepValue& value = series.values[point.value];
  return {{"scene", sweep.scenes[point.scene].name},
          {"series", series.label},
          {"value", value.label},
          {"x", value.x ? json(*value.x) : json()},
          {"seed", point.seed ? json(*point.seed) : json()},
          {"status", name_of(result.status)},
          {"reason", result.reason},
          {"made_by", result.made_by},
          {"commands", result.commands},
          {"figures", figures}};
}

json curve_json(const Sweep& sweep, const Curve& curve) {
  const SweepSeries& series = sweep.series[curve.series];
  json values = json::array();
  for (std::size_t i = 0; i < curve.values.size(); ++i) {
    json figures = json::object();
    for (const auto& [name, figure] : curve.values[i]) figures[name] = json_of(figure);
    values.push_back({{"value", series.values[i].label}, {"figures", std::move(figures)}});
  }
  return {{"scene", sweep.scenes[curve.scene].name}, {"series", series.label}, {"values", std::move(values)}};
}

}  // namespace

Repeated repeated(std::span<const double> values) {
  Repeated figure;
  figure.runs = values.size();
  figure.mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  figure.least = *std::min_element(values.begin(), values.end());
  figure.most = *std::max_element(values.begin(), values.end());
  double squares = 0;
  for (const double value : values) squares += (value - figure.mean) * (value - figure.mean);
  if (values.size() > 1) figure.deviation = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return figure;
}

std::vector<Curve> curves_of(const Sweep& sweep, const std::vector<PointResult>& results) {
  std::vector<Curve> curves;
  std::vector<std::vector<std::map<std::string, std::vector<double>>>> runs;  // by curve, value and metric
  for (std::size_t scene = 0; scene < sweep.scenes.size(); ++scene) {
    for (std::size_t series = 0; series < sweep.series.size(); ++series) {
      const std::size_t values = sweep.series[series].values.size();
      curves.push_back({scene, series, std::vector<std::map<std::string, Repeated>>(values)});
      runs.emplace_back(values);
    }
  }
  const std::vector<Figures> figures_of_each = figures_of_points(results);
  for (std::size_t i = 0; i < results.size(); ++i) {
    const SweepPoint& point = results[i].point;
    auto& of_curve = runs[point.scene * sweep.series.size() + point.series];
    for (const auto& [name, figure] : figures_of_each[i]) of_curve[point.value][name].push_back(figure);
  }
  for (std::size_t curve = 0; curve < curves.size(); ++curve) {
    for (std::size_t value = 0; value < runs[curve].size(); ++value) {
      for (const auto& [name, figures] : runs[curve][value]) curves[curve].values[value][name] = repeated(figures);
    }
  }
  return curves;
}

std::optional<std::size_t> breaking_point(std::span<const std::optional<double>> figures, double fall,
                                          bool more_is_better) {
  if (figures.empty() || !figures.front()) return std::nullopt;
  for (std::size_t i = 1; i < figures.size(); ++i) {
    if (!figures[i]) continue;
    const double lost = more_is_better ? *figures.front() - *figures[i] : *figures[i] - *figures.front();
    if (lost >= fall) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> breaking_point(const Sweep& sweep, const Curve& curve) {
  const std::string& metric = sweep.breaking->metric;
  std::vector<std::optional<double>> figures;
  for (const auto& value : curve.values) {
    const auto found = value.find(metric);
    figures.push_back(found == value.end() ? std::nullopt : std::optional(found->second.mean));
  }
  return breaking_point(figures, sweep.breaking->fall, find_metric(metric)->better == Better::more);
}

std::vector<OnFront> front_of(const std::vector<Curve>& curves, std::size_t scene, const std::string& x,
                              const std::string& y) {
  std::vector<OnFront> all;
  std::vector<FrontPoint> points;
  for (std::size_t curve = 0; curve < curves.size(); ++curve) {
    if (curves[curve].scene != scene) continue;
    for (std::size_t value = 0; value < curves[curve].values.size(); ++value) {
      const auto& figures = curves[curve].values[value];
      if (!figures.contains(x) || !figures.contains(y)) continue;
      all.push_back({curve, value});
      points.push_back({figures.at(x).mean, figures.at(y).mean});
    }
  }
  std::vector<OnFront> front;
  for (const std::size_t i :
       pareto_front(points, find_metric(x)->better == Better::more, find_metric(y)->better == Better::more)) {
    front.push_back(all[i]);
  }
  return front;
}

std::string results_csv(const Sweep& sweep, const std::vector<PointResult>& results) {
  const std::vector<Figures> figures = figures_of_points(results);
  std::set<std::string> measured;
  for (const Figures& of_one : figures) {
    for (const auto& [name, figure] : of_one) measured.insert(name);
  }
  std::vector<std::string> head{"scene", "series", "mark", "value", "x", "seed", "status", "reason", "program"};
  const std::size_t described = head.size();
  for (const Metric& metric : all_metrics()) {
    if (measured.contains(metric.name)) head.push_back(metric.name);
  }
  std::string text = csv_row(head);
  for (std::size_t i = 0; i < results.size(); ++i) {
    const SweepPoint& point = results[i].point;
    const SweepSeries& series = sweep.series[point.series];
    const SweepValue& value = series.values[point.value];
    std::vector<std::string> row{sweep.scenes[point.scene].name,
                                 series.label,
                                 name_of(series.mark),
                                 value.label,
                                 value.x ? number_text(*value.x) : "",
                                 point.seed ? std::to_string(*point.seed) : "",
                                 name_of(results[i].status),
                                 results[i].reason,
                                 results[i].made_by};
    for (std::size_t column = described; column < head.size(); ++column) {
      const auto found = figures[i].find(head[column]);
      row.push_back(found == figures[i].end() ? "" : number_text(found->second));
    }
    text += csv_row(row);
  }
  return text;
}

json results_json(const Sweep& sweep, const std::vector<PointResult>& results) {
  json points = json::array(), curves = json::array(), breaking = json::array();
  const std::vector<Figures> figures = figures_of_points(results);
  for (std::size_t i = 0; i < results.size(); ++i) points.push_back(point_json(sweep, results[i], figures[i]));
  for (const Curve& curve : curves_of(sweep, results)) {
    curves.push_back(curve_json(sweep, curve));
    if (!sweep.breaking) continue;
    const SweepSeries& series = sweep.series[curve.series];
    const std::optional<std::size_t> at = breaking_point(sweep, curve);
    breaking.push_back({{"scene", sweep.scenes[curve.scene].name},
                        {"series", series.label},
                        {"at", at ? json(series.values[*at].label) : json()}});
  }
  return {{"sweep", sweep_json(sweep)}, {"points", points}, {"curves", curves}, {"breaking", breaking}};
}

}  // namespace lumatlas
