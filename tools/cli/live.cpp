// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/interrupt.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/output/json_output.h"
#include "tools/cli/output/next_steps.h"
#include "tools/cli/output/stage_bars.h"
#include "tools/cli/shown_build.h"
#include "tools/live/playback/frame_input.h"
#include "tools/live/playback/frame_socket.h"
#include "tools/live/playback/playback.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/model_inspection.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/output/save_model.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kJointSteps = 15;  // as many as a build takes at most

struct LiveFlags {
  std::filesystem::path source, output;
  PlaybackOptions options;
  PictureFlags pictures;
  HoldFlags hold;
  std::uint16_t listen = 0;
  CLI::Option* listen_option = nullptr;
  bool joint = false;
  bool no_finish = false;
  bool view = false;
  bool no_browser = false;
  ServerOptions server;
  bool json_output = false;
  bool quiet = false;

  [[nodiscard]] bool listens() const { return listen_option->count() > 0; }
  [[nodiscard]] bool reads_input() const { return source == "-"; }
};

PageOptions page_options_of(const LiveFlags& flags) {
  return {flags.output, flags.server, flags.no_browser, flags.json_output, flags.quiet};
}

std::string progress_text(const PlaybackProgress& progress) {
  const LiveStatus& live = progress.live;
  std::string line = number_text(progress.time, 3);
  if (progress.seconds > 0) line += " of " + number_text(progress.seconds, 3);
  line +=
      " s: " + std::to_string(live.offered) + " photographs came, " + std::to_string(live.held) + " are in the model";
  if (live.waiting > 0) line += ", " + std::to_string(live.waiting) + " wait";
  if (live.dropped > 0) line += ", " + std::to_string(live.dropped) + " were given up for others";
  if (live.pieces_given > 0) {
    line += "; " + std::to_string(live.pieces_given) + " pieces of surface came, of " + std::to_string(live.faces) +
            " faces together";
  } else {
    line += "; of " + std::to_string(live.depths_given) + " depth images " + std::to_string(live.fusion.count) +
            " are fused, into " + std::to_string(live.faces) + " faces";
  }
  return line + '\n';
}

nlohmann::json spread_json(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  return {{"median", percentile(values, 0.5)},
          {"p95", percentile(values, 0.95)},
          {"worst", *std::max_element(values.begin(), values.end())}};
}

nlohmann::json times_json(const LiveTimes& times) {
  const double mean = times.count > 0 ? times.total / static_cast<double>(times.count) : 0;
  return {{"count", times.count}, {"mean", mean}, {"last", times.last}, {"worst", times.worst}};
}

// Means over the views that were stored, slowest first, up to the share `of` of them.
nlohmann::json waits_json(const PlaybackRecord& record, double of) {
  std::vector<const LiveOutcome*> stored;
  for (const LiveOutcome& outcome : record.outcomes) {
    if (outcome.verdict.slot) stored.push_back(&outcome);
  }
  std::sort(stored.begin(), stored.end(),
            [](const auto* a, const auto* b) { return a->until_stored > b->until_stored; });
  stored.resize(static_cast<std::size_t>(std::ceil(of * static_cast<double>(stored.size()))));
  if (stored.empty()) return nullptr;
  const auto mean = [&](double LiveWaits::*part) {
    double sum = 0;
    for (const LiveOutcome* outcome : stored) sum += outcome->waits.*part;
    return sum / static_cast<double>(stored.size());
  };
  return {{"views", stored.size()},
          {"for_surface", mean(&LiveWaits::for_surface)},
          {"behind_surface", mean(&LiveWaits::behind_surface)},
          {"behind_views", mean(&LiveWaits::behind_views)},
          {"behind_depths", mean(&LiveWaits::behind_depths)},
          {"storing", mean(&LiveWaits::storing)}};
}

std::vector<double> times_until_stored(const PlaybackRecord& record) {
  std::vector<double> times;
  for (const LiveOutcome& outcome : record.outcomes) {
    if (outcome.verdict.slot) times.push_back(outcome.until_stored);
  }
  return times;
}

