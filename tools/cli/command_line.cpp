// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/command_line.h"

#include <algorithm>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "tools/base/error_sentence.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/process/process_limits.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/output/suggestion.h"

namespace lumatlas {

namespace {

// One line, whatever characters are in the name of a file.
int fail(std::string sentence) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
  std::replace_if(sentence.begin(), sentence.end(), is_control, ' ');
  std::cerr << "lumatlas: " << sentence << '\n';
  return 1;
}

// The long names of the options of the command that was given.
std::vector<std::string> option_names(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands()) {
    for (const CLI::Option* option : command->get_options()) names.push_back(option->get_name());
  }
  return names;
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CLI::App program("lumatlas turns a mesh and posed photographs into a view-dependent textured scene", "lumatlas");
  program.formatter(std::make_shared<HelpFormatter>());
  program.set_help_flag("-h,--help");
  program.set_help_all_flag("--help-all");
  program.set_version_flag("--version", "lumatlas " LUMATLAS_VERSION, "Print the version");
  program.option_defaults()->always_capture_default();
  program.require_subcommand(1);
  add_capture_command(program);
  add_inspect_command(program);
  add_mesh_command(program);
  add_build_command(program);
  add_city_command(program);
  add_live_command(program);
  add_render_command(program);
  add_validate_command(program);
  add_export_command(program);
  add_view_command(program);
  add_synth_command(program);
  add_chart_command(program);
  try {
    program.parse(argc, argv);
    if (!std::cout.flush()) {
      throw_if_interrupted();  // by SIGPIPE: the reader of stdout has gone
      return fail("the result cannot be written to standard output, " + why_not_written());
    }
    return 0;
  } catch (const CLI::ParseError& error) {
    const std::string sentence = with_option_name(error.what(), option_names(program));
    const bool renamed = sentence != error.what();
    if ((renamed ? program.exit(CLI::ValidationError(sentence)) : program.exit(error)) == 0) return 0;
    if (const std::string meant = suggestion(program, argc, argv); !meant.empty()) std::cerr << meant << '\n';
    return 2;
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    return fail(error_sentence(error));
  }
}

}  // namespace lumatlas
