// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "tools/base/html_text.h"
#include "tools/score/report/error_picture.h"
#include "tools/score/report/report.h"
#include "tools/score/report/report_assets.h"

namespace lumatlas {

namespace {

std::string decimals(double value, int digits) {
  if (std::isnan(value)) {
    return "–";
  }
  if (std::isinf(value)) {
    return "∞";
  }
  char text[400];  // the largest double has 309 digits before the point
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string db(double psnr) {
  return decimals(psnr, 2);
}
std::string similarity(double ssim) {
  return decimals(ssim, 3);
}
std::string levels(double value) {
  return std::isnan(value) ? "–" : decimals(value, 2);
}
std::string percent(double share) {
  return std::isnan(share) ? "–" : decimals(100 * share, 1) + " %";
}

// For the script: "inf" and "nan" where there is no number.
std::string for_script(double value) {
  if (std::isnan(value)) {
    return "nan";
  }
  return std::isinf(value) ? "inf" : decimals(value, 6);
}

std::string count_of(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

// ---- The page's head and summary -----------------------------------------------------------------------------------

std::string protocol_sentence(const Report& report) {
  const std::string counts = count_of(report.views.size(), "view") + " are scored, " +
                             count_of(report.input_views, "other photograph") + " could be learned from.";
  if (!report.test.empty())
    return "The views of " + html_escaped(report.test) + ", none of them in the scene: " + counts;
  if (!report.protocol) return "The photographs that the scene itself names for scoring were held out: " + counts;
  const HoldOut& protocol = *report.protocol;
  if (protocol.block == 1) {
    return "Of every " + std::to_string(protocol.hold) +
           " photographs by name one was held out, so its neighbours are known: " + counts;
  }
  return "Whole runs of " + std::to_string(protocol.block) + " photographs were held out, one run of every " +
         std::to_string(protocol.hold) + ", and up to three of each run are scored as new viewpoints: " + counts;
}

std::string score_sentences(bool aligned) {
  return "<p class=\"faint\">Means over the views. <b>Frame</b>: every pixel of the photograph that its mask leaves; "
         "where the method has no picture, it is filled from its surroundings, as <code>lumatlas render</code> shows "
         "it. "
         "<b>Mesh</b>: the pixels where the mesh is seen. <b>Raw</b> is the rendering as it is; <b>fitted</b> is after "
         "one exposure gain, because the exposure of a held-out photograph is unknown; " +
         std::string(aligned ? "<b>aligned</b> is after its camera's pose, too, has been refined; " : "") +
         "<b>textured</b> is the share of these pixels that a photograph coloured.</p>\n";
}

std::string shortfall_paragraph(const Report& report) {
  const std::string sentence = shortfall_sentence(report);
  return sentence.empty() ? "" : "<p>" + sentence + "</p>\n";
}

// Figures that averages over pixels hide.
std::string continuity_table(const Report& report) {
  const bool moved = std::any_of(report.methods.begin(), report.methods.end(),
                                 [](const ReportMethod& method) { return method.flicker.has_value(); });
  std::string rows;
  for (const ReportMethod& method : report.methods) {
    if (!method.seams) continue;
    rows += "<tr><th>" + html_escaped(method.name) + "</th><td>" + levels(*method.seams) + "</td>";
    if (method.flicker) rows += "<td>" + levels(method.flicker->rms) + "</td><td>" + levels(method.flicker->worst);
    rows += method.flicker ? "</td></tr>\n" : "</tr>\n";
  }
  if (rows.empty()) return "";
  return "<div class=\"scroll\"><table class=\"summary\">\n<thead><tr><th>method</th><th>seams</th>" +
         std::string(moved ? "<th>flicker</th><th>of the worst frame</th>" : "") + "</tr></thead>\n<tbody>\n" + rows +
         "</tbody></table></div>\n<p class=\"faint\">8-bit levels. <b>Seams</b> is how much more the error steps at "
         "the borders of cells than beside them" +
         std::string(moved ? "; <b>flicker</b>, how much the error of a surface point changes from one frame of a "
                             "smooth path to the next"
                           : "") +
         ".</p>\n";
}

std::string head(const Report& report) {
  const std::string title = html_escaped(report.title);
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"generator\" content=\"lumatlas\">\n<link rel=\"icon\" href=\"data:,\">\n<title>Validation of " +
         title + "</title>\n<style>\n" + kReportStyle + "</style>\n</head>\n<body>\n<header>\n<h1>Validation of " +
         title + "</h1>\n<p>" + protocol_sentence(report) + "</p>\n</header>\n";
}

std::string facts_list(const Report& report) {
  if (report.facts.empty()) {
    return "";
  }
  std::string html = "<dl class=\"facts\">\n";
  for (const auto& [what, value] : report.facts) {
    html += "<div><dt>" + html_escaped(what) + "</dt><dd>" + html_escaped(value) + "</dd></div>\n";
  }
  return html + "</dl>\n";
}

// RegionScores or MeanScores.
template <typename AnyScores>
std::vector<double> figures(const AnyScores& scores, bool aligned) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> row = {scores.raw.psnr, scores.raw.ssim, scores.fitted.psnr, scores.fitted.ssim};
  if (aligned) {
    const Scores values = scores.aligned.value_or(Scores{kNaN, kNaN});
    row.insert(row.end(), {values.psnr, values.ssim});
  }
  row.push_back(scores.textured);
  return row;
}

// Columns alternate between PSNR and SSIM; the last one is a share.
std::string cell(double value, std::size_t column, std::size_t columns, bool best) {
  const std::string text = column + 1 == columns ? percent(value) : (column % 2 == 0 ? db(value) : similarity(value));
  return (best ? "<td class=\"best\">" : "<td>") + text + "</td>";
}

std::string table_head(bool aligned, const std::string& end_above, const std::string& end_below) {
  std::string above = "<thead><tr><th></th><th></th>";
  std::string below = "<tr><th>method</th><th>pixels</th>";
  for (const char* const group : {"raw", "fitted", "aligned"}) {
    if (aligned || group != std::string("aligned")) {
      above += "<th class=\"group\" colspan=\"2\">" + std::string(group) + "</th>";
      below += "<th>PSNR, dB</th><th>SSIM</th>";
    }
  }
  return above + "<th></th>" + end_above + "</tr>" + below + "<th>textured</th>" + end_below + "</tr></thead>\n";
}

// A row a method, with the best figure of each column marked.
std::string summary_rows(const Report& report, const std::vector<MethodScores>& means, MeanScores MethodScores::*region,
                         const std::string& pixels, bool aligned) {
  std::vector<std::vector<double>> rows;
  rows.reserve(means.size());
  for (const MethodScores& scores : means) rows.push_back(figures(scores.*region, aligned));
  std::string html;
  for (std::size_t method = 0; method < rows.size(); ++method) {
    html += "<tr><th>" + html_escaped(report.methods[method].name) + "</th><th>" + pixels + "</th>";
    for (std::size_t column = 0; column < rows[method].size(); ++column) {
      const double value = rows[method][column];
      const bool best = rows.size() > 1 && std::none_of(rows.begin(), rows.end(), [&](const std::vector<double>& row) {
                          return !(row[column] <= value) && !std::isnan(row[column]);
                        });
      html += cell(value, column, rows[method].size(), best && !std::isnan(value));
    }
    html += "<td class=\"note\">" + html_escaped(report.methods[method].description) + "</td></tr>\n";
  }
  return html;
}

std::string summary_table(const Report& report, const std::vector<MethodScores>& means, bool aligned) {
  return "<div class=\"scroll\"><table class=\"summary\">\n" + table_head(aligned, "<th></th>", "<th></th>") +
         "<tbody>\n" + summary_rows(report, means, &MethodScores::frame, "frame", aligned) + "</tbody>\n<tbody>\n" +
         summary_rows(report, means, &MethodScores::mesh, "mesh", aligned) + "</tbody></table></div>\n";
}

// Worst first: what refinement left.
std::string refinement_table(const Report& report) {
  if (report.refinements.empty()) return "";
  std::vector<ReportRefinement> rows = report.refinements;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const ReportRefinement& a, const ReportRefinement& b) { return a.residual > b.residual; });
  std::string html =
      "<details class=\"refinement\">\n<summary>Refinement of the " + count_of(rows.size(), "photograph") +
      " that were compared with others before they were stored</summary>\n<p class=\"faint\">Residuals are root mean "
      "robust squared differences from the others' medians, in sRGB values of 0 to 1: as given, after the exposure, "
      "and "
      "after the pose.</p>\n<div "
      "class=\"scroll\"><table>\n<thead><tr><th>photograph</th><th>decision</th><th>given</th>"
      "<th>exposed</th><th>refined</th><th>moved, px</th><th>exposure, EV</th></tr></thead>\n<tbody>\n";
  for (const ReportRefinement& row : rows) {
    html += "<tr><th>" + html_escaped(row.name) + "</th><td>" + html_escaped(row.decision) + "</td><td>" +
            decimals(row.residual_given, 4) + "</td><td>" + decimals(row.residual_exposed, 4) + "</td><td>" +
            decimals(row.residual, 4) + "</td><td>" + decimals(row.moved_px, 2) + "</td><td>" +
            decimals(row.exposure_ev, 2) + "</td></tr>\n";
  }
  return html + "</tbody></table></div>\n</details>\n";
}

// ---- The spread over views -----------------------------------------------------------------------------------------

struct Axis {
  double low = 0;
  double high = 1;
  double step = 1;
  [[nodiscard]] std::string place(double value) const {  // in CSS; infinity at the right end
    return decimals(100 * std::clamp((value - low) / (high - low), 0.0, 1.0), 2) + "%";
  }
};

// Whole multiples of a step of 1, 2, 5, 10, 20 ... that makes eight intervals or fewer.
Axis axis_for(const Report& report) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const ReportView& view : report.views) {
    for (const ReportRendering& rendering : view.renderings) {
      if (const double psnr = rendering.scores.frame.fitted.psnr; std::isfinite(psnr)) {
        low = std::min(low, psnr);
        high = std::max(high, psnr);
      }
    }
  }
  if (low > high) {
    return {0, 1, 1};
  }
  const auto fitting = [&](double step) {
    const double first = std::floor(low / step) * step;
    return Axis{first, std::max(std::ceil(high / step) * step, first + step), step};
  };
  Axis axis = fitting(1);
  for (double decade = 1; axis.high - axis.low > 8 * axis.step; decade *= 10) {
    for (const double step : {decade, 2 * decade, 5 * decade}) {
      if (axis.high - axis.low > 8 * axis.step) {
        axis = fitting(step);
      }
    }
  }
  return axis;
}

