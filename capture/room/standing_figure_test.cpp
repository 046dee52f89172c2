#include "capture/room/standing_figure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "capture/room/coarse_depths.h"
#include "capture/room/floor_picture.h"
#include "capture/room/hidden_parts.h"
#include "capture/room/piece_split.h"
#include "capture/room/told_by_depths.h"
#include "capture/testing/test_images.h"
#include "capture/testing/test_ring.h"
#include "core/numbers/parallel.h"

namespace keypose::capture::standing_figure_test {

using Eigen::Vector3d;

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kBookTop = 0.04, kFigureRadius = 0.09, kFigureTop = 0.4;
enum Thing { kNothing, kTable, kBook, kFigure, kBox };

struct Hit {
  double t = kFar;
  Thing thing = kNothing;
};

/// Along a ray, the nearest side of an upright box.
double AlongBox(const Vector3d& from, const Vector3d& ray, const Vector3d& low,
                const Vector3d& high) {
  double enter = 0, leave = kFar;
  for (int k = 0; k < 3; ++k) {
    const double a = (low[k] - from[k]) / ray[k], b = (high[k] - from[k]) / ray[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave ? enter : kFar;
}

/// Along a ray, an upright cylinder about the z axis with its lid.
double AlongFigure(const Vector3d& from, const Vector3d& ray) {
  const double a = ray.head<2>().squaredNorm(), b = from.head<2>().dot(ray.head<2>()),
               c = from.head<2>().squaredNorm() - kFigureRadius * kFigureRadius;
  double best = kFar;
  if (const double root = b * b - a * c; root > 0) {
    const double t = (-b - std::sqrt(root)) / a, z = from.z() + t * ray.z();
    if (t > 0 && z > kBookTop && z < kFigureTop) best = t;
  }
  const double lid = (kFigureTop - from.z()) / ray.z();
  if (lid > 0 && (from + lid * ray).head<2>().norm() < kFigureRadius) best = std::min(best, lid);
  return best;
}

/// A cylinder on a book on a table, with a box beside it.
Hit Look(const Vector3d& from, const Vector3d& ray) {
  Hit hit;
  const auto nearer = [&hit](double t, Thing thing) {
    if (t < hit.t) hit = {t, thing};
  };
  if (ray.z() < 0) {
    const double t = -from.z() / ray.z();
    if ((from + t * ray).head<2>().norm() < 2) nearer(t, kTable);
  }
  nearer(AlongBox(from, ray, {-0.2, -0.16, 0}, {0.2, 0.16, kBookTop}), kBook);
  nearer(AlongBox(from, ray, {0.3, 0.05, 0}, {0.42, 0.2, 0.15}), kBox);
  nearer(AlongFigure(from, ray), kFigure);
  return hit;
}

/// Blobs of grey, in space.
double Texture(const Vector3d& x) {
  double sum = 0;
  for (int k = 1; k <= 3; ++k) {
    const double f = 45.0 * k;
    sum += std::sin(f * x.x() + 3 * k + std::cos(f * 0.7 * x.y())) +
           std::sin(f * 0.9 * x.y() + std::cos(f * 0.8 * x.z())) +
           std::sin(f * 1.1 * x.z() + std::cos(f * 0.6 * x.x()));
  }
  return std::clamp(0.5 + 0.12 * sum, 0.0, 1.0);
}

struct Still {
  std::vector<Image8> images, things;
  Scene scene;
  Vector3d middle = {0, 0, 0.15};
};

Still MakeStill() {
  constexpr int kViews = 16, kWidth = 240, kHeight = 180;
  Still still;
  still.images.resize(kViews);
  still.things.resize(kViews);
  for (int i = 0; i < kViews; ++i)
    still.scene.views.push_back(MakeTestView(i, kViews, 1.2, 0.7, kWidth, kHeight, 300));
  ParallelFor(kViews, [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    const View& view = still.scene.views[v];
    still.images[v] = Image8(kWidth, kHeight, 3, 30);
    still.things[v] = Image8(kWidth, kHeight, 1, kNothing);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Vector3d ray =
            view.camera_from_world.rotation.conjugate() * view.camera.Unproject({x + 0.5, y + 0.5});
        const Hit hit = Look(view.Center(), ray);
        *still.things[v].at(x, y) = static_cast<std::uint8_t>(hit.thing);
        if (hit.thing == kNothing) continue;
        const double grey = Texture(view.Center() + hit.t * ray);
        const double tint[][3] = {
            {0, 0, 0}, {1, 1, 0.9}, {0.9, 0.6, 0.7}, {0.6, 0.8, 1}, {0.7, 1, 0.6}};
        for (int c = 0; c < 3; ++c)
          still.images[v].at(x, y)[c] =
              static_cast<std::uint8_t>(30 + 200 * grey * tint[hit.thing][c]);
      }
  });
  return still;
}

class StandingFigureTest : public ::testing::Test {
 protected:
  static const Still& World() {
    static const Still still = MakeStill();
    return still;
  }
  static const CoarseDepths& Depths() {
    static const CoarseDepths depths =
        FindCoarseDepths(World().images, World().scene, World().middle);
    return depths;
  }
  static std::optional<StandingFigure> Standing() {
    return FindStandingFigure(Depths(), World().scene.views, World().middle, {});
  }
};

TEST_F(StandingFigureTest, DepthsAreThoseOfTheScene) {
  int all = 0, right = 0;
  for (std::size_t v = 0; v < Depths().views.size(); ++v)
    for (const DepthSample& sample : Depths().views[v]) {
      const Vector3d from = World().scene.views[v].Center(), ray = sample.point - from;
      ++all;
      right += std::abs(Look(from, ray).t - 1) < 0.02;
    }
  EXPECT_GT(all, 100000);
  EXPECT_GT(right, 0.98 * all);
}

TEST_F(StandingFigureTest, StandsOnTheBookAndNotTheTable) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  EXPECT_GT(standing->support.up.z(), 0.9999);
  EXPECT_NEAR(standing->support.height, kBookTop, 0.002);
  EXPECT_NEAR(standing->height, kFigureTop - kBookTop, 0.03) << "the lid is seen at a slant";
  int figure = 0, box = 0, wrong = 0;
  for (std::size_t v = 0; v < Depths().views.size(); ++v)
    for (std::size_t k = 0; k < Depths().views[v].size(); ++k) {
      const DepthSample& sample = Depths().views[v][k];
      const auto thing = *World().things[v].at(static_cast<int>(sample.pixel.x()),
                                               static_cast<int>(sample.pixel.y()));
      const bool is_figure = standing->samples[v][k] == Stands::kFigure;
      figure += is_figure;
      box += thing == kBox && standing->samples[v][k] == Stands::kOther;
      wrong += is_figure != (thing == kFigure) && standing->samples[v][k] != Stands::kOpen;
    }
  EXPECT_GT(figure, 10000);
  EXPECT_GT(box, 2000);
  EXPECT_LT(wrong, 0.15 * figure) << "windows widen the figure by a pixel or two";
}

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

TEST_F(StandingFigureTest, ALineOverAPartOfItTakesThatPartAway) {
  // Lines on the upper half say that it is not the figure; clicks below say what is.
  Opinions opinions;
  for (const View& view : World().scene.views) {
    const auto pixel = [&view](const Vector3d& x) -> Eigen::Vector2i {
      return view.Project(x).array().floor().cast<int>();
    };
    const Vector3d front =
        kFigureRadius * Vector3d(view.Center().x(), view.Center().y(), 0).normalized();
    opinions.strokes.emplace_back();
    opinions.strokes.back().figure = {pixel(front + Vector3d(0, 0, 0.1))};
    for (int k = 0; k < 20; ++k)
      opinions.strokes.back().other.push_back(pixel(front + Vector3d(0, 0, 0.28 + 0.005 * k)));
  }
  const auto standing = FindStandingFigure(Depths(), World().scene.views, World().middle, opinions);
  ASSERT_TRUE(standing);
  double highest = 0;
  for (const Vector3d& x : standing->points) highest = std::max(highest, x.z());
  EXPECT_GT(highest, 0.1);
  EXPECT_LT(highest, 0.29);
}

TEST_F(StandingFigureTest, AClickChoosesTheBoxBesideIt) {
  Opinions opinions;
  opinions.strokes.resize(World().images.size());
  for (std::size_t v = 0; v < World().images.size(); ++v)
    for (int p = 0; p < static_cast<int>(World().things[v].data.size()); p += 61)
      if (World().things[v].data[static_cast<std::size_t>(p)] == kBox)
        opinions.strokes[v].figure.push_back(
            {p % World().images[v].width, p / World().images[v].width});
  const auto standing = FindStandingFigure(Depths(), World().scene.views, World().middle, opinions);
  ASSERT_TRUE(standing);
  for (const Vector3d& x : standing->points) EXPECT_GT(x.x(), 0.27);
}

TEST(HiddenParts, AreWhereSomethingElseIsNearer) {
  // A plate of 0.4 x 0.4, and a smaller one that stands 0.3 before a part of it.
  StandingFigure figure;
  figure.spacing = 0.01;
  for (double x = -0.2; x < 0.2; x += figure.spacing)
    for (double z = 0; z < 0.4; z += figure.spacing) figure.points.emplace_back(x, 0, z);
  for (double x = -0.05; x < 0.1; x += figure.spacing)
    for (double z = 0; z < 0.2; z += figure.spacing) figure.others.emplace_back(x, -0.3, z);
  View view;
  view.camera.width = 640, view.camera.height = 480;
  view.camera.fx = view.camera.fy = 900, view.camera.cx = 320, view.camera.cy = 240;
  Eigen::Matrix3d forward_is_y;
  forward_is_y << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Vector3d eye(0, -1.5, 0.2);
  view.camera_from_world = {Eigen::Quaterniond(forward_is_y), -(forward_is_y * eye)};
  View from_behind = view;
  const Eigen::Matrix3d back = Eigen::Vector3d(-1, 1, -1).asDiagonal() * forward_is_y;
  from_behind.camera_from_world = {Eigen::Quaterniond(back), -(back * Vector3d(0, 1.5, 0.2))};
  const std::vector<HiddenPart> parts = HiddenParts({view, from_behind}, figure);
  EXPECT_NEAR(parts[0].share, 0.15 * 1.25 * 0.2 / (0.4 * 0.4), 0.02);
  EXPECT_EQ(parts[1].share, 0);
  const auto hidden = [&](const Vector3d& x) {
    const Eigen::Vector2d pixel = view.Project(x) * parts[0].where.width / view.camera.width;
    return *parts[0].where.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())) > 0;
  };
  EXPECT_TRUE(hidden({0.0, 0, 0.1}));
  EXPECT_TRUE(hidden({0.1, 0, 0.05}));
  EXPECT_FALSE(hidden({-0.1, 0, 0.1})) << "beside it";
  EXPECT_FALSE(hidden({0.0, 0, 0.25})) << "above it";
}

