// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "atlas/model_file.h"
#include "tools/base/child_process.h"
#include "tools/base/interrupt.h"
#include "tools/base/progress.h"
#include "tools/cli/commands.h"
#include "tools/cli/json_output.h"
#include "tools/viewer/site.h"
#include "tools/viewer/site_server.h"

namespace lumatlas {

namespace {

struct ViewFlags {
  std::filesystem::path model;
  ServerOptions server;
  bool no_browser = false;
  bool json_output = false;
  bool quiet = false;
};

// What the desktop opens addresses with. It says nothing here, and may outlive this program, as browsers do.
void open_browser(const std::string& address) {
  const std::filesystem::path opener = find_program("xdg-open");
  if (opener.empty()) return;
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
  }
  std::string program = opener.string();
  std::string argument = address;
  char* arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawn(&child, program.c_str(), &files, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
  if (failed == 0) std::thread([child] { waitpid(child, nullptr, 0); }).detach();
}

// Photographs are in the page as they are in the model, for nobody waits for a network.
SiteOptions local_site(const std::filesystem::path& model) {
  SiteOptions options;
  options.title = title_of(model);
  options.photographs.quality = 97;
  return options;
}

void run(const ViewFlags& flags) {
  SiteServer server(flags.server);
  {
    const Model model = read_model(flags.model);
    Progress progress("page: photographs", site_ticks(model.snapshot), ProgressOptions::standard_error(flags.quiet));
    write_site(
        model.snapshot, local_site(flags.model), [&](SiteFile file) { server.add(std::move(file)); },
        [&] { progress.tick(); });
  }
  if (flags.json_output) {
    print_json({{"address", server.address()}});
  } else {
    std::cout << server.address() << '\n';
  }
  std::cout.flush();  // whoever reads it waits for it
  if (!flags.quiet) std::cerr << "Ctrl-C ends it.\n";
  if (!flags.no_browser) open_browser(server.address());
  server.serve([] {
    throw_if_interrupted();
    return false;
  });
}

}  // namespace

void add_view_command(CLI::App& program) {
  auto flags = std::make_shared<ViewFlags>();
  CLI::App* command = program.add_subcommand("view", "Show a model in the browser, until Ctrl-C");
  add_file(*command, "MODEL", flags->model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  begin_group(*command, "Server");
  command->add_option("--host", flags->server.host, "Listen at another address; then others may see the model")
      ->type_name("ADDRESS");
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
