#include "tests/app/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include "calot/fem/model_file.h"
#include "calot/mesh/mesh_file.h"
#include "tests/support/models.h"

namespace calot::test {
namespace fs = std::filesystem;
namespace {

void redirect(int stream, const fs::path& path) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file < 0 || dup2(file, stream) < 0) _exit(127);
}

[[noreturn]] void become_calot(const std::vector<std::string>& arguments, const RunOptions& options,
                               const fs::path& scratch) {
  redirect(STDOUT_FILENO, scratch / "out");
  redirect(STDERR_FILENO, scratch / "err");
  if (options.largest_file) {
    const rlimit limit{*options.largest_file, *options.largest_file};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(127);
  }
  std::vector<char*> argv{const_cast<char*>(CALOT_PROGRAM)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(CALOT_PROGRAM, argv.data());
  _exit(127);
}

}  // namespace

Outcome calot_run(const std::vector<std::string>& arguments, const RunOptions& options) {
  const TempFolder scratch;
  const pid_t child = fork();
  if (child == 0) become_calot(arguments, options, scratch.path());
  int status = 0;
  for (bool interrupted = !options.interrupt_when; waitpid(child, &status, interrupted ? 0 : WNOHANG) == 0;) {
    const fs::path out = scratch / "out";
    if (fs::exists(out) && options.interrupt_when(read_bytes(out))) {
      kill(child, SIGINT);
      interrupted = true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(scratch / "out"), read_bytes(scratch / "err")};
}

std::string Outcome::error() const {
  const std::string start = "calot: error: ";
  std::string line;
  std::size_t lines = 0;
  for (std::size_t begin = 0; begin < err.size();) {
    const std::size_t end = std::min(err.find('\n', begin), err.size());
    // Long work may have said how long its phases took.
    if (err.compare(begin, start.size(), start) == 0) {
      line = err.substr(begin + start.size(), end - begin - start.size());
      ++lines;
    } else {
      EXPECT_NE(err.substr(begin, end - begin).find(": done in "), std::string::npos) << err;
    }
    begin = end + 1;
  }
  EXPECT_EQ(lines, 1u) << err;
  return line;
}

void expect_refused(const Outcome& run, int code, const std::vector<std::string>& parts) {
  EXPECT_EQ(run.code, code) << run.out << run.err;
  const std::string line = run.error();
  for (const std::string& part : parts) EXPECT_NE(line.find(part), std::string::npos) << line << "\nlacks " << part;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string python(const std::string& program, const std::vector<fs::path>& arguments) {
  const TempFolder scratch;
  write_bytes(scratch / "program.py", program);
  std::string command = "/usr/bin/python3 '" + (scratch / "program.py").string() + "'";
  for (const fs::path& argument : arguments) command += " '" + argument.string() + "'";
  const CommandResult result = run_command(command);
  EXPECT_EQ(result.status, 0) << result.output;
  return result.output;
}

ModelFolder::ModelFolder(double time_step, int fineness) {
  const Model model = biliary_model(time_step, fineness);
  write_mesh(mesh(), model.mesh());
  save_model(this->model(), model, "organ.msh");
}

void ModelFolder::edit_model(const std::string& from, const std::string& to) const {
  std::string text = read_bytes(model());
  const std::size_t place = text.find(from);
  ASSERT_NE(place, std::string::npos) << from;
  write_bytes(model(), text.replace(place, from.size(), to));
}

void ModelFolder::precompute(const std::vector<std::string>& more) const {
  std::vector<std::string> arguments{"precompute", model(), "-o", compliance()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Outcome run = calot_run(arguments);
  EXPECT_EQ(run.code, 0) << run.err;
}

}  // namespace calot::test
