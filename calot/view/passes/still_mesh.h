// Inside this room only: meshes that don't change, on the graphics card: instruments, clips, surroundings.
#pragma once
#include "calot/view/gl/targets.h"
#include "calot/view/models/model.h"
#include "calot/view/passes/drawable.h"

namespace calot::detail {

class StillMesh {
 public:
  explicit StillMesh(const ModelPart& part);
  [[nodiscard]] Drawable drawable() const;

 private:
  GlVertexArray vertices_;
  GlBuffer corners_, indices_;
  GLsizei count_ = 0;
  ModelMaterial material_;
};

/// A mesh's corners as parts of a model; normals where it has none.
ModelPart part_of(const Surface& surface);
/// A dome around a place, seen from inside: the cavity of a scene that has no walls of its own.
ModelPart cavity_dome(const Vec3f& middle, float radius);

}  // namespace calot::detail
