// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace lumatlas {

std::string complaint_about_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is taken, which is this one. Opened the wrong way round, it refuses to be used.
    if (open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) {
      return "/dev/null: cannot be opened in the place of the closed stream " + std::to_string(stream);
    }
  }
  return "";
}

}  // namespace lumatlas
