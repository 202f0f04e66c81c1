// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/open_browser.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "tools/base/process/child_process.h"

namespace lumatlas {

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

}  // namespace lumatlas
