// Injury by tools: tissue blanches under pressure, bruises, and bleeds where its surface breaks.
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calot/contact/tissue_contact.h"
#include "calot/mesh/topology_edit.h"
#include "calot/sim/tissue_properties.h"

namespace calot {

/// What one contact did to tissue within a step.
struct InjuryContact {
  SurfacePoint point;
  double force = 0;    ///< normal, ≥ 0 [N]
  double area = 1e-5;  ///< over which it presses, > 0 [m²]
  double speed = 0;    ///< of the tool relative to the tissue, ≥ 0 [m/s]
  double angle = 0;    ///< between that motion and the inward normal: 0 head-on, π/2 along the surface [rad]
  bool edge = false;   ///< of a jaw, blade or tip; not the round of a shaft
};

struct InjuryOptions {
  double blanching_time = 0.15;  ///< time constant under pressure, > 0 [s]
  double refill_time = 0.7;      ///< on release, > 0: colour is back within 2 s [s]
  double bruising_time = 3;      ///< to bruise wholly at twice the threshold, > 0 [s]
  double edge_factor = 3;        ///< by how much an edge concentrates stress, ≥ 1
  double slicing = 0.5;          ///< how much of an edge's motion along the surface counts as impact, 0 … 1
};

/// A place where the surface broke, or broke further: for `Fluids`.
struct BleedingOnset {
  SurfacePoint point;
  std::int32_t region = 0;
  double rate = 0;      ///< that joins what bled there before [m³/s]
  bool impact = false;  ///< by speed; else by pressure
};

struct InjuryStep {
  std::vector<BleedingOnset> onsets;  ///< in the order of the contacts
  double highest_pressure = 0;        ///< force per area, of any contact [Pa]
};

/// Pressure p = F/A, times `edge_factor` under an edge. Blanching follows min(1, p/blanching_pressure) with two time
/// constants; bruising grows with p above its threshold; the surface breaks by max(p/bleeding_pressure,
/// v/bleeding_speed) − 1, wholly at 1, with v the head-on part of the speed. docs/simulation.md.
class Injury {
 public:
  Injury() = default;
  /// Throws InputError for a region without properties and options out of range.
  Injury(const TetMesh& mesh, const std::map<std::int32_t, TissueProperties>& properties,
         const InjuryOptions& options = {});

  /// One step of `dt` > 0 [s]. Throws InputError for a contact that is not of this mesh or not finite.
  const InjuryStep& step(double dt, const TetMesh& mesh, std::span<const InjuryContact> contacts);
  void follow(const Remap& remap);

  [[nodiscard]] std::span<const double> blanching() const { return blanched_; }  ///< n, 0 … 1
  [[nodiscard]] std::span<const double> bruising() const { return bruised_; }    ///< n, 0 … 1, stays
  [[nodiscard]] std::span<const double> breaks() const { return broken_; }       ///< n, 0 … 1, stays
  void append_state(std::string& bytes) const;

 private:
  void press(double dt, const InjuryContact& contact, const TissueProperties& tissue, std::int32_t region);

  InjuryOptions options_;
  std::map<std::int32_t, TissueProperties> tissues_;
  std::vector<double> blanched_, bruised_, broken_;  // n
  std::vector<double> wanted_;                       // n, blanching that this step's pressure asks for
  InjuryStep report_;
};

}  // namespace calot
