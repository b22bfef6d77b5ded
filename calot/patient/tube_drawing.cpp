#include "calot/patient/tube_drawing.h"

#include <algorithm>
#include <cmath>

#include "calot/base/error.h"
#include "calot/image/morphology.h"
#include "calot/patient/line_of_label.h"
#include "calot/patient/sweep.h"
#include "calot/patient/tube_line.h"

namespace calot {
namespace {

constexpr std::array<Structure, 7> order{Structure::common_hepatic_duct, Structure::common_bile_duct,
                                         Structure::aberrant_right_duct, Structure::right_hepatic_artery,
                                         Structure::cystic_duct,         Structure::cystic_artery,
                                         Structure::second_cystic_artery};

/// A tube on its way into the labels.
struct Tube {
  Structure structure = Structure::none;
  bool given = false;
  Centreline line;    // as it runs: finely stepped
  double radius = 0;  // mean
};

/// What one end of a tube joins.
struct End {
  bool last = false;        // at the line's last point
  StructureSet neighbours;  // any of them
  bool required = true;
  std::string name;  // of the neighbours, for messages
};

/// A ball of the swept tube.
struct Bead {
  Vec3 centre;
  double radius = 0;
  bool beyond = false;      // past the joint: the neighbour keeps its voxels
  StructureSet neighbours;  // of that joint
};

double mean_radius(const Centreline& line) {
  double sum = 0;
  for (const double r : line.radii) sum += r;
  return sum / static_cast<double>(line.radii.size());
}

class Drawing {
 public:
  Drawing(WorkLabels& labels, const CompletionOptions& options, std::vector<CompletionStep>& steps,
          std::vector<std::string>& warnings)
      : labels_(labels),
        options_(options),
        steps_(steps),
        warnings_(warnings),
        edit_(labels),
        spacing_(labels.grid.spacing()),
        to_voxel_(labels.grid.to_world.inverse()) {}

  void gather(const std::vector<Centreline>& given) {
    present_ = boxes_of(labels_.voxels, labels_.grid.size);
    for (const Structure s : order) {
      const auto line =
          std::find_if(given.begin(), given.end(), [&](const Centreline& c) { return structure_named(c.name) == s; });
      if (line != given.end())
        gather_given(s, *line);
      else if (has(s))
        tubes_.push_back({s, false, line_of_label(labels_, s), 0});
    }
    for (Tube& tube : tubes_) tube.radius = mean_radius(tube.line);
    present_ = boxes_of(labels_.voxels, labels_.grid.size);
  }

  void draw(Tube& tube) {
    orient(tube.line, tube.structure, labels_);
    std::vector<Bead> beads;
    if (tube.given)
      for (std::size_t p = 0; p < tube.line.points.size(); ++p)
        beads.push_back({tube.line.points[p], drawn_radius(tube.line.radii[p]), false, {}});
    else
      bridge(tube);
    const std::vector<End> ends = ends_of(tube);
    for (const End& end : ends) {
      std::vector<Bead> joint;  // of a tube that has its label already
      join(tube, end, tube.given ? beads : joint);
      sweep(tube, joint, "joined to its neighbours");
    }
    sweep(tube, beads, "drawn from its centreline");
    for (const End& end : ends) note_joint(tube, end);
    result_.lines.push_back(finished(tube, beads));
  }

  std::vector<Tube>& tubes() { return tubes_; }
  DrawnTubes take() { return std::move(result_); }

 private:
  [[nodiscard]] bool has(Structure s) const { return !present_[label_of(s)].empty(); }
  [[nodiscard]] double step() const { return 0.3 * spacing_.minCoeff(); }
  [[nodiscard]] double drawn_radius(double r) const { return std::max(r, 0.9 * spacing_.maxCoeff()); }

  void gather_given(Structure s, const Centreline& line) {
    tubes_.push_back({s, true, fine_line(line, step()), 0});
    const double thin = *std::min_element(line.radii.begin(), line.radii.end());
    if (drawn_radius(thin) > thin)
      warnings_.push_back(
          text_of("%s: drawn %.2g mm wide where its centreline says %.2g mm; voxels of %.2g mm hold no "
                  "thinner tube",
                  line.name.c_str(), 2e3 * drawn_radius(thin), 2e3 * thin, 1e3 * spacing_.maxCoeff()));
    for_voxels(present_[label_of(s)], labels_.grid.size, [&](std::size_t v, std::size_t) {
      if (labels_.at(v) == s) edit_.set(v, Structure::none);
    });
    edit_.report(steps_, s, "label removed", "its centreline replaces it");
  }

  [[nodiscard]] StructureSet here(std::initializer_list<Structure> list) const {
    StructureSet found;
    for (const Structure s : list)
      if (has(s)) found.insert(s);
    return found;
  }

