#include "calot/patient/mesher.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "calot/base/error.h"
#include "calot/mesh/improve.h"
#include "calot/mesh/parts.h"
#include "calot/patient/cgal_mesh.h"
#include "calot/patient/label_field.h"
#include "calot/patient/mesh_repair.h"
#include "calot/patient/outer_volume.h"
#include "calot/patient/size_field.h"

namespace calot {
namespace {

std::string text(const char* format, auto... values) {
  std::array<char, 300> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

void check(const MesherOptions& options) {
  if (options.vertices < 50) throw InputError("vertices", "are fewer than 50", "ask for more");
  if (options.tets != 0 && options.tets < 100) throw InputError("tets", "are fewer than 100", "ask for more");
  if (!(options.tolerance > 0 && options.tolerance < 1)) throw InputError("tolerance", "isn't between 0 and 1");
  if (!(options.growth > 0)) throw InputError("growth", "isn't positive");
  if (options.tries < 1) throw InputError("tries", "are fewer than 1");
  for (const auto* list : {&options.refine, &options.weights})
    for (const Refinement& r : *list)
      if (!(r.edge > 0) || !std::isfinite(r.edge))
        throw InputError("refine", "an edge length isn't positive", "give millimetres, e.g. 3:1.0");
}

/// Points inside every region, spread over its voxels.
std::vector<Vec3> seeds_in(const LabelField& field) {
  constexpr std::size_t per_region = 24;
  std::vector<std::vector<std::size_t>> voxels(field.labels().size());
  for (std::size_t v = 0; v < field.regions().size(); ++v)
    if (field.regions()[v] > 0) voxels[field.regions()[v] - 1u].push_back(v);
  std::vector<Vec3> seeds;
  const auto& size = field.size();
  for (std::size_t r = 0; r < voxels.size(); ++r)
    for (std::size_t s = 0; s < per_region; ++s) {
      const std::size_t v = voxels[r][(2 * s + 1) * voxels[r].size() / (2 * per_region)];
      const Vec3 at = field.spacing().cwiseProduct(Vec3(static_cast<double>(v % size[0]),
                                                        static_cast<double>(v / size[0] % size[1]),
                                                        static_cast<double>(v / (size[0] * size[1]))));
      if (field.at(at) == static_cast<int>(r + 1)) seeds.push_back(at);
    }
  return seeds;
}

/// The search for sizes and boundary shifts that give the wanted vertex count and volumes.
class Search {
 public:
  Search(const LabelMap& map, const MesherOptions& options, Progress& progress)
      : options_(options),
        progress_(progress),
        field_(map, options.labels, options.smoothing),
        names_(map.names),
        seeds_(seeds_in(field_)) {
    const double voxel = field_.spacing().prod();
    for (const RegionCleaning& label : field_.cleaning())
      wanted_volume_.push_back(static_cast<double>(label.voxels) * voxel);
    extents_ = region_extents(field_);
    shift_.assign(extents_.size(), 0.0);
    for (const RegionExtent& extent : extents_) base_edge_.push_back(std::sqrt(extent.thickness()));
    fixed_.assign(base_edge_.size(), false);
    for (const Refinement& r : options.weights) base_edge_[region_of(r)] = r.edge;
    for (const Refinement& r : options.refine) {
      fixed_[region_of(r)] = true;
      base_edge_[region_of(r)] = r.edge;
    }
  }

  TetMesh run();
  [[nodiscard]] int tries() const { return tries_; }
  [[nodiscard]] const LabelField& field() const { return field_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct Point {
    double log_factor, log_count;
  };
  struct Candidate {
    TetMesh mesh;
    double worst_volume = 0, min_dihedral = 0, max_dihedral = 0;  // relative; degrees
    std::size_t worst_region = 0;                                 // whose volume is off most
    std::vector<std::string> notes;
  };
  [[nodiscard]] std::size_t region_of(const Refinement& refinement) const;
  [[nodiscard]] std::vector<double> edges(double factor) const;
  [[nodiscard]] double first_factor() const;
  Candidate attempt(double factor, bool mend);
  bool shift_boundaries(Candidate& candidate);
  void set_biases();
  [[nodiscard]] bool better(const Candidate& a, const Candidate& b) const;
  [[nodiscard]] bool within_bounds(const Candidate& c) const {
    const double most = options_.max_volume_error > 0 ? options_.max_volume_error : 0.999;  // nobody loses all tets
    return c.worst_volume <= most && c.min_dihedral >= options_.min_dihedral_taken &&
           c.max_dihedral <= options_.max_dihedral_taken;
  }
  void note_shortfall(const Candidate& candidate);
  [[noreturn]] void report_failure() const;
  [[nodiscard]] double next_log_factor() const;
  [[nodiscard]] double away_from_earlier(double log_factor) const;
  [[nodiscard]] bool sound(const Candidate& c) const {
    return c.min_dihedral >= options_.min_dihedral && c.max_dihedral <= options_.max_dihedral;
  }
  /// What is searched for, and how much of it a mesh has: tets where those are asked for, else vertices.
  [[nodiscard]] double wanted() const {
    return static_cast<double>(options_.tets > 0 ? options_.tets : options_.vertices);
  }
  [[nodiscard]] double count(const TetMesh& mesh) const {
    return static_cast<double>(options_.tets > 0 ? mesh.tet_count() : mesh.vertex_count());
  }
  [[nodiscard]] bool counts_match(double count, double part) const {
    return std::abs(count - wanted()) <= part * options_.tolerance * wanted();
  }

  const MesherOptions& options_;
  Progress& progress_;
  LabelField field_;
  const std::map<Label, std::string>& names_;
  std::vector<Vec3> seeds_;
  std::vector<double> wanted_volume_, base_edge_;
  std::vector<double> shift_;  // of each region's boundary, in steps of the smoothed field
  std::vector<RegionExtent> extents_;
  std::vector<bool> fixed_;
  std::vector<Point> history_;
  std::vector<std::string> notes_;
  std::string shortfall_;  // of the last mesh that had the count and was refused
  int tries_ = 0;
};

std::size_t Search::region_of(const Refinement& refinement) const {
  const auto at = std::find(options_.labels.begin(), options_.labels.end(), refinement.label);
  if (at == options_.labels.end())
    throw InputError("refine", "label " + std::to_string(refinement.label) + " isn't meshed", "choose it as well");
  return static_cast<std::size_t>(at - options_.labels.begin());
}

std::vector<double> Search::edges(double factor) const {
  std::vector<double> result = base_edge_;
  for (std::size_t r = 0; r < result.size(); ++r)
    if (!fixed_[r]) result[r] *= factor;
  return result;
}

double Search::first_factor() const {
  constexpr double tets_per_vertex = 4.6;
  const double vertices = wanted() / (options_.tets > 0 ? tets_per_vertex : 1);
  double low = std::log(1e-5), high = std::log(10.0);
  for (int step = 0; step < 50; ++step) {
    const double middle = (low + high) / 2;
    (estimated_vertices(extents_, edges(std::exp(middle))) > vertices ? low : high) = middle;
  }
  return (low + high) / 2;
}

Search::Candidate Search::attempt(double factor, bool mend) {
  ++tries_;
  const SizeField sizes(field_, edges(factor), options_.growth);
  const Vec3 extent = field_.spacing().cwiseProduct(Vec3(static_cast<double>(field_.size()[0] - 1),
                                                         static_cast<double>(field_.size()[1] - 1),
                                                         static_cast<double>(field_.size()[2] - 1)));
  MeshingProblem problem;
  problem.region = [&](const Vec3& p) { return field_.at(p); };
  problem.edge = [&](const Vec3& p) {
    if (progress_.stop_requested()) throw Interrupted();
    return sizes.at(p);
  };
  problem.box = Eigen::AlignedBox3d(Vec3::Zero(), extent);
  problem.seeds = seeds_;
  Candidate candidate;
  candidate.mesh = cgal_mesh(problem);
  candidate.notes = repair_regions(candidate.mesh, field_.labels().size());
  if (mend) {
    improve(candidate.mesh, {.min_dihedral = options_.min_dihedral + 4, .max_dihedral = options_.max_dihedral - 7});
    detail::fit_outer_volumes(candidate.mesh, wanted_volume_, options_.min_dihedral + 2, options_.max_dihedral - 4);
  }
  const Quality measured = quality(candidate.mesh);
  candidate.min_dihedral = measured.min_dihedral;
  candidate.max_dihedral = measured.max_dihedral;
  return candidate;
}

/// Moves each region's boundary by what its volume lacks. Returns whether nothing is left to be gained that way.
bool Search::shift_boundaries(Candidate& candidate) {
  const TetMesh& mesh = candidate.mesh;
  std::vector<double> volume(wanted_volume_.size(), 0.0);
  for (std::size_t t = 0; t < mesh.tet_count(); ++t)
    volume[static_cast<std::size_t>(mesh.regions[t]) - 1] += signed_volume(mesh, TetId(t));
  bool settled = true;
  for (std::size_t r = 0; r < volume.size(); ++r) {
    const double lack = (wanted_volume_[r] - volume[r]) / wanted_volume_[r];
    if (std::abs(lack) >= candidate.worst_volume) {
      candidate.worst_volume = std::abs(lack);
      candidate.worst_region = r;
    }
    if (tries_ > 2 * options_.tries / 3) continue;  // later, only the count is searched for
    // Surface = 4 volume / thickness, so the boundary must move by lack · thickness / 4 [voxels], over which the
    // smoothed field falls by about two thirds; a shift is a difference of two fields, so it counts twice.
    const double move = lack * extents_[r].thickness() / 4 / field_.spacing().mean();
    const double before = shift_[r];
    shift_[r] = std::clamp(before + 1.1 * move, -0.4, 0.5);
    if (std::abs(lack) > 0.02 && std::abs(shift_[r] - before) > 0.02) settled = false;
  }
  set_biases();
  return settled;
}

/// A region's shift counts from what surrounds it: on a boundary the smaller region decides, else neighbours would
/// outbid each other. So a region's bias is its shift on top of the biases of its larger neighbours, by area.
void Search::set_biases() {
  std::vector<std::size_t> order(shift_.size());
  for (std::size_t r = 0; r < order.size(); ++r) order[r] = r;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return extents_[a].volume > extents_[b].volume; });
  std::vector<double> bias(shift_.size() + 1, 0.0);
  std::vector<std::uint8_t> larger(shift_.size() + 1, 0);
  larger[0] = 1;  // the outside
  for (const std::size_t r : order) {
    double sum = 0, area = 0;
    for (std::size_t s = 0; s < larger.size(); ++s)
      if (larger[s] != 0) {
        sum += extents_[r].contact[s] * bias[s];
        area += extents_[r].contact[s];
      }
    bias[r + 1] = (area > 0 ? sum / area : 0) + shift_[r];
    larger[r + 1] = 1;
    field_.set_bias(r + 1, bias[r + 1]);
  }
}

/// Regula falsi while the goal is bracketed, extrapolation along the last slope before.
double Search::next_log_factor() const {
  const double goal = std::log(wanted());
  const Point& last = history_.back();
  std::optional<Point> fine,
      coarse;  // nearest to the goal from above and from below; late ones know the boundaries better
  for (const Point& p : history_) {
    if (p.log_count >= goal && (!fine || p.log_count <= fine->log_count)) fine = p;
    if (p.log_count < goal && (!coarse || p.log_count >= coarse->log_count)) coarse = p;
  }
  if (fine && coarse && fine->log_factor < coarse->log_factor) {
    const double part = (fine->log_count - goal) / (fine->log_count - coarse->log_count);
    return fine->log_factor + std::clamp(part, 0.1, 0.9) * (coarse->log_factor - fine->log_factor);
  }
  constexpr double usual_slope = -2.3;  // between surface and volume
  return last.log_factor + std::clamp((goal - last.log_count) / usual_slope, -0.7, 0.5);
}

/// Counts jump by several per cent between neighbouring sizes, so a size that was tried already is worth no second try:
/// take one beside it.
double Search::away_from_earlier(double log_factor) const {
  for (const Point& p : history_)
    if (std::abs(p.log_factor - log_factor) < 0.0015) return log_factor + 0.0012 * tries_ * (tries_ % 2 == 0 ? 1 : -1);
  return log_factor;
}

/// Better meshes are those with the wanted angles, and of these the ones with the right volumes.
bool Search::better(const Candidate& a, const Candidate& b) const {
  const bool a_sound = sound(a), b_sound = sound(b);
  if (a_sound != b_sound) return a_sound;
  const auto slack = [](const Candidate& c) { return std::min(c.min_dihedral, 180 - c.max_dihedral); };
  return a_sound ? a.worst_volume < b.worst_volume : slack(a) > slack(b);
}

void Search::note_shortfall(const Candidate& candidate) {
  const Label label = field_.labels()[candidate.worst_region];
  const auto name = names_.find(label);
  shortfall_ = text("with %.0f %s, %s is %.0f %% off its volume and angles are %.1f to %.1f degrees", wanted(),
                    options_.tets > 0 ? "tetrahedra" : "vertices",
                    name == names_.end() ? ("label " + std::to_string(label)).c_str() : ("the " + name->second).c_str(),
                    100 * candidate.worst_volume, candidate.min_dihedral, candidate.max_dihedral);
}

void Search::report_failure() const {
  if (!shortfall_.empty())
    throw FailedError("mesh", shortfall_,
                      "ask for more tets or vertices, refine it, or give a label map with smaller voxels");
  const Point* nearest = &history_.front();
  const double goal = std::log(wanted());
  for (const Point& p : history_)
    if (std::abs(p.log_count - goal) < std::abs(nearest->log_count - goal)) nearest = &p;
  const double reached = std::round(std::exp(nearest->log_count));
  const char* const what = options_.tets > 0 ? "tetrahedra" : "vertices";
  throw FailedError(
      "mesh", text("no mesh with %.0f %s in %d tries; the nearest had %.0f", wanted(), what, tries_, reached),
      reached > wanted()
          ? text("ask for more %s, coarser refinement or fewer labels: thin regions need a least number", what)
          : text("ask for fewer %s", what));
}

TetMesh Search::run() {
  double log_factor = first_factor();
  std::optional<Candidate> best;
  bool near = false;
  while (tries_ < options_.tries) {
    progress_.at(static_cast<double>(tries_) / options_.tries);
    Candidate candidate = attempt(std::exp(log_factor), near);
    const double reached = count(candidate.mesh);
    const bool settled = shift_boundaries(candidate);
    const bool closed = check_manifold(boundary_surface(candidate.mesh)).closed_manifold();
    history_.push_back({log_factor, std::log(std::max(reached, 1.0))});
    const bool counted = near && closed && counts_match(reached, 1);
    const bool usable = counted && within_bounds(candidate);
    if (counted && !usable) note_shortfall(candidate);
    const bool good = (settled || candidate.worst_volume <= 0.02) && sound(candidate);
    if (usable && (!best || better(candidate, *best))) best = std::move(candidate);
    if (usable && good) break;
    near = counts_match(reached, 3);  // slivers are worth removing only then
    log_factor = away_from_earlier(next_log_factor());
  }
  if (!best) report_failure();
  notes_ = std::move(best->notes);
  return std::move(best->mesh);
}

MeshedRegion describe(const LabelMap& map, const LabelField& field, std::size_t r, const TetMesh& mesh) {
  MeshedRegion region;
  region.label = field.labels()[r];
  if (const auto name = map.names.find(region.label); name != map.names.end()) region.name = name->second;
  const RegionCleaning& cleaning = field.cleaning()[r];
  region.voxels = cleaning.voxels;
  region.specks = cleaning.specks;
  region.moved_voxels = cleaning.moved;
  region.voxel_volume = static_cast<double>(cleaning.voxels) * map.grid.voxel_volume();
  region.quality = quality(mesh, region.label);
  return region;
}

}  // namespace

LabelMesh mesh_labels(const LabelMap& map, const MesherOptions& asked, Progress& progress) {
  check(asked);
  MesherOptions options = asked;
  if (options.labels.empty())
    for (const auto& [label, count] : voxel_counts(map)) options.labels.push_back(label);
  if (options.labels.empty()) throw InputError("labels", "the map has no label but background", "give a segmentation");
  progress.phase("meshing");
  Search search(map, options, progress);
  LabelMesh result;
  result.mesh = search.run();
  result.tries = search.tries();
  result.notes = search.notes();
  for (Vec3& p : result.mesh.positions) p = search.field().to_world() * p;
  orient(result.mesh);
  for (std::int32_t& region : result.mesh.regions)
    region = search.field().labels()[static_cast<std::size_t>(region) - 1];
  for (const Label label : options.labels)
    if (const auto name = map.names.find(label); name != map.names.end())
      result.mesh.region_names[label] = name->second;
  for (std::size_t r = 0; r < options.labels.size(); ++r) {
    result.regions.push_back(describe(map, search.field(), r, result.mesh));
    const MeshedRegion& region = result.regions.back();
    if (region.specks > 0)
      result.notes.push_back(
          text("label %s: %zu specks (%zu voxels) beside its largest part were given to what surrounds them",
               label_text(map, region.label).c_str(), region.specks, region.moved_voxels));
  }
  result.quality = quality(result.mesh);
  result.outer = check_manifold(boundary_surface(result.mesh));
  progress.at(1);
  return result;
}

std::map<std::string, std::string> mesher_versions() {
  return {{"CGAL", cgal_version()},
          {"Eigen", text("%d.%d.%d", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

}  // namespace calot
