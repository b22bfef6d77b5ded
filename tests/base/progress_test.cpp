#include "calot/base/progress.h"

#include <gtest/gtest.h>

#include <vector>

#include "calot/base/error.h"

namespace calot {
namespace {

TEST(Progress, TellsPhasesAndFractions) {
  std::vector<double> fractions;
  std::string last;
  Progress progress([&](const ProgressState& state) {
    fractions.push_back(state.fraction);
    last = state.phase;
    EXPECT_TRUE(state.fraction > 0.01 ? state.remaining_seconds >= 0 : state.remaining_seconds < 0);
  });
  progress.phase("factoring");
  progress.at(0.5);
  EXPECT_EQ(last, "factoring");
  EXPECT_EQ(fractions, (std::vector<double>{0, 0.5}));
}

TEST(Progress, StopsWhenAsked) {
  Progress progress;
  progress.phase("a");
  progress.request_stop();
  EXPECT_THROW(progress.at(0.1), Interrupted);
  EXPECT_THROW(progress.phase("b"), Interrupted);
}

TEST(Errors, OneLineWithWhereWhatAndWhatToDo) {
  const InputError error(at_line("model.toml", 7), "young must be > 0", "give it in Pa");
  EXPECT_STREQ(error.what(), "model.toml:7: young must be > 0; give it in Pa");
  EXPECT_EQ(error.exit_code(), 2);
  EXPECT_EQ(Unsupported("", "x").exit_code(), 1);
}

}  // namespace
}  // namespace calot