TEST(OtherPart, IsCutAtTheNarrowPlace) {
  // Two squares of one colour, joined by one point.
  constexpr int kSide = 9;
  ColouredSurface surface;
  const auto at = [](int square, int x, int y) { return square * kSide * kSide + y * kSide + x; };
  surface.colours.assign(2 * kSide * kSide, Eigen::Vector3f(90, 90, 90));
  surface.neighbours.resize(surface.colours.size());
  const auto join = [&surface](int a, int b) {
    surface.neighbours[static_cast<std::size_t>(a)].push_back(b);
    surface.neighbours[static_cast<std::size_t>(b)].push_back(a);
  };
  for (int square = 0; square < 2; ++square)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        if (x > 0) join(at(square, x, y), at(square, x - 1, y));
        if (y > 0) join(at(square, x, y), at(square, x, y - 1));
      }
  join(at(0, kSide - 1, 4), at(1, 0, 4));
  const std::vector<char> other = OtherPart(surface, {at(0, 3, 4)}, {at(1, 2, 4)});
  for (int i = 0; i < 2 * kSide * kSide; ++i) EXPECT_EQ(other[i], i >= kSide * kSide) << i;
}

TEST(OtherPart, IsCutWhereTheColourChanges) {
  ColouredSurface line;
  for (int i = 0; i < 40; ++i) {
    line.colours.push_back(Eigen::Vector3f::Constant(i < 30 ? 60 : 200));
    line.neighbours.emplace_back();
    if (i == 0) continue;
    line.neighbours[static_cast<std::size_t>(i)].push_back(i - 1);
    line.neighbours[static_cast<std::size_t>(i) - 1].push_back(i);
  }
  const std::vector<char> other = OtherPart(line, {2}, {35});
  for (int i = 0; i < 40; ++i) EXPECT_EQ(other[i], i >= 30) << i;
}

