#include "app/simulate_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "app/terminal.h"
#include "calot/mesh/parts.h"

namespace calot {
namespace {

constexpr std::size_t kept = 131072;
constexpr double mm = 1e3, ms = 1e3;

template <class... Values>
std::string printed(const char* format, Values... values) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), format, values...);  // NOLINT: formats are ours
  return text.data();
}

nlohmann::ordered_json three(const Tally& d, double unit) {
  return {{"p50", unit * d.percentile(0.5)}, {"p99", unit * d.percentile(0.99)}, {"max", unit * d.max()}};
}

std::string times(std::uint64_t count) {
  return std::to_string(count) + (count == 1 ? " time" : " times");
}

}  // namespace

void Tally::add(double value) {
  max_ = std::max(max_, value);
  if (last_.size() < kept)
    last_.push_back(value);
  else
    last_[next_] = value;
  next_ = (next_ + 1) % kept;
}

double Tally::percentile(double share) const {
  if (last_.empty()) return 0;
  std::vector<double> sorted = last_;
  const auto place = static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(sorted.size() - 1)));
  std::nth_element(sorted.begin(), sorted.begin() + place, sorted.end());
  return sorted[static_cast<std::size_t>(place)];
}

void RunSummary::Solver::add(int count, double reached, bool converged) {
  iterations.add(count);
  residual = std::max(residual, std::isfinite(reached) ? reached : 1e300);
  failed += converged ? 0 : 1;
}

RunSummary::RunSummary(const World& world) : time_step_(world.model().dynamics().time_step), before_(shape_of(world)) {
  for (const InstrumentArm& arm : world.instruments())
    instruments_.push_back(
        {arm.setup().name, std::string(name_of(arm.geometry().kind)), 0, 0, arm.grasp.has_value(), 0});
  hottest_ = world.heat().options().body_temperature;
}

RunSummary::Shape RunSummary::shape_of(const World& world) {
  const TetMesh& mesh = world.model().mesh();
  Shape shape{mesh.vertex_count(), mesh.tet_count(), face_connected_parts(mesh).count(), 0, 0, world.energy()};
  const std::vector<Vec3>& x = world.state().positions;
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    const Tet& tet = mesh.tets[t];
    shape.rest_volume += signed_volume(mesh, TetId(t));
    shape.volume += signed_volume(x[tet[0].index()], x[tet[1].index()], x[tet[2].index()], x[tet[3].index()]);
  }
  return shape;
}

void RunSummary::add_instruments(const World& world) {
  for (std::size_t k = 0; k < instruments_.size(); ++k) {
    const InstrumentArm& arm = world.instruments()[k];
    instruments_[k].peak_force = std::max(instruments_[k].peak_force, arm.force.norm());
    if (!arm.grasp) continue;
    instruments_[k].slip += arm.grasp->report().slip;
    instruments_[k].held = arm.grasp->held_count();
  }
}

void RunSummary::step(const World& world) {
  const StepReport& report = world.report();
  ++steps_;
  for (std::size_t k = 0; k < phase_count; ++k) phases_[k].add(report.seconds[k]);
  total_.add(report.total());
  late_ += report.total() > time_step_ ? 1 : 0;
  free_.add(report.free_motion.iterations, report.free_motion.residual, report.free_motion.converged);
  if (report.contacts > 0) {
    response_.add(report.response.iterations, report.response.residual, report.response.converged);
    friction_.add(report.friction.iterations, report.friction.residual, report.friction.converged);
  }
  contacts_.add(static_cast<double>(report.contacts));
  nonlinear_.add(report.nonlinear_residual);
  overlap_ = std::max(overlap_, report.deepest_overlap);
  stretch_ = std::max(stretch_, report.largest_stretch);
  touched_ = std::max(touched_, report.touched);
  inverted_ = std::max(inverted_, report.inverted);
  steps_inverted_ += report.inverted > 0 ? 1 : 0;
  ran_away_ += report.ran_away ? 1 : 0;
  const auto peak = world.heat().peak_temperatures();
  if (!peak.empty()) hottest_ = std::max(hottest_, *std::max_element(peak.begin(), peak.end()));
  add_instruments(world);
  add_events(world);
}