nlohmann::json finish_json(const FinishRecord& finish) {
  if (!finish.why_not.empty()) return {{"done", false}, {"why_not", finish.why_not}};
  if (!finish.done) return {{"done", false}};
  return {
      {"done", true}, {"voxel", finish.voxel}, {"fusing_ms", finish.fusing_ms}, {"building_ms", finish.building_ms}};
}

nlohmann::json moments_json(const std::vector<PlaybackMoment>& moments) {
  nlohmann::json list = nlohmann::json::array();
  for (const PlaybackMoment& moment : moments) {
    list.push_back({{"seconds", moment.seconds},
                    {"frames", moment.frames},
                    {"offer_ms", {{"median", moment.offer_median_ms}, {"worst", moment.offer_worst_ms}}},
                    {"depths", {{"given", moment.depths_given}, {"fused", moment.depths_fused}}},
                    {"held", moment.held},
                    {"waiting", moment.waiting},
                    {"faces", moment.faces},
                    {"summed_coverage", moment.summed_coverage},
                    {"resident_bytes", moment.resident_bytes}});
  }
  return list;
}

nlohmann::json live_json(const PlaybackRecord& record) {
  const LiveStatus& live = record.live;
  return {
      {"frames", record.frames},
      {"seconds", record.seconds},
      {"ended_early", record.ended_early},
      {"dropped_views", live.dropped},
      {"depths", {{"given", live.depths_given}, {"dropped", live.depths_dropped}, {"refused", live.depths_refused}}},
      {"pieces", {{"given", live.pieces_given}, {"refused", live.pieces_refused}}},
      {"offer_ms", spread_json(record.offer_ms)},
      {"moments", moments_json(record.moments)},
      {"moving_ms", times_json(live.moving)},
      {"fusing_again_ms", times_json(live.fusing_again)},
      {"until_stored_ms", spread_json(times_until_stored(record))},
      {"waits_ms", {{"all", waits_json(record, 1)}, {"slowest_tenth", waits_json(record, 0.1)}}},
      {"late_ms", spread_json(record.late_ms)},
      {"fusion_ms", times_json(live.fusion)},
      {"surface_making_ms", times_json(live.surface_making)},
      {"surface_taking_ms", times_json(live.surface_taking)},
      {"depth_renewing_ms", times_json(live.depth_renewing)},
      {"storing_ms", times_json(live.storing)},
      {"finish", finish_json(record.finish)},
      {"finish_ms", record.finish_ms}};
}

std::string spread_text(const nlohmann::json& spread) {
  return number_text(spread["median"].get<double>(), 3) + " / " + number_text(spread["p95"].get<double>(), 3) + " / " +
         number_text(spread["worst"].get<double>(), 3);
}

std::string live_text(const nlohmann::json& live) {
  std::string text = "  stream of " + number_text(live["seconds"].get<double>(), 3) + " s; ms, median / p95 / worst:";
  if (!live["offer_ms"].is_null()) text += " an offer " + spread_text(live["offer_ms"]);
  if (!live["until_stored_ms"].is_null())
    text += ", until a photograph is stored " + spread_text(live["until_stored_ms"]);
  return text + '\n';
}

void tell(const LiveFlags& flags, const Playback& playback) {
  if (!flags.quiet) {
    for (const std::string& note : playback.result.scene_notes) std::cerr << "scene: " << note << '\n';
  }
  for (const SkippedView& view : playback.result.skipped) std::cerr << "warning: " << view.why << '\n';
  const LiveStatus& live = playback.record.live;
  if (live.depths_refused > 0) {
    std::cerr << "warning: " << live.depths_refused
              << " depth images could not be fused; the last failure: " << live.last_failure << '\n';
  }
  if (!live.surface_failure.empty()) {
    std::cerr << "warning: the surface lacks the last pieces: " << live.surface_failure << '\n';
  }
}

