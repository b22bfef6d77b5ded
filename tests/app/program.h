// Runs the calot executable as a user would, also under limits and with Ctrl-C.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calot/fem/model.h"
#include "tests/support/files.h"

namespace calot::test {

struct RunOptions {
  std::optional<std::uint64_t> largest_file = {};  ///< [bytes], as on a full disk
  /// Asked every few milliseconds with what stdout holds; once true, the program gets Ctrl-C.
  std::function<bool(const std::string& out)> interrupt_when = {};
};

struct Outcome {
  int code = -1;  ///< exit code; −1 after a signal
  std::string out, err;
  /// The one error line without "calot: error: "; fails the test unless stderr holds exactly one.
  [[nodiscard]] std::string error() const;
};
Outcome calot_run(const std::vector<std::string>& arguments, const RunOptions& options = {});

/// Expects exit code `code` and one error line that holds every one of `parts`.
void expect_refused(const Outcome& run, int code, const std::vector<std::string>& parts);

/// Names in a folder, sorted.
std::vector<std::string> names_in(const std::filesystem::path& folder);

/// Runs a Python program with the given arguments and expects it to succeed. @return what it printed
std::string python(const std::string& program, const std::vector<std::filesystem::path>& arguments);

/// A folder with a biliary tree's mesh (389 vertices, metres) and model.toml, its ends fixed.
class ModelFolder : public TempFolder {
 public:
  explicit ModelFolder(double time_step = 0.02, int fineness = 1);
  [[nodiscard]] std::string model() const { return (path() / "model.toml").string(); }
  [[nodiscard]] std::string mesh() const { return (path() / "organ.msh").string(); }
  [[nodiscard]] std::string compliance() const { return (path() / "C.h5").string(); }
  [[nodiscard]] std::string name(const std::string& file) const { return (path() / file).string(); }
  /// Replaces `from` in model.toml by `to`, which must occur.
  void edit_model(const std::string& from, const std::string& to) const;
  /// calot precompute, expected to work.
  void precompute(const std::vector<std::string>& more = {}) const;
};

/// A plane through the cystic duct of the biliary tree.
inline const std::string duct_plane = "20.3mm,0,0,1,0.1,0.05";

}  // namespace calot::test
