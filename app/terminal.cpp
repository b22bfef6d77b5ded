#include "app/terminal.h"

#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <new>

#include "calot/base/error.h"
#include "calot/base/memory.h"

namespace calot {
namespace {

constexpr double redraw_seconds = 0.1;
constexpr double worth_a_line_seconds = 2;

/// Draws progress; remembers whether a bar stands on the terminal so that other lines can wipe it first.
class Bar {
 public:
  void show(const ProgressState& state) {
    if (terminal_)
      draw(state);
    else
      print_end(state);
  }
  void wipe() {
    if (!drawn_) return;
    std::fputs("\r\033[K", stderr);
    drawn_ = false;
  }

 private:
  void draw(const ProgressState& state) {
    const bool ended = state.fraction >= 1;
    const bool new_phase = state.phase != phase_;
    if (!ended && !new_phase && state.elapsed_seconds - last_ < redraw_seconds) return;
    phase_ = state.phase;
    last_ = state.elapsed_seconds;
    if (ended) return wipe();
    constexpr int width = 24;
    const int filled = static_cast<int>(std::lround(width * state.fraction));
    std::string line = "\r\033[K" + phase_ + " [" + std::string(filled, '#') + std::string(width - filled, '.') + "] " +
                       std::to_string(static_cast<int>(100 * state.fraction)) + " %";
    if (state.remaining_seconds >= 0) line += ", " + seconds_text(state.remaining_seconds) + " left";
    std::fputs(line.c_str(), stderr);
    drawn_ = true;
  }
  void print_end(const ProgressState& state) const {
    if (state.fraction < 1 || state.elapsed_seconds < worth_a_line_seconds) return;
    std::fprintf(stderr, "calot: %s: done in %s\n", std::string(state.phase).c_str(),
                 seconds_text(state.elapsed_seconds).c_str());
  }

  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool drawn_ = false;
  std::string phase_;
  double last_ = 0;
};

Bar& bar() {
  static Bar the_bar;
  return the_bar;
}

extern "C" void stop_on_signal(int) {
  terminal_progress().request_stop();
}

void print_line(const std::string& prefix, std::string text) {
  bar().wipe();
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  std::cout.flush();
  std::fprintf(stderr, "%s%s\n", prefix.c_str(), text.c_str());
}

/// What the process held when memory ran out, for a message with numbers in it.
std::string memory_text() {
  return "not enough memory: the process held " + readable_bytes(peak_memory()) + " and " +
         readable_bytes(available_memory()) + " are left";
}

}  // namespace

Progress& terminal_progress() {
  static Progress progress([](const ProgressState& state) { bar().show(state); });
  return progress;
}

void handle_signals() {
  terminal_progress();  // made here, so that the handler never constructs it
  struct sigaction action {};
  action.sa_handler = stop_on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);
}

void say(const std::string& line) {
  bar().wipe();
  std::cout << line << '\n';
}

void warn(const std::string& line) {
  print_line("calot: warning: ", line);
}

int report_error(const std::exception& error) {
  if (const auto* own = dynamic_cast<const Error*>(&error)) {
    print_line("calot: error: ", own->what());
    return own->exit_code();
  }
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr)
    print_line("calot: error: ", memory_text() + "; use a smaller mesh or the sparse backend");
  else
    print_line("calot: error: ", std::string(error.what()) + "; this is a fault of calot, please report it");
  return static_cast<int>(ErrorKind::could_not);
}

int report_usage(const std::string& message) {
  print_line("calot: error: ", message);
  return static_cast<int>(ErrorKind::bad_input);
}

std::string number_text(double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

std::string seconds_text(double seconds) {
  if (seconds < 60) return number_text(seconds, 2) + " s";
  const auto whole = static_cast<long>(std::lround(seconds));
  if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

}  // namespace calot
