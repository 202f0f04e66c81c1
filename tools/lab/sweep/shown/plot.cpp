// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/shown/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>

#include "mesh/base/errors.h"
#include "mesh/base/pending_file.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/child_process.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Pixels of the drawing.
constexpr int kPanelWidth = 440, kPanelHeight = 300, kMostColumns = 3;
constexpr int kLeft = 88, kRight = 18, kTop = 32, kBottom = 56;  // around the axes of a panel
constexpr int kKeyRow = 20;

// A quote ends a text of gnuplot, two are one within it.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

std::string number(double value) {
  return nlohmann::json(value).dump();
}

struct Sample {
  double x = 0;
  Repeated y;
};

// One plot of a sweep.
class Drawing {
 public:
  Drawing(const Sweep& sweep, const SweepPlot& plot, const std::vector<Curve>& curves)
      : sweep_(sweep), plot_(plot), curves_(curves) {
    std::set<std::string> shown;
    for (std::size_t scene = 0; scene < sweep.scenes.size(); ++scene) {
      const std::size_t before = scenes_.size();
      for (const std::string& y : plot.y) {
        if (!has_samples(scene, y)) continue;
        shown.insert(y);
        if (scenes_.size() == before) scenes_.push_back(scene);
      }
    }
    std::erase_if(plot_.y, [&](const std::string& y) { return !shown.contains(y); });
    for (const SweepSeries& series : sweep.series) {
      for (const SweepValue& value : series.values) {
        if (std::find(labels_.begin(), labels_.end(), value.label) == labels_.end()) labels_.push_back(value.label);
      }
    }
  }

  [[nodiscard]] std::string script(const fs::path& svg) const;

 private:
  // The grid of panels: scenes beside each other and metrics below, or the metrics of a single scene beside each other.
  [[nodiscard]] bool is_of_one_scene() const { return scenes_.size() == 1; }
  [[nodiscard]] int across() const { return static_cast<int>(is_of_one_scene() ? plot_.y.size() : scenes_.size()); }
  [[nodiscard]] int columns() const { return std::min(kMostColumns, across()); }
  [[nodiscard]] int rows() const {
    const int blocks = (across() + kMostColumns - 1) / kMostColumns;
    return is_of_one_scene() ? blocks : blocks * static_cast<int>(plot_.y.size());
  }
  [[nodiscard]] std::size_t key_entries() const {
    return sweep_.series.size() + plot_.lines.size() + (plot_.front ? 1 : 0);
  }
  [[nodiscard]] int key_columns() const;
  [[nodiscard]] int key_rows() const { return (static_cast<int>(key_entries()) + key_columns() - 1) / key_columns(); }
  [[nodiscard]] int key_height() const { return kKeyRow * key_rows() + 16; }
  [[nodiscard]] std::optional<double> x_of(const Curve& curve, std::size_t value) const;
  [[nodiscard]] std::vector<Sample> samples(const Curve& curve, const std::string& y) const;
  [[nodiscard]] bool has_samples(std::size_t scene, const std::string& y) const;
  [[nodiscard]] std::string style(std::size_t series) const;
  [[nodiscard]] std::string line_style(std::size_t series) const {
    const std::string whole = style(series);
    return whole.substr(0, whole.find(" pt "));
  }
  [[nodiscard]] std::string title(std::size_t series) const;
  // The marks of the x axis, where each value has its own; none where they are numbers or too many.
  [[nodiscard]] std::map<double, std::string> labelled_ticks() const;
  // The height of labels that have no room beside each other and are slanted; 0 if they have room.
  [[nodiscard]] int slanted_height() const;
  [[nodiscard]] int panel_height() const { return kPanelHeight + slanted_height(); }
  [[nodiscard]] std::string ticks() const;
  [[nodiscard]] std::string front(std::size_t scene, const std::string& y) const;
  [[nodiscard]] std::string panel(std::size_t scene, std::size_t y, int row, int column, bool is_last) const;
  [[nodiscard]] std::string plot_command(std::size_t scene, const std::string& y, std::string& data,
                                         bool is_last) const;

  const Sweep& sweep_;
  SweepPlot plot_;  // without metrics of which there is nothing to show
  const std::vector<Curve>& curves_;
  std::vector<std::size_t> scenes_;  // that have anything to show
  std::vector<std::string> labels_;  // of all values, in the order of their appearance
};

std::optional<double> Drawing::x_of(const Curve& curve, std::size_t value) const {
  const SweepValue& swept = sweep_.series[curve.series].values[value];
  if (plot_.x == "value") return swept.x;
  if (plot_.x == "label") {
    return static_cast<double>(std::find(labels_.begin(), labels_.end(), swept.label) - labels_.begin());
  }
  const auto found = curve.values[value].find(plot_.x);
  return found == curve.values[value].end() ? std::nullopt : std::optional(found->second.mean);
}

