// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/cli/program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>

namespace lumatlas {

Run::Run(Arguments arguments) {
  arguments.insert(arguments.begin(), LUMATLAS_PROGRAM);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const std::string out = (streams_ / "out").string();
  const std::string err = (streams_ / "err").string();
  child_ = fork();
  if (child_ == 0) {
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(open(out.c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
    dup2(open(err.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
    signal(SIGINT, SIG_DFL);  // a background job starts with it ignored
    execv(argv[0], argv.data());
    _exit(127);
  }
  REQUIRE(child_ > 0);
}

void Run::interrupt() const {
  kill(child_, SIGINT);
}

std::string Run::out() const {
  return bytes_of(streams_ / "out");
}

Outcome Run::wait() const {
  int status = 0;
  REQUIRE(waitpid(child_, &status, 0) == child_);
  const int code = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  return {code, bytes_of(streams_ / "out"), bytes_of(streams_ / "err")};
}

Outcome lumatlas(const Arguments& arguments) {
  Outcome outcome = Run(arguments).wait();
  INFO(outcome.err);
  CHECK(outcome.status >= 0);
  return outcome;
}

void check_failure(const Outcome& outcome, const std::string& part) {
  CHECK(outcome.status == 1);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Catch::StartsWith("lumatlas: ") && Catch::Contains(part));
  CHECK(outcome.err.find('\n') == outcome.err.size() - 1);
}

const Made& made() {
  static const Made once;
  return once;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

nlohmann::json options_beside(const fs::path& output) {
  return nlohmann::json::parse(bytes_of(output / "lumatlas.json"))["options"];
}

}  // namespace lumatlas