std::string dots(const Report& report, std::size_t method, const Axis& axis) {
  std::string html;
  for (std::size_t i = 0; i < report.views.size(); ++i) {
    const double psnr = report.views[i].renderings[method].scores.frame.fitted.psnr;
    if (!std::isnan(psnr)) {
      const std::string label = "\"" + html_escaped(report.views[i].name) + ": " + db(psnr) + " dB\"";
      html += "<a href=\"#view" + std::to_string(i) + "\"";
      html += " title=" + label;
      html += " aria-label=" + label;
      html += " style=\"left:" + axis.place(psnr) + "\"></a>";
    }
  }
  return html;
}

std::string spread(const Report& report, const std::vector<MethodScores>& means) {
  const Axis axis = axis_for(report);
  std::string html = "<h2>Fitted PSNR of the frame, view by view</h2>\n<div class=\"spread\">\n";
  for (std::size_t method = 0; method < means.size(); ++method) {
    html += "<div class=\"strip\"><span>" + html_escaped(report.methods[method].name) + "</span><div class=\"track\">" +
            dots(report, method, axis);
    if (const double mean = means[method].frame.fitted.psnr; !std::isnan(mean)) {
      html += "<i title=\"mean: " + db(mean) + " dB\" style=\"left:" + axis.place(mean) + "\"></i>";
    }
    html += "</div></div>\n";
  }
  html += "<div class=\"strip\"><span></span><div class=\"axis\">";
  for (double tick = axis.low; tick <= axis.high + axis.step / 2; tick += axis.step) {
    const std::string unit = tick + axis.step / 2 > axis.high ? " dB" : "";
    html += "<span style=\"left:" + axis.place(tick) + "\">" + decimals(tick, 0) + unit + "</span>";
  }
  return html + "</div></div>\n</div>\n<p class=\"faint\">A dot is a view and leads to it; the line is the mean.</p>\n";
}

