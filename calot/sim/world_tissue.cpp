// What a step's motion does to tissue: what holds it, heat, injury, bleeding, tearing.
#include <algorithm>

#include "calot/sim/hook.h"
#include "calot/sim/world.h"

namespace calot {
namespace {

constexpr double suction_radius = 8e-3;     // pooled fluid this near to the tip is taken up [m]; assumed
constexpr double suction_flow = 50e-6;      // [m³/s]; assumed, 3 L a minute
constexpr double spread_of_contact = 4e-6;  // area a contact point stands for [m²]: contacts lie 2 mm apart

constexpr double clip_reach = 1e-3;  // jaws catch a clip this far beyond their faces [m]

// Tets that clips squeeze: between their legs, and all that share a vertex with what is held there; ascending. A tube's
// tets stand for its wall and its lumen: pressed flat, the lumen goes and the wall isn't stretched, but the tets are.
std::vector<TetId> squeezed_by(std::span<const Clip> clips, const VertexTets& around) {
  std::vector<TetId> squeezed;
  for (const Clip& clip : clips) {
    if (clip.state() == ClipState::off) continue;
    squeezed.insert(squeezed.end(), clip.tets().begin(), clip.tets().end());
    for (const auto& [vertex, weight] : clip.held())
      for (std::uint32_t k = around.start[vertex.index()]; k < around.start[vertex.index() + 1]; ++k)
        squeezed.push_back(around.tets[k]);
  }
  std::sort(squeezed.begin(), squeezed.end());
  squeezed.erase(std::unique(squeezed.begin(), squeezed.end()), squeezed.end());
  return squeezed;
}

bool borders_on(const std::array<VertexId, 3>& face, std::span<const TetId> tets, const TetMesh& mesh,
                const VertexTets& around) {
  for (std::uint32_t k = around.start[face[0].index()]; k < around.start[face[0].index() + 1]; ++k) {
    const TetId t = around.tets[k];
    const Tet& tet = mesh.tets[t.index()];
    if (std::all_of(face.begin() + 1, face.end(),
                    [&](VertexId v) { return std::find(tet.begin(), tet.end(), v) != tet.end(); }) &&
        std::binary_search(tets.begin(), tets.end(), t))
      return true;
  }
  return false;
}

}  // namespace

void World::follow_up(std::span<const Vec3> before) {
  pull_clips(before);
  update_holds();
  update_injury();
  if (options_.heat) update_heat();
  if (options_.fluids) update_fluids();
  const TearStep& tears = tearing_.step(model_.mesh(), around_, state_.positions);
  const std::vector<TetId> squeezed = squeezed_by(clips_, around_);
  report_.largest_stretch = tears.largest;
  report_.inverted = tears.inverted.size();
  report_.stuck = static_cast<std::size_t>(std::count_if(tears.stuck.begin(), tears.stuck.end(), [&](TetId t) {
    return !std::binary_search(squeezed.begin(), squeezed.end(), t);
  }));
  if (report_.inverted > inverted_before_)
    say(EventKind::inverted, -1, static_cast<double>(report_.inverted),
        std::to_string(report_.inverted) + " tets are turned inside out");
  inverted_before_ = report_.inverted;
  if (!options_.tearing) return;
  to_part_ = tears.faces;
  if (!squeezed.empty())
    std::erase_if(to_part_, [&](const auto& face) { return borders_on(face, squeezed, model_.mesh(), around_); });
  // A tet is tried every other step only: the number flickers. Said again where it has more than doubled.
  if (report_.stuck <= 2 * stuck_said_) return;
  stuck_said_ = report_.stuck;
  say(EventKind::overstretched, -1, static_cast<double>(report_.stuck),
      std::to_string(report_.stuck) + " tets are stretched beyond what they bear, and no crack relieves them");
}

// Jaws that close on a clip hold it and nothing else: its legs keep them off the tissue. What is in the clip is drawn
// along by springs as stiff as the instrument.
void World::grip_clips() {
  for (InstrumentArm& arm : arms_) {
    if (!arm.grasp) continue;
    arm.clip_pull.setZero();
    if (arm.input().opening > arm.clip_opening + 0.02) arm.held_clip = -1;
    if (arm.held_clip < 0 && arm.closing())
      for (std::size_t k = 0; k < clips_.size() && arm.held_clip < 0; ++k) {
        if (clips_[k].state() == ClipState::off) continue;
        const Vec3 place = arm.from().inverse() * clips_[k].frame().position;
        const InstrumentGeometry& g = arm.geometry();
        const double half_gap = std::tan(arm.opening_from() / 2) * std::max(0.0, place.z());
        if (place.z() < g.face_start || place.z() > g.jaw_length || std::abs(place.y()) > half_gap + clip_reach ||
            std::abs(place.x() - g.middle(place.z())) > g.width(place.z()) / 2 + clip_reach)
          continue;
        arm.held_clip = static_cast<std::int32_t>(k);
        arm.clip_anchor = place;
        arm.clip_opening = arm.input().opening;
      }
    if (arm.held_clip < 0) continue;
    const Clip& clip = clips_[static_cast<std::size_t>(arm.held_clip)];
    if (clip.state() == ClipState::off) {
      arm.held_clip = -1;
      continue;
    }
    arm.set_opening(std::max(arm.opening_to(), arm.opening_from()));
    arm.grasp->release(arm.opening_to());
    const Vec3 motion = arm.to() * arm.clip_anchor - clip.frame().position;
    for (const auto& [vertex, weight] : clip.held()) {
      Spring spring;
      spring.vertex = vertex;
      spring.anchor = state_.positions[vertex.index()] + motion;
      spring.stiffness = weight * arm.geometry().grip_stiffness * Mat3::Identity();
      springs_.push_back(spring);
    }
  }
}

// What the jaws pull a clip with, once the tissue has moved; the clip comes off where it is too much.
void World::pull_clips(std::span<const Vec3> before) {
  for (InstrumentArm& arm : arms_) {
    if (arm.held_clip < 0) continue;
    Clip& clip = clips_[static_cast<std::size_t>(arm.held_clip)];
    const Vec3 motion = arm.to() * arm.clip_anchor - clip.frame().position;
    Vec3 force = Vec3::Zero();
    for (const auto& [vertex, weight] : clip.held())
      force +=
          weight * arm.geometry().grip_stiffness * (before[vertex.index()] + motion - state_.positions[vertex.index()]);
    clip.pull(force);
    arm.clip_pull = force;
    arm.force -= force;
  }
}

void World::place_clip(std::size_t k) {
  const InstrumentArm& arm = arms_[k];
  Clip clip({}, arm.geometry(), arm.to(), std::max(arm.opening_to(), 0.25 * arm.geometry().max_opening),
            tissue_surface(), model_.mesh());
  if (clip.state() == ClipState::off) {
    say(EventKind::clip_lost, static_cast<std::int32_t>(k), 0, "a clip was fired with nothing between its legs");
    return;
  }
  say(EventKind::clip_placed, static_cast<std::int32_t>(k), 1e6 * clip.held_area(),
      arm.setup().name +
          (clip.whole() ? " placed a clip across the whole tube" : " placed a clip across a part of the tube"));
  clips_.push_back(std::move(clip));
}

void World::update_holds() {
  for (std::size_t k = 0; k < arms_.size(); ++k) {
    InstrumentArm& arm = arms_[k];
    const auto number = static_cast<std::int32_t>(k);
    if (arm.geometry().kind == InstrumentKind::clip_applier && arm.fires()) place_clip(k);
    if (!arm.grasp) continue;
    const bool held = arm.held_before;
    arm.grasp->after_step(state_.positions);
    arm.force += arm.grasp->report().pull;
    arm.held_before = arm.grasp->holding() || arm.held_clip >= 0;
    if (!held && arm.held_before)
      say(EventKind::grasped, number, static_cast<double>(arm.grasp->held_count()),
          arm.setup().name + " took hold of " +
              (arm.held_clip >= 0 ? "a clip" : std::to_string(arm.grasp->held_count()) + " vertices"));
    if (held && !arm.held_before) say(EventKind::let_go, number, 0, arm.setup().name + " let go");
    const bool slips = arm.grasp->report().slip > 0;
    if (slips && !arm.slipped_before)
      say(EventKind::slipped, number, arm.grasp->report().hold_limit,
          arm.setup().name + " slips: pulled beyond what its jaws hold");
    arm.slipped_before = slips;
    if (!arm.grasp->bruises().empty() && !arm.bruised_before)
      say(EventKind::bruised, number, arm.grasp->report().grip, arm.setup().name + " bruises what it holds");
    arm.bruised_before = !arm.grasp->bruises().empty();
  }
  for (Clip& clip : clips_) {
    const ClipState before = clip.state();
    clip.after_step(state_.positions);
    if (before != ClipState::off && clip.state() == ClipState::off) say(EventKind::clip_lost, -1, 0, "a clip came off");
  }
}

void World::update_heat() {
  std::vector<HeatSource> sources;
  for (const InstrumentArm& arm : arms_) {
    if (arm.geometry().kind != InstrumentKind::hook || !arm.input().energy) continue;
    if (const auto contact = hook_contact(arm.geometry(), arm.to(), tissue_surface()))
      sources.push_back({contact->place, std::max(1e-3, contact->radius), arm.setup().power, 0.5, 0.5});
  }
  const HeatStep& step = heat_.step(model_.dynamics().time_step, sources, model_.mesh(), state_.positions);
  to_vaporise_ = step.vaporised;
  to_stiffen_ = step.stiffened;
  std::erase_if(to_stiffen_, [&](TetId t) { return std::binary_search(to_vaporise_.begin(), to_vaporise_.end(), t); });
}

void World::update_injury() {
  std::vector<InjuryContact> touches;
  const double h = model_.dynamics().time_step;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const TissueContact& contact = contacts_[k];
    const double force = report_.friction.forces[3 * static_cast<Eigen::Index>(k)];
    if (contact.partner != ContactPartner::shape || !(force > 0)) continue;
    InjuryContact touch;
    touch.point = contact.point;
    touch.force = force;
    touch.area = spread_of_contact;
    // How fast they met: before the contact's own forces, which take the speed away.
    Vec3 parting = problem_.free_motion.segment<3>(3 * static_cast<Eigen::Index>(k));
    parting.x() -= gap_of_step(contact);
    const Vec3 speed = rows_[k].frame * -parting / h;
    touch.speed = speed.norm();
    touch.angle = touch.speed > 1e-9 ? std::acos(std::clamp(speed.dot(contact.normal) / touch.speed, -1.0, 1.0)) : 0;
    touch.edge = shape_owner_[contact.shape].second != 0;
    touches.push_back(touch);
  }
  for (const InstrumentArm& arm : arms_) {
    if (!arm.grasp) continue;
    for (const Bruise& bruise : arm.grasp->bruises()) {
      InjuryContact touch;
      touch.point.vertices = {bruise.vertex, bruise.vertex, bruise.vertex};
      touch.point.weights = Vec3::UnitX();
      touch.point.tet = around_.tets[around_.start[bruise.vertex.index()]];
      touch.force = bruise.force;
      touch.area = std::max(bruise.area, 1e-8);
      touches.push_back(touch);
    }
  }
  const InjuryStep& step = injury_.step(h, model_.mesh(), touches);
  if (!options_.fluids) return;
  for (const BleedingOnset& onset : step.onsets) {
    fluids_.injure(onset, model_.mesh());
    say(EventKind::bleeding, -1, millilitres(onset.rate),
        std::string("a tool broke the surface by ") + (onset.impact ? "its speed" : "its pressure"));
  }
}

