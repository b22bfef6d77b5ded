// What surrounds a phantom's operating field in its CT: simple bodies without labels.
#pragma once
#include <vector>

#include "calot/patient/phantom_field.h"

namespace calot {

/// A body that is filled evenly, with partial volume at its surface.
struct Filled {
  enum class Kind { ellipsoid, tube } kind;
  Superellipsoid ellipsoid;  ///< for an ellipsoid
  Curve curve;               ///< for a tube
  double radius = 0;
  double hounsfield;
  double gas_above = 1e9;  ///< y from where it is filled with gas: patients lie on their back [m]
  [[nodiscard]] Eigen::AlignedBox3d box() const;
  [[nodiscard]] double distance(const Vec3& p) const;
};

/// The trunk: an upright cylinder of superelliptic section.
struct Trunk {
  double x = 0, y = 0, half_width = 0.17, half_depth = 0.115;  ///< of the skin [m]
  double fat = 14e-3, muscle = 11e-3;                          ///< layers in front [m]
  /// First order, negative inside.
  [[nodiscard]] double distance(double px, double py) const;
};

struct Abdomen {
  Trunk trunk;
  double spine_y = 0;  ///< middle of the vertebral bodies
  SampledField dome;   ///< negative in the abdomen, positive in the chest
  std::vector<Filled> bodies;
};

/// Lays an abdomen around the field: the trunk just large enough to hold the liver.
Abdomen draw_abdomen(Random& random, const OperatingField& field);

/// HU of trunk, spine, ribs, lungs and bodies, before noise, for one slice at a time.
class AbdomenPainter {
 public:
  AbdomenPainter(const Abdomen& abdomen, const Vec3& hub, const VoxelGrid& grid);
  void paint(std::size_t k, std::span<float> hounsfield) const;

 private:
  struct Column {       ///< what a column of voxels shares, however high
    float depth;        ///< below the skin [m], negative outside
    float fat, wall;    ///< depth of the fat's and of the muscles' inner side
    float rib, margin;  ///< height of a rib there, and where ribs end [m]
  };
  void paint_layers(std::size_t k, std::span<float> hounsfield) const;
  void paint_spine(std::size_t k, std::span<float> hounsfield) const;

  const Abdomen& abdomen_;
  Vec3 hub_;
  const VoxelGrid& grid_;
  double voxel_;
  std::vector<Column> columns_;
};

}  // namespace calot
