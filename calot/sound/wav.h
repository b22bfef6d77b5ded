// Sounds as files, for listening.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace calot {

/// Writes a WAV file of 16-bit samples at kSampleRate, whole or not at all.
/// @param samples  interleaved, a multiple of `channels` of them
/// Throws FailedError (disk), InputError (not a multiple, channels not 1 or 2, more than 4 GiB).
void write_wav(const std::filesystem::path& path, std::span<const std::int16_t> samples, int channels = 1);

/// −1 … 1 as 16-bit numbers, rounded; what lies beyond is cut off.
std::vector<std::int16_t> to_16_bit(std::span<const float> samples);

/// Writes every sound as DIR/NAME.wav, a loop for at least two rounds and 6 s, the beep once for each of 100, 95, 90 …
/// 70 %. Makes the folder if it is absent. Returns the files, in order.
std::vector<std::filesystem::path> write_all_sounds(const std::filesystem::path& folder, std::uint64_t seed = 0);

}  // namespace calot
