// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/cli/program_here.h"

#include <iostream>
#include <sstream>

#include "tools/cli/command_line.h"

namespace lumatlas {

namespace {

// Takes what is written to a stream while this lives.
class Written {
 public:
  explicit Written(std::ostream& stream) : stream_(stream), before_(stream.rdbuf(text_.rdbuf())) {}
  ~Written() { stream_.rdbuf(before_); }
  Written(const Written&) = delete;
  Written& operator=(const Written&) = delete;
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::ostream& stream_;
  std::streambuf* before_;
};

}  // namespace

Outcome lumatlas_here(const Arguments& arguments) {
  std::vector<const char*> argv{"lumatlas"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  argv.push_back(nullptr);
  const Written out(std::cout), err(std::cerr);
  const int status = run_command_line(static_cast<int>(argv.size()) - 1, argv.data());
  return {status, out.text(), err.text()};
}

}  // namespace lumatlas
