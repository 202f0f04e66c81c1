// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "atlas/model/model_file.h"
#include "tools/base/interrupt.h"
#include "tools/base/progress.h"
#include "tools/cli/commands.h"
#include "tools/cli/output/print_address.h"
#include "tools/viewer/live_site.h"
#include "tools/viewer/open_browser.h"
#include "tools/viewer/site.h"
#include "tools/viewer/site_server.h"

namespace lumatlas {

namespace {

struct ViewFlags {
  std::filesystem::path model;
  ServerOptions server;
  bool follow = false;
  bool no_browser = false;
  bool json_output = false;
  bool quiet = false;
};

// A model that is replaced while it is looked at.
class FollowedModel {
 public:
  explicit FollowedModel(std::filesystem::path path) : path_(std::move(path)) {}

  // Throws InputError.
  void read() {
    const auto written = last_written();
    unseen_ = std::make_shared<const Model>(read_model(path_));
    written_ = written;
  }
  // Returns the model if it was replaced since the last call, otherwise null. Throws InputError, once for each bad
  // model.
  std::shared_ptr<const Snapshot> changed() {
    const auto written = last_written();
    if (written != written_) {
      written_ = written;
      unseen_ = std::make_shared<const Model>(read_model(path_));
    }
    const std::shared_ptr<const Model> model = std::exchange(unseen_, nullptr);
    return model ? std::shared_ptr<const Snapshot>(model, &model->snapshot) : nullptr;
  }

 private:
  // Returns when the model's file, or the main file of its folder, was written; the earliest time while there is none.
  [[nodiscard]] std::filesystem::file_time_type last_written() const {
    std::error_code missing;
    const bool folder = std::filesystem::is_directory(path_, missing);
    const auto time = std::filesystem::last_write_time(folder ? path_ / "scene.gltf" : path_, missing);
    return missing ? std::filesystem::file_time_type::min() : time;
  }

  std::filesystem::path path_;
  std::filesystem::file_time_type written_;
  std::shared_ptr<const Model> unseen_;  // read, but not returned yet
};

// The page gets photographs as they are in the model, because a local server is fast.
SiteOptions local_site(const std::filesystem::path& model) {
  SiteOptions options;
  options.title = title_of(model);
  options.photographs.quality = 97;
  return options;
}

void write_once(const ViewFlags& flags, SiteServer& server) {
  const Model model = read_model(flags.model);
  Progress progress("page: photographs", site_ticks(model.snapshot), ProgressOptions::standard_error(flags.quiet));
  write_site(
      model.snapshot, local_site(flags.model), [&](SiteFile file) { server.add(std::move(file)); },
      [&] { progress.tick(); });
}

void show(const ViewFlags& flags, const SiteServer& server) {
  print_address(server.address(), flags.json_output);
  if (!flags.quiet) {
    for (const std::string& other : server.addresses_for_others())
      std::cerr << "from other machines: " << other << '\n';
    std::cerr << "Ctrl-C ends it.\n";
  }
  if (!flags.no_browser) open_browser(server.address());
}

bool go_on() {
  throw_if_interrupted();
  return false;
}

void run(const ViewFlags& flags) {
  SiteServer server(flags.server);
  if (!flags.follow) {
    write_once(flags, server);
    show(flags, server);
    return server.serve(go_on);
  }
  LiveSite site(server, title_of(flags.model));
  FollowedModel model(flags.model);
  model.read();  // a model that is bad from the start is refused
  const auto follows = show_while_it_changes(
      site, [&model] { return model.changed(); },
      [&flags](const std::string& why) {
        if (!flags.quiet) std::cerr << why << ", what was there before is shown on\n";
      });
  show(flags, server);
  server.serve(go_on);
}

}  // namespace

void add_view_command(CLI::App& program) {
  auto flags = std::make_shared<ViewFlags>();
  CLI::App* command = program.add_subcommand("view", "Show a model in the browser, until Ctrl-C");
  add_file(*command, "MODEL", flags->model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  command->add_flag("--follow", flags->follow, "Show what becomes of it: each time that it is replaced, what changed");
  begin_group(*command, "Server");
  command->add_option("--host", flags->server.host, "Listen at another address; then others may see the model")
      ->type_name("ADDRESS")
      ->check(host_name());
  command->add_option("--port", flags->server.port, "Listen at this port; 0: any that is free")
      ->type_name("N")
      ->transform(whole_number(0, 65535));
  command->add_flag("--no-browser", flags->no_browser, "Only print the address");
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