// ---- The views -----------------------------------------------------------------------------------------------------

std::string css_color(const std::array<std::uint8_t, 3>& color) {
  char text[8];
  std::snprintf(text, sizeof(text), "#%02x%02x%02x", unsigned{color[0]}, unsigned{color[1]}, unsigned{color[2]});
  return text;
}

std::string legend() {
  constexpr int kStops = 32;
  std::string ramp;
  for (int stop = 0; stop <= kStops; ++stop) {
    ramp.append(",").append(css_color(error_color(kErrorFullScale * stop / kStops)));
  }
  return "<div class=\"legend\">error of the fitted frame, in levels of 255: <span>0</span><span class=\"ramp\" "
         "style=\"background:linear-gradient(90deg" +
         ramp + ")\"></span><span>" + decimals(kErrorFullScale, 0) +
         " or more</span><span class=\"swatch\" style=\"background:" + css_color(kNotScoredColor) +
         "\"></span><span>not scored</span></div>\n";
}

std::string bar(const Report& report) {
  std::string html = "<div class=\"bar\">\n<div class=\"choice needs-script\" id=\"method\">";
  for (const ReportMethod& method : report.methods) {
    html += "<button type=\"button\" title=\"" + html_escaped(method.description) + "\">" + html_escaped(method.name) +
            "</button>";
  }
  html +=
      "</div>\n<label class=\"needs-script\">order <select id=\"order\"><option value=\"worst\">worst first</option>"
      "<option value=\"best\">best first</option><option value=\"name\">by name</option></select></label>\n"
      "<label class=\"needs-script\">by <select id=\"score\"><option value=\"fitted\">fitted PSNR</option>"
      "<option value=\"raw\">raw PSNR</option><option value=\"ssim\">fitted SSIM</option>"
      "<option value=\"textured\">textured share</option>"
      "<option value=\"mesh\">fitted PSNR of the mesh</option></select></label>\n";
  return html + legend() + "</div>\n";
}

