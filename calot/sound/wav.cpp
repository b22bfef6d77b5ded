#include "calot/sound/wav.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "calot/base/error.h"
#include "calot/base/files.h"
#include "calot/sound/sounds.h"

namespace calot {

namespace {

template <class T>
void put(std::ostream& out, T value) {  // little-endian, on any machine
  std::array<char, sizeof(T)> bytes{};
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = static_cast<char>((value >> (8 * i)) & 0xff);
  out.write(bytes.data(), bytes.size());
}

std::vector<float> as_heard(SoundKind kind, std::uint64_t seed) {
  std::vector<float> heard;
  if (kind == SoundKind::beep) {
    for (int saturation = 100; saturation >= 70; saturation -= 5) {
      const std::vector<float> one = synthesise(kind, seed, {.saturation = static_cast<double>(saturation)});
      heard.insert(heard.end(), one.begin(), one.end());
      heard.resize(heard.size() + static_cast<std::size_t>(0.4 * kSampleRate));
    }
    return heard;
  }
  const std::vector<float> one = synthesise(kind, seed);
  const int rounds =
      loops(kind) ? std::max(2, static_cast<int>(std::ceil(6.0 * kSampleRate / static_cast<double>(one.size())))) : 1;
  for (int i = 0; i < rounds; ++i) heard.insert(heard.end(), one.begin(), one.end());
  return heard;
}

}  // namespace

std::vector<std::int16_t> to_16_bit(std::span<const float> samples) {
  std::vector<std::int16_t> out(samples.size());
  std::transform(samples.begin(), samples.end(), out.begin(),
                 [](float s) { return static_cast<std::int16_t>(std::lrint(std::clamp(s, -1.0F, 1.0F) * 32767.0F)); });
  return out;
}

void write_wav(const std::filesystem::path& path, std::span<const std::int16_t> samples, int channels) {
  if (channels != 1 && channels != 2)
    throw InputError("write_wav", std::to_string(channels) + " channels", "give 1 or 2");
  if (samples.size() % static_cast<std::size_t>(channels) != 0) {
    throw InputError("write_wav", std::to_string(samples.size()) + " samples are not a multiple of the channels");
  }
  if (samples.size_bytes() > 0xffffffffU - 36)
    throw InputError("write_wav", "more than a WAV file holds (4 GiB)", "write parts");
  const auto bytes = static_cast<std::uint32_t>(samples.size_bytes());
  const auto frame = static_cast<std::uint16_t>(2 * channels);
  write_file(path, [&](std::ostream& out) {
    out.write("RIFF", 4);
    put<std::uint32_t>(out, 36 + bytes);
    out.write("WAVEfmt ", 8);
    put<std::uint32_t>(out, 16);
    put<std::uint16_t>(out, 1);  // whole numbers
    put<std::uint16_t>(out, static_cast<std::uint16_t>(channels));
    put<std::uint32_t>(out, kSampleRate);
    put<std::uint32_t>(out, static_cast<std::uint32_t>(kSampleRate) * frame);
    put<std::uint16_t>(out, frame);
    put<std::uint16_t>(out, 16);
    out.write("data", 4);
    put<std::uint32_t>(out, bytes);
    for (const std::int16_t s : samples) put<std::uint16_t>(out, static_cast<std::uint16_t>(s));
  });
}

std::vector<std::filesystem::path> write_all_sounds(const std::filesystem::path& folder, std::uint64_t seed) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw FailedError(folder.string(), "cannot make this folder: " + failed.message());
  std::vector<std::filesystem::path> files;
  for (const SoundKind kind : all_sounds()) {
    files.push_back(folder / (std::string(name_of(kind)) + ".wav"));
    write_wav(files.back(), to_16_bit(as_heard(kind, seed)));
  }
  return files;
}

}  // namespace calot
