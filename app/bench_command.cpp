// `calot bench`: runs a benchmark and says whether it reached its goals.
#include <iostream>
#include <memory>

#include "app/commands.h"
#include "app/terminal.h"
#include "bench/bench.h"
#include "calot/base/error.h"
#include "calot/base/files.h"

namespace calot {
namespace {

struct Arguments {
  std::string name;
  std::filesystem::path output, model;
  bool json = false, list = false;
};

void run_bench(const Arguments& arguments) {
  if (arguments.list) {
    for (const bench::Bench& bench : bench::benches()) say(bench.name + ": " + bench.description);
    return;
  }
  if (arguments.name.empty())
    throw InputError("bench", "which one?", "name a benchmark; calot bench --list shows them");
  const bench::Bench& bench = bench::find_bench(arguments.name);
  const bench::Report report = bench::run(bench, {arguments.output, arguments.model, &terminal_progress()});
  const std::string json = bench::to_json(report);
  if (!arguments.output.empty()) {
    write_file(arguments.output / (bench.name + ".json"), [&](std::ostream& out) { out << json; });
    write_file(arguments.output / (bench.name + ".txt"), [&](std::ostream& out) { out << bench::to_text(report); });
  }
  std::cout << (arguments.json ? json : bench::to_text(report));
}

}  // namespace

void add_bench_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("bench", "Runs a benchmark: measured numbers beside goals and baselines");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("NAME", arguments->name, "the benchmark");
  command->add_flag("--list", arguments->list, "names every benchmark");
  command->add_flag("--json", arguments->json, "prints one JSON object on stdout");
  command->add_option("-o,--output", arguments->output, "folder for the JSON, tables, figures and pictures");
  command->add_option("--model", arguments->model, "measures this model.toml instead of the benchmark's own mesh");
  command->footer("Example: calot bench cut --json -o out/bench");
  command->callback([arguments] { run_bench(*arguments); });
}

}  // namespace calot