  /// By the order of drawing: of two tubes that join, the later one looks for the earlier.
  [[nodiscard]] std::vector<End> ends_of(const Tube& tube) const {
    const auto sac = here({Structure::gallbladder, Structure::gallbladder_wall});
    const auto ducts =
        here({Structure::common_bile_duct, Structure::common_hepatic_duct, Structure::aberrant_right_duct});
    switch (tube.structure) {
      case Structure::common_bile_duct:
        return ends_with({{false, here({Structure::common_hepatic_duct}), true, "common hepatic duct"}});
      case Structure::aberrant_right_duct:
        return ends_with(
            {{true, here({Structure::common_bile_duct, Structure::common_hepatic_duct}), false, "bile duct"}});
      case Structure::cystic_duct:
        return ends_with({{false, ducts, true, "bile duct"}, {true, sac, true, "gallbladder"}});
      case Structure::cystic_artery:
      case Structure::second_cystic_artery:
        return ends_with({{false, here({Structure::right_hepatic_artery}), true, "right hepatic artery"},
                          {true, sac, true, "gallbladder"}});
      default:
        return {};
    }
  }

  static std::vector<End> ends_with(std::vector<End> ends) {
    std::erase_if(ends, [](const End& end) { return end.neighbours.empty(); });
    return ends;
  }

  [[nodiscard]] Structure structure_at(const Vec3& place) const {
    const Vec3 at = to_voxel_ * place;
    std::array<std::size_t, 3> voxel{};
    for (std::size_t d = 0; d < 3; ++d) {
      const double x = std::round(at[static_cast<Eigen::Index>(d)]);
      if (!(x >= 0 && x < static_cast<double>(labels_.grid.size[d]))) return Structure::none;
      voxel[d] = static_cast<std::size_t>(x);
    }
    return labels_.at(labels_.grid.index(voxel[0], voxel[1], voxel[2]));
  }

  [[nodiscard]] Vec3 centre_of(std::size_t v) const {
    const auto& n = labels_.grid.size;
    return labels_.grid.to_world * Vec3(static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                        static_cast<double>(v / (n[0] * n[1])));
  }

  /// Appends to `beads` what takes the end into its neighbour, or marks those that are in it already.
  void join(Tube& tube, const End& end, std::vector<Bead>& beads) {
    Centreline& line = tube.line;
    const Vec3 tip = end.last ? line.points.back() : line.points.front();
    if (!tube.given && touches_any(tube.structure, end.neighbours)) return;
    const Gap gap = gap_to(labels_, end.neighbours, tip);
    if (gap.distance > options_.joint_reach) {
      if (end.required) refuse_far(tube, end, tip, gap.distance);
      return;
    }
    if (end.last) std::reverse(beads.begin(), beads.end());  // from the tip on
    const double radius = drawn_radius(end.last ? line.radii.back() : line.radii.front());
    if (tube.given) mark_beyond(tube, end, beads);
    prolong(tip, away(line, end.last), radius, end, gap, beads);
    if (end.last) std::reverse(beads.begin(), beads.end());
  }

  /// Where the line goes on to at a tip.
  static Vec3 away(const Centreline& line, bool last) {
    const std::size_t n = line.points.size(), back = std::min<std::size_t>(n - 1, 5);
    const Vec3 tangent = last ? line.points[n - 1] - line.points[n - 1 - back] : line.points[0] - line.points[back];
    return tangent.normalized();
  }

  /// How far beyond its joint a tube still counts: to the middle of a tube that it joins, lest it comes out behind.
  [[nodiscard]] double depth_of_joint(const End& end, double radius) const {
    double depth = options_.overlap + radius;
    for (const Tube& other : tubes_)
      if (end.neighbours.contains(other.structure)) depth = std::min(depth, other.radius);
    return depth;
  }

  void mark_beyond(const Tube& tube, const End& end, std::vector<Bead>& beads) const {
    std::size_t inside = 0;
    while (inside < beads.size() && end.neighbours.contains(structure_at(beads[inside].centre))) ++inside;
    if (inside == beads.size())
      throw InputError("centreline \"" + tube.line.name + "\"", "lies in the " + end.name + " altogether",
                       "draw it from the " + end.name + "'s surface on, or shrink that label");
    const double most = depth_of_joint(end, beads[inside].radius);
    double depth = 0;
    std::size_t kept = inside;
    while (kept > 0 && depth < most) {
      --kept;
      depth += (beads[kept].centre - beads[kept + 1].centre).norm();
      beads[kept].beyond = true;
      beads[kept].neighbours = end.neighbours;
    }
    beads.erase(beads.begin(), beads.begin() + static_cast<std::ptrdiff_t>(kept));
  }

