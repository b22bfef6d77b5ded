#include "bench/plot.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "calot/base/error.h"
#include "calot/base/files.h"

namespace calot::bench {
namespace fs = std::filesystem;
namespace {

// Told apart with any colour vision [Okabe2008].
const std::vector<std::string> colors{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

void check(const Plot& plot) {
  const auto wrong = [&](const std::string& what) { throw InputError("plot \"" + plot.title + "\"", what); };
  if (plot.series.empty()) wrong("there is nothing to draw");
  for (const PlotSeries& s : plot.series) {
    const std::size_t count = plot.groups.empty() ? s.x.size() : plot.groups.size();
    if (s.y.empty() || s.y.size() != count)
      wrong("series \"" + s.title + "\" has " + std::to_string(s.y.size()) + " values for " + std::to_string(count) +
            " places");
    for (const double y : s.y)
      if (std::isinf(y) || (plot.log_y && y <= 0)) wrong("series \"" + s.title + "\" has a value its axis can't show");
    for (const double x : s.x)
      if (!std::isfinite(x) || (plot.log_x && x <= 0))
        wrong("series \"" + s.title + "\" has a place its axis can't show");
  }
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result + '"';
}

void write_data(std::ostream& out, const Plot& plot) {
  out.precision(17);
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    out << "$data" << s << " << end_of_data\n";
    for (std::size_t i = 0; i < plot.series[s].y.size(); ++i) {
      if (plot.groups.empty())
        out << plot.series[s].x[i];
      else
        out << quoted(plot.groups[i]);
      out << ' ' << plot.series[s].y[i] << '\n';
    }
    out << "end_of_data\n";
  }
}

void write_curves(std::ostream& out, const Plot& plot) {
  out << "plot ";
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    const std::string color = quoted(colors[s % colors.size()]);
    out << (s > 0 ? ", " : "") << "$data" << s;
    if (plot.groups.empty())
      out << " using 1:2 with linespoints linewidth 2 pointtype 7 pointsize 0.7 linecolor rgb " << color;
    else
      out << " using 2:xtic(1) linecolor rgb " << color;
    out << " title " << quoted(plot.series[s].title) << " noenhanced";
  }
  out << '\n';
}

std::string script(const Plot& plot, const fs::path& svg, const fs::path& png) {
  std::ostringstream out;
  write_data(out, plot);
  out << "set encoding utf8\nset title " << quoted(plot.title) << " noenhanced\nset xlabel " << quoted(plot.x_label)
      << " noenhanced\nset ylabel " << quoted(plot.y_label) << " noenhanced\nset key top left reverse Left\n"
      << "set grid linecolor rgb \"#dddddd\"\nset border 3\nset tics nomirror\nset datafile missing \"nan\"\n";
  if (plot.log_x) out << "set logscale x\n";
  if (plot.log_y) out << "set logscale y\n";
  if (!plot.groups.empty()) {
    out << "set style data histograms\nset style histogram clustered gap 1\nset style fill solid 0.9 noborder\n";
    if (!plot.log_y) out << "set yrange [0:*]\n";
  }
  for (const auto& [terminal, file] :
       {std::pair{std::string("svg size 800,560 font \"sans,14\" background \"white\""), svg},
        std::pair{std::string("pngcairo size 1200,840 fontscale 1.2"), png}}) {
    out << "set terminal " << terminal << "\nset output " << quoted(file.string()) << '\n';
    write_curves(out, plot);
    out << "unset output\n";
  }
  return out.str();
}

void run_gnuplot(const fs::path& script_file) {
  std::string program = "gnuplot", file = script_file.string();
  char* arguments[] = {program.data(), file.data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments, environ);
  int status = 0;
  if (failed == 0) waitpid(child, &status, 0);
  if (failed != 0 || (WIFEXITED(status) && WEXITSTATUS(status) == 127))
    throw FailedError("gnuplot", "is not installed, so figures can't be drawn",
                      "install gnuplot-nox, or run ./dev setup");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw FailedError("gnuplot", "could not draw the figure", "see its message above");
}

}  // namespace

void write_plot(const fs::path& path, const Plot& plot) {
  check(plot);
  PartialFile svg(path.string() + ".svg"), png(path.string() + ".png"), commands(path.string() + ".gnuplot");
  std::ofstream(commands.path()) << script(plot, svg.path(), png.path());
  run_gnuplot(commands.path());
  svg.commit();
  png.commit();
}

void write_csv(const fs::path& path, const std::vector<std::string>& header,
               const std::vector<std::vector<std::string>>& rows) {
  const auto cell = [](const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
  };
  write_file(path, [&](std::ostream& out) {
    const auto line = [&](const std::vector<std::string>& cells) {
      for (std::size_t i = 0; i < cells.size(); ++i) out << (i > 0 ? "," : "") << cell(cells[i]);
      out << '\n';
    };
    line(header);
    for (const std::vector<std::string>& row : rows) line(row);
  });
}

}  // namespace calot::bench
