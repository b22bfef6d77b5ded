// Pictures of the world for the view: what is copied after a step, and which faces an edit laid bare.
#pragma once
#include <atomic>
#include <span>

#include "calot/base/triple_buffer.h"
#include "calot/view/snapshot.h"

namespace calot {

/// Which faces of the tets lie in the skin that the tissue had at the start; followed through edits. A face of a piece
/// is skin where it lies in a skin face of the tet that it is a piece of.
class SkinFaces {
 public:
  SkinFaces() = default;
  SkinFaces(const TetMesh& mesh, std::span<const ContactTriangle> boundary);
  /// The edits of one step, in order; `mesh` is the one after the last of them.
  void follow(std::span<const StiffnessChange> changes, const TetMesh& mesh);
  [[nodiscard]] bool is_skin(TetId tet, std::uint32_t face) const { return (faces_[tet.index()] >> face & 1) != 0; }

 private:
  std::vector<Tet> tets_;            // m
  std::vector<std::uint8_t> faces_;  // m, a bit for each face
};

/// Fills snapshots of one world, whose present skin counts as uncut. Call `follow` once after each step, whether or not
/// a snapshot is taken.
class SnapshotMaker {
 public:
  explicit SnapshotMaker(const World& world);
  /// Remembers what happened, so that no event and no edit is missed.
  void follow(const World& world);
  /// Everything of this moment, into memory that is used again. The skin is copied only where `out` has another one.
  /// `out.events` are those from number `first_event` on.
  void fill(const World& world, std::uint64_t first_event, Snapshot& out);
  [[nodiscard]] std::uint64_t events_seen() const { return first_kept_ + kept_.size(); }
  void forget_events(std::uint64_t before);  ///< those of lower numbers won't be asked for

 private:
  void build_skin(const World& world);
  void fill_tissue(const World& world, Snapshot& out) const;
  [[nodiscard]] Triangle skin_triangle(const SurfacePoint& place, const TetMesh& mesh) const;

  SkinFaces faces_;
  TissueSkin skin_;
  std::vector<std::uint32_t> triangle_of_face_;  // skin triangle of tet · 4 + face
  std::vector<std::uint32_t> first_, next_;      // skin vertices of each vertex of the mesh, as lists
  std::vector<WorldEvent> kept_;
  std::uint64_t first_kept_ = 0;
  double heat_before_ = 0, cautery_ = 0;  // [J], [W] of all hooks in the last step
};

/// From the thread that steps the world to the one that draws it. Neither waits for the other; a snapshot that was not
/// fetched in time is replaced by the next, but its events are in that one.
class SnapshotFeed {
 public:
  explicit SnapshotFeed(const World& world) : maker_(world) { hand_over(world); }

  /// After each step, on the world's thread.
  void publish(const World& world);

  /// On the drawing thread. @return the newest snapshot; null where it is the one returned before
  const Snapshot* fetch();
  [[nodiscard]] const Snapshot& current() const { return *current_; }  ///< the last one fetched; after a first `fetch`

 private:
  struct Slot {
    mutable Snapshot snapshot;  // only the side that has the slot touches it
  };
  void hand_over(const World& world);

  TripleBuffer<Slot> slots_;
  SnapshotMaker maker_;
  std::atomic<std::uint64_t> events_fetched_ = 0;
  const Snapshot* current_ = nullptr;
};

}  // namespace calot