  /// Straight across the gap, if there is one, then on inside the neighbour.
  void prolong(const Vec3& tip, const Vec3& tangent, double radius, const End& end, const Gap& gap,
               std::vector<Bead>& beads) {
    std::vector<Bead> more;  // from the tip outwards
    Vec3 direction = tangent, from = tip;
    if (gap.distance > 0) {
      const Vec3 target = centre_of(gap.voxel), across = target - tip;
      const double reach = across.norm();
      direction = across / reach;
      for (double s = beads.empty() ? 0 : step(); s < reach; s += step()) {
        const Vec3 at = tip + s * direction;
        more.push_back({at, radius, end.neighbours.contains(structure_at(at)), end.neighbours});
      }
      from = target;
    }
    const std::size_t counted = beads.size();
    double depth = 0;
    for (std::size_t b = 1; b < counted && beads[b - 1].beyond; ++b)
      depth += (beads[b].centre - beads[b - 1].centre).norm();
    const double most = depth_of_joint(end, radius);
    for (double s = 0; depth + s < most; s += step()) {
      const Vec3 at = from + s * direction;
      if (!end.neighbours.contains(structure_at(at))) break;
      more.push_back({at, radius, true, end.neighbours});
    }
    beads.insert(beads.begin(), more.rbegin(), more.rend());
  }

  [[noreturn]] static void refuse_far(const Tube& tube, const End& end, const Vec3& tip, double distance) {
    const std::string name(name_of(tube.structure));
    throw InputError(tube.given ? "centreline \"" + name + "\"" : "label \"" + name + "\"",
                     text_of("ends %.1f mm from the %s, at ", 1e3 * distance, end.name.c_str()) + place_text(tip),
                     tube.given ? "draw it up to the " + end.name + ", or raise joint_reach"
                                : "draw it with a centreline that reaches the " + end.name);
  }

  /// A label that hangs together by corners or not at all is drawn along its middle, so that faces join it.
  void bridge(const Tube& tube) {
    const VoxelBox& box = present_[label_of(tube.structure)];
    Mask mask =
        cut_out(labels_.voxels, labels_.grid.size, box, [&](std::uint8_t l) { return l == label_of(tube.structure); });
    if (keep_largest_part(mask, box.size(), Joined::by_faces) == 0) return;
    std::vector<Bead> beads;
    const Centreline fine = fine_line(tube.line, step());
    for (std::size_t p = 0; p < fine.points.size(); ++p)
      beads.push_back({fine.points[p], drawn_radius(0.7 * fine.radii[p]), false, {}});
    sweep(tube, beads, "bridged along its middle");
  }

  /// Which voxels are nearest to which bead, and whether within it; then who gets them.
  void sweep(const Tube& tube, const std::vector<Bead>& beads, const char* step_name) {
    if (beads.empty()) return;
    BallChain balls;
    for (const Bead& bead : beads) balls.push_back({bead.centre, bead.radius});
    const VoxelBox box = voxels_of(balls);
    std::vector<float> depth(box.count(), 0.0f);
    std::vector<std::uint32_t> nearest(box.count(), 0);
    for (std::size_t b = 0; b < beads.size(); ++b) lower(beads[b], static_cast<std::uint32_t>(b), box, depth, nearest);
    for_voxels(box, labels_.grid.size, [&](std::size_t v, std::size_t inside) {
      if (depth[inside] < 0 && wins(tube, beads[nearest[inside]], labels_.at(v))) edit_.set(v, tube.structure);
    });
    const std::string name(name_of(tube.structure));
    edit_.report(steps_, tube.structure, step_name,
                 text_of("%.1f mm long, %.2g mm wide", 1e3 * length(tube.line), 2e3 * tube.radius));
    edit_.report_all(steps_, "made room for the " + name);
  }

  [[nodiscard]] VoxelBox voxels_of(const BallChain& balls) const {
    Eigen::AlignedBox3d box;
    for (const Ball& ball : balls) {
      const Vec3 at = to_voxel_ * ball.centre, reach = ball.radius * spacing_.cwiseInverse();
      box.extend(Vec3(at - reach));
      box.extend(Vec3(at + reach));
    }
    VoxelBox voxels;
    for (std::size_t d = 0; d < 3; ++d) {
      const auto axis = static_cast<Eigen::Index>(d);
      const double n = static_cast<double>(labels_.grid.size[d]);
      voxels.first[d] = static_cast<std::size_t>(std::clamp(std::ceil(box.min()[axis]), 0.0, n));
      voxels.last[d] = static_cast<std::size_t>(std::clamp(std::floor(box.max()[axis]) + 1, 0.0, n));
    }
    return voxels;
  }

