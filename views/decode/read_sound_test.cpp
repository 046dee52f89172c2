// Sound in files of all usual kinds comes out as it is known to be.
#include "views/decode/read_sound.h"

#include <gmock/gmock.h>

#include <cmath>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "core/values/image.h"
#include "views/film/mp4.h"

namespace keypose::read_sound_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;

/// A tone that begins at 0.25 s, of 0.5; on the right of 0.25.
double Tone(double seconds, double hertz = 441) {
  return seconds < 0.25 ? 0 : 0.5 * std::sin(2 * kPi * hertz * (seconds - 0.25));
}

std::string Word(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 255);
  return text;
}

/// 16 bits. Source: Microsoft's and IBM's Multimedia Programming Interface 1.0, WAVE.
std::string Wav(int rate, int channels, double seconds) {
  std::string data;
  for (int i = 0; i < std::lround(seconds * rate); ++i)
    for (int c = 0; c < channels; ++c)
      data += Word(static_cast<std::uint32_t>(
                       std::lround(32767 * Tone(i / static_cast<double>(rate)) / (c + 1))),
                   2);
  const auto n = static_cast<std::uint32_t>(channels), r = static_cast<std::uint32_t>(rate);
  return "RIFF" + Word(static_cast<std::uint32_t>(36 + data.size()), 4) + "WAVEfmt " + Word(16, 4) +
         Word(1, 2) + Word(n, 2) + Word(r, 4) + Word(2 * n * r, 4) + Word(2 * n, 2) + Word(16, 2) +
         "data" + Word(static_cast<std::uint32_t>(data.size()), 4) + data;
}

/// The largest difference of one channel from the tone, away from its abrupt begin.
double WorstOf(const Sound& sound, int channel, double scale) {
  double worst = 0;
  for (std::int64_t i = 0; i < sound.length(); ++i) {
    const double t = static_cast<double>(i) / kSoundRate;
    if (std::abs(t - 0.25) < 0.01 || t > sound.seconds() - 0.01) continue;
    worst = std::max(worst, std::abs(sound.samples[2 * i + channel] - scale * Tone(t)));
  }
  return worst;
}

/// How much later than the tone the sound is, to a sample, by their product.
double Lag(const Sound& sound, double most_s = 0.001) {
  const std::int64_t most = std::llround(most_s * kSoundRate);
  double best = 0, lag = 1e9;
  for (std::int64_t by = -most; by <= most; ++by) {
    double sum = 0;
    for (std::int64_t i = most; i + most < sound.length(); ++i)
      sum += sound.samples[2 * (i + by)] * Tone(static_cast<double>(i) / kSoundRate);
    if (sum > best) best = sum, lag = static_cast<double>(by) / kSoundRate;
  }
  return lag;
}

class ReadSoundOf : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  fs::path File(const std::string& name, const std::string& bytes) {
    WriteFile(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string Refusal(const fs::path& path) {
    try {
      ReadSound(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "was read";
  }
};

TEST_F(ReadSoundOf, OneChannelOfAnotherRateIsOnBothSides) {
  for (const int rate : {8000, 44100, 48000, 96000}) {
    const Sound sound = ReadSound(File("mono.wav", Wav(rate, 1, 1.5)));
    EXPECT_NEAR(sound.seconds(), 1.5, 1e-3) << rate;
    EXPECT_LT(WorstOf(sound, 0, 1), 2e-3) << rate;
    EXPECT_LT(WorstOf(sound, 1, 1), 2e-3) << rate;
  }
}

TEST_F(ReadSoundOf, TwoChannelsStayApart) {
  const Sound sound = ReadSound(File("two.wav", Wav(44100, 2, 1)));
  EXPECT_LT(WorstOf(sound, 0, 1), 2e-3);
  EXPECT_LT(WorstOf(sound, 1, 0.5), 2e-3);
}

TEST_F(ReadSoundOf, WhatAFilmCarriesIsHeardAtItsTimeAndEndsWithIt) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  const Sound tone = ReadSound(File("tone.wav", Wav(48000, 1, 3)));
  Mp4Writer writer(folder_ / "film.mp4", 64, 48, 12, Moved(tone, -0.125));
  for (int i = 0; i < 18; ++i) writer.Add(Image8(64, 48, 3));
  writer.Finish();
  const Sound heard = ReadSound(folder_ / "film.mp4");
  EXPECT_NEAR(heard.seconds(), 1.5, 0.025) << "a block of AAC is 0.021 s";
  EXPECT_NEAR(Lag(Moved(heard, 0.125)), 0, 0.0002);
}

TEST_F(ReadSoundOf, ALaterSoundThanTheFilmIsNone) {
  if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264 here";
  const auto film = [&](const std::string& name, const Sound& sound) {
    Mp4Writer writer(folder_ / name, 64, 48, 12, sound);
    for (int i = 0; i < 2; ++i) writer.Add(Image8(64, 48, 3));
    writer.Finish();
    return folder_ / name;
  };
  EXPECT_THAT(Refusal(film("silent.mp4", {})), HasSubstr("has no sound"));
  const Sound tone = ReadSound(File("tone.wav", Wav(48000, 1, 1)));
  EXPECT_EQ(ReadFile(film("a.mp4", tone)), ReadFile(film("b.mp4", tone)));
}

TEST_F(ReadSoundOf, WhatIsNoSoundIsNamed) {
  EXPECT_THAT(Refusal(File("notes.wav", "shot on Monday\n")), HasSubstr("is no film or sound"));
  EXPECT_THAT(Refusal(File("empty.wav", Wav(48000, 1, 0))), HasSubstr("empty.wav"));
  EXPECT_THROW(ReadSound(folder_ / "none.wav"), DiskError);
}

TEST_F(ReadSoundOf, SamplesThatAreNoNumbersAreNamed) {
  std::string wav = Wav(48000, 2, 0.5);  // as floats: of each four bytes one number
  wav.replace(20, 2, Word(3, 2)).replace(34, 2, Word(32, 2));
  wav.replace(28, 4, Word(8 * 48000, 4)).replace(32, 2, Word(8, 2));
  for (std::size_t at = 44; at < wav.size(); ++at) wav[at] = 0;
  wav.replace(44 + 800, 4, Word(0x7fc00000, 4));
  try {
    ReadSound(File("nan.wav", wav));
    FAIL() << "there is a NaN";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("nan.wav holds samples that are no numbers"));
  }
}

TEST_F(ReadSoundOf, ChannelsThatCannotBeMixedNameTheFile) {
  try {
    ReadSound(File("many.wav", Wav(48000, 32, 0.1)));
    FAIL() << "32 channels have no layout";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("many.wav has 32 channels that cannot be mixed down"));
  }
}

}  // namespace keypose::read_sound_test
