// After a cut: everything on the skin finds its place on the new one.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <unordered_map>

#include "calot/view/effects/surface_fluid.h"

namespace calot::detail {
namespace {

using RestTriangle = std::array<std::uint32_t, 9>;  // the bits of its corners at rest, the least first

struct RestHash {
  std::size_t operator()(const RestTriangle& t) const {
    const auto a = mix3(t[0], t[1], t[2]), b = mix3(t[3] ^ a[0], t[4] ^ a[1], t[5] ^ a[2]);
    return mix3(t[6] ^ b[0], t[7] ^ b[1], t[8] ^ b[2])[0];
  }
};

RestTriangle rest_triangle(const Sheet& sheet, std::uint32_t t) {
  std::array<std::array<std::uint32_t, 3>, 3> corner{};
  for (std::size_t k = 0; k < 3; ++k) std::memcpy(corner[k].data(), sheet.rests()[sheet.triangle(t)[k]].data(), 12);
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (corner[k] < corner[least]) least = k;
  RestTriangle out{};
  for (std::size_t k = 0; k < 3; ++k)
    std::copy_n(corner[(least + k) % 3].begin(), 3, out.begin() + static_cast<std::ptrdiff_t>(3 * k));
  return out;
}

/// A seat as the old skin had it.
struct OldSeat {
  Place* place = nullptr;
  bool has_triangle = false;
  RestTriangle triangle{};
  Vec3f first_rest = Vec3f::Zero();  // of the triangle's first corner, which tells how it was turned
  Vec3f position = Vec3f::Zero(), normal = Vec3f::Zero();
};

}  // namespace

/// The same triangle where it is still there, else the nearest that looks the same way. What finds none falls.
void SurfaceFluid::find_new_seats(const Snapshot& snapshot) {
  Sheet& skin = sheets_[0];
  std::vector<OldSeat> seats;
  const auto note = [&](Place& place) {
    OldSeat old;
    old.place = &place;
    if (place.seat.triangle < skin.triangle_count() && skin.triangle(place.seat.triangle) != Triangle{}) {
      old.position = skin.position(place.seat);
      old.has_triangle = skin.usable(place.seat.triangle);
      if (old.has_triangle) {
        old.normal = skin.normal(place.seat.triangle);
        old.triangle = rest_triangle(skin, place.seat.triangle);
        old.first_rest = skin.rests()[skin.triangle(place.seat.triangle)[0]];
      }
    } else {
      old.position = Vec3f::Constant(NAN);
    }
    seats.push_back(old);
  };
  for (Parcel& parcel : parcels_)
    if (!parcel.place.still) note(parcel.place);
  for (Lens& pool : pools_)
    if (!pool.place.still) note(pool.place);
  for (Source& source : sources_) {
    note(source.well.place);
    source.well.draped = 0;
  }
  skin.take_skin(snapshot.skin, snapshot.positions);
  skin_version_ = snapshot.skin.version;
  if (seats.empty()) return;

  std::unordered_map<RestTriangle, std::uint32_t, RestHash> now;
  now.reserve(2 * seats.size());
  for (const OldSeat& old : seats)
    if (old.has_triangle) now.emplace(old.triangle, no_triangle);
  for (std::uint32_t t = 0; t < skin.triangle_count(); ++t) {
    if (!skin.usable(t)) continue;
    const auto found = now.find(rest_triangle(skin, t));
    if (found != now.end() && found->second == no_triangle) found->second = t;
  }
  for (const OldSeat& old : seats) {
    Seat& seat = old.place->seat;
    const std::uint32_t same = old.has_triangle ? now.at(old.triangle) : no_triangle;
    if (same != no_triangle) {
      int turn = 0;
      for (int k = 0; k < 3; ++k)
        if (skin.rests()[skin.triangle(same)[static_cast<std::size_t>(k)]] == old.first_rest) turn = k;
      Vec3f weights;
      for (int k = 0; k < 3; ++k) weights[(k + turn) % 3] = seat.weights[k];
      seat = {same, weights};
      continue;
    }
    const auto near = skin.nearest(old.position, 6e-3F, old.normal);
    seat = near ? near->seat : Seat{};
  }
  const auto falls = [&](const Place& place) { return !place.still && place.seat.triangle == no_triangle; };
  const auto drop_from = [&](const Vec3f& at, Fluid fluid, double volume) {
    if (!at.allFinite()) {
      ledger(fluid).gone += volume;
      return;
    }
    const int pieces = std::clamp(static_cast<int>(volume / 40e-9), 1, 8);
    for (int k = 0; k < pieces; ++k) {
      Drop drop;
      drop.position = at + (pieces > 1 ? 2e-3F : 0.0F) * random_.in_ball();
      drop.fluid = fluid;
      drop.volume = volume / pieces;
      add_drop(drop);
    }
  };
  std::size_t s = 0;
  for (Parcel& parcel : parcels_) {
    if (parcel.place.still) continue;
    if (falls(parcel.place)) {
      drop_from(seats[s].position, parcel.fluid, parcel.volume);
      parcel.volume = 0;
    }
    ++s;
  }
  for (Lens& pool : pools_) {
    pool.draped = 0;
    if (pool.place.still) continue;
    if (falls(pool.place)) {
      drop_from(seats[s].position, pool.fluid, pool.volume);
      pool.volume = 0;
    }
    ++s;
  }
  std::erase_if(parcels_, [](const Parcel& parcel) { return !(parcel.volume > 0); });
  std::erase_if(pools_, [](const Lens& pool) { return !(pool.volume > 0); });
}

}  // namespace calot::detail
