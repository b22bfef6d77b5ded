// What goes wrong at the door: a bad file, a bad call, or something that could not be done.
#pragma once
#include <stdexcept>
#include <string>

namespace calot {

/// The process exit code that an error leads to.
enum class ErrorKind {
  could_not = 1,  ///< the input was right but the work could not be done: unsupported part, no memory, disk full
  bad_input = 2,  ///< the input or the call is wrong
};

/// One readable line: where (file:line, field or argument; may be empty), what is wrong, what to do (may be empty).
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& where, const std::string& what, const std::string& what_to_do = {});
  [[nodiscard]] ErrorKind kind() const { return kind_; }
  [[nodiscard]] int exit_code() const { return static_cast<int>(kind_); }

 private:
  ErrorKind kind_;
};

/// A bad file or a bad call (exit code 2).
class InputError : public Error {
 public:
  InputError(const std::string& where, const std::string& what, const std::string& what_to_do = {})
      : Error(ErrorKind::bad_input, where, what, what_to_do) {}
};

/// Right input that could not be worked on (exit code 1).
class FailedError : public Error {
 public:
  FailedError(const std::string& where, const std::string& what, const std::string& what_to_do = {})
      : Error(ErrorKind::could_not, where, what, what_to_do) {}
};

/// A static part that can move freely, or is hinged: its stiffness has no inverse (exit code 1).
class Unsupported : public FailedError {
 public:
  using FailedError::FailedError;
};

/// The user asked to stop (Ctrl-C); nothing half-written is left (exit code 1).
class Interrupted : public FailedError {
 public:
  Interrupted() : FailedError("", "stopped on request") {}
};

/// "FILE:LINE" for messages; line 0 gives the file alone.
std::string at_line(const std::string& file, std::size_t line);

}  // namespace calot
