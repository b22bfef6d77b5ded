// Several files that appear together or not at all.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace calot {

/// A folder beside the target, filled first and put in the target's place when whole; removed if left uncommitted.
class StagedFolder {
 public:
  /// Throws InputError if the target exists and is no folder. Touches nothing.
  explicit StagedFolder(std::filesystem::path target);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& target() const { return target_; }
  /// Throws InputError if the target holds files but not this one, which every earlier output of the same kind has: it
  /// is somebody else's.
  void require_own(const std::string& marker) const;
  /// Throws InputError if one of these files would replace one of the inputs.
  void require_apart(const std::vector<std::string>& files, const std::vector<std::filesystem::path>& inputs) const;
  /// Makes the folder, lets `write` fill it, and commits. Throws what `write` throws, with the target's name for the
  /// folder's.
  void fill(const std::function<void(const std::filesystem::path& folder)>& write,
            const std::vector<std::string>& files);

  /// Makes the folder to fill. Throws FailedError.
  const std::filesystem::path& open();
  /// Renames the folder to the target; where that exists already, renames the files into it, in this order, after
  /// looking that nothing stands in the way of any of them.
  void commit(const std::vector<std::string>& files);

 private:
  void check_room(const std::vector<std::string>& files) const;

  std::filesystem::path target_, folder_;
  std::filesystem::path made_;  // the topmost parent that had to be made; empty if none
  bool committed_ = false;
};

}  // namespace calot
