#include "calot/scene/recording.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/base/toml_file.h"

namespace calot {
namespace {

constexpr std::uint64_t size_limit = std::uint64_t{4} << 30;
constexpr std::uint64_t most_steps = 100'000'000;
constexpr std::uint64_t longest_gap = 20'000;  // of steps without a line; a state is written every second
const std::string first_line = "# calot recording 1";
const std::string columns = "step,instrument,x,y,z,qw,qx,qy,qz,opening,grip,energy,fire";
constexpr std::size_t column_count = 13;

void append(std::string& line, double value) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  line += ',';
  line.append(text.data(), end);
}

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

}  // namespace

InputRecorder::InputRecorder(std::filesystem::path path, const RecordingHeader& header)
    : path_(std::move(path)), flushed_(std::chrono::steady_clock::now()) {
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file_ < 0 && errno == EEXIST)
    throw InputError(path_.string(), "is there already", "give another name, or remove it first");
  if (file_ < 0) throw FailedError(path_.string(), std::string("can't be written: ") + std::strerror(errno));
  std::string time_step;
  append(time_step, header.time_step);
  buffer_ = first_line + "\n# version: " + one_line(header.version) + "\n# scene: " + one_line(header.scene) +
            "\n# scene_sha256: " + header.scene_hash + "\n# kernel: " + one_line(header.kernel) +
            "\n# time_step: " + time_step.substr(1) + "\n";
  for (const std::string& name : header.instruments) buffer_ += "# instrument: " + one_line(name) + "\n";
  buffer_ += columns + "\n";
  flush();
}

InputRecorder::~InputRecorder() {
  try {
    flush();
  } catch (const Error&) {  // NOLINT(bugprone-empty-catch): whoever cares has called `end`
  }
  ::close(file_);
}

void InputRecorder::step(const std::vector<std::optional<InstrumentInput>>& inputs) {
  ++steps_;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    if (!inputs[k]) continue;
    const InstrumentInput& input = *inputs[k];
    buffer_ += std::to_string(steps_) + ',' + std::to_string(k);
    for (int axis = 0; axis < 3; ++axis) append(buffer_, input.pose.position[axis]);
    const Eigen::Quaterniond& q = input.pose.rotation;
    for (const double value : {q.w(), q.x(), q.y(), q.z(), input.opening, input.grip}) append(buffer_, value);
    buffer_ += input.energy ? ",1" : ",0";
    buffer_ += input.fire ? ",1\n" : ",0\n";
  }
  constexpr std::chrono::milliseconds most(500);
  if (std::chrono::steady_clock::now() - flushed_ > most) flush();
}

void InputRecorder::state(const std::string& hash) {
  buffer_ += "# state: " + std::to_string(steps_) + ' ' + hash + '\n';
}

void InputRecorder::end(const std::string& hash) {
  buffer_ += "# end: " + std::to_string(steps_) + ' ' + hash + '\n';
  flush();
}

void InputRecorder::flush() {
  flushed_ = std::chrono::steady_clock::now();
  std::string text;
  text.swap(buffer_);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = ::write(file_, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      throw FailedError(path_.string(), std::string("can't be written: ") + std::strerror(errno), "free some space");
    done += static_cast<std::size_t>(written);
  }
}

namespace {

class RecordingReader {
 public:
  explicit RecordingReader(const std::filesystem::path& path) : path_(path), text_(read_file(path, size_limit)) {}

  Recording read() {
    if (!next() || line_ != first_line) fail("this is no recording of Calot", "give a file that --record wrote");
    while (next() && line_.starts_with("# ")) read_header();
    if (line_ != columns) fail("expected the line \"" + columns + "\"", "record it again");
    if (out_.header.scene_hash.size() != 64 || !(out_.header.time_step > 0))
      fail("the lines before don't say scene_sha256 and time_step", "record it again");
    while (next()) {
      if (out_.complete) fail("goes on after its end", "remove what follows the line \"# end\"");
      if (line_.starts_with("# "))
        read_state();
      else
        read_step();
    }
    if (step_ > out_.steps.size()) out_.steps.resize(step_, no_inputs());
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& to_do) const {
    throw InputError(at_line(path_.string(), number_), what, to_do);
  }