TEST(BorderOf, SmallPartsOfOneColourCostMore) {
  // A strip, one point wide; its last ten points have another colour.
  ColouredSurface strip;
  for (int i = 0; i < 40; ++i) {
    strip.colours.push_back(Eigen::Vector3f::Constant(i < 30 ? 60 : 200));
    strip.neighbours.emplace_back();
    if (i > 0) strip.neighbours.back().push_back(i - 1);
    if (i < 39) strip.neighbours.back().push_back(i + 1);
  }
  const auto last = [](int count) {
    std::vector<char> part(40, 0);
    std::fill(part.end() - count, part.end(), 1);
    return part;
  };
  EXPECT_LT(BorderOf(strip, last(10)), 0.1 * BorderOf(strip, last(8)));
  EXPECT_NEAR(BorderOf(strip, last(2)), 2 * BorderOf(strip, last(8)), 1e-6);
  EXPECT_NEAR(BorderOf(strip, last(38)), BorderOf(strip, last(2)), 1e-6);
  EXPECT_EQ(BorderOf(strip, last(0)), kFar);
}

TEST(OtherPart, FollowsThePlaceWhereNeitherWidthNorColourTells) {
  // A strip of one colour and width; the line was drawn round its end.
  ColouredSurface strip;
  for (int i = 0; i < 40; ++i) {
    strip.colours.push_back(Eigen::Vector3f::Constant(90));
    strip.neighbours.emplace_back();
    strip.lean.push_back(static_cast<float>(std::max(-1.0, (i - 24.5) / 10)));
    if (i == 0) continue;
    strip.neighbours[static_cast<std::size_t>(i)].push_back(i - 1);
    strip.neighbours[static_cast<std::size_t>(i) - 1].push_back(i);
  }
  const std::vector<char> other = OtherPart(strip, {2}, {38});
  for (int i = 0; i < 40; ++i) EXPECT_EQ(other[i], i >= 25) << i;
}

