// calot phantom: a synthetic patient as CT, label map and centrelines.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/staged_folder.h"
#include "app/terminal.h"
#include "calot/patient/phantom.h"

namespace calot {
namespace {

struct PhantomArguments {
  std::filesystem::path folder;
  std::uint64_t seed = 1;
  int count = 1;
};

void write_phantom(const std::filesystem::path& folder, std::uint64_t seed) {
  StagedFolder staged(folder);
  const Phantom phantom = make_biliary_tree(seed, 0.6e-3, &terminal_progress());
  staged.fill(
      [&](const std::filesystem::path& place) {
        write_ct(place / "ct.nii.gz", phantom.ct);
        write_label_map(place / "labels.nii.gz", phantom.labels);
        write_markups(place / "ducts.mrk.json", phantom.lines);
      },
      {"ct.nii.gz", "ducts.mrk.json", "labels.nii.gz"});
  const PhantomFacts& f = phantom.facts;
  char line[300];
  std::snprintf(line, sizeof line,
                "%s: seed %llu, gallbladder %.0f x %.0f mm, %.1f mL; cystic duct %.1f x %.2f mm; "
                "common bile duct %.0f x %.1f mm, hepatic duct %.0f mm above it",
                folder.c_str(), static_cast<unsigned long long>(seed), f.gallbladder_length * 1e3,
                f.gallbladder_width * 1e3, f.gallbladder_volume * 1e6, f.cystic_duct_length * 1e3,
                f.cystic_duct_diameter * 1e3, f.bile_duct_length * 1e3, f.bile_duct_diameter * 1e3,
                f.hepatic_duct_length * 1e3);
  say(line);
}

void run_phantom(const PhantomArguments& arguments) {
  if (arguments.count == 1) return write_phantom(arguments.folder, arguments.seed);
  for (int i = 0; i < arguments.count; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "phantom_%03d", i);
    write_phantom(arguments.folder / name, arguments.seed + static_cast<std::uint64_t>(i));
  }
}

}  // namespace

void add_phantom_command(CLI::App& app) {
  auto arguments = std::make_shared<PhantomArguments>();
  CLI::App* command = app.add_subcommand("phantom", "Make a synthetic patient: CT, label map and duct centrelines");
  command->add_option("-o,--output", arguments->folder, "folder for ct.nii.gz, labels.nii.gz and ducts.mrk.json")
      ->required()
      ->type_name("DIR");
  command->add_option("--seed", arguments->seed, "which patient: the same seed gives the same files")
      ->capture_default_str();
  command->add_option("--count", arguments->count, "how many, with seeds counting up, into DIR/phantom_000 …")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->footer("Example:\n  calot phantom -o patient --seed 7");
  command->callback([arguments] { run_phantom(*arguments); });
}

}  // namespace calot
