// A label volume while it is worked on, with an account of every change.
#pragma once
#include <Eigen/Core>
#include <initializer_list>

#include "calot/image/voxel_box.h"
#include "calot/patient/completion.h"

namespace calot {

/// A few structures.
class StructureSet {
 public:
  StructureSet() = default;
  StructureSet(std::initializer_list<Structure> list) {
    for (const Structure s : list) insert(s);
  }
  void insert(Structure s) { bits_ |= 1u << label_of(s); }
  [[nodiscard]] bool contains(Structure s) const { return (bits_ >> label_of(s) & 1u) != 0; }
  [[nodiscard]] bool empty() const { return bits_ == 0; }

 private:
  std::uint32_t bits_ = 0;
};

/// Structure numbers, a byte a voxel.
struct WorkLabels {
  VoxelGrid grid;
  std::vector<std::uint8_t> voxels;  ///< grid.count()

  [[nodiscard]] Structure at(std::size_t v) const { return static_cast<Structure>(voxels[v]); }
  [[nodiscard]] std::size_t count(Structure s) const;
};

/// Changes labels and counts what each structure gained and lost, so that no step can change what it doesn't report.
class LabelEdit {
 public:
  explicit LabelEdit(WorkLabels& labels) : labels_(labels) {}
  LabelEdit(const LabelEdit&) = delete;
  LabelEdit& operator=(const LabelEdit&) = delete;

  void set(std::size_t v, Structure s);
  /// What the structure gained and lost since the last call for it, as a step; the counters start again. Nothing is
  /// appended when nothing changed.
  void report(std::vector<CompletionStep>& steps, Structure structure, const std::string& step,
              const std::string& detail = {});
  /// The same for every structure that changed, by number.
  void report_all(std::vector<CompletionStep>& steps, const std::string& step, const std::string& detail = {});

 private:
  struct Change {
    std::size_t added = 0, removed = 0;
  };
  WorkLabels& labels_;
  std::array<Change, 256> changes_{};
};

/// printf for messages and details.
std::string text_of(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// "(1.0, -2.5, 30.1) mm" of a place [m].
std::string place_text(const Vec3& place);

}  // namespace calot
