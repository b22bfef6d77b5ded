// Pictures: what one costs on a processor that draws by itself, what sending a surface costs, and whether the world
// keeps its pace beside them.
#include <sys/resource.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

#include "bench/benchmarks.h"
#include "bench/simulation_rows.h"
#include "calot/view/effects/effects.h"
#include "calot/view/gl/context.h"
#include "calot/view/renderer.h"
#include "calot/view/snapshot_maker.h"

namespace calot::bench {
namespace {

using Clock = std::chrono::steady_clock;

// Of all threads of the process: llvmpipe draws on several.
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Towards the waist of the organ, from the side on which the tubes press.
Camera camera_on(const Snapshot& snapshot) {
  Vec3f middle = Vec3f::Zero();
  for (const Vec3f& x : snapshot.positions) middle += x;
  middle /= static_cast<float>(snapshot.positions.size());
  return camera_looking(middle + Vec3f(0.02F, -0.08F, 0.05F), middle, Vec3f::UnitZ());
}

struct Drawn {
  std::vector<double> processor, wall;  // [ms]
};

Drawn draw(Renderer& renderer, const Snapshot& snapshot, int width, int height, std::size_t count) {
  const PictureCanvas canvas(width, height);
  const Effects effects(snapshot);
  const Camera camera = camera_on(snapshot);
  Drawn drawn;
  for (std::size_t k = 0; k < count + 3; ++k) {
    const double before = processor_time();
    const Stopwatch watch;
    renderer.render(snapshot, effects.state(), camera, canvas.canvas());
    (void)canvas.read();
    if (k < 3) continue;  // programs are compiled, memory comes
    drawn.processor.push_back(1e3 * (processor_time() - before));
    drawn.wall.push_back(1e3 * watch.seconds());
  }
  return drawn;
}

void add_picture_rows(const std::string& name, PictureQuality quality, const Snapshot& snapshot, int width, int height,
                      double goal, std::size_t count, std::vector<Row>& rows) {
  Renderer renderer(quality);
  const Drawn drawn = draw(renderer, snapshot, width, height, count);
  Row row = distribution_row(name, "ms", drawn.processor);
  row.value = *row.p50;
  row.p99.reset();  // the goal is for a usual picture
  row.goal = goal;
  rows.push_back(row);
  rows.push_back(distribution_row(name + ".wall", "ms", drawn.wall));
}

// A dented ball of so many vertices.
Snapshot ball(std::size_t vertices) {
  const auto rings = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(vertices) / 2)), sides = 2 * rings;
  Snapshot snapshot;
  snapshot.time_step = 1.0 / 60;
  snapshot.skin.version = 1;
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < sides; ++j) {
      const double a = std::numbers::pi * (i + 0.5) / rings, b = 2 * std::numbers::pi * j / sides;
      const double r = 0.03 * (1 + 0.05 * std::sin(9 * b) * std::sin(7 * a));
      const Vec3f x(static_cast<float>(r * std::sin(a) * std::cos(b)),
                    static_cast<float>(r * std::sin(a) * std::sin(b)), static_cast<float>(r * std::cos(a)));
      snapshot.skin.vertices.push_back({i * sides + j, x, TissueLook::liver, false});
      snapshot.positions.push_back(x);
      if (i + 1 == rings) continue;
      const std::uint32_t here = i * sides + j, right = i * sides + (j + 1) % sides;
      snapshot.skin.triangles.push_back({here, here + sides, right});
      snapshot.skin.triangles.push_back({right, here + sides, right + sides});
    }
  snapshot.conditions.resize(snapshot.positions.size());
  return snapshot;
}

Row upload_row(std::size_t vertices, std::size_t count) {
  Renderer renderer(PictureQuality::lite);
  Snapshot snapshot = ball(vertices);
  const PictureCanvas canvas(64, 64);
  const Effects effects(snapshot);
  const Camera camera = camera_on(snapshot);
  std::vector<double> times;
  for (std::size_t k = 0; k < count; ++k) {
    ++snapshot.step;
    for (Vec3f& x : snapshot.positions) x *= 1.0001F;
    renderer.render(snapshot, effects.state(), camera, canvas.canvas());
    if (k > 3) times.push_back(1e3 * renderer.statistics().upload);
  }
  Row row = distribution_row("view.upload_20k", "ms", times);
  row.value = *row.p50;
  row.p99.reset();
  row.goal = 0.6;
  return row;
}