TEST_F(StandingFigureTest, AWallIsSeenFromTheFrontTheLeftAndTheRight) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  EXPECT_FALSE(standing->on_wall);
  // The plane as a wall, before which a person walks to and fro: up in the pictures is y.
  std::vector<View> views = World().scene.views;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double turn =
        (static_cast<double>(v) / static_cast<double>(views.size() - 1) - 0.5) * 1.8;
    const Vector3d back(std::sin(turn), 0.2, std::cos(turn));
    const Vector3d forward = -back.normalized(),
                   right = forward.cross(Vector3d::UnitY()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    views[v].camera_from_world.rotation = Eigen::Quaterniond(rotation);
    views[v].camera_from_world.translation =
        -(views[v].camera_from_world.rotation * (World().middle - 1.2 * forward));
  }
  const auto relief = FindStandingFigure(Depths(), views, World().middle, {});
  ASSERT_TRUE(relief);
  EXPECT_TRUE(relief->on_wall);
}

TEST_F(StandingFigureTest, SameForAnyThreadCount) {
  Depths();
  SetThreadCount(1);
  const CoarseDepths one = FindCoarseDepths(World().images, World().scene, World().middle);
  SetThreadCount(0);
  for (std::size_t v = 0; v < one.views.size(); ++v) {
    ASSERT_EQ(one.views[v].size(), Depths().views[v].size());
    for (std::size_t k = 0; k < one.views[v].size(); ++k)
      ASSERT_EQ(one.views[v][k].point, Depths().views[v][k].point);
  }
}

}  // namespace keypose::capture::standing_figure_test