std::string figure(const ReportView& view, const std::string& kind, const std::string& path,
                   const std::string& caption) {
  const std::string width = std::to_string(view.width);
  const std::string height = std::to_string(view.height);
  const std::string text = "<figcaption>" + caption + "</figcaption></figure>\n";
  if (path.empty()) {
    return "<figure><div class=\"none\" style=\"aspect-ratio:" + width + "/" + height + "\">no picture</div>" + text;
  }
  return "<figure><a data-kind=\"" + kind + "\" href=\"" + url_of(path) + "\"><img loading=\"lazy\" width=\"" + width +
         "\" height=\"" + height + "\" alt=\"" + kind + " of " + html_escaped(view.name) + "\" src=\"" + url_of(path) +
         "\"></a>" + text;
}

std::string aligned_pictures(const ReportView& view, const ReportRendering& rendering, const std::string& name,
                             std::size_t method) {
  if (rendering.aligned_picture.empty()) return "";
  return "<div class=\"row\" data-method=\"" + std::to_string(method) + "\">\n" +
         figure(view, "photograph", view.photograph, "photograph") +
         figure(view, "rendering", rendering.aligned_picture, "aligned rendering, " + name) +
         figure(view, "error", rendering.aligned_error, "aligned error, " + name) + "</div>\n";
}

std::string pictures(const Report& report, const ReportView& view, std::size_t method) {
  const ReportRendering& rendering = view.renderings[method];
  const std::string name = html_escaped(report.methods[method].name);
  return "<div class=\"row\" data-method=\"" + std::to_string(method) + "\">\n" +
         figure(view, "photograph", view.photograph, "photograph") +
         figure(view, "rendering", rendering.picture, "rendering, " + name) +
         figure(view, "error", rendering.error,
                "error, " + name + ", after a gain of " + decimals(rendering.scores.frame.gain, 3)) +
         "</div>\n" + aligned_pictures(view, rendering, name, method);
}

