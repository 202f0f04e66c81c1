// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/shown/markdown.h"

#include <fstream>
#include <iterator>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tools/base/output_folder.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// The text as a cell of a table.
std::string cell_text(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

std::string table(const std::vector<TextRow>& rows) {
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const std::string& cell : rows[i]) text += "| " + cell_text(cell) + " ";
    text += "|\n";
    if (i > 0) continue;
    for (std::size_t column = 0; column < rows[i].size(); ++column) text += "|---";
    text += "|\n";
  }
  return text;
}

void write_text(const fs::path& path, const std::string& text) {
  AtomicFile file(path);
  file.stream() << text;
  file.commit();
}

std::string image_name(const Sweep& sweep, std::size_t plot) {
  return "chart-" + sweep.name + "-" + std::to_string(plot + 1) + ".svg";
}

std::string block(const SweepReport& report, const ChartPage& page) {
  const Sweep& sweep = report.sweep;
  const std::vector<Curve> curves = curves_of(sweep, report.results);
  std::string text =
      "**Expected**" + (sweep.source.empty() ? "" : " (" + sweep.source + ")") + ": " + sweep.expected + "\n";
  for (std::size_t i = 0; i < sweep.plots.size(); ++i) {
    const SweepPlot& plot = sweep.plots[i];
    if (report.plots[i].empty()) continue;
    const std::string& title = plot.title.empty() ? sweep.title : plot.title;
    text += "\n![" + title + "](images/" + image_name(sweep, i) + ")\n";
    for (const std::string& sentence : front_sentences(sweep, plot, curves)) text += "\n- " + sentence;
    text += plot.front ? "\n" : "";
  }
  for (const std::string& sentence : breaking_sentences(sweep, curves)) text += "\n- " + sentence;
  text += sweep.breaking ? "\n" : "";
  for (std::size_t scene = 0; scene < sweep.scenes.size(); ++scene) {
    const std::vector<TextRow> rows = results_table(sweep, curves, scene);
    if (rows.size() > 1) text += "\n" + sweep.scenes[scene].name + ":\n\n" + table(rows);
  }
  const std::string makers = makers_sentence(report.results, page.program);
  text += makers.empty() ? "\n*" : "\n*" + makers + "*\n\n*";
  for (std::size_t i = 0; i < page.facts.size(); ++i) {
    text += (i == 0 ? "" : "; ") + page.facts[i].first + ": " + page.facts[i].second;
  }
  return text + "*\n";
}

void replace_block(std::string& text, const std::string& name, const std::string& block, const fs::path& file) {
  const std::string begin = "<!-- chart " + name + " -->\n", end = "<!-- end of chart " + name + " -->\n";
  const std::size_t from = text.find(begin), to = text.find(end);
  if (from == std::string::npos && to == std::string::npos) {
    text += (text.empty() ? "" : "\n") + begin + block + end;
    return;
  }
  if (from == std::string::npos || to == std::string::npos || to < from) {
    throw InputError(file.string() + ": must have the lines " + begin.substr(0, begin.size() - 1) + " and " +
                     end.substr(0, end.size() - 1) + ", in this order, or neither");
  }
  text.replace(from + begin.size(), to - from - begin.size(), block);
}

}  // namespace

void update_markdown(const fs::path& file, const ChartPage& page) {
  std::string text;
  std::error_code error;
  const bool is_new = !fs::exists(file, error) || (fs::is_regular_file(file, error) && fs::file_size(file, error) == 0);
  if (!is_new) text = read_whole_file(file);
  const fs::path images = fs::absolute(file).parent_path() / "images";
  fs::create_directories(images, error);
  if (error) throw InputError(images.string() + ": cannot be made: " + error.message());
  for (const SweepReport& report : page.sweeps) {
    for (std::size_t i = 0; i < report.plots.size(); ++i) {
      if (!report.plots[i].empty()) write_text(images / image_name(report.sweep, i), report.plots[i]);
    }
    replace_block(text, report.sweep.name, block(report, page), file);
  }
  write_text(file, text);
}

}  // namespace lumatlas