void World::update_fluids() {
  // Whether a clip shuts its tube is looked at a few times a second: it looks at every tet.
  if (!clips_.empty() && step_ % 6 == 0) {
    closed_.assign(model_.mesh().tet_count(), 0);
    for (const Clip& clip : clips_) {
      if (clip.state() == ClipState::off) continue;
      std::vector<std::int32_t> regions;
      for (const TetId t : clip.tets()) regions.push_back(model_.mesh().regions[t.index()]);
      std::sort(regions.begin(), regions.end());
      regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
      for (const std::int32_t region : regions) {
        if (!clip.closes(region, model_.mesh(), state_.positions)) continue;
        for (const TetId t : clip.tets())
          if (model_.mesh().regions[t.index()] == region) closed_[t.index()] = 1;
      }
    }
  }
  const double h = model_.dynamics().time_step;
  fluids_.step(h, model_.mesh(), state_.positions, heat_.coagulation(), closed_);
  for (const FluidSource& source : fluids_.sources()) {
    if (source.kind == FluidSourceKind::injury) continue;
    const bool flows = source.rate > 0 && !source.ended;
    if (flows == flowing_.contains(source.id)) continue;
    if (!flows) {
      flowing_.erase(source.id);
      continue;
    }
    flowing_.insert(source.id);
    const auto region = model_.mesh().region_names.find(source.region);
    const std::string name = region == model_.mesh().region_names.end() ? "tissue" : region->second;
    const bool vessel = source.kind == FluidSourceKind::vessel;
    say(vessel && source.fluid == Fluid::bile ? EventKind::leaking : EventKind::bleeding, -1, millilitres(source.rate),
        name + (vessel ? " is open" : " oozes"));
  }
  for (const InstrumentArm& arm : arms_)
    if (arm.geometry().kind == InstrumentKind::suction && arm.input().energy)
      fluids_.suck(arm.to().position, suction_radius, suction_flow, h);
}

}  // namespace calot