void tell_finish(const LiveFlags& flags, const FinishRecord& finish) {
  if (!finish.why_not.empty()) {
    std::cerr << "warning: the model is saved as the stream left it: " << finish.why_not << '\n';
  } else if (finish.done && !flags.quiet) {
    std::cerr << "finished in " << number_text((finish.fusing_ms + finish.building_ms) / 1000, 3) << " s, "
              << number_text(finish.fusing_ms / 1000, 3) << " s of them for the surface\n";
  }
}

void print_totals(const LiveFlags& flags, nlohmann::json totals, const PlaybackRecord& record) {
  totals["live"] = live_json(record);
  totals["file"] = file_bytes_json(flags.output);
  if (flags.json_output) {
    print_result(totals, flags.output);
    return;
  }
  print_result(summary_text(totals, flags.output.string()) + live_text(totals["live"]) + "  on disk " +
                   file_bytes_text(totals["file"]) + '\n',
               flags.output);
  if (!flags.quiet) {
    std::cerr << next_steps(flags.output, flags.hold.protocol() ? flags.source : std::filesystem::path());
  }
}

// Tells every other second.
std::function<void(const PlaybackProgress&)> told_on_standard_error(bool quiet) {
  if (quiet) return {};
  return [calls = 0](const PlaybackProgress& progress) mutable {
    const bool is_last = progress.frame == progress.frames;
    if (calls++ % 2 == 0 || is_last) std::cerr << progress_text(progress);
  };
}

// Shows how the model is made anew when the stream has ended. Another Ctrl-C then stops that, and the model is saved as
// the stream left it.
void show_finish(const LiveFlags& flags, std::optional<EndRequest>& end_request, PlaybackCallbacks& callbacks) {
  callbacks.finishing = [&end_request, quiet = flags.quiet](std::size_t depths, std::size_t photographs) {
    end_request.reset();
    end_request.emplace();
    if (quiet) return;
    std::cerr << "finishing: ";
    if (depths > 0) std::cerr << "fusing " << depths << " depth images again in fine voxels, and ";
    std::cerr << "choosing among " << photographs << " photographs; Ctrl-C saves the model without that\n";
  };
  callbacks.fusing = [&end_request, bars = bars_on_standard_error(flags.quiet)](const std::string& stage,
                                                                                std::size_t steps) {
    return [&end_request, tick = bars(stage, steps)](std::size_t done) {
      if (end_request->made()) throw BuildStopped();
      tick(done);
    };
  };
  callbacks.building = [&end_request, shown = progress_on_standard_error(flags.quiet)](const BuildProgress& progress) {
    return !end_request->made() && shown(progress);
  };
}

