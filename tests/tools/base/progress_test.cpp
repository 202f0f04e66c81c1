// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/progress.h"

#include <catch2/catch.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace lumatlas {
namespace {

using namespace std::chrono_literals;

// A stream and a clock that stands still until it is told otherwise.
struct Stage {
  std::ostringstream out;
  ProgressOptions::Clock::time_point time{};

  ProgressOptions options(bool is_terminal) {
    ProgressOptions options;
    options.out = &out;
    options.is_terminal = is_terminal;
    options.now = [this] { return time; };
    return options;
  }
  std::string take() {
    const std::string text = out.str();
    out.str("");
    return text;
  }
};

TEST_CASE("work that is done within a second leaves no trace, on a terminal or not") {
  for (const bool is_terminal : {true, false}) {
    Stage stage;
    {
      Progress progress("planning", 3, stage.options(is_terminal));
      for (int i = 0; i < 3; ++i) {
        stage.time += 300ms;
        progress.tick();
      }
    }
    CHECK(stage.out.str().empty());
  }
}

TEST_CASE("quiet work leaves no trace however long it takes") {
  Stage stage;
  ProgressOptions options = stage.options(true);
  options.quiet = true;
  {
    Progress progress("planning", 3, options);
    stage.time += 100s;
    progress.tick();
  }
  CHECK(stage.out.str().empty());
}

TEST_CASE("without a terminal there is a line after a second, one every ten seconds, and one at the end") {
  Stage stage;
  {
    Progress progress("reading photographs", 400, stage.options(false));
    stage.time += 999ms;
    progress.tick(9);
    CHECK(stage.take().empty());
    stage.time += 1ms;
    progress.tick();
    CHECK(stage.take() == "reading photographs: 10 of 400, 10/s, 0:39 left\n");
    stage.time += 9999ms;
    progress.tick(90);
    CHECK(stage.take().empty());
    stage.time += 1ms;
    progress.tick(10);
    CHECK(stage.take() == "reading photographs: 110 of 400, 10/s, 0:29 left\n");
    stage.time += 1s;
    progress.tick(290);
    CHECK(stage.take().empty());
  }
  CHECK(stage.take() == "reading photographs: 400 in 12.0 s (33/s)\n");
}

TEST_CASE("a terminal shows a bar ten times a second at most and one line in its place at the end") {
  Stage stage;
  {
    Progress progress("reading", 100, stage.options(true));
    stage.time += 2s;
    progress.tick(50);
    CHECK(stage.take() ==
          "\r\x1b[Kreading [" + std::string(15, '#') + std::string(15, '-') + "] 50 of 100, 25/s, 0:02 left");
    stage.time += 99ms;
    progress.tick();
    CHECK(stage.take().empty());
    stage.time += 1ms;
    progress.tick();
    CHECK(stage.take().find("52 of 100") != std::string::npos);
  }
  CHECK(stage.take() == "\r\x1b[Kreading: 52 of 100 in 2.1 s (25/s)\n");
}

TEST_CASE("the bar's line stays narrower than the terminal") {
  for (const std::size_t columns : {0U, 1U, 10U, 40U, 57U, 58U, 80U, 200U}) {
    Stage stage;
    ProgressOptions options = stage.options(true);
    options.columns = columns;
    Progress progress("reading photographs", 1000, options);
    stage.time += 2s;
    progress.tick(200);
    const std::string line = stage.take().substr(4);
    CAPTURE(line);
    CHECK(line.size() < std::max<std::size_t>(columns, 2));
    CHECK((line.find('[') != std::string::npos) == (columns >= 58));
  }
}

TEST_CASE("slow work says the time of each, long work the hours that are left") {
  Stage stage;
  Progress progress("refining", 100, stage.options(false));
  stage.time += 300s;
  progress.tick(2);
  CHECK(stage.take() == "refining: 2 of 100, 150.0 s each, 4:05:00 left\n");
}

TEST_CASE("work of unknown length and ticks beyond the total have no remaining time") {
  Stage stage;
  {
    Progress unknown("reading", 0, stage.options(true));
    stage.time += 4s;
    unknown.tick(10);
    CHECK(stage.take() == "\r\x1b[Kreading 10, 2.5/s");
  }
  stage.take();
  Progress beyond("reading", 5, stage.options(true));
  stage.time += 2s;
  beyond.tick(7);
  CHECK(stage.take() == "\r\x1b[Kreading [" + std::string(30, '#') + "] 7 of 5, 3.5/s");
}

TEST_CASE("an exception wipes the bar and says nothing more") {
  Stage stage;
  try {
    Progress progress("reading", 10, stage.options(true));
    stage.time += 2s;
    progress.tick();
    stage.take();
    throw std::runtime_error("stop");
  } catch (const std::runtime_error&) {
    CHECK(stage.take() == "\r\x1b[K");
  }
}

TEST_CASE("ticks from several threads all count") {
  Stage stage;
  {
    Progress progress("counting", 40000, stage.options(false));
    stage.time += 2s;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&progress] {
        for (int i = 0; i < 10000; ++i) {
          progress.tick();
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    stage.take();
  }
  CHECK(stage.take() == "counting: 40000 in 2.0 s (20000/s)\n");
}

TEST_CASE("progress without a stream is refused") {
  CHECK_THROWS_WITH(Progress("reading", 1, ProgressOptions{}), "progress: out is null, must be a stream");
}

}  // namespace
}  // namespace lumatlas
