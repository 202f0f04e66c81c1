// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/results.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/lab/sweep/pareto_front.h"
#include "tools/lab/sweep/shown/markdown.h"
#include "tools/lab/sweep/shown/page.h"
#include "tools/lab/sweep/shown/plot.h"

namespace lumatlas {
namespace {

using nlohmann::json;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// ---- Fronts and breaking points ------------------------------------------------------------------------------------

bool beats(const FrontPoint& a, const FrontPoint& b, bool more_x, bool more_y) {
  const double ax = more_x ? a.x : -a.x, bx = more_x ? b.x : -b.x, ay = more_y ? a.y : -a.y, by = more_y ? b.y : -b.y;
  return ax >= bx && ay >= by && (ax > bx || ay > by);
}

TEST_CASE("a front is what no other point beats, found by trying all pairs") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    // Few different numbers, so that there are ties and equal points.
    std::uniform_int_distribution<int> number(0, trial % 2 == 0 ? 5 : 1000);
    std::vector<FrontPoint> points(static_cast<std::size_t>(trial % 40));
    for (FrontPoint& point : points) point = {double(number(random)), double(number(random))};
    for (const bool more_x : {false, true}) {
      for (const bool more_y : {false, true}) {
        std::vector<std::size_t> expected;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const auto beats_it = [&](const FrontPoint& other) { return beats(other, points[i], more_x, more_y); };
          if (std::none_of(points.begin(), points.end(), beats_it)) expected.push_back(i);
        }
        CHECK(pareto_front(points, more_x, more_y) == expected);
      }
    }
  }
}

TEST_CASE("a point that is not finite is on no front and keeps no other off it") {
  const std::vector<FrontPoint> points{{1, 1}, {0, kNaN}, {kNaN, 9}, {0, std::numeric_limits<double>::infinity()}};
  CHECK(pareto_front(points, false, true) == std::vector<std::size_t>{0});
  CHECK(pareto_front({}, true, true).empty());
}

TEST_CASE("a method breaks at the first value that is worse than the first by so much") {
  using Figures = std::vector<std::optional<double>>;
  CHECK(breaking_point(Figures{30, 29.5, 29, 20}, 1, true) == 2u);
  CHECK(breaking_point(Figures{30, 29.5, 29.1}, 1, true) == std::nullopt);
  CHECK(breaking_point(Figures{30, std::nullopt, 20}, 1, true) == 2u);
  CHECK(breaking_point(Figures{30, 40, 31}, 1, true) == std::nullopt);
  CHECK(breaking_point(Figures{30, 40, 31}, 1, false) == 1u);
  CHECK(breaking_point(Figures{std::nullopt, 40, 20}, 1, true) == std::nullopt);
  CHECK(breaking_point(Figures{}, 1, true) == std::nullopt);
}

TEST_CASE("repeated runs have a mean, their extremes and a deviation of the sample") {
  const Repeated figure = repeated(std::vector<double>{2, 4, 9});
  CHECK(figure.mean == Approx(5));
  CHECK(figure.least == 2);
  CHECK(figure.most == 9);
  CHECK(figure.deviation == Approx(std::sqrt(13)));  // (9 + 1 + 16) / 2
  CHECK(figure.runs == 3);
  CHECK(repeated(std::vector<double>{7}).deviation == 0);
}

// ---- A sweep with results ------------------------------------------------------------------------------------------

constexpr const char* kAwkward = R"(b, "<ours>" & 'its' | own)";

