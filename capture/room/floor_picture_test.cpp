#include "capture/room/floor_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/room/testing/figure_on_book.h"

namespace keypose::capture::floor_picture_test {

TEST_F(StandingFigureTest, ThePlanesPictureIsSeenAroundTheFoot) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  const FloorPicture floor(World().images, World().scene.views, Depths(), *standing);
  int on_book = 0, like = 0, figure = 0, wrong = 0;
  for (std::size_t v = 0; v < World().images.size(); v += 5) {
    const Image8 likeness = LikeFloor(World().images[v], floor.SeenBy(World().scene.views[v]));
    for (std::size_t p = 0; p < likeness.data.size(); ++p) {
      on_book += World().things[v].data[p] == kBook;
      like += World().things[v].data[p] == kBook && likeness.data[p] != kNotFloor;
      figure += World().things[v].data[p] == kFigure;
      wrong += World().things[v].data[p] == kFigure && likeness.data[p] == kSurelyFloor;
    }
  }
  EXPECT_GT(like, 0.4 * on_book) << "its sides are not the plane";
  EXPECT_LT(wrong, 0.01 * figure);
}

}  // namespace keypose::capture::floor_picture_test
