#include "capture/room/asked_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "capture/testing/test_ring.h"

namespace keypose::capture::asked_views_test {

const Eigen::Vector3d kMiddle = Eigen::Vector3d::Zero();

TEST(ViewsToAsk, AreFarApartAndOnlyOnce) {
  const TestRing ring = MakeTestRing();
  const std::vector<int> asked = ViewsToAsk(ring.views, kMiddle, 4, {7});
  ASSERT_EQ(asked.size(), 4u);
  EXPECT_EQ(asked[0], 7);
  for (std::size_t a = 0; a < asked.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Vector3d x = ring.views[asked[a]].Center(), y = ring.views[asked[b]].Center();
      EXPECT_LT(x.normalized().dot(y.normalized()), std::cos(0.9));
    }
}

TEST(TurnsToUpright, FollowsTheWorldsZ) {
  View view = MakeTestRing().views[0];
  EXPECT_EQ(TurnsToUpright(view, kMiddle), 0);
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  view.camera_from_world = Compose({roll, Eigen::Vector3d::Zero()}, view.camera_from_world);
  EXPECT_EQ(TurnsToUpright(view, kMiddle), 3);  // z points to the right in the picture
}

}  // namespace keypose::capture::asked_views_test