// Two series of two values on one scene, with a front and a breaking point.
Sweep sample_sweep() {
  Sweep sweep;
  sweep.name = "cells";
  sweep.title = "Cells & <co>";
  sweep.expected = "More is better.";
  sweep.label = "views";
  sweep.scenes = {{.name = "tiny", .folder = "", .kind = "apartment", .options = {}}};
  const std::vector<SweepValue> values{{.label = "1", .x = 1, .options = {}}, {.label = "2", .x = 2, .options = {}}};
  sweep.series = {
      {.label = kAwkward, .mark = SweepSeries::Mark::is_default, .once = false, .options = {}, .values = values},
      {.label = "printed", .mark = SweepSeries::Mark::printed, .once = false, .options = {}, .values = values}};
  sweep.metrics = {"psnr.fitted", "time.build", "psnr.fitted.vertex"};
  sweep.plots = {
      {.title = "",
       .x = "value",
       .y = {"psnr.fitted"},
       .log_x = true,
       .log_y = false,
       .front = false,
       .lines = {{.on_x = false, .at = 26, .label = "hoped for"}, {.on_x = true, .at = 1.5, .label = "here"}}},
      {.title = "Speed",
       .x = "time.build",
       .y = {"psnr.fitted"},
       .log_x = false,
       .log_y = false,
       .front = true,
       .lines = {}}};
  sweep.breaking = SweepBreaking{"psnr.fitted", 1};
  return sweep;
}

PointResult result_of(std::size_t series, std::size_t value, std::uint64_t seed, double psnr, double seconds) {
  PointResult result;
  result.point.series = series;
  result.point.value = value;
  result.point.seed = seed;
  result.point.name = "tiny/" + std::to_string(series) + "/" + std::to_string(value);
  result.point.kind = "apartment";
  result.status = PointResult::Status::done;
  result.made_by = "0.1.0 commit a";
  result.commands = {"lumatlas build SCENE"};
  result.build = {{"time_ms",
                   {{"total", 1000 * seconds},
                    {"per_view",
                     {{"plan", {{"median", 2.5}, {"views", 3}}},
                      {"visibility", {{"median", 1.25}, {"views", 3}}},
                      {"refine", {{"median", 0}, {"views", 0}}}}}}}};
  result.scores = {{"methods", {{"store", {{"fitted", {{"psnr", psnr}, {"ssim", nullptr}}}}}}}};
  return result;
}

// The default gets better with views, the printed one falls; one point failed.
std::vector<PointResult> sample_results() {
  std::vector<PointResult> results{result_of(0, 0, 1, 25.1, 1), result_of(1, 0, 1, 24, 1.5), result_of(0, 1, 1, 27, 2),
                                   result_of(0, 1, 2, 29.3, 2), result_of(1, 1, 1, 20, 3),   result_of(1, 1, 2, 0, 0)};
  results.back().status = PointResult::Status::failed;
  results.back().reason = "build: the disk is full, \"really\"";
  return results;
}

TEST_CASE("figures are those that were measured, planning the sum of its stages") {
  const PointResult result = result_of(0, 0, 1, 25, 1.5);
  const Figures figures = figures_of(result.build, result.scores);
  CHECK(figures == Figures{{"psnr.fitted", 25},
                           {"time.build", 1.5},
                           {"time.plan", 2.5},
                           {"time.planning", 3.75},
                           {"time.visibility", 1.25}});
  CHECK(figures_of(json(), json()).empty());
}

TEST_CASE("a loss is measured against the first value of the same series and seed, where one was predicted") {
  // Seeds 1 and 2 of two values of series 0; series 1 predicts nothing.
  std::vector<PointResult> results{result_of(0, 0, 1, 30, 1),    result_of(0, 0, 2, 31, 1),
                                   result_of(1, 0, 1, 28, 1),    result_of(0, 1, 1, 29.5, 1),
                                   result_of(0, 1, 2, 31.25, 1), result_of(1, 1, 1, 20, 1)};
  for (PointResult& result : results) {
    if (result.point.series == 0) result.build["parsimony"]["predicted_loss_db"] = 0.25 * double(result.point.value);
  }
  const json points = results_json(sample_sweep(), results)["points"];
  CHECK(points[0]["figures"]["loss.predicted"] == 0);
  CHECK(points[0]["figures"]["loss.measured"] == 0);
  CHECK(points[3]["figures"]["loss.predicted"] == 0.25);
  CHECK(points[3]["figures"]["loss.measured"] == 0.5);
  CHECK(points[4]["figures"]["loss.measured"] == -0.25);
  CHECK_FALSE(points[5]["figures"].contains("loss.measured"));
  CHECK(curves_of(sample_sweep(), results)[0].values[1].at("loss.measured").mean == 0.125);
  CHECK_THAT(results_csv(sample_sweep(), results), Catch::Contains("loss.predicted,loss.measured"));

  results[0].status = PointResult::Status::failed;
  CHECK_FALSE(results_json(sample_sweep(), results)["points"][3]["figures"].contains("loss.measured"));
}