std::vector<Sample> Drawing::samples(const Curve& curve, const std::string& y) const {
  std::vector<Sample> samples;
  for (std::size_t value = 0; value < curve.values.size(); ++value) {
    const auto found = curve.values[value].find(y);
    const std::optional<double> x = x_of(curve, value);
    if (!x || found == curve.values[value].end()) continue;
    if ((plot_.log_x && !(*x > 0)) || (plot_.log_y && !(found->second.least > 0))) continue;
    samples.push_back({*x, found->second});
  }
  return samples;
}

bool Drawing::has_samples(std::size_t scene, const std::string& y) const {
  return std::any_of(curves_.begin(), curves_.end(),
                     [&](const Curve& curve) { return curve.scene == scene && !samples(curve, y).empty(); });
}

// The legend puts as many entries into a row as there is room for the longest.
int Drawing::key_columns() const {
  constexpr int kLetter = 8, kSample = 60;
  std::size_t longest = plot_.front ? 12 : 1;
  for (std::size_t i = 0; i < sweep_.series.size(); ++i) longest = std::max(longest, title(i).size());
  for (const SweepLine& line : plot_.lines) longest = std::max(longest, line.label.size());
  const int fit = columns() * kPanelWidth / (kLetter * static_cast<int>(longest) + kSample);
  return std::clamp(fit, 1, static_cast<int>(key_entries()));
}

std::string Drawing::style(std::size_t series) const {
  constexpr std::array kColors = {"#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#444444", "#8C510A", "#762A83"};
  constexpr std::array kPoints = {5, 9, 13, 11, 15, 2, 3};
  switch (sweep_.series[series].mark) {
    case SweepSeries::Mark::is_default:
      return "lc rgb '#0072B2' lw 3 pt 7 ps 0.8";
    case SweepSeries::Mark::printed:
      return "lc rgb '#D55E00' lw 2 dt (8,4) pt 4 ps 0.9";
    case SweepSeries::Mark::none:
      break;
  }
  std::size_t rank = 0;  // among those without a mark
  for (std::size_t i = 0; i < series; ++i) rank += sweep_.series[i].mark == SweepSeries::Mark::none ? 1 : 0;
  return std::string("lc rgb '") + kColors[rank % kColors.size()] + "' lw 1.6 pt " +
         std::to_string(kPoints[rank % kPoints.size()]) + " ps 0.8";
}

std::string Drawing::title(std::size_t series) const {
  const std::string& label = sweep_.series[series].label;
  switch (sweep_.series[series].mark) {
    case SweepSeries::Mark::is_default:
      return label == "default" ? label : label + " (default)";
    case SweepSeries::Mark::printed:
      return label + " (the paper's)";
    case SweepSeries::Mark::none:
      break;
  }
  return label;
}

// Marks at 1, 2 and 5 times each power of ten: gnuplot's own are none but the powers, of which a panel may have only
// one.
std::string log_ticks() {
  std::string list;
  for (int exponent = -9; exponent <= 12; ++exponent) {
    for (const int digit : {1, 2, 5}) {
      const std::string at = std::to_string(digit) + "e" + std::to_string(exponent);
      list += (list.empty() ? "" : ", ") + ("'%g' " + at);
    }
  }
  return "set xtics (" + list + ")\n";
}

std::map<double, std::string> Drawing::labelled_ticks() const {
  constexpr std::size_t kMostTicks = 14;
  const bool has_labels = plot_.x == "label" || (plot_.x == "value" && plot_.log_x);
  std::map<double, std::string> ticks;
  if (!has_labels || labels_.size() > kMostTicks) return ticks;
  for (const Curve& curve : curves_) {
    for (std::size_t value = 0; value < curve.values.size(); ++value) {
      if (const auto x = x_of(curve, value)) ticks.emplace(*x, sweep_.series[curve.series].values[value].label);
    }
  }
  return ticks;
}

int Drawing::slanted_height() const {
  constexpr std::size_t kLettersInRow = 52;
  constexpr double kRisePerLetter = 3.2;
  std::size_t letters = 0, longest = 0;
  for (const auto& [x, label] : labelled_ticks()) {
    letters += label.size() + 2;
    longest = std::max(longest, label.size());
  }
  return letters > kLettersInRow ? static_cast<int>(kRisePerLetter * static_cast<double>(longest)) : 0;
}

