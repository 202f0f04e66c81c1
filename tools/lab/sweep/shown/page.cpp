// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/shown/page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <set>

#include "tools/base/html_text.h"
#include "tools/lab/sweep/shown/chart_style.h"
#include "tools/lab/sweep/shown/plot.h"

namespace lumatlas {

namespace {

using Mark = SweepSeries::Mark;

std::string decimals(double value, int digits) {
  char text[400];  // the largest double has 309 digits before the point
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string count_of(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string figure_text(const std::map<std::string, Repeated>& figures, const Metric& metric) {
  const auto found = figures.find(metric.name);
  if (found == figures.end()) return "–";
  const Repeated& figure = found->second;
  std::string text = decimals(figure.mean, metric.decimals);
  if (figure.runs > 1) {
    text += " (" + decimals(figure.least, metric.decimals) + ".." + decimals(figure.most, metric.decimals) + ")";
  }
  return text;
}

std::string joined(const std::vector<std::string>& texts, const char* between) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : between) + text;
  return all;
}

// ---- Parts of the page ---------------------------------------------------------------------------------------------

std::string sentences(const std::vector<std::string>& all) {
  std::string html;
  for (const std::string& sentence : all) html += "<li>" + html_escaped(sentence) + "</li>\n";
  return html.empty() ? "" : "<ul class=\"said\">\n" + html + "</ul>\n";
}

std::string plots_of(const SweepReport& report, const std::vector<Curve>& curves) {
  std::string html;
  for (std::size_t i = 0; i < report.sweep.plots.size(); ++i) {
    const SweepPlot& plot = report.sweep.plots[i];
    if (report.plots[i].empty()) continue;
    html += "<figure style=\"width: " + std::to_string(plot_width(report.plots[i])) + "px\">" +
            inline_svg(report.plots[i], report.sweep.name + "-" + std::to_string(i + 1)) +
            (plot.title.empty() ? "" : "<figcaption>" + html_escaped(plot.title) + "</figcaption>") +
            sentences(front_sentences(report.sweep, plot, curves)) + "</figure>\n";
  }
  return html.empty() ? "" : "<div class=\"plots\">\n" + html + "</div>\n";
}

std::string table_of(const std::vector<TextRow>& rows) {
  std::string html = "<div class=\"scroll\"><table>\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    html += i == 0 ? "<thead><tr>" : "<tr>";
    for (const std::string& cell : rows[i]) {
      html += i == 0 ? "<th>" : "<td>";
      html += html_escaped(cell);
      html += i == 0 ? "</th>" : "</td>";
    }
    html += i == 0 ? "</tr></thead>\n<tbody>\n" : "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string tables_of(const Sweep& sweep, const std::vector<Curve>& curves) {
  std::string html;
  for (std::size_t scene = 0; scene < sweep.scenes.size(); ++scene) {
    const std::vector<TextRow> rows = results_table(sweep, curves, scene);
    if (rows.size() > 1) html += "<h3>" + html_escaped(sweep.scenes[scene].name) + "</h3>\n" + table_of(rows);
  }
  return html;
}

// "12 points: 10 done (8 found, 2 made now), 1 failed, 1 skipped"
std::string counts_of(const std::vector<PointResult>& results) {
  std::map<PointResult::Status, std::size_t> counts;
  for (const PointResult& result : results) ++counts[result.status];
  std::vector<std::string> parts;
  parts.reserve(counts.size());
  for (const auto& [status, count] : counts) parts.push_back(std::to_string(count) + " " + name_of(status));
  return count_of(results.size(), "point") + ": " + joined(parts, ", ");
}

// Lists each reason once, with the points that it holds for.
std::string reasons_of(const std::vector<PointResult>& results) {
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> points;
  for (const PointResult& result : results) {
    if (!result.reason.empty()) points[{name_of(result.status), result.reason}].push_back(result.point.name);
  }
  std::string html;
  for (const auto& [what, names] : points) {
    html += "<p class=\"" + what.first + "\"><b>" + what.first + "</b>: " + html_escaped(what.second) + " (" +
            html_escaped(names.front()) +
            (names.size() > 1 ? " and " + count_of(names.size() - 1, "other point") : std::string()) + ")</p>\n";
  }
  return html;
}

std::string commands_of(const SweepReport& report) {
  std::string lines;
  for (const PointResult& result : report.results) {
    if (result.commands.empty()) continue;
    lines += "# " + result.point.name;
    lines += result.status == PointResult::Status::failed ? ", failed\n" : "\n";
    if (result.point.folder.empty()) {
      std::vector<std::string> synth{"synth", result.point.kind};
      for (const std::string& argument : arguments_of(result.point.synth)) synth.push_back(argument);
      lines += "lumatlas " + joined(synth, " ") + " -o SCENE\n";
    } else {
      lines += "# SCENE: " + result.point.folder + "\n";
    }
    for (const std::string& command : result.commands) lines += command + "\n";
  }
  if (lines.empty()) return "";
  return "<details><summary>Commands of every point</summary><pre>" + html_escaped(lines) + "</pre></details>\n";
}

std::string options_of(const Sweep& sweep) {
  const auto line = [](const char* command, const OptionValues& options) {
    const std::vector<std::string> arguments = arguments_of(options);
    return arguments.empty() ? "" : std::string(command) + " " + joined(arguments, " ");
  };
  std::vector<std::string> all{line("build", sweep.options.build), line("validate", sweep.options.validate)};
  std::erase(all, "");
  for (const SweepScene& scene : sweep.scenes) {
    if (!scene.kind.empty())
      all.push_back(scene.name + ": synth " + scene.kind + " " + joined(arguments_of(scene.options.synth), " "));
  }
  std::string html = "<p class=\"faint\">Options of all points: ";
  for (std::size_t i = 0; i < all.size(); ++i)
    html += (i == 0 ? "" : "; ") + ("<code>" + html_escaped(all[i]) + "</code>");
  html += all.empty() ? "the program's defaults" : "";
  html += ". " + (sweep.repeats == 0 ? "One run each, in the given order."
                                     : "Mean (least..most) of " + count_of(sweep.repeats, "order") + " by seed.");
  return html + (sweep.scored_undisturbed ? " Scored on the undisturbed photographs.</p>\n" : "</p>\n");
}

std::string section(const SweepReport& report, const std::string& program) {
  const std::string makers = makers_sentence(report.results, program);
  const Sweep& sweep = report.sweep;
  const std::vector<Curve> curves = curves_of(sweep, report.results);
  std::string html = "<section id=\"" + sweep.name + "\">\n<h2>" + html_escaped(sweep.title) + "</h2>\n";
  html += "<p><b>Expected</b>" + (sweep.source.empty() ? "" : " (" + html_escaped(sweep.source) + ")") + ": " +
          html_escaped(sweep.expected) + "</p>\n";
  html += reasons_of(report.results);
  if (!makers.empty()) html += "<p class=\"skipped\">" + html_escaped(makers) + "</p>\n";
  html += plots_of(report, curves);
  html += sentences(breaking_sentences(sweep, curves)) + options_of(sweep);
  html += "<details" + std::string(sweep.plots.empty() ? " open" : "") + "><summary>Figures (" +
          counts_of(report.results) + ")</summary>\n" + tables_of(sweep, curves) + "</details>\n";
  return html + commands_of(report) + "</section>\n";
}

std::string contents(const std::vector<SweepReport>& sweeps) {
  if (sweeps.size() < 2) return "";
  std::string html = "<nav>";
  for (const SweepReport& report : sweeps) {
    html += "<a href=\"#" + report.sweep.name + "\">" + html_escaped(report.sweep.title) + "</a> ";
  }
  return html + "</nav>\n";
}

bool has_figures(const Curve& curve) {
  return std::any_of(curve.values.begin(), curve.values.end(), [](const auto& figures) { return !figures.empty(); });
}

std::string marked_name(const SweepSeries& series) {
  if (series.mark == Mark::printed) return "the paper's (" + series.label + ")";
  return series.label == "default" ? "the default" : "the default (" + series.label + ")";
}

}  // namespace

std::vector<std::string> front_sentences(const Sweep& sweep, const SweepPlot& plot, const std::vector<Curve>& curves) {
  std::vector<std::string> all;
  if (!plot.front) return all;
  for (std::size_t scene = 0; scene < sweep.scenes.size(); ++scene) {
    for (const std::string& y : plot.y) {
      const std::vector<OnFront> front = front_of(curves, scene, plot.x, y);
      if (front.empty()) continue;
      std::vector<std::string> parts;
      for (std::size_t curve = 0; curve < curves.size(); ++curve) {
        const SweepSeries& series = sweep.series[curves[curve].series];
        if (curves[curve].scene != scene || series.mark == Mark::none || !has_figures(curves[curve])) continue;
        const auto on = std::count_if(front.begin(), front.end(), [&](const OnFront& at) { return at.curve == curve; });
        parts.push_back(marked_name(series) + " has " + std::to_string(on) + " of " +
                        count_of(series.values.size(), "point") + " on it");
      }
      std::vector<std::string> names;
      for (const OnFront& at : front) {
        const SweepSeries& series = sweep.series[curves[at.curve].series];
        names.push_back(series.label + " " + series.values[at.value].label);
      }
      all.push_back(sweep.scenes[scene].name + ", front of " + find_metric(plot.x)->label + " and " +
                    find_metric(y)->label + ": " + joined(parts, ", ") + (parts.empty() ? "" : "; ") + "on it are " +
                    joined(names, ", ") + ".");
    }
  }
  return all;
}

std::vector<std::string> breaking_sentences(const Sweep& sweep, const std::vector<Curve>& curves) {
  std::vector<std::string> all;
  if (!sweep.breaking) return all;
  const Metric& metric = *find_metric(sweep.breaking->metric);
  const std::string fall = decimals(sweep.breaking->fall, metric.decimals);
  for (const Curve& curve : curves) {
    const SweepSeries& series = sweep.series[curve.series];
    if (!curve.values.front().contains(metric.name)) continue;
    const std::optional<std::size_t> at = breaking_point(sweep, curve);
    all.push_back(sweep.scenes[curve.scene].name + ", " + series.label +
                  (at ? ": breaks at " + series.values[*at].label : ": does not break in this range") + " (" +
                  metric.label + ": " + fall + " worse than at " + series.values.front().label + ").");
  }
  return all;
}

std::string makers_sentence(const std::vector<PointResult>& results, const std::string& program) {
  std::set<std::string> makers;
  for (const PointResult& result : results) {
    if (result.status == PointResult::Status::done) makers.insert(result.made_by);
  }
  if (makers.empty() || makers == std::set<std::string>{program}) return "";
  return "The points were made by another program: " + joined({makers.begin(), makers.end()}, "; ") + ".";
}

std::vector<TextRow> results_table(const Sweep& sweep, const std::vector<Curve>& curves, std::size_t scene) {
  std::vector<TextRow> rows{{"series", sweep.label}};
  for (const std::string& name : sweep.metrics) rows.front().push_back(find_metric(name)->label);
  for (const Curve& curve : curves) {
    if (curve.scene != scene) continue;
    const SweepSeries& series = sweep.series[curve.series];
    for (std::size_t value = 0; value < curve.values.size(); ++value) {
      if (curve.values[value].empty()) continue;
      TextRow row{series.label, series.values[value].label};
      for (const std::string& name : sweep.metrics) row.push_back(figure_text(curve.values[value], *find_metric(name)));
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

std::string chart_page(const ChartPage& page) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"lumatlas\">\n<link rel=\"icon\" href=\"data:,\">\n<title>Charts of "
      "lumatlas</title>\n<style>\n";
  html += std::string(kChartStyle) + "</style>\n</head>\n<body>\n<header>\n<h1>Charts of lumatlas</h1>\n";
  html += "<dl class=\"facts\">\n";
  for (const auto& [what, value] : page.facts) {
    html += "<div><dt>" + html_escaped(what) + "</dt><dd>" + html_escaped(value) + "</dd></div>\n";
  }
  html += "</dl>\n";
  for (const std::string& note : page.notes) html += "<p class=\"note\">" + html_escaped(note) + "</p>\n";
  html += contents(page.sweeps) + "</header>\n";
  for (const SweepReport& report : page.sweeps) html += section(report, page.program);
  return html + "</body>\n</html>\n";
}

}  // namespace lumatlas
