#include "calot/sound/wav.h"

#include <gtest/gtest.h>

#include <cstring>

#include "calot/sound/sounds.h"
#include "tests/support/files.h"

namespace calot {
namespace {

std::uint32_t number_at(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

TEST(Wav, HoldsTheSamplesAsTheyAre) {
  const test::TempFolder folder;
  const std::vector<std::int16_t> samples = {0, 1, -1, 32767, -32768, 258};
  write_wav(folder / "a.wav", samples, 2);
  const std::string bytes = test::read_bytes(folder / "a.wav");
  ASSERT_EQ(bytes.size(), 44U + 12U);
  EXPECT_EQ(bytes.substr(0, 4), "RIFF");
  EXPECT_EQ(number_at(bytes, 4, 4), bytes.size() - 8);
  EXPECT_EQ(bytes.substr(8, 8), "WAVEfmt ");
  EXPECT_EQ(number_at(bytes, 20, 2), 1U);          // PCM
  EXPECT_EQ(number_at(bytes, 22, 2), 2U);          // channels
  EXPECT_EQ(number_at(bytes, 24, 4), 48000U);      // samples a second
  EXPECT_EQ(number_at(bytes, 28, 4), 48000U * 4);  // bytes a second
  EXPECT_EQ(number_at(bytes, 32, 2), 4U);          // bytes a frame
  EXPECT_EQ(number_at(bytes, 34, 2), 16U);         // bits
  EXPECT_EQ(number_at(bytes, 40, 4), 12U);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(static_cast<std::int16_t>(number_at(bytes, 44 + 2 * i, 2)), samples[i]);
  }
}

TEST(Wav, RefusesWhatItCannotHold) {
  const std::vector<std::int16_t> samples(3);
  EXPECT_NE(test::message_of([&] { write_wav("a.wav", samples, 3); }).find("3 channels; give 1 or 2"),
            std::string::npos);
  EXPECT_NE(test::message_of([&] { write_wav("a.wav", samples, 2); }).find("not a multiple"), std::string::npos);
  EXPECT_NE(test::message_of([&] { write_wav("/nonexistent/a.wav", samples); }), "");
}

TEST(Wav, RoundsAndCutsOff) {
  EXPECT_EQ(to_16_bit(std::vector<float>{0, 1, -1, 2, -2, 0.5F}),
            (std::vector<std::int16_t>{0, 32767, -32767, 32767, -32767, 16384}));
}

TEST(Wav, EverySoundCanBeListenedTo) {
  const test::TempFolder folder;
  const std::vector<std::filesystem::path> files = write_all_sounds(folder / "sounds");
  ASSERT_EQ(files.size(), static_cast<std::size_t>(kSoundKinds));
  for (const std::filesystem::path& file : files)
    EXPECT_GT(std::filesystem::file_size(file), 0.1 * kSampleRate * 2) << file;
}

}  // namespace
}  // namespace calot