std::string Drawing::ticks() const {
  const std::map<double, std::string> labelled = labelled_ticks();
  if (labelled.empty()) {
    return std::string("set xtics autofreq norotate offset 0,0.3\n") + (plot_.log_x ? log_ticks() : "");
  }
  std::string list;
  for (const auto& [x, label] : labelled) list += (list.empty() ? "" : ", ") + quoted(label) + " " + number(x);
  // Slanted ones end at their ticks, so that none runs over the drawing's right edge.
  return std::string("set xtics ") + (slanted_height() > 0 ? "rotate by 25 right " : "norotate offset 0,0.3 ") + "(" +
         list + ")\n";
}

std::string Drawing::front(std::size_t scene, const std::string& y) const {
  std::vector<std::pair<double, double>> points;
  for (const OnFront& on : front_of(curves_, scene, plot_.x, y)) {
    const auto& figures = curves_[on.curve].values[on.value];
    points.emplace_back(figures.at(plot_.x).mean, figures.at(y).mean);
  }
  std::sort(points.begin(), points.end());
  std::string lines;
  for (const auto& [at, height] : points) lines += number(at) + " " + number(height) + "\n";
  return lines;
}

// `data` grows by the blocks that the command names. The last panel's key tells all series, shown in it or not.
std::string Drawing::plot_command(std::size_t scene, const std::string& y, std::string& data, bool is_last) const {
  std::vector<std::string> parts;
  const auto block = [&](const std::string& lines) {
    std::string name = "$block" + std::to_string(parts.size());
    data += name + " << EOD\n" + lines + "EOD\n";
    return name;
  };
  const auto titled = [&](const std::string& text) { return is_last ? " title " + quoted(text) : " notitle"; };
  if (plot_.front) {
    const std::string lines = front(scene, y);
    const std::string what = lines.empty() ? "NaN" : block(lines) + " using 1:2";
    parts.push_back(what + " with linespoints lc rgb '#c9ced3' lw 9 pt 7 ps 2.2" + titled("Pareto front"));
  }
  double least = 0, most = 0;  // of all y, for lines across
  bool first = true;
  for (const Curve& curve : curves_) {
    if (curve.scene != scene) continue;
    const std::vector<Sample> shown = samples(curve, y);
    std::string lines;
    bool has_spread = false;
    for (const Sample& sample : shown) {
      lines += number(sample.x) + " " + number(sample.y.mean) + " " + number(sample.y.least) + " " +
               number(sample.y.most) + "\n";
      has_spread = has_spread || sample.y.runs > 1;
      least = first ? sample.y.least : std::min(least, sample.y.least);
      most = first ? sample.y.most : std::max(most, sample.y.most);
      first = false;
    }
    if (is_last) parts.push_back("NaN with linespoints " + style(curve.series) + titled(title(curve.series)));
    if (shown.empty()) continue;
    const std::string name = block(lines);
    if (has_spread)
      parts.push_back(name + " using 1:2:3:4 with yerrorbars " + line_style(curve.series) + " ps 0 notitle");
    parts.push_back(name + " using 1:2 with linespoints " + style(curve.series) + " notitle");
  }
  for (const SweepLine& line : plot_.lines) {
    const std::string at = number(line.at);
    std::string what = at;
    if (line.on_x) {
      std::string ends = at;
      ends += " " + number(least) + "\n" + at + " " + number(most) + "\n";
      what = block(ends) + " using 1:2";
    }
    parts.push_back(what + " with lines lc rgb '#777777' lw 1.3 dt (2,3)" + titled(line.label));
  }
  std::string command = "plot ";
  for (std::size_t i = 0; i < parts.size(); ++i) command += (i == 0 ? "" : ", \\\n  ") + parts[i];
  return command + "\n";
}

std::string Drawing::panel(std::size_t scene, std::size_t y, int row, int column, bool is_last) const {
  const double width = columns() * kPanelWidth, height = rows() * panel_height() + key_height();
  const auto margin = [](const char* side, double share) {
    return std::string("set ") + side + "margin at screen " + number(share) + "\n";
  };
  const double top = height - row * panel_height(), bottom = top - panel_height();
  std::string script = margin("l", (column * kPanelWidth + kLeft) / width) +
                       margin("r", ((column + 1) * kPanelWidth - kRight) / width) + margin("t", (top - kTop) / height) +
                       margin("b", (bottom + kBottom + slanted_height()) / height);
  script += "set title " + quoted(sweep_.scenes[scene].name) + " font ',13' offset 0,-0.4\n";
  const Metric* const x = find_metric(plot_.x);
  script += "set xlabel " + quoted(x == nullptr ? sweep_.label : x->label) + " offset 0,0.3\n";
  script += "set ylabel " + quoted(find_metric(plot_.y[y])->label) + " offset 0.6,0\n";
  script += is_last ? "set key at screen 0.5,0.01 center bottom vertical maxrows " + std::to_string(key_rows()) + "\n"
                    : "unset key\n";
  std::string data;
  const std::string command = plot_command(scene, plot_.y[y], data, is_last);
  return script + data + command;
}

