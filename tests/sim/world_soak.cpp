// Many short runs of random scenes: instruments that move, cut, burn, grasp, clip and fail at random, edits from
// outside. After each step everything is checked that must hold whatever is done. A run depends on its seed alone.
//   world_soak [STEPS] [FIRST_SEED] [RUNS] [--hash]   exits with 1 if anything broke; says the seeds
// --hash prints the state each run ended in, and all of them as one, to be compared between builds.
#include <malloc.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <limits>
#include <numbers>

#include "calot/base/files.h"
#include "calot/cut/split.h"
#include "calot/mesh/quality.h"
#include "tests/sim/world_scenes.h"
#include "tests/support/edits.h"

namespace calot {
namespace {

constexpr double mm = 1e-3;

struct Tally {
  std::size_t steps = 0, runs = 0, failures = 0, edits = 0, ran_away = 0, unsolved = 0, inverted = 0, contacts = 0;
  std::array<std::size_t, 32> events{};
  std::array<double, phase_count> seconds{};
  double worst_residual = 0, slowest = 0;
  std::uint64_t slowest_seed = 0;
  bool tells_hashes = false;
  std::string hashes;  ///< of the states in which runs ended
};

Vec3 direction(test::Random& random) {
  for (;;) {
    const Vec3 v(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}

TetMesh random_mesh(test::Random& random) {
  const auto cells = [&](int low, int high) { return low + static_cast<int>(random.below(high - low + 1)); };
  TetMesh mesh;
  switch (random.below(4)) {
    case 0:
      mesh = test::box_mesh(cells(5, 9), cells(2, 4), cells(1, 2), Vec3(30 * mm, 10 * mm, 4 * mm));
      mesh.region_names[1] = "gallbladder";
      break;
    case 1:
      mesh = test::box_mesh(cells(3, 5), cells(3, 5), cells(2, 3), Vec3(25 * mm, 25 * mm, 12 * mm));
      mesh.region_names[1] = "liver";
      break;
    case 2: {  // an organ on a duct
      const int n = cells(6, 9);
      mesh = test::cell_mesh(n, 3, 3, Vec3(36 * mm, 9 * mm, 9 * mm), [&](int i, int j, int k) {
        return 3 * i < n ? 2 : (j == 1 && k == 1 ? 3 : (3 * i >= 2 * n ? 4 : 0));
      });
      mesh.region_names = {{2, "gallbladder"}, {3, "cystic duct"}, {4, "common bile duct"}};
      break;
    }
    default:
      mesh = test::cell_mesh(6, 4, 2, Vec3(30 * mm, 20 * mm, 8 * mm),
                             [](int i, int j, int) { return i < 3 ? 1 : (j > 0 && j < 3 ? 2 : 1); });
      mesh.region_names = {{1, "liver"}, {2, "cystic artery"}};
  }
  return mesh;
}

/// An instrument's wishes: it wanders between places near the tissue, and now and then its device fails.
class Wanderer {
 public:
  Wanderer(const InstrumentSetup& setup, test::Random& random) : input_(setup.start), setup_(&setup.geometry) {
    choose(random);
  }
  std::optional<InstrumentInput> next(test::Random& random, double step) {
    if (left_-- == 0) choose(random);
    const Vec3 way = target_ - input_.pose.position;
    input_.pose.position += way * std::min(1.0, speed_ * step / std::max(1e-9, way.norm()));
    input_.pose.rotation = input_.pose.rotation.slerp(turning_, rotation_).normalized();
    input_.opening += std::clamp(opening_ - input_.opening, -3 * step, 3 * step);
    input_.opening = std::clamp(input_.opening, 0.0, setup_->max_opening);
    const std::size_t trouble = random.below(400);
    InstrumentInput bad = input_;
    if (trouble == 0) return {};
    if (trouble == 1) bad.pose.position.x() = std::numeric_limits<double>::quiet_NaN();
    if (trouble == 2) bad.pose.position += Vec3(1, 0, 0);
    if (trouble == 3) bad.pose.rotation.coeffs().setZero();
    if (trouble == 4) bad.opening = 7;
    return bad;
  }

 private:
  void choose(test::Random& random) {
    left_ = 5 + random.below(30);
    const bool rough = random.below(20) == 0;  // crushes, and throws
    const Vec3 aim(random.between(0, 36) * mm, random.between(0, 20) * mm, random.between(rough ? -2 : 3, 14) * mm);
    rotation_ = test::facing(random.below(3) == 0 ? direction(random) : Vec3(-Vec3::UnitZ()), direction(random));
    // The working end, not the frame's origin, comes to the tissue.
    const double length = setup_->has_jaws() ? 0.7 * setup_->jaw_length : setup_->hook_tip.z();
    target_ = aim - rotation_ * Vec3(0, 0, length);
    speed_ = rough ? 2.5 : random.between(0.005, 0.1);
    turning_ = random.between(0, 0.2);
    opening_ = random.below(2) == 0 ? 0 : random.between(0, setup_->max_opening);
    input_.grip = random.between(0, rough ? setup_->max_grip : setup_->usual_grip);
    input_.energy = random.below(4) != 0;
    input_.fire = random.below(3) == 0;
  }

  InstrumentInput input_;
  const InstrumentGeometry* setup_;
  Vec3 target_;
  Eigen::Quaterniond rotation_;
  double speed_ = 0, turning_ = 0, opening_ = 0;
  std::size_t left_ = 0;
};

WorldSetup random_setup(test::Random& random) {
  TetMesh mesh = random_mesh(random);
  std::vector<std::uint8_t> fixed(mesh.vertex_count(), 0);
  const std::size_t held = random.below(3);  // one end, the underside, nothing
  for (std::size_t v = 0; v < fixed.size(); ++v)
    fixed[v] = (held == 0 && mesh.positions[v].x() < 1e-9) || (held == 1 && mesh.positions[v].z() < 1e-9) ? 1 : 0;
  std::map<std::int32_t, Material> materials;
  for (const std::int32_t region : mesh.regions)
    materials[region] = {std::pow(10, random.between(random.below(8) == 0 ? 3.3 : 4.3, 6)), random.between(0.2, 0.47),
                         1000};
  const double step = random.below(2) == 0 ? 1.0 / 60 : 0.01;
  WorldSetup setup = test::world_setup(
      Model(mesh, materials, fixed,
            {.time_step = step, .rayleigh_mass = random.between(0, 1), .rayleigh_stiffness = random.between(0, 0.02)}));
  setup.options.gravity = 9.81 * direction(random);
  setup.options.split = random.below(4) != 0;
  setup.options.tearing = random.below(5) == 0;
  setup.options.heat = setup.options.fluids = true;
  setup.options.contact.self_contact = random.below(4) != 0;
  const std::size_t count = 1 + random.below(3);
  for (std::size_t k = 0; k < count; ++k) {
    const auto kind = static_cast<InstrumentKind>(random.below(6));
    InstrumentSetup tool =
        test::instrument(kind, Vec3(random.between(0, 36), random.between(0, 20), random.between(25, 40)) * mm,
                         -Vec3::UnitZ(), direction(random), 0);
    tool.start.opening = random.between(0, tool.geometry.max_opening);
    tool.power = random.between(20, 200);  // beyond what generators give, so that short runs burn too
    setup.instruments.push_back(tool);
  }
  if (held == 2 || random.below(3) == 0)
    for (std::size_t k = 0; k < 4; ++k) {
      Spring spring;
      spring.vertex = VertexId(random.below(fixed.size()));
      spring.anchor = mesh.position(spring.vertex);
      spring.stiffness = random.between(1, 500) * Mat3::Identity();
      spring.damping = random.between(0, 0.05);
      setup.ligaments.push_back(spring);
    }
  if (random.below(2) == 0) {
    Surface table;
    table.positions = {{-0.2, -0.2, -0.02}, {0.2, -0.2, -0.02}, {0.2, 0.2, -0.02}, {-0.2, 0.2, -0.02}};
    table.triangles = {{0, 1, 2}, {0, 2, 3}};
    setup.still.emplace_back(std::move(table), random.between(0, 0.6), random.below(2) == 0);
  }
  return setup;
}

/// A cut from outside: through a plane, along a patch, of random tets, or nonsense that must be refused.
void random_edit(World& world, test::Random& random) {
  const TetMesh& mesh = world.model().mesh();
  if (mesh.tet_count() == 0) return;
  const Vec3 at = mesh.position(mesh.tets[random.below(mesh.tet_count())][0]) + 0.3 * mm * direction(random);
  TopologyEdit edit;
  switch (random.below(5)) {
    case 0:
      edit = split(mesh, Plane{at, direction(random)});
      break;
    case 1: {
      const Vec3 normal = direction(random), along = normal.unitOrthogonal();
      edit = split(mesh, BladePatch{at, normal, along, random.between(2, 20) * mm, random.between(2, 20) * mm});
      break;
    }
    case 2:
      edit.removed = test::random_tets(mesh, 1 + random.below(6), random.next());
      break;
    case 3:
      edit = test::random_edit(mesh, 3, random.next());
      break;
    default:
      edit.removed = {TetId(mesh.tet_count() + random.below(5))};
  }
  world.edit(edit, EventKind::cut, "from outside");
}

double mass_of(const World& world) {
  double sum = 0;
  for (const double m : world.model().vertex_masses()) sum += m;
  return sum;
}

/// Tets turned inside out now: surely, and perhaps (flat within rounding).
std::pair<std::size_t, std::size_t> inverted(const World& world) {
  std::size_t surely = 0, perhaps = 0;
  const TetMesh& mesh = world.model().mesh();
  for (const Tet& tet : mesh.tets) {
    Mat3 edges;
    for (int c = 0; c < 3; ++c)
      edges.col(c) = world.state().positions[tet[static_cast<std::size_t>(c) + 1].index()] -
                     world.state().positions[tet[0].index()];
    const double volume = edges.determinant(), size = std::pow(edges.norm(), 3);
    if (volume < -1e-9 * size) ++surely;
    if (volume < 1e-9 * size) ++perhaps;
  }
  return {surely, perhaps};
}

bool within(std::span<const double> values, double low, double high) {
  return std::all_of(values.begin(), values.end(), [&](double x) { return x >= low && x <= high; });
}

/// What is wrong with the heat; empty if nothing. Nothing is colder than blood or much hotter than boiling water.
std::string wrong(const TissueHeat& heat) {
  for (std::size_t v = 0; v < heat.peak_temperatures().size(); ++v)
    if (const double now = heat.temperature(VertexId(v)); !(now >= 36.9 && heat.peak_temperatures()[v] <= 101))
      return "a temperature is out of range: now " + std::to_string(now) + ", at most " +
             std::to_string(heat.peak_temperatures()[v]);
  const HeatLedger& l = heat.ledger();
  const double error = l.supplied + l.reshaped - heat.stored() - l.perfused - l.exchanged - l.removed;
  if (!(std::abs(error) <= 1e-9 * (l.supplied + std::abs(l.reshaped))))
    return "the heat's books are off by " + std::to_string(1e3 * error) + " mJ";
  return {};
}

/// What is wrong now; empty if nothing.
std::string wrong(const World& world, double mass_before, bool lost_tets) {
  if (!test::all_finite(world)) return "positions or velocities are not finite";
  if (!std::isfinite(world.energy())) return "energy is not finite";
  const StepReport& report = world.report();
  if (!report.ran_away && world.model().mesh().tet_count() > 0) {
    const auto [surely, perhaps] = inverted(world);
    if (report.inverted < surely || report.inverted > perhaps)
      return std::to_string(surely) + " … " + std::to_string(perhaps) + " tets are inverted, " +
             std::to_string(report.inverted) + " reported";
  }
  if (!world.changes().empty())
    if (const MeshProblems problems = validate(world.model().mesh()); problems.fatal()) return problems.describe();
  const double mass = mass_of(world);
  if (lost_tets ? mass > mass_before * (1 + 1e-3) : std::abs(mass - mass_before) > 1e-3 * mass_before)
    return "mass went from " + std::to_string(1e3 * mass_before) + " g to " + std::to_string(1e3 * mass) + " g";
  if (!within(world.heat().coagulation(), 0, 1 + 1e-9)) return "coagulation out of range";
  if (const std::string bad = wrong(world.heat()); !bad.empty()) return bad;
  if (!within(world.injury().blanching(), 0, 1) || !within(world.injury().bruising(), 0, 1))
    return "injury out of range";
  for (const InstrumentArm& arm : world.instruments())
    if (!arm.force.allFinite() || !arm.to().position.allFinite()) return "an instrument's force is not finite";
  for (const Clip& clip : world.clips())
    if (!clip.frame().position.allFinite()) return "a clip is nowhere";
  return {};
}

std::string one_step(World& world, std::vector<Wanderer>& wanderers, test::Random& random, Tally& tally) {
  double mass = mass_of(world);
  const double step = world.model().dynamics().time_step;
  std::string bad;
  if (random.below(40) == 0) {
    random_edit(world, random);
    mass = mass_of(world);  // moved and bisected at random, not only split
    ++tally.edits;
  }
  test::Inputs inputs;
  for (Wanderer& wanderer : wanderers) inputs.push_back(wanderer.next(random, step));
  const StepReport& report = world.step(inputs);
  bool lost = !world.options().split;
  for (const WorldEvent& event : world.events()) {
    lost = lost || event.kind == EventKind::burnt;
    if (event.kind == EventKind::debris)
      mass -= 1e-6 * event.amount * world.model().materials().begin()->second.density;
    ++tally.events[static_cast<std::size_t>(event.kind)];
  }
  ++tally.steps;
  tally.contacts += report.contacts;
  for (std::size_t k = 0; k < phase_count; ++k) tally.seconds[k] += report.seconds[k];
  tally.ran_away += report.ran_away;
  tally.inverted += report.inverted;
  if (!report.free_motion.converged || !report.response.converged) ++tally.unsolved;
  if (!report.ran_away)
    tally.worst_residual = std::max({tally.worst_residual, report.free_motion.residual, report.response.residual});
  return wrong(world, mass, lost);
}

void one_run(std::uint64_t seed, Tally& tally, std::size_t most) {
  test::Random random(seed * 0x9E3779B97F4A7C15ull + 1);
  for (int k = 0; k < 4; ++k) random.next();
  std::size_t step = 0;
  try {
    WorldSetup setup = random_setup(random);
    const std::vector<InstrumentSetup> tools = setup.instruments;
    World world(std::move(setup));
    std::vector<Wanderer> wanderers;
    for (const InstrumentSetup& tool : tools) wanderers.emplace_back(tool, random);
    const std::size_t length = std::min(most, 40 + random.below(160));
    for (; step < length; ++step) {
      const std::string bad = one_step(world, wanderers, random, tally);
      if (world.report().total() > tally.slowest) {
        tally.slowest = world.report().total();
        tally.slowest_seed = seed;
      }
      if (bad.empty()) continue;
      std::printf("seed %llu step %zu: %s\n", static_cast<unsigned long long>(seed), step, bad.c_str());
      ++tally.failures;
      break;
    }
    if (tally.tells_hashes) {
      const std::string hash = world.state_hash();
      tally.hashes += hash;
      std::printf("state seed %llu step %zu %s\n", static_cast<unsigned long long>(seed), step, hash.c_str());
    }
  } catch (const std::exception& e) {
    std::printf("seed %llu step %zu: threw %s\n", static_cast<unsigned long long>(seed), step, e.what());
    ++tally.failures;
  }
  ++tally.runs;
}

/// What the program holds between runs, when all worlds are gone: asked for and not given back [MB].
double held() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
}

/// What is really in memory then [MB].
double resident() {
  malloc_trim(0);
  std::ifstream in("/proc/self/statm");
  double all = 0, pages = 0;
  in >> all >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void print(const Tally& tally) {
  std::printf(
      "%zu steps in %zu runs: %zu failures; %zu edits from outside, %zu ran away, %zu unsolved (worst residual %.1e), "
      "%zu inverted tets, %zu contacts; slowest step %.0f ms (seed %llu); %.2f MB held between runs, %.1f MB "
      "resident\n",
      tally.steps, tally.runs, tally.failures, tally.edits, tally.ran_away, tally.unsolved, tally.worst_residual,
      tally.inverted, tally.contacts, 1e3 * tally.slowest, static_cast<unsigned long long>(tally.slowest_seed), held(),
      resident());
  std::printf("  ms a step:");
  for (std::size_t k = 0; k < phase_count; ++k)
    std::printf(" %s %.2f", std::string(name_of(static_cast<Phase>(k))).c_str(),
                1e3 * tally.seconds[k] / static_cast<double>(tally.steps));
  std::printf("\n");
  for (std::size_t k = 0; k < tally.events.size(); ++k)
    if (tally.events[k] > 0)
      std::printf("  %zu × %s\n", tally.events[k], std::string(name_of(static_cast<EventKind>(k))).c_str());
  std::fflush(stdout);
}

int soak(std::size_t steps, std::uint64_t seed, std::size_t runs, bool hashes) {
  Tally tally;
  tally.tells_hashes = hashes;
  double held_before = 0, resident_before = 0;
  const std::size_t between = std::max<std::size_t>(1, std::min<std::size_t>(steps / 10, 10000));
  std::size_t next_print = between;
  while (tally.steps < steps && tally.runs < runs) {
    one_run(seed++, tally, steps - tally.steps);
    if (tally.steps < next_print) continue;
    if (held_before == 0) {  // warmed up
      held_before = held();
      resident_before = resident();
    }
    print(tally);
    while (next_print <= tally.steps) next_print += between;
  }
  print(tally);
  if (hashes) std::printf("state of all %s\n", sha256(tally.hashes).c_str());
  // Buffers that threads keep grow to what the worst step needed (8 MB: 33,000 pairs of features within reach of each
  // other, in tissue that runs away); a leak in each of many runs doesn't stop at that.
  constexpr double held_slack = 16, resident_slack = 60;
  const bool grew =
      held_before > 0 && (held() > held_before + held_slack || resident() > resident_before + resident_slack);
  if (grew)
    std::printf("memory grew from %.2f to %.2f MB held, from %.1f to %.1f MB resident\n", held_before, held(),
                resident_before, resident());
  return tally.failures > 0 || grew ? 1 : 0;
}

}  // namespace
}  // namespace calot

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 14);
  std::vector<std::uint64_t> numbers = {2000, 1, ~0ull};
  std::size_t given = 0;
  bool hashes = false;
  for (int k = 1; k < argc; ++k) {
    if (std::string_view(argv[k]) == "--hash")
      hashes = true;
    else if (given < numbers.size())
      numbers[given++] = std::strtoull(argv[k], nullptr, 10);
  }
  return calot::soak(numbers[0], numbers[1], numbers[2], hashes);
}
