#include "export/film/exposure_sheet.h"

#include <gmock/gmock.h>

#include "core/surfaces/shapes.h"

namespace keypose::exporting {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Two poses and a frame between them, each shown for two pictures at 4 a second, as on twos.
Scene OnTwos() {
  Scene scene;
  for (int i = 0; i < 6; ++i) {
    scene.frames.push_back(MakeBox(1, 1, 1));
    scene.frames.back().points.array() += 0.1 * (i / 2);
    scene.frame_names.push_back("frame_000" + std::to_string(i));
    scene.frame_t.push_back(0.5 * (i / 2));
    scene.clip.picture.push_back(i / 2 * 2);
    scene.clip.stands.push_back(0);
  }
  scene.keys = {{0, "rest & sit"}, {4, "jump"}};
  scene.playback.fps = 4;
  return scene;
}

TEST(ExposureSheet, HasARowForEachPictureWithItsPose) {
  const std::string page = MakeExposureSheet(OnTwos(), {}).files.at(0).bytes;
  EXPECT_THAT(page, HasSubstr("6 pictures, 1.50 s, 4 a second"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">1</td><td class=\"number\">0:00</td><td "
                              "class=\"key\">rest &amp; sit</td>"));
  EXPECT_THAT(
      page, HasSubstr("<td class=\"number\">2</td><td class=\"number\">0:01</td><td>&#124;</td>"));
  EXPECT_THAT(page,
              HasSubstr("<td class=\"number\">3</td><td class=\"number\">0:02</td><td>50 %</td>"));
  EXPECT_THAT(page, HasSubstr("<tr class=\"second\"><td class=\"number\">5</td><td "
                              "class=\"number\">1:00</td><td class=\"key\">jump</td>"));
  EXPECT_THAT(page, Not(HasSubstr("<th>sound</th>")));
}

TEST(ExposureSheet, SoundOfAPictureIsItsRange) {
  Sound sound;
  sound.samples.resize(2 * kSoundRate / 2);  // half a second: two pictures
  sound.samples[10] = 0.5f;
  sound.samples[11] = -0.25f;
  sound.samples[2 * (kSoundRate / 4) + 1] = 0.75f;  // the first sample of the second picture
  const auto ranges = SoundRanges(sound, 3, 4);
  ASSERT_EQ(ranges.size(), 3u);
  EXPECT_EQ(ranges[0].low, -0.25f);
  EXPECT_EQ(ranges[0].high, 0.5f);
  EXPECT_EQ(ranges[1].low, 0.f);
  EXPECT_EQ(ranges[1].high, 0.75f);
  EXPECT_EQ(ranges[2].high, 0.f);
  const std::string page = MakeExposureSheet(OnTwos(), sound).files.at(0).bytes;
  EXPECT_THAT(page, HasSubstr("sound until 0.50 s"));
  EXPECT_THAT(page, HasSubstr("<rect x=\"45.00\" width=\"45.00\""));
}

}  // namespace
}  // namespace keypose::exporting
