// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/open_browser.h"

#include <sys/wait.h>

#include <filesystem>
#include <thread>

#include "mesh/base/errors.h"
#include "tools/base/process/child_process.h"

namespace lumatlas {

void open_browser(const std::string& address) {
  const std::filesystem::path opener = find_program("xdg-open");
  if (opener.empty()) return;
  try {
    const pid_t browser = start_program(opener, {address});
    std::thread([browser] { waitpid(browser, nullptr, 0); }).detach();
  } catch (const InputError&) {  // the address is printed anyway
  }
}

}  // namespace lumatlas