  /// The next line that is whole.
  bool next() {
    const std::size_t end = text_.find('\n', place_);
    ++number_;
    line_.clear();
    if (end == std::string::npos) return false;
    line_.assign(text_, place_, end - place_);
    place_ = end + 1;
    return true;
  }

  void read_header() {
    const std::size_t colon = line_.find(": ");
    const std::string key = line_.substr(2, colon == std::string::npos ? colon : colon - 2),
                      value = colon == std::string::npos ? "" : line_.substr(colon + 2);
    RecordingHeader& header = out_.header;
    if (key == "version") header.version = value;
    if (key == "scene") header.scene = value;
    if (key == "scene_sha256") header.scene_hash = value;
    if (key == "kernel") header.kernel = value;
    if (key == "time_step") header.time_step = real(value);
    if (key == "instrument") header.instruments.push_back(value);
  }

  /// "# state: STEP HASH" or "# end: STEP HASH".
  void read_state() {
    std::istringstream in(line_.substr(2));
    std::string kind, step, hash;
    in >> kind >> step >> hash;
    if ((kind != "state:" && kind != "end:") || hash.size() != 64)
      fail("is neither a state nor the end", "record it again");
    const std::uint64_t number = whole(step, most_steps);
    if (number < step_ || number > step_ + longest_gap) fail("the steps don't ascend", "record it again");
    step_ = number;
    out_.states[number] = hash;
    out_.complete = kind == "end:";
  }

  void read_step() {
    std::array<std::string, column_count> fields;
    std::size_t count = 0;
    std::istringstream in(line_);
    for (std::string field; std::getline(in, field, ','); ++count)
      if (count < column_count) fields[count] = field;
    if (count != column_count) fail(std::to_string(count) + " values for 13 columns", "record it again");
    const std::uint64_t step = whole(fields[0], most_steps);
    if (out_.header.instruments.empty()) fail("there are no instruments", "record it again");
    const std::size_t instrument = whole(fields[1], out_.header.instruments.size() - 1);
    if (step == 0 || step < step_ || step > step_ + longest_gap || (step == step_ && out_.states.contains(step)))
      fail("the steps don't ascend", "record it again");
    step_ = step;
    out_.steps.resize(std::max<std::size_t>(out_.steps.size(), step), no_inputs());
    std::array<double, 9> v;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = real(fields[2 + i]);
    InstrumentInput input;
    input.pose.position = {v[0], v[1], v[2]};
    input.pose.rotation = Eigen::Quaterniond(v[3], v[4], v[5], v[6]);
    input.opening = v[7];
    input.grip = v[8];
    input.energy = whole(fields[11], 1) == 1;
    input.fire = whole(fields[12], 1) == 1;
    if (out_.steps[step - 1][instrument]) fail("an instrument is there twice in this step", "record it again");
    out_.steps[step - 1][instrument] = input;
  }

  [[nodiscard]] std::vector<std::optional<InstrumentInput>> no_inputs() const {
    return std::vector<std::optional<InstrumentInput>>(out_.header.instruments.size());
  }

  /// Any value, also those that a device shouldn't have sent.
  [[nodiscard]] double real(const std::string& text) const {
    double value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc() || end != text.data() + text.size())
      fail("\"" + detail::brief(text) + "\" is not a number", "record it again");
    return value;
  }

  [[nodiscard]] std::uint64_t whole(const std::string& text, std::uint64_t most) const {
    std::uint64_t value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc() || end != text.data() + text.size() || value > most)
      fail("\"" + detail::brief(text) + "\" is not a whole number in range", "record it again");
    return value;
  }

  std::filesystem::path path_;
  std::string text_, line_;
  std::size_t place_ = 0, number_ = 0;
  std::uint64_t step_ = 0;
  Recording out_;
};

}  // namespace

Recording read_recording(const std::filesystem::path& path) {
  return RecordingReader(path).read();
}

}  // namespace calot
