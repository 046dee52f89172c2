#include "capture/room/told_by_depths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "capture/room/floor_picture.h"
#include "capture/room/testing/figure_on_book.h"
#include "capture/testing/test_ring.h"

namespace keypose::capture::told_by_depths_test {

TEST_F(StandingFigureTest, MasksOfAllPhotographsFollow) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  const Still& world = World();
  const FloorPicture floor(world.images, world.scene.views, Depths(), *standing);
  std::vector<Image8> likeness;
  for (std::size_t v = 0; v < world.images.size(); ++v)
    likeness.push_back(LikeFloor(world.images[v], floor.SeenBy(world.scene.views[v])));
  const ToldFigure told =
      TellByDepths(world.images, world.scene.views, Depths(), *standing, likeness);
  ASSERT_EQ(told.fitting.size(), world.images.size());
  std::vector<BoardOdds> known;
  for (const ToldView& view : told.views) known.push_back(KnownOdds(view, 6, 6));
  SpaceOptions space;
  space.floor = standing->support.height;
  const std::vector<Image8> masks =
      CarryToAll(world.images, world.scene.views, told, known, {}, space);
  for (std::size_t v = 0; v < masks.size(); ++v) {
    Image8 truth = world.things[v];
    for (std::uint8_t& thing : truth.data) thing = thing == kFigure ? 255 : 0;
    EXPECT_GT(Iou(masks[v], truth), 0.94) << v;
  }
}

TEST_F(StandingFigureTest, ANetworkThatTakesTheBookAsWellIsNotBelieved) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  const Still& world = World();
  const std::vector<Image8> nothing(world.images.size(),
                                    Image8(world.images[0].width, world.images[0].height, 1, 0));
  const ToldFigure depths =
      TellByDepths(world.images, world.scene.views, Depths(), *standing, nothing,
                   {.near = std::numeric_limits<double>::infinity()});
  ToldFigure right, with_book;
  for (std::size_t v = 0; v < world.images.size(); ++v) {
    Image8 figure = world.things[v], both = figure;
    for (std::uint8_t& thing : figure.data) thing = thing == kFigure ? 255 : 0;
    for (std::uint8_t& thing : both.data) thing = thing == kFigure || thing == kBook ? 255 : 0;
    const auto kinds = [](const Image8& mask) {
      Image8 of = mask;
      for (std::uint8_t& kind : of.data) kind = kind ? kToldFigure : kToldRoom;
      return of;
    };
    right.views.push_back({figure, kinds(figure)});
    with_book.views.push_back({both, kinds(both)});
    if (v % 3 != 0) continue;
    right.fitting.push_back(static_cast<int>(v));
    with_book.fitting.push_back(static_cast<int>(v));
  }
  EXPECT_TRUE(ToldByBoth(with_book, depths).fitting.empty());
  EXPECT_FALSE(ToldByBoth(right, depths).fitting.empty());
}

}  // namespace keypose::capture::told_by_depths_test
