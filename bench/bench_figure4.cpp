// The paper's figure 4: the organ after the cut, recomputed and updated, one over the other, and how far they differ.
#include <algorithm>
#include <cstdio>

#include "bench/benchmarks.h"
#include "bench/plot.h"
#include "bench/three_ways.h"
#include "calot/mesh/parts.h"
#include "calot/picture/picture.h"

namespace calot::bench {
namespace {

constexpr double mm = 1e3;
constexpr double peak = 5e-3;  // Forces are chosen so that the recomputed peak displacement is this [m].

// What the paper reports for its one probe [mm].
constexpr Distance reported{0.1246, 0.0198, 0.0192};

struct Probe {
  std::string name, where;
  PointForce force;
  Displacements recomputed, paper, exact;
  Distance paper_distance, exact_distance;
};

// The vertices of the parts that are held, or of those that are not, without fixed ones.
std::vector<VertexId> vertices_of_parts(const ThreeWays& ways, bool held) {
  const Parts parts = face_connected_parts(ways.after.mesh());
  std::vector<VertexId> found;
  for (const std::vector<VertexId>& vertices : parts.vertices) {
    const bool fixed =
        std::any_of(vertices.begin(), vertices.end(), [&](VertexId v) { return ways.after.is_fixed(v); });
    if (fixed != held) continue;
    for (const VertexId v : vertices)
      if (!ways.after.is_fixed(v)) found.push_back(v);
  }
  return found;
}

double distance_to_face(const ThreeWays& ways, VertexId v) {
  double nearest = 1e300;
  for (const VertexId old : ways.change.touched)
    nearest = std::min(nearest, (ways.after.mesh().position(ways.change.remap.vertex_to_new[old.index()]) -
                                 ways.after.mesh().position(v))
                                    .norm());
  return nearest;
}

Probe probe_at(const ThreeWays& ways, std::string name, std::string where, VertexId vertex, const Vec3& direction) {
  Probe probe{std::move(name), std::move(where), {vertex, direction}, {}, {}, {}, {}, {}};
  double largest = 0;
  for (const Vec3& u : ways.recomputed.solve({probe.force})) largest = std::max(largest, u.norm());
  probe.force.force *= peak / largest;
  probe.recomputed = ways.recomputed.solve({probe.force});
  probe.paper = multiply(ways.paper, {probe.force});
  probe.exact = ways.exact.solve({probe.force});
  probe.paper_distance = distance_between(probe.paper, probe.recomputed);
  probe.exact_distance = distance_between(probe.exact, probe.recomputed);
  return probe;
}

std::vector<Probe> probes_of(const ThreeWays& ways) {
  const std::vector<VertexId> held = vertices_of_parts(ways, true), severed = vertices_of_parts(ways, false);
  const auto nearer = [&](VertexId a, VertexId b) { return distance_to_face(ways, a) < distance_to_face(ways, b); };
  const Vec3 up(0, 0, 1);
  // Far on the held part, but not beside a support, where nothing moves: the median distance.
  std::vector<VertexId> sorted = held;
  std::sort(sorted.begin(), sorted.end(), nearer);
  return {probe_at(ways, "far", "on the held part, far from the cut", sorted[sorted.size() / 2], up),
          probe_at(ways, "face", "on the held part, at the face of the cut", sorted.front(), up),
          probe_at(ways, "severed", "on the part that was held through the cut only",
                   *std::max_element(severed.begin(), severed.end(), nearer), up)};
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void write_table(const std::filesystem::path& path, const std::vector<Probe>& probes) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const Probe& probe, const char* method, const Distance& d) {
    rows.push_back({probe.name, probe.where, method, number(probe.force.force.norm()), number(mm * d.max),
                    number(mm * d.mean), number(mm * d.std), number(100 * d.max / peak)});
  };
  for (const Probe& probe : probes) {
    add(probe, "paper", probe.paper_distance);
    add(probe, "exact", probe.exact_distance);
  }
  rows.push_back({"reported", "by the paper of 2013, place and force not given", "paper", "", number(reported.max),
                  number(reported.mean), number(reported.std), ""});
  write_csv(path, {"probe", "where", "method", "force_N", "max_mm", "mean_mm", "std_mm", "max_percent_of_peak"}, rows);
}

std::vector<Vec3> moved(const TetMesh& mesh, const Displacements& u, double factor) {
  std::vector<Vec3> places = mesh.positions;
  for (std::size_t v = 0; v < places.size(); ++v) places[v] += factor * u[v];
  return places;
}

void write_overlay(const std::filesystem::path& path, const ThreeWays& ways, const Probe& probe) {
  const Surface surface = boundary_surface(ways.after.mesh());
  constexpr double factor = 3;
  const std::vector<Vec3> truth = moved(ways.after.mesh(), probe.recomputed, factor),
                          paper = moved(ways.after.mesh(), probe.paper, factor),
                          exact = moved(ways.after.mesh(), probe.exact, factor);
  const Vec3 at = truth[probe.force.vertex.index()];
  const Surface arrow = arrow_surface(at, at + Vec3(0, 0, 0.015), 0.0012);
  const PictureItem recomputed{
      .surface = &surface, .positions = truth, .color = {0.91, 0.55, 0.66}, .label = "recomputed"};
  const PictureItem by_paper{.surface = &surface,
                             .positions = paper,
                             .color = {0.20, 0.35, 0.80},
                             .opacity = 0.55,
                             .label = "the paper's update"};
  const PictureItem by_exact{
      .surface = &surface, .positions = exact, .color = {0.20, 0.35, 0.80}, .opacity = 0.55, .label = "exact update"};
  const PictureItem force{.surface = &arrow, .color = {0.15, 0.15, 0.15}, .label = "force"};
  PictureOptions options{.width = 900, .height = 1000, .frame = frame_of({recomputed, by_paper, by_exact, force})};
  options.caption = "force " + probe.where + "; displacements x 3";
  options.title = "paper: up to " + number(mm * probe.paper_distance.max) + " mm off";
  const Image left = render_picture({recomputed, by_paper, force}, options);
  options.title = "exact: up to " + number(mm * probe.exact_distance.max) + " mm off";
  write_png(path, beside({left, render_picture({recomputed, by_exact, force}, options)}));
}

void write_bars(const std::filesystem::path& path, const std::vector<Probe>& probes) {
  Plot plot{.title = "Distance from the recomputed displacement (its peak: 5 mm)",
            .y_label = "largest distance [mm]",
            .log_y = true};
  PlotSeries paper{.title = "the paper's update"}, exact{.title = "exact update"};
  for (const Probe& probe : probes) {
    plot.groups.push_back(probe.name);
    paper.y.push_back(mm * probe.paper_distance.max);
    exact.y.push_back(std::max(1e-12, mm * probe.exact_distance.max));
  }
  plot.series = {paper, exact};
  write_plot(path, plot);
}

}  // namespace