void RunSummary::add_events(const World& world) {
  for (const WorldEvent& event : world.events()) {
    ++events_[event.kind];
    if (event.kind == EventKind::burnt) vaporised_ += event.amount;
  }
}

std::uint64_t RunSummary::count(EventKind kind) const {
  const auto found = events_.find(kind);
  return found == events_.end() ? 0 : found->second;
}

void RunSummary::end(const World& world, double wall_seconds) {
  wall_ = wall_seconds;
  after_ = shape_of(world);
  fluids_ = world.fluids().totals();
  const TetMesh& mesh = world.model().mesh();
  const auto coagulation = world.heat().coagulation();
  for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
    double mean = 0;
    for (const VertexId v : mesh.tets[t]) mean += coagulation[v.index()] / 4;
    coagulated_ += mean * signed_volume(mesh, TetId(t));
  }
  state_hash_ = world.state_hash();
}

std::string RunSummary::timing_text() const {
  std::string text = printed("%-22s %9s %9s %9s\n", "a step took [ms]", "p50", "p99", "max");
  const auto line = [&](const char* name, const Tally& d) {
    text += printed("  %-20s %9.3f %9.3f %9.3f\n", name, ms * d.percentile(0.5), ms * d.percentile(0.99), ms * d.max());
  };
  for (std::size_t k = 0; k < phase_count; ++k) line(std::string(name_of(static_cast<Phase>(k))).c_str(), phases_[k]);
  line("all without waiting", total_);
  return text + printed("  longer than a step's %.2f ms: %s\n", ms * time_step_, times(late_).c_str());
}

std::string RunSummary::solver_text() const {
  std::string text = printed("%-22s %9s %9s %9s %12s %s\n", "solvers", "p50", "p99", "max", "residual", "not reached");
  const auto line = [&](const char* name, const Solver& s) {
    text += printed("  %-20s %9.0f %9.0f %9.0f %12.2e %s\n", name, s.iterations.percentile(0.5),
                    s.iterations.percentile(0.99), s.iterations.max(), s.residual, times(s.failed).c_str());
  };
  line("free motion", free_);
  line("response", response_);
  line("friction", friction_);
  text += printed("  %-20s %9.1e %9.1e %9.1e\n", "true force residual", nonlinear_.percentile(0.5),
                  nonlinear_.percentile(0.99), nonlinear_.max());
  return text + printed("contacts: %.0f usually, %.0f at most; deepest overlap %.3f mm\n", contacts_.percentile(0.5),
                        contacts_.max(), mm * overlap_);
}

std::string RunSummary::tissue_text() const {
  const auto number = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
  std::string text;
  text += printed("tissue: stretched to %.3f at most; inside out at most %zu tets, in %llu steps; ran away %s\n",
                  stretch_, inverted_, number(steps_inverted_), times(ran_away_).c_str());
  text +=
      printed("edits: %llu cuts, %llu burns, %llu tears, %llu refused; %zu vertices touched between factors at most\n",
              number(count(EventKind::cut)), number(count(EventKind::burnt)), number(count(EventKind::torn)),
              number(count(EventKind::cut_refused)), touched_);
  text += printed("mesh: %zu to %zu tets, %zu to %zu parts, %.3f to %.3f mL at rest, %.3f to %.3f mL as it lies\n",
                  before_.tets, after_.tets, before_.parts, after_.parts, 1e6 * before_.rest_volume,
                  1e6 * after_.rest_volume, 1e6 * before_.volume, 1e6 * after_.volume);
  text +=
      printed("clips: %llu placed, %llu lost; heat: %.1f degrees at most, %.3f mL coagulated, %.0f tets vaporised\n",
              number(count(EventKind::clip_placed)), number(count(EventKind::clip_lost)), hottest_, 1e6 * coagulated_,
              vaporised_);
  text += printed("fluids: %.2f mL blood, %.2f mL bile, %.2f mL of it sucked\n", 1e6 * fluids_.blood_lost,
                  1e6 * fluids_.bile_spilled, 1e6 * fluids_.sucked);
  return text;
}

