#include "bench/bench.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "calot/base/error.h"

namespace calot::bench {
namespace {

TEST(Distribution, PercentilesAreValuesThatWereMeasured) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Distribution d = distribution(values);
  EXPECT_EQ(d.p50, 50);
  EXPECT_EQ(d.p99, 99);
  EXPECT_EQ(d.max, 100);
  EXPECT_DOUBLE_EQ(d.mean, 50.5);
  EXPECT_EQ(distribution({7}).p50, 7);
  EXPECT_EQ(distribution({3, 1, 2}).p99, 3);
  EXPECT_THROW(distribution({}), InputError);
}

TEST(Row, IsMetWhenEveryGoalIs) {
  EXPECT_TRUE(met({.name = "no goal", .value = 9}));
  EXPECT_TRUE(met({.value = 1, .goal = 1}));
  EXPECT_FALSE(met({.value = 1.1, .goal = 1}));
  EXPECT_FALSE(met({.value = 1, .p99 = 3, .goal = 2}));
  EXPECT_FALSE(met({.value = 1, .ratio = 0.3, .goal = 1, .goal_ratio = 0.2}));
  EXPECT_FALSE(met({.value = 1, .goal_ratio = 0.2})) << "a goal for a ratio that wasn't measured is not met";
}

Report sample() {
  return {this_machine(),
          {{.name = "precompute.dense",
            .value = 0.5,
            .unit = "s",
            .baseline = "LAPACK potrf + potri",
            .ratio = 0.07,
            .goal = 0.8,
            .goal_ratio = 0.08},
           distribution_row("gradual.step", "ms", {1, 2, 3})}};
}

TEST(Report, JsonHasEveryKeyAndNullWhereThereIsNothing) {
  const auto json = nlohmann::json::parse(to_json(sample()));
  EXPECT_EQ(json.size(), 2u);
  EXPECT_GE(json["machine"]["cores"].get<int>(), 1);
  EXPECT_FALSE(json["machine"]["blas"].get<std::string>().empty());
  EXPECT_FALSE(json["machine"]["compiler"].get<std::string>().empty());
  ASSERT_EQ(json["rows"].size(), 2u);
  for (const auto& row : json["rows"])
    for (const char* key : {"name", "value", "unit", "p50", "p99", "max", "baseline", "ratio", "goal", "goal_ratio"})
      EXPECT_TRUE(row.contains(key)) << key;
  EXPECT_TRUE(json["rows"][0]["p50"].is_null());
  EXPECT_TRUE(json["rows"][1]["baseline"].is_null());
  EXPECT_EQ(json["rows"][0]["ratio"].get<double>(), 0.07);
  EXPECT_EQ(json["rows"][1]["p99"].get<double>(), 3);
}

TEST(Report, TextNamesEveryRowAndSaysWhetherItsGoalIsMet) {
  const std::string text = to_text(sample());
  EXPECT_NE(text.find("precompute.dense"), std::string::npos);
  EXPECT_NE(text.find("yes"), std::string::npos);
  EXPECT_EQ(text.find("NO"), std::string::npos);
  EXPECT_NE(text.find("LAPACK potrf + potri"), std::string::npos);
}

TEST(Benches, HaveDifferentNamesAndUnknownOnesAreRefused) {
  std::set<std::string> names;
  for (const Bench& bench : benches()) {
    EXPECT_TRUE(names.insert(bench.name).second) << bench.name;
    EXPECT_FALSE(bench.description.empty());
    EXPECT_EQ(&find_bench(bench.name), &bench);
  }
  EXPECT_THROW(find_bench("no such benchmark"), InputError);
}

TEST(Stopwatch, RunsForward) {
  const Stopwatch watch;
  const double first = watch.seconds();
  EXPECT_GE(first, 0);
  EXPECT_GE(watch.seconds(), first);
  EXPECT_GE(seconds_of([] {}), 0);
}

}  // namespace
}  // namespace calot::bench
