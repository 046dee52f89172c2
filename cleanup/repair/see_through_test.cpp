// Windows in a slab: the handles through which photographs see stay.
#include "cleanup/repair/see_through.h"

#include <gtest/gtest.h>

#include "cleanup/repair/handle_loops.h"
#include "cleanup/repair/handles.h"
#include "cleanup/testing/windowed_slab.h"
#include "core/surfaces/geometry.h"

namespace keypose::cleanup::see_through_test {

const Window kNarrow = {3, 6, 3, 6}, kBroad = {9, 16, 2, 7}, kThird = {17, 20, 3, 6};

TEST(HandlesSeenThrough, CountsTheWindowsThatTheMasksShow) {
  const Mesh both = Slab({kNarrow, kBroad});
  ASSERT_TRUE(CheckClosed(both).closed());
  ASSERT_EQ(Genus(both), 2);
  EXPECT_EQ(HandlesSeenThrough(both, LinesOf(PhotographOfSlab(both, {-20, 0, 15}))), 2);
  EXPECT_EQ(HandlesSeenThrough(both, LinesOf(PhotographOfSlab(Slab({kNarrow}), {-20, 0, 15}))), 1);
  EXPECT_EQ(HandlesSeenThrough(both, LinesOf(PhotographOfSlab(Slab({}), {-20, 0, 15}))), 0);
  const Mesh three = Slab({kNarrow, kBroad, kThird});
  EXPECT_EQ(HandlesSeenThrough(three, LinesOf(PhotographOfSlab(three, {-20, 0, 15}))), 3);
}

TEST(HandlesSeenThrough, OneViewIsNotBelieved) {
  const Mesh slab = Slab({kNarrow});
  EXPECT_EQ(HandlesSeenThrough(slab, LinesOf(PhotographOfSlab(slab, {0}))), 0);
  EXPECT_EQ(HandlesSeenThrough(slab, LinesOf(PhotographOfSlab(slab, {0, 10}))), 1);
}

TEST(HandlesSeenThrough, HolesOfMasksOverASolidSurfaceAreNoHandles) {
  const Mesh closed = Slab({});
  const std::vector<SightLine> lines = LinesOf(PhotographOfSlab(Slab({kNarrow}), {-10, 0, 10}));
  EXPECT_EQ(HandlesSeenThrough(closed, lines), 0);
  EXPECT_EQ(ViewsWithClosedWindow(closed, lines), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(ViewsWithClosedWindow(Slab({kNarrow}), lines).empty());
}

TEST(WithoutHandles, KeepsTheNarrowWindowThatIsSeenAndFillsTheBroadOne) {
  // By loop length alone, the result would be the opposite.
  const Mesh both = Slab({kNarrow, kBroad});
  const Mesh by_length = WithoutHandles(both, 1).mesh;
  EXPECT_FALSE(Open(by_length, kNarrow) && !Open(by_length, kBroad));
  const HandlesResult result =
      WithoutHandles(both, 1, LinesOf(PhotographOfSlab(Slab({kNarrow}), {-15, 0, 15})));
  EXPECT_EQ(result.cut, 1);
  EXPECT_EQ(Genus(result.mesh), 1);
  EXPECT_TRUE(Open(result.mesh, kNarrow));
  EXPECT_EQ(HandlesSeenThrough(result.mesh, LinesOf(PhotographOfSlab(Slab({kNarrow}), {-15, 0, 15}))), 1);
}

}  // namespace keypose::cleanup::see_through_test