void run(LiveFlags flags) {
  if (flags.listens() != flags.source.empty()) {
    throw CLI::ValidationError("SOURCE", "is needed unless --listen is given, and not with it");
  }
  if (flags.reads_input() && flags.hold.hold_option->count() > 0) {
    throw CLI::ValidationError("--hold", "leaves out photographs of a capture, not of standard input");
  }
  if (flags.reads_input() && isatty(STDIN_FILENO) != 0) {
    throw CLI::ValidationError("SOURCE",
                               "is standard input, which is a terminal: a program or file must send a stream");
  }
  flags.options.pictures = flags.pictures.folders();
  flags.options.hold_out = flags.hold.protocol();
  if (flags.joint) flags.options.polish_steps = kJointSteps;
  flags.options.finish = !flags.no_finish;
  check_usage(flags.options);
  const std::filesystem::path folder = flags.reads_input() ? std::filesystem::path() : flags.source;
  check_apart(flags.output, std::array{folder, flags.pictures.images, flags.pictures.masks});
  ModelOutput output(flags.output);
  flags.options.scratch_folder = scratch_folder_for(flags.output);
  std::optional<FrameSocket> socket;
  if (flags.listens()) socket.emplace(flags.listen);
  FrameInput input(STDIN_FILENO);
  const auto shown = flags.view ? std::make_unique<ShownBuild>(page_options_of(flags)) : nullptr;
  std::optional<EndRequest> end_request(std::in_place);
  PlaybackCallbacks callbacks;
  callbacks.ended = [&end_request] { return end_request->made(); };
  callbacks.told = told_on_standard_error(flags.quiet);
  show_finish(flags, end_request, callbacks);
  if (shown) {
    callbacks.watch = [&shown](LiveModel& live) {
      return shown->follow([&live] { return live.snapshot(); }, ShowingShare::much);
    };
  }
  callbacks.warned = [](const std::string& sentence) { std::cerr << "warning: " << sentence << '\n'; };
  if (socket) std::cerr << "listening for frames at 127.0.0.1:" << socket->port() << '\n';
  if (!flags.quiet) std::cerr << "Ctrl-C ends the stream and saves the model\n";
  FrameSource* const sender = socket ? static_cast<FrameSource*>(&*socket) : flags.reads_input() ? &input : nullptr;
  const Playback playback = sender != nullptr ? receive_stream(*sender, flags.options, callbacks)
                                              : play_capture(flags.source, flags.options, callbacks);
  tell(flags, playback);
  tell_finish(flags, playback.record.finish);
  print_totals(flags, save_model(playback.result, output), playback.record);
  const bool asked_to_end = playback.record.ended_early || end_request->made();
  end_request.reset();
  if (shown && !asked_to_end) shown->show_until_interrupted(playback.result.snapshot);
}

void add_page_options(CLI::App& command, LiveFlags& flags) {
  command.add_flag("--view", flags.view, "Show the model in the browser while it grows, and until Ctrl-C");
  CLI::Option* const views = command.get_option("--view");
  command.add_option("--port", flags.server.port, "With --view, listen at this port; 0: any that is free")
      ->type_name("N")
      ->transform(whole_number(0, 65535))
      ->needs(views);
  command.add_flag("--no-browser", flags.no_browser, "With --view, only say the address")->needs(views);
}

}  // namespace

void add_live_command(CLI::App& program) {
  auto flags = std::make_shared<LiveFlags>();
  CLI::App* command = program.add_subcommand("live", "Make a model of a stream with depth images while it is played");
  add_file(*command, "SOURCE", flags->source, "SOURCE",
           "Capture with depth images: TUM RGB-D, ScanNet, Polycam; -: a stream on standard input");
  PlaybackOptions& options = flags->options;
  begin_group(*command, "Files");
  add_model_output(*command, flags->output);
  flags->pictures.add_to(*command);
  begin_group(*command, "Stream");
  flags->listen_option =
      command
          ->add_option("--listen", flags->listen, "Take frames that a program sends to this port; 0: any that is free")
          ->type_name("PORT")
          ->transform(whole_number(0, 65535))
          ->default_str("");
  command->add_option("--speed", options.speed, "Speed, as a multiple of the speed at which the stream was taken")
      ->type_name("X");
  command->add_option("--rate", options.rate, "Photographs a second where the capture has no times")->type_name("N");
  flags->hold.add_to(*command, "Leave out every H-th photograph, for validate");
  flags->hold.hold_option->excludes(flags->listen_option);
  begin_group(*command, "Model");
  command->add_option("--max-views", options.live.max_views, "Photographs that the model keeps")
      ->type_name("N")
      ->transform(whole_number(1, 100'000));
  command
      ->add_option("--voxel", options.live.surface.voxel,
                   "Side of the surface's voxels, scene units; without it 6 pixels of the first depth image")
      ->type_name("LENGTH");
  command->add_flag("--joint", flags->joint, "Refine all photographs together when the stream has ended");
  command->add_flag("--no-finish", flags->no_finish,
                    "Save the model as it was shown; without it the surface is fused again in fine voxels");
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  add_page_options(*command, *flags);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
