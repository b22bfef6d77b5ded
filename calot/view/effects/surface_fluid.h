// Inside this room only: blood and bile from where they well up to where they lie, hang, drip or are sucked off.
#pragma once
#include <array>
#include <vector>

#include "calot/view/effects/effects.h"
#include "calot/view/effects/film.h"
#include "calot/view/effects/film_mask.h"
#include "calot/view/effects/noise.h"
#include "calot/view/effects/sheet.h"

namespace calot::detail {

/// A point of the skin or of a still surface.
struct Place {
  bool still = false;
  Seat seat;
};

/// A little liquid that runs, or rests until more comes.
struct Parcel {
  Place place;
  Vec3f velocity = Vec3f::Zero();  ///< along the surface [m/s]
  double volume = 0;               ///< [m³]
  Fluid fluid = Fluid::blood;
  std::uint32_t id = 0;
  float age = 0;                       ///< [s]
  float progress = 0;                  ///< downhill, of late [m/s]
  Vec3f laid = Vec3f::Constant(1e9F);  ///< where it last laid film, at rest [m]
};

/// A lens on the surface: a well at a source, or a pool.
struct Lens {
  static constexpr std::size_t rays = 12;
  Place place;
  double volume = 0;  ///< [m³]
  Fluid fluid = Fluid::blood;
  float radius = 0, depth = 0;         ///< [m]
  float clot = 0;                      ///< 0 … 1
  float draped = 0;                    ///< radius for which the ring was found [m]; 0: not yet
  float steepest = 0;                  ///< fall of the surface towards the lowest of the ring, per radius
  std::uint32_t lowest = 0;            ///< of the ring
  std::uint32_t since = 0;             ///< steps since the ring was found
  std::array<Place, 2 * rays> ring{};  ///< half way out, then the rim
};

struct Source {
  std::uint32_t id = 0;
  double seen = 0;   ///< shed, as the snapshots had it [m³]
  double due = 0;    ///< to well up in each step until the next snapshot [m³]
  double rate = 0;   ///< [m³/s]
  bool raw = false;  ///< of a raw face: it oozes here and there
  bool artery = false;
  Lens well;
};

struct Drop {
  Vec3f position = Vec3f::Zero(), velocity = Vec3f::Zero();
  double volume = 0;
  Fluid fluid = Fluid::blood;
  float age = 0;  ///< [s]
};

/// Where a suction tube draws.
struct Suction {
  Vec3f tip = Vec3f::Zero();
};

class SurfaceFluid {
 public:
  SurfaceFluid() = default;
  SurfaceFluid(const Snapshot& first, std::span<const Surface> still, const EffectsOptions& options);

  /// Takes a snapshot: new places of everything; on another skin, all are seated anew.
  void take(const Snapshot& snapshot, std::uint64_t steps);
  void step(double dt);
  void tell(EffectsState& state) const;  ///< drops, pools and ledgers

  [[nodiscard]] const std::vector<Parcel>& parcels() const { return parcels_; }
  [[nodiscard]] const std::vector<Lens>& pools() const { return pools_; }
  [[nodiscard]] const std::vector<Drop>& drops() const { return drops_; }
  [[nodiscard]] FilmMask& film() { return film_; }
  [[nodiscard]] const FilmMask& film() const { return film_; }
  [[nodiscard]] Sheet& skin() { return sheets_[0]; }
  [[nodiscard]] Vec3f position(const Place& place) const { return sheet(place).position(place.seat); }
  /// Lets liquid out anywhere, counted as shed.
  void pour(const Place& place, Fluid fluid, double volume);

 private:
  [[nodiscard]] const Sheet& sheet(const Place& place) const { return sheets_[place.still ? 1 : 0]; }
  [[nodiscard]] const Liquid& liquid(Fluid fluid) const { return liquids_[fluid == Fluid::blood ? 0 : 1]; }
  FluidLedger& ledger(Fluid fluid) { return ledgers_[fluid == Fluid::blood ? 0 : 1]; }
  [[nodiscard]] bool usable(const Place& place) const { return sheet(place).usable(place.seat.triangle); }
  [[nodiscard]] LensShape shape(double volume, Fluid fluid, float wet) const;

  void take_sources(const Snapshot& snapshot, std::uint64_t steps);
  void place_source(Source& source, const FluidSnapshot& fluid);
  void find_new_seats(const Snapshot& snapshot);

  void well_up(double dt);
  void throw_spurt(Source& source, double volume);
  void add_parcel(Parcel parcel);
  void run(double dt);
  bool run(Parcel& parcel, double dt);
  Vec3f heading(const Parcel& parcel, const Vec3f& down, const Vec3f& normal) const;
  void lay_film(Parcel& parcel, double thickness, float radius);
  void join_resting();
  void settle();
  void join_pools();
  void add_pool(const Place& place, Fluid fluid, double volume);

  void tend_pools(double dt);
  void shape_lens(Lens& lens);
  void drape(Lens& lens);
  bool spill(Lens& pool, double dt);
  void drip(const Place& place, Fluid fluid, double volume, float depth);
  void add_drop(Drop drop);
  void fall(double dt);
  bool land(const Drop& drop, const Place& place);
  void splash(const Drop& drop, const Vec3f& at, const Vec3f& normal);
  void suck(double dt);
  void tell(const Lens& lens, EffectsState& state) const;

  EffectsOptions options_;
  std::array<Liquid, 2> liquids_;
  std::array<FluidLedger, 2> ledgers_;
  std::array<Sheet, 2> sheets_;  // the skin; what is still
  std::uint64_t skin_version_ = 0;
  FilmMask film_;
  Vec3f gravity_ = Vec3f(0, 0, -9.81F), down_ = -Vec3f::UnitZ();
  float floor_ = 0;  // along down_: what falls beyond is gone [m]
  std::vector<Suction> suctions_;
  std::vector<Source> sources_;  // ascending by id
  std::vector<Parcel> parcels_;
  std::vector<Lens> pools_;
  std::vector<Drop> drops_;
  std::uint32_t next_id_ = 0;
  std::uint64_t steps_ = 0;
  double time_ = 0;
  RandomLine random_;
};

}  // namespace calot::detail