std::string view_row(const RegionScores& scores, std::size_t method, const std::string& name, const std::string& pixels,
                     bool aligned) {
  const std::vector<double> row = figures(scores, aligned);
  std::string html =
      "<tr data-method=\"" + std::to_string(method) + "\"><th>" + html_escaped(name) + "</th><th>" + pixels + "</th>";
  for (std::size_t column = 0; column < row.size(); ++column) html += cell(row[column], column, row.size(), false);
  return html + "<td>" + decimals(scores.gain, 3) + "</td></tr>\n";
}

std::string view_table(const Report& report, const ReportView& view, bool aligned) {
  std::string html =
      "<div class=\"scroll\"><table>\n" + table_head(aligned, "<th></th>", "<th>gain</th>") + "<tbody>\n";
  for (std::size_t method = 0; method < report.methods.size(); ++method) {
    const ViewScores& scores = view.renderings[method].scores;
    const std::string& name = report.methods[method].name;
    html +=
        view_row(scores.frame, method, name, "frame", aligned) + view_row(scores.mesh, method, name, "mesh", aligned);
  }
  return html + "</tbody></table></div>\n";
}

template <typename Value>
std::string data_attribute(const std::string& key, const ReportView& view, Value value) {
  std::string html = " data-" + key + "=\"";
  for (const ReportRendering& rendering : view.renderings) {
    html += (html.back() == '"' ? "" : " ") + for_script(value(rendering.scores));
  }
  return html + "\"";
}

std::string article(const Report& report, std::size_t index, bool aligned) {
  const ReportView& view = report.views[index];
  const std::string id = "view" + std::to_string(index);
  std::string html = "<article id=\"" + id + "\" class=\"" + (view.height > view.width ? "portrait" : "landscape") +
                     "\" data-rank=\"" + std::to_string(index) + "\" data-name=\"" + html_escaped(view.name) + "\"" +
                     data_attribute("fitted", view, [](const ViewScores& s) { return s.frame.fitted.psnr; }) +
                     data_attribute("raw", view, [](const ViewScores& s) { return s.frame.raw.psnr; }) +
                     data_attribute("ssim", view, [](const ViewScores& s) { return s.frame.fitted.ssim; }) +
                     data_attribute("textured", view, [](const ViewScores& s) { return s.frame.textured; }) +
                     data_attribute("mesh", view, [](const ViewScores& s) { return s.mesh.fitted.psnr; }) + ">\n";
  html += "<h3><a href=\"#" + id + "\">" + html_escaped(view.name) + "</a></h3>\n" + view_table(report, view, aligned);
  for (std::size_t method = 0; method < report.methods.size(); ++method) {
    html += pictures(report, view, method);
  }
  return html + "</article>\n";
}

// Ranks of the views, worst first by the first method; views without a score last.
std::vector<std::size_t> worst_first(const Report& report) {
  std::vector<std::size_t> order(report.views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t rank) {
    const double psnr = report.views[rank].renderings[0].scores.frame.fitted.psnr;
    return std::pair(std::isnan(psnr), std::isnan(psnr) ? 0 : psnr);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

std::string viewer() {
  return "<dialog aria-label=\"comparison\"><img alt=\"\"><div><span></span>"
         "<button type=\"button\" data-kind=\"photograph\">photograph</button>"
         "<button type=\"button\" data-kind=\"rendering\">rendering</button>"
         "<button type=\"button\" data-kind=\"error\">error</button>"
         "<button type=\"button\" class=\"close\">close</button></div></dialog>\n";
}

}  // namespace

std::string report_page(const Report& report) {
  check(report);
  const std::vector<MethodScores> means = method_means(report);
  const bool aligned = std::any_of(means.begin(), means.end(),
                                   [](const MethodScores& scores) { return scores.frame.aligned.has_value(); });
  std::string html = head(report) + facts_list(report) + summary_table(report, means, aligned) +
                     shortfall_paragraph(report) + score_sentences(aligned) + continuity_table(report) +
                     spread(report, means) + refinement_table(report) + "<h2>Held-out views</h2>\n" +
                     "<p class=\"faint needs-script\">Click a picture to compare it with the others in place.</p>\n" +
                     bar(report) + "<main id=\"views\">\n";
  for (const std::size_t index : worst_first(report)) {
    html += article(report, index, aligned);
  }
  return html + "</main>\n" + viewer() + "<script>\n" + kReportScript + "</script>\n</body>\n</html>\n";
}

}  // namespace lumatlas