// Draws whatever is newest until it is told to stop, giving way to the world.
void keep_drawing(SnapshotFeed& feed, std::atomic<bool>& stop, std::atomic<std::size_t>& pictures) {
  setpriority(PRIO_PROCESS, 0, 19);
  OffscreenContext context;
  Renderer renderer(PictureQuality::lite);
  const PictureCanvas canvas(640, 360);
  std::optional<Effects> effects;
  while (!stop) {
    const Snapshot* newest = feed.fetch();
    if (newest == nullptr) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    if (!effects) effects.emplace(*newest);
    effects->advance(*newest, newest->step - effects->state().step);
    renderer.render(*newest, effects->state(), camera_on(*newest), canvas.canvas());
    (void)canvas.read();
    ++pictures;
  }
}

void add_together_rows(Operation& operation, std::size_t steps, std::vector<Row>& rows) {
  SnapshotFeed feed(operation.world());
  std::atomic<bool> stop = false;
  std::atomic<std::size_t> pictures = 0;
  std::vector<double> publishing;
  std::thread drawing([&] { keep_drawing(feed, stop, pictures); });
  const PacedRun run = run_paced(
      operation, steps, [&] { publishing.push_back(1e3 * seconds_of([&] { feed.publish(operation.world()); })); });
  stop = true;
  drawing.join();
  for (Row& row : paced_rows("view.step_beside", run, 1e3 / 60)) rows.push_back(std::move(row));
  rows.push_back(distribution_row("view.publish", "ms", publishing));
  const double period = 1e3 * static_cast<double>(steps) / 60 / std::max<double>(1, static_cast<double>(pictures));
  rows.push_back({.name = "view.picture_period", .value = period, .unit = "ms"});
}

// From a device's motion to the finished picture that shows it: a world that takes it in at its next step, and a thread
// that draws what is newest.
Row latency_row(const Organ& organ, std::size_t motions) {
  Operation operation(organ, {});
  SnapshotFeed feed(operation.world());
  std::atomic<bool> stop = false;
  std::atomic<std::int64_t> moved_at = 0;                        // what the device has said last [ns]
  std::vector<std::atomic<std::int64_t>> seen_by_step(100'000);  // what the device had said when the step began
  const auto now = [] { return Clock::now().time_since_epoch().count(); };
  std::thread world([&] {
    auto due = Clock::now();
    while (!stop && operation.steps() + 1 < seen_by_step.size()) {
      seen_by_step[operation.steps() + 1] = moved_at.load();
      (void)operation.step();
      feed.publish(operation.world());
      due += std::chrono::microseconds(16667);
      std::this_thread::sleep_until(due);
    }
  });
  std::vector<double> delays;
  std::thread drawing([&] {
    setpriority(PRIO_PROCESS, 0, 19);
    OffscreenContext context;
    Renderer renderer(PictureQuality::lite);
    const PictureCanvas canvas(320, 180);
    std::optional<Effects> effects;
    std::int64_t shown = 0;
    while (delays.size() < motions) {
      const Snapshot* newest = feed.fetch();
      if (newest == nullptr) continue;
      if (!effects) effects.emplace(*newest);
      renderer.render(*newest, effects->state(), camera_on(*newest), canvas.canvas());
      (void)canvas.read();
      const std::int64_t seen = seen_by_step[newest->step];
      if (seen > shown) delays.push_back(1e-6 * static_cast<double>(now() - seen));
      shown = std::max(shown, seen);
    }
    stop = true;
  });
  for (std::uint64_t k = 0; !stop; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + (k * 37) % 23));
    moved_at = now();
  }
  world.join();
  drawing.join();
  Row row = distribution_row("view.input_to_picture", "ms", delays);
  row.goal = 50;
  row.baseline = "lite, 320 x 180, a world of " + std::to_string(organ.model.mesh().tet_count()) + " tets";
  return row;
}

}  // namespace

std::vector<Row> view_rows(const Organ& organ, const Organ& small, std::size_t pictures, std::size_t steps) {
  Operation operation(organ, {});
  warm_up(operation);
  std::vector<Row> rows;
  {
    SnapshotMaker maker(operation.world());
    Snapshot snapshot;
    maker.fill(operation.world(), 0, snapshot);
    const OffscreenContext context;
    add_picture_rows("view.lite_360p", PictureQuality::lite, snapshot, 640, 360, 60, pictures, rows);
    add_picture_rows("view.full_720p", PictureQuality::full, snapshot, 1280, 720, 250, pictures, rows);
    rows.push_back(upload_row(20'000, 4 + 10 * pictures));
  }
  add_together_rows(operation, steps, rows);
  rows.push_back(latency_row(small, pictures));
  return rows;
}

std::vector<Row> bench_view(const BenchOptions& options) {
  return view_rows(make_organ_of_tets(options, 10'000, 1.0 / 60), make_organ_of_tets(options, 3'000, 1.0 / 60), 40,
                   300);
}

}  // namespace calot::bench
