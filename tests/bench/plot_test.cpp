#include "bench/plot.h"

#include <gtest/gtest.h>
#include <png.h>
#include <stdlib.h>
#include <unistd.h>

#include <cmath>

#include "calot/base/error.h"
#include "calot/base/files.h"

namespace calot::bench {
namespace {
namespace fs = std::filesystem;

class PlotTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("calot_plot_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

Plot lines() {
  return {.title = "Time \"of\" a cut_2",
          .x_label = "vertices",
          .y_label = "time [s]",
          .series = {{"exact", {140, 399, 961}, {1e-4, 1e-3, 1e-2}}, {"paper's", {140, 399, 961}, {1e-3, 1e-2, 0.1}}},
          .log_x = true,
          .log_y = true};
}

TEST_F(PlotTest, DrawsSvgAndPngWithTheSameBytesEachTime) {
  write_plot(folder_ / "a", lines());
  write_plot(folder_ / "b", lines());
  EXPECT_EQ(files(), 4u) << "only the figures stay";
  EXPECT_EQ(read_file(folder_ / "a.svg"), read_file(folder_ / "b.svg"));
  EXPECT_EQ(read_file(folder_ / "a.png"), read_file(folder_ / "b.png"));
  const std::string svg = read_file(folder_ / "a.svg");
  EXPECT_NE(svg.find("cut_2"), std::string::npos);
  EXPECT_NE(svg.find("exact"), std::string::npos);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  const std::string png = read_file(folder_ / "a.png");
  EXPECT_TRUE(png_image_begin_read_from_memory(&header, png.data(), png.size()));
  EXPECT_EQ(header.width, 1200u);
  png_image_free(&header);
}

TEST_F(PlotTest, DrawsBars) {
  write_plot(folder_ / "bars", {.title = "Error",
                                .x_label = "",
                                .y_label = "mm",
                                .series = {{"max", {}, {1, 2}}, {"mean", {}, {0.5, 0.2}}},
                                .groups = {"far", "near"}});
  EXPECT_NE(read_file(folder_ / "bars.svg").find("near"), std::string::npos);
}

TEST_F(PlotTest, RefusesNumbersThatDontFit) {
  Plot none = lines(), uneven = lines(), zero = lines();
  none.series.clear();
  uneven.series[0].y.pop_back();
  zero.series[1].y[0] = 0;
  for (const Plot& plot : {none, uneven, zero}) EXPECT_THROW(write_plot(folder_ / "bad", plot), InputError);
  EXPECT_EQ(files(), 0u);
}

TEST_F(PlotTest, SaysWhatToInstallWhenGnuplotIsMissing) {
  const std::string path = getenv("PATH");
  setenv("PATH", folder_.c_str(), 1);
  try {
    write_plot(folder_ / "a", lines());
    ADD_FAILURE() << "drew without gnuplot";
  } catch (const FailedError& error) {
    EXPECT_NE(std::string(error.what()).find("gnuplot-nox"), std::string::npos);
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(files(), 0u);
}

TEST_F(PlotTest, CsvQuotesWhatNeedsIt) {
  write_csv(folder_ / "t.csv", {"name", "value"}, {{"a,b", "1"}, {"say \"x\"", "2"}});
  EXPECT_EQ(read_file(folder_ / "t.csv"), "name,value\n\"a,b\",1\n\"say \"\"x\"\"\",2\n");
}

}  // namespace
}  // namespace calot::bench
