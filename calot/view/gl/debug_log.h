// What the graphics driver has to say, by KHR_debug.
#pragma once
#include <string>
#include <vector>

namespace calot {

/// Collects errors and messages of high and medium severity of the current context while it lives. It must outlive the
/// context, or die while that is current; it doesn't move, as the driver keeps its address.
class DebugLog {
 public:
  DebugLog();
  ~DebugLog();
  DebugLog(const DebugLog&) = delete;
  DebugLog& operator=(const DebugLog&) = delete;

  /// Whether the driver can tell at all.
  [[nodiscard]] bool listens() const { return listens_; }
  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }  ///< the first 100
  [[nodiscard]] bool silent() const { return messages_.empty(); }
  void add(std::string message);
  void clear() { messages_.clear(); }

 private:
  bool listens_ = false;
  std::vector<std::string> messages_;
};

}  // namespace calot
