// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/standard_streams.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <functional>

namespace lumatlas {
namespace {

// Returns the result of `work` in a child of its own.
int in_child(const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_CASE("a file that is opened after a stream was closed does not get the stream's number") {
  for (const int stream : {0, 1, 2}) {
    CAPTURE(stream);
    CHECK(in_child([&] {
            close(stream);
            return open("/dev/null", O_RDONLY);
          }) == stream);
    CHECK(in_child([&] {
            close(stream);
            if (!complaint_about_streams().empty()) return 1;
            return open("/dev/null", O_RDONLY);
          }) > 2);
  }
}

TEST_CASE("a stream that was closed refuses to be written to, one that is open is left alone") {
  CHECK(in_child([] {
          close(2);
          if (!complaint_about_streams().empty()) return 1;
          return write(2, "x", 1) < 0 ? 7 : 0;
        }) == 7);
  CHECK(in_child([] {
          const int file = open("/dev/null", O_WRONLY);
          dup2(file, 2);
          if (!complaint_about_streams().empty()) return 1;
          return write(2, "x", 1) == 1 ? 7 : 0;
        }) == 7);
}

TEST_CASE("whichever streams were closed, the next file gets a number above them") {
  for (int closed = 0; closed < 8; ++closed) {
    CAPTURE(closed);
    CHECK(in_child([closed] {
            for (const int stream : {0, 1, 2}) {
              if ((closed & 1 << stream) != 0) close(stream);
            }
            if (!complaint_about_streams().empty()) return 1;
            return open("/dev/null", O_RDONLY);
          }) > 2);
  }
}

}  // namespace
}  // namespace lumatlas