std::string RunSummary::text() const {
  std::string text =
      printed("%llu steps, %s simulated in %s\n", static_cast<unsigned long long>(steps_),
              seconds_text(time_step_ * static_cast<double>(steps_)).c_str(), seconds_text(wall_).c_str());
  text += timing_text() + solver_text();
  for (const Instrument& tool : instruments_) {
    text += printed("%s (%s): %.2f N at most", tool.name.c_str(), tool.kind.c_str(), tool.peak_force);
    if (tool.jaws) text += printed(", slipped %.2f mm, holds %zu vertices", mm * tool.slip, tool.held);
    text += '\n';
  }
  return text + tissue_text() + "state " + state_hash_;
}

nlohmann::ordered_json RunSummary::json() const {
  using Json = nlohmann::ordered_json;
  const auto solver = [](const Solver& s) {
    return Json{{"iterations", three(s.iterations, 1)}, {"residual_max", s.residual}, {"not_converged", s.failed}};
  };
  Json json;
  json["steps"] = steps_;
  json["time_step_s"] = time_step_;
  json["simulated_s"] = time_step_ * static_cast<double>(steps_);
  json["wall_s"] = wall_;
  for (std::size_t k = 0; k < phase_count; ++k)
    json["phases_ms"][std::string(name_of(static_cast<Phase>(k)))] = three(phases_[k], ms);
  json["total_ms"] = three(total_, ms);
  json["late_steps"] = late_;
  json["free_motion"] = solver(free_);
  json["response"] = solver(response_);
  json["friction"] = solver(friction_);
  json["nonlinear_residual"] = three(nonlinear_, 1);
  json["contacts"] = {
      {"p50", contacts_.percentile(0.5)}, {"max", contacts_.max()}, {"deepest_overlap_mm", mm * overlap_}};
  json["largest_stretch"] = stretch_;
  json["inverted_tets"] = {{"max", inverted_}, {"steps", steps_inverted_}};
  json["ran_away"] = ran_away_;
  json["instruments"] = Json::array();
  for (const Instrument& tool : instruments_) {
    Json each{{"name", tool.name}, {"kind", tool.kind}, {"peak_force_N", tool.peak_force}};
    if (tool.jaws) each["slip_mm"] = mm * tool.slip, each["held_vertices"] = tool.held;
    json["instruments"].push_back(each);
  }
  json["clips"] = {{"placed", count(EventKind::clip_placed)}, {"lost", count(EventKind::clip_lost)}};
  json["heat"] = {{"hottest_C", hottest_}, {"coagulated_mL", 1e6 * coagulated_}, {"vaporised_tets", vaporised_}};
  json["fluids"] = {{"blood_mL", 1e6 * fluids_.blood_lost},
                    {"bile_mL", 1e6 * fluids_.bile_spilled},
                    {"sucked_mL", 1e6 * fluids_.sucked}};
  json["edits"] = {{"cuts", count(EventKind::cut)},
                   {"burns", count(EventKind::burnt)},
                   {"tears", count(EventKind::torn)},
                   {"refused", count(EventKind::cut_refused)},
                   {"touched_rows_max", touched_}};
  const auto shape = [](const Shape& s) {
    return Json{
        {"vertices", s.vertices},      {"tets", s.tets},      {"parts", s.parts}, {"rest_mL", 1e6 * s.rest_volume},
        {"volume_mL", 1e6 * s.volume}, {"energy_J", s.energy}};
  };
  json["mesh"] = {{"start", shape(before_)}, {"end", shape(after_)}};
  json["state_hash"] = state_hash_;
  return json;
}

std::string event_text(const WorldEvent& event, double time_step) {
  return printed("%9.3f s  %-15s ", static_cast<double>(event.step) * time_step,
                 std::string(name_of(event.kind)).c_str()) +
         event.text;
}

nlohmann::ordered_json event_json(const WorldEvent& event, const World& world) {
  nlohmann::ordered_json json{{"step", event.step},
                              {"time_s", static_cast<double>(event.step) * world.model().dynamics().time_step},
                              {"kind", std::string(name_of(event.kind))}};
  json["instrument"] = nullptr;
  if (event.instrument >= 0)
    json["instrument"] = world.instruments()[static_cast<std::size_t>(event.instrument)].setup().name;
  json["amount"] = event.amount;
  json["text"] = event.text;
  return json;
}

}  // namespace calot
