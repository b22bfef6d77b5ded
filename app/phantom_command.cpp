// calot phantom: a synthetic patient as CT, label map, centrelines and the truth about it.
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "app/staged_folder.h"
#include "app/terminal.h"
#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/patient/phantom.h"

namespace calot {
namespace {

struct PhantomArguments {
  std::filesystem::path folder;
  std::uint64_t seed = 1;
  int count = 1;
  std::string variant = "usual", matrix;
  std::optional<double> voxel;  ///< [mm]
  bool tree = false;
};

PhantomVariant parse_variant(const std::string& name) {
  if (const auto variant = variant_named(name)) return *variant;
  std::string all;
  for (const auto v :
       {PhantomVariant::usual, PhantomVariant::short_cystic_duct, PhantomVariant::low_insertion,
        PhantomVariant::aberrant_right_duct, PhantomVariant::second_cystic_artery, PhantomVariant::inflamed})
    all += (all.empty() ? "" : ", ") + std::string(name_of(v));
  throw InputError("--variant " + name, "is no variant", "there are " + all);
}

/// "512x512x300".
std::array<std::size_t, 3> parse_matrix(const std::string& text) {
  std::array<std::size_t, 3> size{};
  const char *at = text.data(), *end = at + text.size();
  for (std::size_t d = 0; d < 3; ++d) {
    if (d > 0 && (at == end || *at++ != 'x')) at = nullptr;
    const auto [stop, code] =
        at ? std::from_chars(at, end, size[d]) : std::from_chars_result{nullptr, std::errc::invalid_argument};
    if (code != std::errc() || (d == 2 && stop != end))
      throw InputError("--matrix " + text, "isn't COLUMNSxROWSxSLICES", "write e.g. --matrix 512x512x300");
    at = stop;
  }
  return size;
}

/// Lengths in mm, volumes in mL; what isn't there is left out.
nlohmann::ordered_json truth_of(const PhantomArguments& arguments, std::uint64_t seed, const Phantom& phantom) {
  const PhantomFacts& f = phantom.facts;
  nlohmann::ordered_json json;
  json["seed"] = seed;
  json["variant"] = arguments.tree ? "tree" : arguments.variant;
  const auto length = [&](const char* name, double metres) {
    if (metres > 0) json[std::string(name) + "_mm"] = metres * 1e3;
  };
  const auto volume = [&](const char* name, double cubic_metres) {
    if (cubic_metres > 0) json[std::string(name) + "_mL"] = cubic_metres * 1e6;
  };
  volume("liver_volume", f.liver_volume);
  length("liver_width", f.liver_width);
  length("liver_depth", f.liver_depth);
  length("liver_height", f.liver_height);
  volume("gallbladder_volume", f.gallbladder_volume);
  length("gallbladder_length", f.gallbladder_length);
  length("gallbladder_width", f.gallbladder_width);
  length("gallbladder_wall_thickness", f.wall_thickness);
  length("cystic_duct_length", f.cystic_duct_length);
  length("cystic_duct_diameter", f.cystic_duct_diameter);
  length("common_bile_duct_length", f.bile_duct_length);
  length("common_bile_duct_diameter", f.bile_duct_diameter);
  length("common_hepatic_duct_length", f.hepatic_duct_length);
  length("cystic_artery_length", f.cystic_artery_length);
  length("cystic_artery_diameter", f.cystic_artery_diameter);
  for (const auto& [label, count] : voxel_counts(phantom.labels))
    json["label_volumes_mL"][phantom.labels.names.at(label)] =
        static_cast<double>(count) * phantom.labels.grid.voxel_volume() * 1e6;
  return json;
}

void say_facts(const std::filesystem::path& folder, const PhantomArguments& arguments, std::uint64_t seed,
               const PhantomFacts& f) {
  char line[500], field[200] = "";
  if (f.liver_volume > 0)
    std::snprintf(field, sizeof field, "; liver %.0f mL, %.0f x %.0f x %.0f mm; cystic artery %.1f x %.2f mm",
                  f.liver_volume * 1e6, f.liver_width * 1e3, f.liver_depth * 1e3, f.liver_height * 1e3,
                  f.cystic_artery_length * 1e3, f.cystic_artery_diameter * 1e3);
  std::snprintf(line, sizeof line,
                ": %s, seed %llu, gallbladder %.0f x %.0f mm, %.1f mL; cystic duct %.1f x %.2f mm; "
                "common bile duct %.0f x %.1f mm, hepatic duct %.0f mm above it%s",
                arguments.tree ? "biliary tree" : arguments.variant.c_str(), static_cast<unsigned long long>(seed),
                f.gallbladder_length * 1e3, f.gallbladder_width * 1e3, f.gallbladder_volume * 1e6,
                f.cystic_duct_length * 1e3, f.cystic_duct_diameter * 1e3, f.bile_duct_length * 1e3,
                f.bile_duct_diameter * 1e3, f.hepatic_duct_length * 1e3, field);
  say(folder.string() + line);
}

Phantom make(const PhantomArguments& arguments, std::uint64_t seed) {
  if (arguments.tree) return make_biliary_tree(seed, arguments.voxel.value_or(0.6) * 1e-3, &terminal_progress());
  PhantomOptions options;
  options.seed = seed;
  options.variant = parse_variant(arguments.variant);
  options.voxel = arguments.voxel.value_or(0.7) * 1e-3;
  if (!arguments.matrix.empty()) options.matrix = parse_matrix(arguments.matrix);
  return make_phantom(options, terminal_progress());
}

void write_phantom(const PhantomArguments& arguments, const std::filesystem::path& folder, std::uint64_t seed) {
  StagedFolder staged(folder);
  staged.require_own("truth.json");
  staged.open();
  const Phantom phantom = make(arguments, seed);
  const std::string truth = truth_of(arguments, seed, phantom).dump(2) + "\n";
  terminal_progress().phase("phantom: files");
  staged.fill(
      [&](const std::filesystem::path& place) {
        write_ct(place / "ct.nii.gz", phantom.ct);
        terminal_progress().at(0.9);
        write_label_map(place / "labels.nii.gz", phantom.labels);
        write_markups(place / "ducts.mrk.json", phantom.lines);
        write_file(place / "truth.json", [&](std::ostream& out) { out << truth; });
      },
      {"ct.nii.gz", "ducts.mrk.json", "labels.nii.gz", "truth.json"});
  terminal_progress().at(1);
  say_facts(folder, arguments, seed, phantom.facts);
}

void run_phantom(const PhantomArguments& arguments) {
  if (arguments.count == 1) return write_phantom(arguments, arguments.folder, arguments.seed);
  for (int i = 0; i < arguments.count; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "phantom_%03d", i);
    write_phantom(arguments, arguments.folder / name, arguments.seed + static_cast<std::uint64_t>(i));
  }
}

}  // namespace

