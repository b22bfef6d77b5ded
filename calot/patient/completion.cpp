#include "calot/patient/completion.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/image/voxel_parts.h"
#include "calot/patient/border.h"
#include "calot/patient/label_cleaning.h"
#include "calot/patient/tissue_layers.h"
#include "calot/patient/tube_drawing.h"
#include "calot/patient/tube_line.h"
#include "calot/patient/working_grid.h"

namespace calot {
namespace {

void check_range(const char* name, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw InputError("completion", text_of("%s is %.4g", name, value), text_of("give %.4g … %.4g", low, high));
}

void check_options(const CompletionOptions& o) {
  check_range("spacing [m]", o.spacing, 0.3e-3, 1e-3);
  check_range("margin [m]", o.margin, 5e-3, 100e-3);
  check_range("closing [m]", o.closing, 0, 5e-3);
  check_range("ragged_above", o.ragged_above, 1, 100);
  check_range("largest_hole [m³]", o.largest_hole, 0, 1e-3);
  check_range("overlap [m]", o.overlap, 0, 10e-3);
  check_range("joint_reach [m]", o.joint_reach, 0, 30e-3);
  check_range("connective_reach [m]", o.connective_reach, 0, 20e-3);
  check_range("triangle_reach [m]", o.triangle_reach, 0, 50e-3);
  check_range("bed_thickness [m]", o.bed_thickness, 0, 20e-3);
  check_range("bed_reach [m]", o.bed_reach, 0, 50e-3);
  check_range("fat_low [HU]", o.fat_low, -1000, o.fat_high);
  check_range("connective_low [HU]", o.connective_low, -1000, o.connective_high);
}

/// The structures' surroundings as bytes: the rest of the volume needs no work.
WorkLabels compact(const LabelMap& labels, double closing) {
  VoxelBox box;
  const auto& size = labels.grid.size;
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    const Label label = labels.voxels[v];
    if (label == 0) continue;
    if (label > all_structures().size())
      throw InputError("labels", text_of("label %u is no structure", static_cast<unsigned>(label)),
                       "map the segmentation's names to structures first");
    const VoxelSize at{v % size[0], v / size[0] % size[1], v / (size[0] * size[1])};
    box = joined(box, {at, {at[0] + 1, at[1] + 1, at[2] + 1}});
  }
  VoxelSize room{};
  for (std::size_t d = 0; d < 3; ++d)
    room[d] = 5 + static_cast<std::size_t>(std::ceil(closing / labels.grid.spacing()[static_cast<Eigen::Index>(d)]));
  box = padded(box, room, size);
  WorkLabels work;
  work.grid.size = box.size();
  work.grid.to_world =
      labels.grid.to_world * Eigen::Translation3d(static_cast<double>(box.first[0]), static_cast<double>(box.first[1]),
                                                  static_cast<double>(box.first[2]));
  work.voxels.resize(box.count());
  for_voxels(box, size,
             [&](std::size_t v, std::size_t b) { work.voxels[b] = static_cast<std::uint8_t>(labels.voxels[v]); });
  return work;
}

/// What there is, by label or line.
std::set<Structure> check_input(const CtImage& ct, const LabelMap& labels, const std::vector<Centreline>& lines) {
  const auto whole = [](const VoxelGrid& grid, std::size_t voxels) {
    return grid.count() > 0 && voxels == grid.count();
  };
  if (!whole(ct.grid, ct.hounsfield.size()) || !whole(labels.grid, labels.voxels.size()))
    throw InputError("labels", "or CT have no voxels, or not as many as their grid says");
  if (const std::string difference = grid_difference(ct.grid, labels.grid); !difference.empty())
    throw InputError("labels", "are on another grid than the CT (CT and labels differ: " + difference + ")",
                     "resample the labels onto the CT, or give the CT that they were made on");
  std::set<Structure> there;
  for (const auto& [label, count] : voxel_counts(labels)) there.insert(static_cast<Structure>(label));
  const auto need = [&](Structure s) {
    if (!there.contains(s))
      throw InputError("labels", "have no " + std::string(name_of(s)), "segment it, or map its name to the structure");
  };
  need(Structure::gallbladder);
  need(Structure::liver);
  check_lines(lines, ct);
  for (const Centreline& line : lines) there.insert(*structure_named(line.name));
  if (!there.contains(Structure::cystic_duct))
    throw InputError("labels", "have no cystic duct, and no centreline draws it",
                     "draw a centreline \"cystic duct\" from the bile duct to the gallbladder's neck");
  if (!there.contains(Structure::common_bile_duct) && !there.contains(Structure::common_hepatic_duct))
    throw InputError("labels", "have no bile duct, and no centreline draws it",
                     "draw a centreline \"common bile duct\", above and below the cystic duct's mouth");
  return there;
}

void warn_of_cuts(const CompletedAnatomy& anatomy, const VoxelGrid& grid, std::vector<std::string>& warnings) {
  for (const BorderCut& cut : anatomy.border_cuts)
    warnings.push_back(text_of("the %s is cut by the volume's %s end (%.1f cm²); the cut face becomes a fixed boundary",
                               std::string(name_of(cut.structure)).c_str(),
                               side_name(grid, cut.axis, cut.upper).c_str(), 1e4 * cut.area));
}

std::map<Structure, std::size_t> counts_of(const WorkLabels& labels, const auto& structures) {
  std::map<Structure, std::size_t> counts;
  for (const Structure s : structures) counts[s] = labels.count(s);
  return counts;
}

/// Of structures that the steps from `first` on took more than a twentieth of.
void warn_of_losses(const char* what, const std::map<Structure, std::size_t>& before, std::size_t first,
                    CompletedAnatomy& anatomy) {
  std::map<Structure, std::pair<std::size_t, double>> lost;  // voxels, mL
  for (std::size_t s = first; s < anatomy.steps.size(); ++s) {
    auto& [voxels, ml] = lost[anatomy.steps[s].structure];
    voxels += anatomy.steps[s].removed;
    ml += anatomy.steps[s].removed_ml;
  }
  for (const auto& [s, loss] : lost)
    if (const auto was = before.find(s); was != before.end() && 20 * loss.first > was->second)
      anatomy.warnings.push_back(text_of("%s took %.0f %% of the %s (%.3g mL); look whether its label is in pieces",
                                         what, 100 * static_cast<double>(loss.first) / static_cast<double>(was->second),
                                         std::string(name_of(s)).c_str(), loss.second));
}

WorkLabels on_working_grid(const CtImage& ct, const WorkLabels& labels, const WorkingGrid& chosen,
                           CompletedAnatomy& anatomy, Progress& progress) {
  anatomy.ct = resample_ct(ct, chosen.grid, progress);
  WorkLabels work = resample_labels(labels, chosen, progress);
  report_resampling(labels, work, chosen.detail, anatomy.steps);
  if (!chosen.warning.empty()) anatomy.warnings.push_back(chosen.warning);
  anatomy.steps.push_back({"working grid", Structure::none, 0, 0, 0, 0, chosen.detail});
  return work;
}

/// One piece each; what goes is given to whom it touches most.
void keep_one_piece(WorkLabels& labels, std::vector<CompletionStep>& steps) {
  VoxelBox box;
  const std::array<VoxelBox, 256> boxes = boxes_of(labels.voxels, labels.grid.size);
  for (const Structure s : all_structures()) box = joined(box, boxes[label_of(s)]);
  box = padded(box, {1, 1, 1}, labels.grid.size);
  LabelEdit edit(labels);
  for (int round = 0; round < 4; ++round) {  // a speck that moves may leave a speck: rare, and soon over
    std::vector<std::uint8_t> regions(box.count());
    for_voxels(box, labels.grid.size, [&](std::size_t v, std::size_t b) { regions[b] = labels.voxels[v]; });
    std::size_t specks = 0;
    for (const RegionCleaning& cleaning : keep_largest_parts(regions, box.size(), all_structures().size()))
      specks += cleaning.specks;
    if (specks == 0) break;
    for_voxels(box, labels.grid.size,
               [&](std::size_t v, std::size_t b) { edit.set(v, static_cast<Structure>(regions[b])); });
  }
  edit.report_all(steps, "one piece each", "parts that had come off go to what they touch most");
}

/// What the drawing promised still holds.
void check_result(const WorkLabels& labels, const std::set<Structure>& there, const DrawnTubes& drawn,
                  const std::map<Structure, std::size_t>& before) {
  for (const Structure s : there) {
    const std::size_t now = labels.count(s);
    const auto was = before.find(s);
    if (now == 0 || (is_tube(s) && was != before.end() && 10 * now < 9 * was->second))
      throw InputError("labels", "the " + std::string(name_of(s)) + " comes apart where it meets other structures",
                       "draw it, or what crosses it, with a centreline that passes beside");
  }
  for (const auto& [tube, neighbour] : drawn.joints)
    if (!touches(labels, tube, neighbour))
      throw FailedError(
          "labels",
          "the " + std::string(name_of(tube)) + " could not be joined to the " + std::string(name_of(neighbour)),
          "draw its end anew");
}

}  // namespace

