// `calot`: the command line. Exit codes: 0 done, 1 could not, 2 the input or the call is wrong.
#include "app/commands.h"
#include "app/terminal.h"
#include "calot/base/error.h"

namespace {

void add_commands(CLI::App& app) {
  calot::add_phantom_command(app);
  calot::add_patient_command(app);
  calot::add_mesh_command(app);
  calot::add_precompute_command(app);
  calot::add_cut_command(app);
  calot::add_solve_command(app);
  calot::add_compare_command(app);
  calot::add_convert_command(app);
  calot::add_simulate_command(app);
  calot::add_view_command(app);
  calot::add_bench_command(app);
}

/// The command that was being called, for "try calot cut --help".
std::string called_command(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) return "calot " + command->get_name();
  return "calot";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Exact, real-time cutting of precomputed soft tissue.", "calot");
  app.set_version_flag("--version", "calot " CALOT_VERSION);
  app.footer("`calot COMMAND --help` explains a command, with an example.");
  app.require_subcommand(1);
  try {
    calot::handle_signals();
    add_commands(app);
    const std::string first = argc > 1 ? argv[1] : "-";
    const auto called = [&](const CLI::App* command) { return command->get_name() == first; };
    if (first[0] != '-' && app.get_subcommands(called).empty())
      return calot::report_usage("there is no command \"" + first + "\"; try calot --help");
    app.parse(argc, argv);
    std::cout.flush();
    if (!std::cout) throw calot::FailedError("standard output", "can't be written", "free some space");
  } catch (const CLI::Success& success) {
    return app.exit(success);  // --help, --version
  } catch (const CLI::ParseError& wrong) {
    return calot::report_usage(std::string(wrong.what()) + "; try " + called_command(app) + " --help");
  } catch (const std::exception& error) {
    return calot::report_error(error);
  }
  return 0;
}