  void lower(const Bead& bead, std::uint32_t number, const VoxelBox& box, std::vector<float>& depth,
             std::vector<std::uint32_t>& nearest) const {
    const VoxelBox own = voxels_of({{bead.centre, bead.radius}});
    const Vec3 at = to_voxel_ * bead.centre;
    const VoxelSize size = box.size();
    for (std::size_t k = own.first[2]; k < own.last[2]; ++k)
      for (std::size_t j = own.first[1]; j < own.last[1]; ++j)
        for (std::size_t i = own.first[0]; i < own.last[0]; ++i) {
          const Vec3 apart = Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) - at;
          const auto d = static_cast<float>(apart.cwiseProduct(spacing_).norm() - bead.radius);
          const std::size_t b = (i - box.first[0]) + size[0] * ((j - box.first[1]) + size[1] * (k - box.first[2]));
          if (d >= depth[b]) continue;
          depth[b] = d;
          nearest[b] = number;
        }
  }

  [[nodiscard]] bool wins(const Tube& tube, const Bead& bead, Structure now) const {
    if (now == Structure::none) return true;
    if (bead.beyond && bead.neighbours.contains(now)) return false;
    if (!is_tube(now)) return true;
    if (bead.beyond) return false;
    for (const Tube& other : tubes_)
      if (other.structure == now) return tube.radius < other.radius;
    return false;
  }

  [[nodiscard]] bool touches_any(Structure tube, const StructureSet& neighbours) const {
    return std::any_of(all_structures().begin(), all_structures().end(),
                       [&](Structure other) { return neighbours.contains(other) && touches(labels_, tube, other); });
  }

  void note_joint(const Tube& tube, const End& end) {
    for (const Structure other : all_structures())
      if (end.neighbours.contains(other) && touches(labels_, tube.structure, other)) {
        result_.joints.emplace_back(tube.structure, other);
        return;
      }
  }

  /// The line between its joints.
  Centreline finished(const Tube& tube, const std::vector<Bead>& beads) {
    present_ = boxes_of(labels_.voxels, labels_.grid.size);
    if (!tube.given) return tube.line;
    Centreline line{std::string(name_of(tube.structure)), {}, {}};
    for (const Bead& bead : beads)
      if (!bead.beyond) {
        line.points.push_back(bead.centre);
        line.radii.push_back(bead.radius);
      }
    if (line.points.size() < 2 || length(line) < 1e-3)
      throw InputError("centreline \"" + line.name + "\"", "has less than 1 mm outside of what it joins",
                       "draw the duct or artery itself, from one neighbour's surface to the other's");
    return thinned(line);
  }

  static Centreline thinned(const Centreline& line) {
    Centreline even{line.name, {}, {}};
    const double total = length(line);
    const auto count = static_cast<std::size_t>(std::max(2.0, std::round(total / 0.5e-3)));
    for (std::size_t p = 0; p <= count; ++p) {
      const LinePlace place = place_at(line, total * static_cast<double>(p) / static_cast<double>(count));
      even.points.push_back(place.point);
      even.radii.push_back(place.radius);
    }
    return even;
  }

  WorkLabels& labels_;
  const CompletionOptions& options_;
  std::vector<CompletionStep>& steps_;
  std::vector<std::string>& warnings_;
  LabelEdit edit_;
  Vec3 spacing_;
  Eigen::Affine3d to_voxel_;
  std::array<VoxelBox, 256> present_;
  std::vector<Tube> tubes_;
  DrawnTubes result_;
};

}  // namespace

bool touches(const WorkLabels& labels, Structure a, Structure b) {
  const VoxelBox box = padded(boxes_of(labels.voxels, labels.grid.size)[label_of(a)], {1, 1, 1}, labels.grid.size);
  bool found = false;
  for_voxels(box, labels.grid.size, [&](std::size_t v, std::size_t) {
    if (found || labels.at(v) != a) return;
    for_face_neighbours(v, labels.grid.size, [&](std::size_t w) { found = found || labels.at(w) == b; });
  });
  return found;
}

DrawnTubes draw_tubes(WorkLabels& labels, const std::vector<Centreline>& given, const CompletionOptions& options,
                      std::vector<CompletionStep>& steps, std::vector<std::string>& warnings, Progress& progress) {
  progress.phase("completing: ducts and arteries");
  Drawing drawing(labels, options, steps, warnings);
  drawing.gather(given);
  double done = 0;
  for (Tube& tube : drawing.tubes()) {
    progress.at(done++ / static_cast<double>(drawing.tubes().size()));
    drawing.draw(tube);
  }
  progress.at(1);
  return drawing.take();
}

}  // namespace calot