std::vector<Row> bench_figure4(const BenchOptions& options) {
  const Organ organ = make_organ(options);
  const std::vector<Edit> cuts = transections(organ, 5);
  const ThreeWays ways = cut_three_ways(organ.model, cuts[cuts.size() / 2], options.progress);
  const std::vector<Probe> probes = probes_of(ways);
  if (!options.output.empty()) {
    std::filesystem::create_directories(options.output);
    write_table(options.output / "figure4.csv", probes);
    write_bars(options.output / "figure4_errors", probes);
    for (const Probe& probe : probes) write_overlay(options.output / ("figure4_" + probe.name + ".png"), ways, probe);
  }
  std::vector<Row> rows;
  for (const Probe& probe : probes) {
    const auto add = [&](const std::string& method, const char* what, double value, double theirs) {
      rows.push_back({.name = "figure4." + probe.name + "." + method + "." + what,
                      .value = mm * value,
                      .unit = "mm",
                      .baseline = "the paper's own " + number(theirs) + " mm (" + probe.where + ")",
                      .ratio = mm * value / theirs});
    };
    for (const auto& [method, d] :
         {std::pair<std::string, Distance>{"paper", probe.paper_distance}, {"exact", probe.exact_distance}}) {
      add(method, "max", d.max, reported.max);
      add(method, "mean", d.mean, reported.mean);
      add(method, "std", d.std, reported.std);
    }
    rows.push_back({.name = "figure4." + probe.name + ".paper.max_of_peak",
                    .value = 100 * probe.paper_distance.max / peak,
                    .unit = "%"});
  }
  return rows;
}

}  // namespace calot::bench