void add_phantom_command(CLI::App& app) {
  auto arguments = std::make_shared<PhantomArguments>();
  CLI::App* command =
      app.add_subcommand("phantom", "Make a synthetic patient: CT, label map, centrelines and the truth about it");
  command
      ->add_option("-o,--output", arguments->folder, "folder for ct.nii.gz, labels.nii.gz, ducts.mrk.json, truth.json")
      ->required()
      ->type_name("DIR");
  command->add_option("--seed", arguments->seed, "which patient: the same seed gives the same files")
      ->capture_default_str();
  command->add_option("--count", arguments->count, "how many, with seeds counting up, into DIR/phantom_000 …")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  CLI::Option* variant =
      command
          ->add_option("--variant", arguments->variant,
                       "usual, short-cystic-duct, low-insertion, aberrant-right-duct, second-cystic-artery or inflamed")
          ->type_name("NAME")
          ->capture_default_str();
  CLI::Option* voxel =
      command->add_option("--voxel", arguments->voxel, "edge of the voxels; default 0.7, of the tree alone 0.6")
          ->type_name("MM");
  CLI::Option* matrix =
      command->add_option("--matrix", arguments->matrix, "a CT of the whole trunk instead of a box around the liver")
          ->type_name("COLUMNSxROWSxSLICES")
          ->excludes(voxel);
  command->add_flag("--tree", arguments->tree, "gallbladder, cystic and bile duct alone, in fat")
      ->excludes(variant)
      ->excludes(matrix);
  command->footer("Example:\n  calot phantom -o patient --seed 7 --variant inflamed");
  command->callback([arguments] { run_phantom(*arguments); });
}

}  // namespace calot
