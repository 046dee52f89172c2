#include "views/film/sound.h"

#include <gmock/gmock.h>

namespace keypose {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

TEST(MovedSound, LaterBeginsWithSilenceAndEarlierLosesItsBegin) {
  const Sound sound{{0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}};
  EXPECT_EQ(sound.length(), 3);
  const Sound later = Moved(sound, 2.0 / kSoundRate);
  EXPECT_THAT(later.samples, ElementsAre(0, 0, 0, 0, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f));
  EXPECT_THAT(Moved(sound, -1.0 / kSoundRate).samples, ElementsAre(0.3f, 0.4f, 0.5f, 0.6f));
  EXPECT_THAT(Moved(sound, -1).samples, ElementsAre());
  const Sound silence = Moved(Sound{}, 0.5);
  EXPECT_DOUBLE_EQ(silence.seconds(), 0.5);
  EXPECT_THAT(silence.samples, Each(0.f));
}

}  // namespace
}  // namespace keypose