std::string Drawing::script(const fs::path& svg) const {
  if (scenes_.empty()) return "";
  const int width = columns() * kPanelWidth, height = rows() * panel_height() + key_height();
  std::string script =
      "set encoding utf8\nset terminal svg size " + std::to_string(width) + "," + std::to_string(height) +
      " dynamic noenhanced font 'DejaVu Sans,12' background rgb 'white'\nset output " + quoted(svg.string()) +
      "\nset autoscale xfix\nset border 3 lc rgb '#555555'\nset tics nomirror out scale 0.5 textcolor rgb '#333333'\n"
      "set grid lc rgb '#e4e6e8' lw 1 dt 1\nset offsets graph 0.04, graph 0.04, graph 0.06, graph "
      "0.06\nset key Left reverse samplen 3 spacing 1.1 width 1\n";
  if (plot_.log_x) script += "set logscale x\n";
  if (plot_.log_y) script += "set logscale y\n";
  script += ticks() + "set multiplot\n";
  std::vector<std::pair<std::size_t, std::size_t>> panels;  // scene and metric, as ranks; those with anything to show
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    for (std::size_t y = 0; y < plot_.y.size(); ++y) {
      if (has_samples(scenes_[i], plot_.y[y])) panels.emplace_back(i, y);
    }
  }
  for (const auto& [i, y] : panels) {
    const int place = static_cast<int>(is_of_one_scene() ? y : i), block = place / kMostColumns;
    const int row = is_of_one_scene() ? block : block * static_cast<int>(plot_.y.size()) + static_cast<int>(y);
    script += panel(scenes_[i], y, row, place % kMostColumns, std::pair(i, y) == panels.back());
  }
  return script + "unset multiplot\n";
}

}  // namespace

std::string plot_script(const Sweep& sweep, const SweepPlot& plot, const std::vector<Curve>& curves,
                        const fs::path& svg) {
  return Drawing(sweep, plot, curves).script(svg);
}

void draw_plot(const fs::path& gnuplot, const std::string& script, const fs::path& svg) {
  fs::path commands = svg, out = svg, err = svg;
  commands.replace_extension(".gnuplot");
  out += ".out";
  err += ".err";
  PendingFile pending(svg);
  std::string text = script;
  const std::size_t at = text.find(quoted(svg.string()));
  if (at != std::string::npos) text.replace(at, quoted(svg.string()).size(), quoted(pending.path().string()));
  {
    AtomicFile file(commands);
    file.stream() << text;
    file.commit();
  }
  const int status = run_to_end({gnuplot, {"-d", commands.string()}, out, err});
  std::ifstream words(err);
  const std::string said{std::istreambuf_iterator<char>(words), {}};
  for (const fs::path& file : {commands, out, err}) fs::remove(file);
  if (status != 0) {
    std::string line = said.substr(0, said.find_last_not_of('\n') + 1);
    std::replace(line.begin(), line.end(), '\n', ' ');
    throw InputError(svg.string() + ": gnuplot cannot draw it: " + line);
  }
  if (fs::file_size(pending.path()) == 0) throw InputError(svg.string() + ": gnuplot has drawn nothing");
  pending.commit();
}

int plot_width(const std::string& svg) {
  std::smatch size;
  return std::regex_search(svg, size, std::regex("viewBox=\"0 0 ([0-9]{1,6}) ")) ? std::stoi(size[1]) : kPanelWidth;
}

std::string inline_svg(std::string svg, const std::string& prefix) {
  svg.erase(0, svg.find("<svg"));
  svg = std::regex_replace(svg, std::regex("viewBox=\"[^\"]*\""), "$& role=\"img\"",
                           std::regex_constants::format_first_only);
  svg = std::regex_replace(svg, std::regex("<title>Gnuplot</title>\\s*<desc>[^<]*</desc>\\s*"), "");
  svg = std::regex_replace(svg, std::regex("\\bid=(['\"])"), "id=$1" + prefix + "-");
  svg = std::regex_replace(svg, std::regex("href=(['\"])#"), "href=$1#" + prefix + "-");
  return std::regex_replace(svg, std::regex("url\\(#"), "url(#" + prefix + "-");
}

}  // namespace lumatlas