CompletedAnatomy complete_anatomy(const CtImage& ct, const LabelMap& labels, const std::vector<Centreline>& lines,
                                  const CompletionOptions& options, Progress& progress) {
  progress.phase("completing: checks");
  check_options(options);
  std::set<Structure> there = check_input(ct, labels, lines);
  std::set<Structure> redrawn;
  for (const Centreline& line : lines) redrawn.insert(*structure_named(line.name));
  CompletedAnatomy anatomy;
  anatomy.border_cuts = border_cuts(labels, redrawn);
  warn_of_cuts(anatomy, ct.grid, anatomy.warnings);
  WorkLabels work;
  {
    WorkLabels source = compact(labels, options.closing);
    const std::map<Structure, std::size_t> given = counts_of(source, there);
    clean_labels(source, options, redrawn, anatomy.steps, progress);
    warn_of_losses("cleaning", given, 0, anatomy);
    work = on_working_grid(ct, source, choose_working_grid(source, ct.grid, lines, options), anatomy, progress);
  }
  const DrawnTubes drawn = draw_tubes(work, lines, options, anatomy.steps, anatomy.warnings, progress);
  anatomy.lines = drawn.lines;
  const std::map<Structure, std::size_t> before = counts_of(work, there);
  if (options.fat) {
    progress.phase("completing: fat and bed");
    add_gallbladder_bed(work, anatomy.ct, options, anatomy.steps, anatomy.warnings);
    progress.at(0.5);
    add_triangle_fat(work, anatomy.ct, anatomy.lines, options, anatomy.steps, anatomy.warnings);
  }
  progress.phase("completing: one piece each");
  const std::map<Structure, std::size_t> scattered = counts_of(work, all_structures());
  const std::size_t steps = anatomy.steps.size();
  keep_one_piece(work, anatomy.steps);
  warn_of_losses("keeping one piece of each structure", scattered, steps, anatomy);
  check_result(work, there, drawn, before);
  anatomy.labels = {work.grid, {work.voxels.begin(), work.voxels.end()}, structure_names()};
  progress.at(1);
  return anatomy;
}

}  // namespace calot
