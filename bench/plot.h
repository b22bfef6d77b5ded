// Figures of measured numbers, drawn by gnuplot.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace calot::bench {

/// One line, or one colour of bars.
struct PlotSeries {
  std::string title = {};
  std::vector<double> x = {}, y = {};  ///< as many y as x; bars take no x
};

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  std::vector<PlotSeries> series = {};
  bool log_x = false, log_y = false;
  std::vector<std::string> groups = {};  ///< names under groups of bars; empty: lines with points
};

/// Draws PATH.svg and PATH.png (path without ending), each whole or not at all. Throws FailedError if gnuplot is
/// missing or refuses, InputError for a plot without numbers, with counts that don't fit, or with values a log axis
/// can't show.
void write_plot(const std::filesystem::path& path, const Plot& plot);

/// Writes a table as CSV: a header line, then rows of cells; cells with commas or quotes are quoted.
void write_csv(const std::filesystem::path& path, const std::vector<std::string>& header,
               const std::vector<std::vector<std::string>>& rows);

}  // namespace calot::bench