TEST_CASE("every metric's name is its own, and only once") {
  std::vector<std::string> names;
  for (const Metric& metric : all_metrics()) {
    names.push_back(metric.name);
    CHECK(find_metric(metric.name) == &metric);
  }
  std::sort(names.begin(), names.end());
  CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
  CHECK(find_metric("psnr") == nullptr);
}

// The rows and fields of RFC 4180, written anew for this test.
std::vector<std::vector<std::string>> parsed_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& field = rows.back().back();
    if (quoted && text[i] == '"' && text.substr(i, 2) == "\"\"") {
      field += text[++i];
    } else if (text[i] == '"') {
      quoted = !quoted;
    } else if (!quoted && text[i] == ',') {
      rows.back().emplace_back();
    } else if (!quoted && text.substr(i, 2) == "\r\n") {
      ++i;
      rows.push_back({""});
    } else {
      field += text[i];
    }
  }
  rows.pop_back();
  return rows;
}

TEST_CASE("results as CSV read back as they were, whatever the labels hold") {
  const auto rows = parsed_csv(results_csv(sample_sweep(), sample_results()));
  REQUIRE(rows.size() == 7);
  const std::vector<std::string> head{
      "scene",  "series",  "mark",        "value",           "x",         "seed",          "status",
      "reason", "program", "psnr.fitted", "time.visibility", "time.plan", "time.planning", "time.build"};
  CHECK(rows[0] == head);
  for (const auto& row : rows) CHECK(row.size() == head.size());
  CHECK(rows[1][1] == kAwkward);
  CHECK(rows[1][2] == "default");
  CHECK(std::strtod(rows[1][9].c_str(), nullptr) == 25.1);  // exactly
  CHECK(rows[6][6] == "failed");
  CHECK(rows[6][7] == "build: the disk is full, \"really\"");
  CHECK(rows[6][9].empty());
}

TEST_CASE("results as JSON have points, means over seeds and breaking points") {
  const json all = results_json(sample_sweep(), sample_results());
  CHECK(all["points"].size() == 6);
  CHECK(all["points"][5]["reason"] == "build: the disk is full, \"really\"");
  const json& figure = all["curves"][0]["values"][1]["figures"]["psnr.fitted"];
  CHECK(figure["mean"].get<double>() == Approx(28.15));
  CHECK(figure["runs"] == 2);
  CHECK(all["curves"][1]["values"][1]["figures"]["psnr.fitted"]["runs"] == 1);  // the other one failed
  CHECK(all["breaking"][0]["at"].is_null());
  CHECK(all["breaking"][1]["at"] == "2");
}

TEST_CASE("sentences say what breaks where, and who is on the front") {
  const Sweep sweep = sample_sweep();
  const std::vector<Curve> curves = curves_of(sweep, sample_results());
  const std::vector<std::string> breaking = breaking_sentences(sweep, curves);
  REQUIRE(breaking.size() == 2);
  CHECK_THAT(breaking[0], Catch::Contains("does not break"));
  CHECK_THAT(breaking[1], Catch::Contains("printed: breaks at 2 (PSNR fitted, dB: 1.00 worse than at 1)"));
  CHECK(front_sentences(sweep, sweep.plots[0], curves).empty());
  const std::vector<std::string> front = front_sentences(sweep, sweep.plots[1], curves);
  REQUIRE(front.size() == 1);
  CHECK_THAT(front[0], Catch::Contains("the default (" + std::string(kAwkward) + ") has 2 of 2 points on it") &&
                           Catch::Contains("the paper's (printed) has 0 of 2 points on it"));
}

