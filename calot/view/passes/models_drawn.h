// Inside this room only: instruments, clips and surroundings on the graphics card.
#pragma once
#include <map>
#include <optional>

#include "calot/view/passes/still_mesh.h"

namespace calot::detail {

class ModelsDrawn {
 public:
  void set_surroundings(std::span<const Surface> surfaces);
  void add_to(const Snapshot& snapshot, std::vector<Drawable>& drawables);

 private:
  struct Part {
    ModelFrame frame;
    StillMesh mesh;
  };
  struct Instrument {
    InstrumentGeometry geometry;
    std::vector<Part> parts;
  };
  struct Changing {  // rebuilt when what it shows has changed
    double key = -1;
    std::optional<StillMesh> mesh;
  };
  const Instrument& instrument(InstrumentKind kind);
  void add_instrument(const Snapshot& snapshot, std::size_t index, std::vector<Drawable>& drawables);
  void add_clip(const ClipSnapshot& clip, std::size_t index, std::vector<Drawable>& drawables);
  void add_cavity(const Snapshot& snapshot, std::vector<Drawable>& drawables);

  std::map<InstrumentKind, Instrument> instruments_;
  std::vector<Changing> clips_, loaded_;
  std::vector<StillMesh> surroundings_;
  std::optional<StillMesh> cavity_;
};

}  // namespace calot::detail
