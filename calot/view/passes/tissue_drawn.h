// Inside this room only: the tissue's skin on the graphics card.
#pragma once
#include <vector>

#include "calot/view/gl/targets.h"
#include "calot/view/passes/drawable.h"
#include "calot/view/surface_stream.h"

namespace calot::detail {

class TissueDrawn {
 public:
  /// Sends positions, normals and conditions; what stays between cuts only when the skin is another one.
  void upload(const Snapshot& snapshot);
  /// One for each look, and for its cut faces.
  void add_to(std::vector<Drawable>& drawables) const;
  [[nodiscard]] std::size_t vertex_count() const { return stream_.vertex_count(); }
  [[nodiscard]] std::size_t index_uploads() const { return index_uploads_; }  ///< so far

 private:
  struct Part {
    TissueLook look;
    bool cut;
    std::size_t first, count;  // of indices
  };
  void send_skin(const TissueSkin& skin);

  SurfaceStream stream_;
  GlVertexArray vertices_;
  StreamBuffer moving_;
  GlBuffer still_, indices_;
  std::vector<Part> parts_;
  std::uint64_t version_ = 0;
  std::size_t index_uploads_ = 0;
};

}  // namespace calot::detail