// ---- Plots and pages -----------------------------------------------------------------------------------------------

std::size_t count_of(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// The plots as files of `folder`; none without gnuplot.
std::vector<std::string> drawn(const Sweep& sweep, const TemporaryFolder& folder) {
  std::vector<std::string> plots;
  for (const SweepPlot& plot : sweep.plots) {
    plots.emplace_back();
    if (find_program("gnuplot").empty()) continue;
    const auto svg = folder / "plot.svg";
    draw_plot(find_program("gnuplot"), plot_script(sweep, plot, curves_of(sweep, sample_results()), svg), svg);
    plots.back() = bytes_of(svg);
  }
  return plots;
}

TEST_CASE("gnuplot draws what it is told, labels as they are, and nothing is left beside the plot") {
  if (find_program("gnuplot").empty()) return skip("there is no gnuplot");
  const TemporaryFolder folder;
  const std::vector<std::string> plots = drawn(sample_sweep(), folder);
  for (const std::string& plot : plots) {
    CHECK_THAT(plot, Catch::Contains("<svg") && Catch::EndsWith("</svg>\n\n"));
    CHECK_THAT(plot, Catch::Contains("\"&lt;ours") && Catch::Contains("'its' | own (default)"));
    CHECK_THAT(plot, Catch::Contains("printed (the paper's)") && Catch::Contains("PSNR fitted, dB"));
  }
  CHECK_THAT(plots[0], Catch::Contains("hoped for"));
  CHECK_THAT(plots[1], Catch::Contains("Pareto front") && Catch::Contains("building, s"));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
  const std::string script = "this is no command\n";
  CHECK_THROWS_WITH(draw_plot(find_program("gnuplot"), script, folder / "no.svg"),
                    Catch::Contains("no.svg: gnuplot cannot draw it: "));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("a plot without any figures has no script") {
  const Sweep sweep = sample_sweep();
  CHECK(plot_script(sweep, sweep.plots[0], curves_of(sweep, {}), "a.svg").empty());
  SweepPlot other = sweep.plots[0];
  other.y = {"flicker"};
  CHECK(plot_script(sweep, other, curves_of(sweep, sample_results()), "a.svg").empty());
}

TEST_CASE("a metric without any figures has no panel") {
  const Sweep sweep = sample_sweep();
  SweepPlot more = sweep.plots[0];
  more.y.insert(more.y.begin(), "flicker");
  const std::vector<Curve> curves = curves_of(sweep, sample_results());
  CHECK(plot_script(sweep, more, curves, "a.svg") == plot_script(sweep, sweep.plots[0], curves, "a.svg"));
}

TEST_CASE("plots on one page have parts of different names") {
  const std::string svg =
      "<?xml?>\n<svg viewBox=\"0 0 40 30\"><title>Gnuplot</title>\n<desc>by X</desc>\n<circle id='gpDot'/>"
      "<g id=\"plot\"><use xlink:href='#gpDot' fill=\"url(#gpFill)\"/></g></svg>\n";
  CHECK(plot_width(svg) == 40);
  CHECK(inline_svg(svg, "a-1") ==
        "<svg viewBox=\"0 0 40 30\" role=\"img\"><circle id='a-1-gpDot'/><g "
        "id=\"a-1-plot\"><use "
        "xlink:href='#a-1-gpDot' fill=\"url(#a-1-gpFill)\"/></g></svg>\n");
}

TEST_CASE("the page stands alone: it loads nothing, runs nothing, and no text becomes markup") {
  const TemporaryFolder folder;
  ChartPage page;
  page.facts = {{"machine", "a <b> machine"}};
  page.notes = {"Made 2 side by side."};
  page.sweeps = {{sample_sweep(), sample_results(), drawn(sample_sweep(), folder)}};
  const std::string html = chart_page(page);
  // The only addresses are names of XML's vocabularies.
  CHECK(count_of("http", html) == count_of("http://www.w3.org/", html));
  CHECK(count_of("http", html) == count_of("xmlns=\"http", html) + count_of("xmlns:xlink=\"http", html));
  for (const char* const loads :
       {"<script", "<img", "<link rel=\"stylesheet\"", "<iframe", "@import", " src=", "<b> m"}) {
    CAPTURE(loads);
    CHECK_THAT(html, !Catch::Contains(loads));
  }
  CHECK(count_of("<link", html) == 1);  // the empty icon, so that none is asked for
  CHECK_THAT(html, Catch::Contains("Cells &amp; &lt;co&gt;") && Catch::Contains("Made 2 side by side.") &&
                       Catch::Contains("28.15 (27.00..29.30)") && Catch::Contains("<td>20.00</td>"));
  CHECK_THAT(html, Catch::Contains("<b>failed</b>: build: the disk is full, &quot;really&quot; (tiny/1/1)"));
  if (!page.sweeps[0].plots[0].empty()) CHECK(count_of("<svg", html) == 2);
}

TEST_CASE("points that another program made are said to be, on the page and in Markdown") {
  const TemporaryFolder folder;
  std::vector<PointResult> results = sample_results();
  for (PointResult& result : results) result.made_by = "1.0 commit a";
  const auto texts = [&](const std::string& program) {
    ChartPage page;
    page.program = program;
    page.sweeps = {{sample_sweep(), results, {"", ""}}};
    update_markdown(folder / "results.md", page);
    return chart_page(page) + bytes_of(folder / "results.md");
  };
  CHECK(count_of("made by another program", texts("1.0 commit a")) == 0);
  CHECK(count_of("The points were made by another program: 1.0 commit a.", texts("1.0 commit b")) == 2);
  results[0].made_by = "0.9";
  CHECK(count_of("The points were made by another program: 0.9; 1.0 commit a.", texts("1.0 commit a")) == 2);
}

TEST_CASE("a page in Markdown keeps what people wrote, and has its figures once however often they are made") {
  const TemporaryFolder folder;
  const auto file =
      folder.with_file("results.md", "# Results\n\n<!-- chart cells -->\nold\n<!-- end of chart cells -->\n\nI say.\n");
  ChartPage page;
  page.sweeps = {{sample_sweep(), sample_results(), {"<svg/>", ""}}};
  update_markdown(file, page);
  const std::string text = bytes_of(file);
  CHECK_THAT(text, Catch::StartsWith("# Results\n\n<!-- chart cells -->\n**Expected**: More is better.") &&
                       Catch::EndsWith("<!-- end of chart cells -->\n\nI say.\n"));
  CHECK_THAT(text, !Catch::Contains("old") && Catch::Contains("](images/chart-cells-1.svg)") &&
                       Catch::Contains("'its' \\| own | 2 | 28.15 (27.00..29.30) |"));
  CHECK(bytes_of(folder / "images/chart-cells-1.svg") == "<svg/>");
  update_markdown(file, page);
  CHECK(bytes_of(file) == text);
  const auto fresh = folder / "fresh.md";
  update_markdown(fresh, page);
  CHECK_THAT(bytes_of(fresh), Catch::StartsWith("<!-- chart cells -->\n"));
  const auto half = folder.with_file("half.md", "<!-- chart cells -->\n");
  CHECK_THROWS_WITH(update_markdown(half, page), Catch::Contains("half.md: must have the lines"));
  CHECK(bytes_of(half) == "<!-- chart cells -->\n");
}

}  // namespace
}  // namespace lumatlas
