// What the command line says: results on stdout; progress, warnings and the one error line on stderr.
#pragma once
#include <exception>
#include <string>

#include "calot/base/progress.h"

namespace calot {

/// The process-wide progress: a one-line bar with percentage and remaining time when stderr is a terminal, else a line
/// at the end of each phase that took more than 2 s. Hand it to everything long.
Progress& terminal_progress();

/// Ctrl-C (and SIGTERM) ask `terminal_progress` to stop, so that work ends by Interrupted with nothing half-written. A
/// second one ends the process at once. Also makes a file-size limit an error instead of a signal.
void handle_signals();

/// A line on stdout.
void say(const std::string& line);
/// "calot: warning: LINE" on stderr.
void warn(const std::string& line);

/// Prints "calot: error: WHERE: what; what to do", always one line, and returns the exit code: the Error's own, 1 for
/// any other exception.
int report_error(const std::exception& error);
/// The same line for a wrong call; returns 2.
int report_usage(const std::string& message);

/// A number with `digits` significant digits; "3.2 s", "2 min 5 s".
std::string number_text(double value, int digits = 4);
std::string seconds_text(double seconds);

}  // namespace calot
