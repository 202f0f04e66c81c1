// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/sweep.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/strict_json.h"
#include "tools/lab/sweep/metrics.h"

namespace lumatlas {

namespace {

using nlohmann::json;

void overlay(OptionValues& options, const OptionValues& over) {
  for (const auto& [name, value] : over) options[name] = value;
}

OptionValues& options_of(CommandOptions& options, const std::string& command) {
  if (command == "synth") return options.synth;
  if (command == "mesh") return options.mesh;
  return command == "build" ? options.build : options.validate;
}

bool is_name(const std::string& text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

std::string name_of_file(const JsonPlace& place) {
  std::string name = place.text();
  if (!is_name(name)) place.refuse("is \"" + name + "\", must be of a-z, 0-9 and '-', because files are called so");
  return name;
}

// Reads one file; the members are the steps, from the inside of the description to its outside.
class SweepReader {
 public:
  SweepReader(SweepScale scale, const KnowsOption& knows_option) : scale_(scale), knows_option_(knows_option) {}

  [[nodiscard]] Sweep sweep(const JsonPlace& file) const;

 private:
  // The option or setting that a swept value sets if it is not an object.
  struct SweptOption {
    std::string command, name;  // empty: nothing
  };

  [[nodiscard]] JsonPlace at_scale(const JsonPlace& place) const;
  void check_option(const std::string& command, const std::string& name, const JsonPlace& place) const;
  [[nodiscard]] static OptionValue option_value(const std::string& name, const JsonPlace& place);
  [[nodiscard]] OptionValues option_values(const std::string& command, const JsonPlace& place) const;
  [[nodiscard]] CommandOptions command_options(const JsonPlace& place) const;
  [[nodiscard]] SweptOption swept_option(const JsonPlace& place) const;
  [[nodiscard]] SweepValue value(const JsonPlace& place, const SweptOption& option) const;
  [[nodiscard]] std::vector<SweepValue> values(const JsonPlace& place, const SweptOption& option) const;
  [[nodiscard]] std::vector<SweepSeries> series(const JsonPlace& file) const;
  [[nodiscard]] SweepScene scene(const JsonPlace& place) const;
  [[nodiscard]] std::vector<SweepScene> scenes(const JsonPlace& place) const;

  SweepScale scale_;
  const KnowsOption& knows_option_;
};

JsonPlace SweepReader::at_scale(const JsonPlace& place) const {
  place.expect_keys({"small", "full"}, {"medium"});
  const bool falls_back = scale_ == SweepScale::medium && !place.has("medium");
  return place.at(name_of(falls_back ? SweepScale::full : scale_));
}

void SweepReader::check_option(const std::string& command, const std::string& name, const JsonPlace& place) const {
  constexpr std::array kOwn = {"output", "json", "quiet", "help", "help-all", "set"};
  if (std::find(kOwn.begin(), kOwn.end(), name) != kOwn.end() ||
      (command == "validate" && (name == "views" || name == "no-pictures"))) {
    place.refuse("--" + name + " is for `lumatlas chart` to give");
  }
  if (knows_option_(command, name)) return;
  place.refuse("`lumatlas " + command + "` has no " + (is_setting(name) ? "setting " : "option --") + name);
}

OptionValue SweepReader::option_value(const std::string& name, const JsonPlace& place) {
  const json& value = place.value();
  if (value.is_null()) return {.given = false, .text = {}};
  if (value.is_boolean() && is_setting(name)) return {.given = true, .text = value.get<bool>() ? "on" : "off"};
  if (value.is_boolean()) return {.given = value.get<bool>(), .text = {}};
  if (value.is_number()) return {.given = true, .text = value.dump()};
  if (value.is_string()) return {.given = true, .text = place.text()};
  if (!value.is_array()) place.refuse("must be a number, a text, true, false or a list of these");
  std::string list;
  for (const JsonPlace& element : place.elements()) {
    const bool is_list = element.value().is_array();
    const std::optional<std::string> text = is_list ? std::nullopt : option_value(name, element).text;
    if (!text) element.refuse("must be a number or a text");
    list += (list.empty() ? "" : ",") + *text;
  }
  return {.given = true, .text = list};
}

OptionValues SweepReader::option_values(const std::string& command, const JsonPlace& place) const {
  OptionValues options;
  for (const auto& [name, member] : place.members()) {
    if (command == "synth" && name == "kind") continue;
    check_option(command, name, member);
    options[name] = option_value(name, member);
  }
  return options;
}

CommandOptions SweepReader::command_options(const JsonPlace& place) const {
  CommandOptions options;
  for (const char* const command : {"synth", "mesh", "build", "validate"}) {
    if (place.has(command)) options_of(options, command) = option_values(command, place.at(command));
  }
  return options;
}

SweepReader::SweptOption SweepReader::swept_option(const JsonPlace& place) const {
  place.expect_keys({}, {"synth", "mesh", "build", "validate"});
  const auto members = place.members();
  if (members.size() != 1) place.refuse("must name one option, {\"build\": \"references\"} for example");
  const auto& [command, name] = members.front();
  check_option(command, name.text(), name);
  return {command, name.text()};
}

SweepValue SweepReader::value(const JsonPlace& place, const SweptOption& option) const {
  SweepValue value;
  const auto set = [&](const JsonPlace& of) {
    if (option.name.empty()) of.refuse("there is no \"option\" that it could be a value of");
    options_of(value.options, option.command)[option.name] = option_value(option.name, of);
  };
  if (place.value().is_object()) {
    place.expect_keys({"label"}, {"x", "value", "synth", "mesh", "build", "validate"});
    value.options = command_options(place);
    if (place.has("value")) set(place.at("value"));
    value.label = place.at("label").text();
    if (place.has("x")) value.x = place.at("x").number();
    return value;
  }
  set(place);
  value.label = place.value().is_string() ? place.text() : place.value().dump();
  if (value.label.starts_with('=')) value.label.erase(0, 1);
  if (place.value().is_number()) value.x = place.number();
  return value;
}

std::vector<SweepValue> SweepReader::values(const JsonPlace& place, const SweptOption& option) const {
  std::vector<SweepValue> values;
  std::set<std::string> labels;
  for (const JsonPlace& element : at_scale(place).elements()) {
    values.push_back(value(element, option));
    if (!labels.insert(values.back().label).second) element.refuse("\"" + values.back().label + "\" occurs twice");
  }
  if (values.empty()) place.refuse("has no value at scale " + std::string(name_of(scale_)));
  return values;
}

std::vector<SweepSeries> SweepReader::series(const JsonPlace& file) const {
  std::vector<SweepSeries> all;
  std::set<std::string> labels;
  for (const JsonPlace& place : file.at("series").elements()) {
    place.expect_keys({"label"}, {"mark", "once", "option", "values", "synth", "mesh", "build", "validate"});
    SweepSeries one;
    one.label = place.at("label").text();
    if (!labels.insert(one.label).second) place.refuse("\"" + one.label + "\" occurs twice");
    if (place.has("mark")) {
      one.mark = place.at("mark").one_of({"default", "printed"}) == "default" ? SweepSeries::Mark::is_default
                                                                              : SweepSeries::Mark::printed;
    }
    one.once = place.has("once") && place.at("once").boolean();
    one.options = command_options(place);
    const JsonPlace& option_from = place.has("option") ? place : file;
    const SweptOption option = option_from.has("option") ? swept_option(option_from.at("option")) : SweptOption{};
    one.values = values((place.has("values") ? place : file).at("values"), option);
    all.push_back(std::move(one));
  }
  if (all.empty()) file.at("series").refuse("is empty, a sweep needs at least one");
  return all;
}

SweepScene SweepReader::scene(const JsonPlace& place) const {
  place.expect_keys({"name"}, {"folder", "synth", "mesh", "build", "validate"});
  SweepScene scene;
  scene.name = name_of_file(place.at("name"));
  scene.options = command_options(place);
  if (place.has("folder") == place.has("synth")) {
    place.refuse("must have either \"folder\" (below --scenes) or \"synth\" (options of `lumatlas synth`)");
  }
  if (place.has("folder")) {
    scene.folder = place.at("folder").text();
    const std::filesystem::path folder(scene.folder);
    const bool leaves = std::find(folder.begin(), folder.end(), "..") != folder.end();
    if (folder.is_absolute() || leaves) place.at("folder").refuse("must be the name of a folder below --scenes");
  } else {
    scene.kind = place.at("synth").at("kind").text();
  }
  return scene;
}

std::vector<SweepScene> SweepReader::scenes(const JsonPlace& place) const {
  std::vector<SweepScene> all;
  std::set<std::string> names;
  for (const JsonPlace& element : at_scale(place).elements()) {
    all.push_back(scene(element));
    if (!names.insert(all.back().name).second) element.refuse("\"" + all.back().name + "\" occurs twice");
  }
  if (all.empty()) place.refuse("has none at scale " + std::string(name_of(scale_)));
  return all;
}

std::string metric_at(const JsonPlace& place) {
  std::string name = place.text();
  if (find_metric(name) != nullptr) return name;
  std::string known;
  for (const Metric& metric : all_metrics()) known += (known.empty() ? "" : ", ") + metric.name;
  place.refuse("is \"" + name + "\", must be a metric: " + known);
}

std::vector<std::string> metrics_at(const JsonPlace& place) {
  std::vector<std::string> names;
  for (const JsonPlace& element : place.elements()) names.push_back(metric_at(element));
  if (names.empty()) place.refuse("is empty, name at least one metric");
  return names;
}

SweepLine line_at(const JsonPlace& place) {
  place.expect_keys({"at", "label"}, {"axis"});
  SweepLine line;
  line.on_x = place.has("axis") && place.at("axis").one_of({"x", "y"}) == "x";
  line.at = place.at("at").number();
  line.label = place.at("label").text();
  return line;
}

SweepPlot plot_at(const JsonPlace& place) {
  place.expect_keys({"x", "y"}, {"title", "log", "front", "lines"});
  SweepPlot plot;
  if (place.has("title")) plot.title = place.at("title").text();
  plot.x = place.at("x").text();
  if (plot.x != "value" && plot.x != "label") metric_at(place.at("x"));
  plot.y = metrics_at(place.at("y"));
  const std::string log = place.has("log") ? place.at("log").one_of({"x", "y", "xy"}) : "";
  plot.log_x = log.starts_with('x');
  plot.log_y = log.ends_with('y');
  plot.front = place.has("front") && place.at("front").boolean();
  if (place.has("lines")) {
    for (const JsonPlace& line : place.at("lines").elements()) plot.lines.push_back(line_at(line));
  }
  return plot;
}

bool is_judged(const std::string& metric) {
  const Metric* const found = find_metric(metric);
  return found != nullptr && found->better != Better::neither;
}

// Checks what only the whole sweep can tell about a plot.
void check_plot(const SweepPlot& plot, const Sweep& sweep, const JsonPlace& place) {
  if (plot.front && !(is_judged(plot.x) && std::all_of(plot.y.begin(), plot.y.end(), is_judged))) {
    place.refuse("a front needs metrics of which more or less is better, on both axes");
  }
  if (plot.x == "label" && plot.log_x) place.refuse("labels are evenly spaced, there is no logarithm of them");
  if (plot.x != "value") return;
  for (const SweepSeries& series : sweep.series) {
    for (const SweepValue& value : series.values) {
      if (!value.x) place.refuse("the value \"" + value.label + "\" of \"" + series.label + "\" has no \"x\"");
      if (plot.log_x && !(*value.x > 0)) {
        place.refuse("the value \"" + value.label + "\" of \"" + series.label + "\" has no logarithm");
      }
    }
  }
}

void check_breaking(const Sweep& sweep, const JsonPlace& place) {
  if (!is_judged(sweep.breaking->metric)) place.refuse("needs a metric of which more or less is better");
  if (!(sweep.breaking->fall > 0)) place.at("fall").refuse("must be above 0");
}

// A folder's photographs are what they are.
void check_folders(const Sweep& sweep, const JsonPlace& file) {
  const auto folder = std::find_if(sweep.scenes.begin(), sweep.scenes.end(),
                                   [](const SweepScene& scene) { return !scene.folder.empty(); });
  if (folder == sweep.scenes.end()) return;
  for (const SweepSeries& series : sweep.series) {
    const bool disturbs = std::any_of(series.values.begin(), series.values.end(),
                                      [](const SweepValue& value) { return !value.options.synth.empty(); });
    if (!series.options.synth.empty() || disturbs) {
      file.at("scenes").refuse("the scene \"" + folder->name + "\" is a folder, but the series \"" + series.label +
                               "\" changes options of `lumatlas synth`");
    }
  }
}

const json& members_of(const JsonPlace& place) {
  (void)place.members();  // refuses what is no object
  return place.value();
}

Sweep SweepReader::sweep(const JsonPlace& file) const {
  file.expect_keys({"name", "title", "expected", "label", "scenes", "series", "metrics", "plots"},
                   {"source", "option", "values", "repeats", "mesh", "build", "validate", "scored_on", "breaking"});
  Sweep sweep;
  sweep.name = name_of_file(file.at("name"));
  sweep.title = file.at("title").text();
  sweep.expected = file.at("expected").text();
  sweep.label = file.at("label").text();
  if (file.has("source")) sweep.source = file.at("source").text();
  sweep.options = command_options(file);
  sweep.scenes = scenes(file.at("scenes"));
  sweep.series = series(file);
  if (file.has("repeats")) sweep.repeats = at_scale(file.at("repeats")).count(0, 1000);
  sweep.scored_undisturbed =
      file.has("scored_on") && file.at("scored_on").one_of({"same", "undisturbed"}) == "undisturbed";
  sweep.metrics = metrics_at(file.at("metrics"));
  for (const JsonPlace& plot : file.at("plots").elements()) {
    sweep.plots.push_back(plot_at(plot));
    check_plot(sweep.plots.back(), sweep, plot);
  }
  if (file.has("breaking")) {
    const JsonPlace place = file.at("breaking");
    place.expect_keys({"metric", "fall"}, {});
    sweep.breaking = SweepBreaking{metric_at(place.at("metric")), place.at("fall").number()};
    check_breaking(sweep, place);
  }
  check_folders(sweep, file);
  return sweep;
}

}  // namespace

void overlay(CommandOptions& options, const CommandOptions& over) {
  overlay(options.synth, over.synth);
  overlay(options.mesh, over.mesh);
  overlay(options.build, over.build);
  overlay(options.validate, over.validate);
}

const char* name_of(SweepScale scale) {
  return scale == SweepScale::small ? "small" : scale == SweepScale::medium ? "medium" : "full";
}

bool is_setting(const std::string& name) {
  return name.find('.') != std::string::npos;
}

std::vector<std::string> arguments_of(const OptionValues& options) {
  std::vector<std::string> arguments;
  for (const auto& [name, value] : options) {
    if (!value.given) continue;
    const std::string option = is_setting(name) ? "--set=" + name : "--" + name;
    arguments.push_back(option + (value.text ? "=" + *value.text : ""));
  }
  return arguments;
}

std::vector<Sweep> read_sweeps(const std::filesystem::path& path, SweepScale scale, const KnowsOption& knows_option) {
  const json value = read_json_with_comments(path);
  const JsonPlace file(path.string(), "", value);
  const SweepReader reader(scale, knows_option);
  if (!file.has("sweeps")) return {reader.sweep(file)};
  file.expect_keys({"sweeps"}, {"common"});
  const json common = file.has("common") ? members_of(file.at("common")) : json::object();
  std::vector<Sweep> sweeps;
  for (const JsonPlace& place : file.at("sweeps").elements()) {
    json description = common;
    description.update(members_of(place));
    sweeps.push_back(reader.sweep(place.with(description)));
    const auto same = [&](const Sweep& sweep) { return sweep.name == sweeps.back().name; };
    if (std::count_if(sweeps.begin(), sweeps.end(), same) > 1) {
      place.refuse("the name \"" + sweeps.back().name + "\" occurs twice");
    }
  }
  if (sweeps.empty()) file.at("sweeps").refuse("is empty, describe at least one");
  return sweeps;
}

Sweep sweep_named(const std::string& name, const std::vector<Sweep>& sweeps, const std::filesystem::path& file) {
  std::string names;
  for (const Sweep& sweep : sweeps) {
    if (sweep.name == name) return sweep;
    names += (names.empty() ? "" : ", ") + sweep.name;
  }
  throw InputError(file.string() + ": has no sweep called \"" + name + "\", there are " + names);
}

}  // namespace lumatlas
