#include "calot/patient/border.h"

#include "calot/base/error.h"

namespace calot {
namespace {

struct Contact {
  std::size_t voxels = 0;
  Vec3 sum = Vec3::Zero();  // of voxel coordinates
};

/// What touches one face, by structure number.
std::array<Contact, 256> contacts(const LabelMap& labels, int axis, bool upper) {
  std::array<Contact, 256> found;
  const auto& size = labels.grid.size;
  const auto a = static_cast<std::size_t>(axis), b = (a + 1) % 3, c = (a + 2) % 3;
  std::array<std::size_t, 3> at{};
  at[a] = upper ? size[a] - 1 : 0;
  for (at[b] = 0; at[b] < size[b]; ++at[b])
    for (at[c] = 0; at[c] < size[c]; ++at[c]) {
      const Label label = labels.voxels[labels.grid.index(at[0], at[1], at[2])];
      if (label == 0 || label > 255) continue;
      ++found[label].voxels;
      found[label].sum += Vec3(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2]));
    }
  return found;
}

BorderCut cut_of(const VoxelGrid& grid, Structure s, int axis, bool upper, const Contact& contact) {
  const Vec3 spacing = grid.spacing();
  Vec3 middle = contact.sum / static_cast<double>(contact.voxels);
  middle[axis] += upper ? 0.5 : -0.5;
  const double face = spacing[(axis + 1) % 3] * spacing[(axis + 2) % 3];
  const Vec3 outward = (upper ? 1 : -1) * grid.to_world.linear().col(axis).normalized();
  return {s, axis, upper, grid.to_world * middle, outward, face * static_cast<double>(contact.voxels)};
}

bool must_be_whole(Structure s) {
  return is_tube(s) || s == Structure::gallbladder || s == Structure::gallbladder_wall;
}

[[noreturn]] void refuse(Structure s, const std::string& side) {
  const std::string name(name_of(s));
  throw InputError("labels", "the " + name + " is cut by the volume's " + side + " end",
                   is_tube(s) ? "give a volume that holds it, or draw it with a centreline that stays inside"
                              : "give a CT and labels that hold all of it");
}

}  // namespace

std::string side_name(const VoxelGrid& grid, int axis, bool upper) {
  const Vec3 outward = (upper ? 1 : -1) * grid.to_world.linear().col(axis);
  Eigen::Index most = 0;
  outward.cwiseAbs().maxCoeff(&most);
  static constexpr std::array<const char*, 6> names{
      "left", "right", "back (posterior)", "front (anterior)", "lower (inferior)", "upper (superior)"};
  return names[2 * static_cast<std::size_t>(most) + (outward[most] > 0 ? 1 : 0)];
}

std::vector<BorderCut> border_cuts(const LabelMap& labels, const std::set<Structure>& redrawn) {
  std::vector<BorderCut> cuts;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true}) {
      const std::array<Contact, 256> found = contacts(labels, axis, upper);
      for (const Structure s : all_structures()) {
        const Contact& contact = found[label_of(s)];
        if (contact.voxels == 0 || redrawn.contains(s)) continue;
        if (must_be_whole(s)) refuse(s, side_name(labels.grid, axis, upper));
        cuts.push_back(cut_of(labels.grid, s, axis, upper, contact));
      }
    }
  return cuts;
}

}  // namespace calot
