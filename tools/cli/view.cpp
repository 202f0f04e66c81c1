// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"
#include "tools/cli/commands.h"
#include "tools/cli/output/print_address.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/viewer/http/site_server.h"
#include "tools/viewer/model_files.h"
#include "tools/viewer/open_browser.h"

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

void show(const ViewFlags& flags, const SiteServer& server) {
  print_address(server.address(), flags.json_output);
  if (!flags.quiet) {
    for (const std::string& other : server.addresses_for_others())
      std::cerr << "from other machines: " << other << '\n';
    std::cerr << "Ctrl-C ends it.\n";
  }
  if (!flags.no_browser) open_browser(server.address());
}

// Looks about once a second whether another model is there.
class Watch {
 public:
  Watch(ServedModel& model, bool quiet) : model_(model), quiet_(quiet) {}

  // False: the server goes on.
  bool look() {
    throw_if_interrupted();
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return false;
    next_ = now + std::chrono::seconds(1);
    try {
      (void)model_.refresh();
    } catch (const InputError& error) {
      if (!quiet_) std::cerr << error.what() << ", what was there before is shown on\n";
    }
    return false;
  }

 private:
  ServedModel& model_;
  bool quiet_;
  std::chrono::steady_clock::time_point next_;
};

void run(const ViewFlags& flags) {
  SiteServer server(flags.server);
  ServedModel model(server, flags.model, flags.follow, length_unit_of(flags.model));
  show(flags, server);
  Watch watch(model, flags.quiet);
  server.serve([&watch] { return watch.look(); });
}

}  // namespace

void add_view_command(CLI::App& program) {
  auto flags = std::make_shared<ViewFlags>();
  CLI::App* command = program.add_subcommand("view", "Show a model in the browser, until Ctrl-C");
  add_file(*command, "MODEL", flags->model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  command->add_flag("--follow", flags->follow, "Follow the model: show what has changed each time that it is replaced");
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
