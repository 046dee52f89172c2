// The ring model on known rings: start from matches, bundle adjustment, gaps, uneven steps, wrong
// matches, free cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <numeric>
#include <random>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/numerics/simplex_search.h"
#include "reconstruct/turntable/ring_order.h"
#include "reconstruct/turntable/ring_sfm.h"
#include "reconstruct/turntable/ring_tracks.h"

namespace keypose::reconstruct::ring_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846, kDegree = kPi / 180;

struct RingWorld {
  RingModel truth;
  std::vector<Vector3d> points, normals;
  std::vector<std::string> names;
  std::mt19937 random{7};

  double Gauss(double sigma) { return std::normal_distribution<double>(0, sigma)(random); }
  /// Whether a view sees a point of the closed body.
  bool Sees(std::size_t v, std::size_t p) const {
    const Rigid3 pose = truth.CameraFromTable(truth.views[v]);
    return normals[p].dot((pose.Inverse().translation - points[p]).normalized()) > 0.25;
  }
  Vector2d Pixel(std::size_t v, std::size_t p, double noise) {
    return truth.camera.Project(truth.CameraFromTable(truth.views[v]) * points[p]) +
           Vector2d(Gauss(noise), Gauss(noise));
  }
};

/// Rings of `count` cameras each at these elevations, 4 units from a body of half axes 0.5, 0.4,
/// 0.8 that is slightly off the axis.
RingWorld MakeWorld(const std::vector<double>& elevations_deg, int count, int points,
                    double slop_deg) {
  RingWorld world;
  Camera& camera = world.truth.camera;
  camera.width = 1200, camera.height = 900, camera.fx = camera.fy = 1800, camera.cx = 600,
  camera.cy = 450;
  for (std::size_t r = 0; r < elevations_deg.size(); ++r) {
    const double e = elevations_deg[r] * kDegree;
    const Vector3d aim(0.05, -0.03, 0.1),
        eye = aim + (4 + 0.3 * static_cast<double>(r)) * Vector3d(std::cos(e), 0, std::sin(e));
    const Vector3d forward = (aim - eye).normalized(),
                   right = forward.cross(Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    rotation = Eigen::AngleAxisd(0.02, Vector3d::UnitZ()) * rotation;
    world.truth.rings.push_back({Eigen::Quaterniond(rotation), -(rotation * eye)});
    world.truth.step_rad.push_back(2 * kPi / count);
    for (int k = 0; k < count; ++k) {
      const double start = 0.5 * static_cast<double>(r) * world.truth.step_rad[r];
      world.truth.views.push_back(
          {SizeOf(world.names), static_cast<int>(r), static_cast<double>(k),
           start + k * world.truth.step_rad[r] + world.Gauss(slop_deg * kDegree)});
      world.names.push_back("P" + std::to_string(1017 + world.names.size()) + ".jpg");
    }
  }
  for (int p = 0; p < points; ++p) {
    const Vector3d d = Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1)).normalized(),
                   axes(0.5, 0.4, 0.8);
    world.points.push_back(d.cwiseProduct(axes) + Vector3d(0.1, 0, 0.05));
    world.normals.push_back(d.cwiseQuotient(axes).normalized());
  }
  return world;
}

/// Matches of all pairs of views up to 50 degrees apart, with `wrong` of them at random places.
std::vector<PairPoints> MakePairs(RingWorld& world, double noise, double wrong, std::size_t each) {
  std::vector<PairPoints> pairs;
  std::uniform_real_distribution<double> uniform(0, 1);
  for (std::size_t a = 0; a < world.truth.views.size(); ++a)
    for (std::size_t b = a + 1; b < world.truth.views.size(); ++b) {
      const Eigen::Quaterniond turn =
          SecondFromFirst(world.truth, world.truth.views[a], world.truth.views[b]).rotation;
      if ((turn * Vector3d::UnitZ()).z() < std::cos(50 * kDegree)) continue;
      std::vector<Eigen::Vector4d> rows;
      for (std::size_t p = (a * 7 + b) % 3; p < world.points.size() && rows.size() < each; p += 3) {
        if (!world.Sees(a, p) || !world.Sees(b, p)) continue;
        rows.emplace_back();
        rows.back() << world.Pixel(a, p, noise), world.Pixel(b, p, noise);
        if (uniform(world.random) < wrong)
          rows.back().tail<2>() << 300 + 600 * uniform(world.random),
              200 + 500 * uniform(world.random);
      }
      PairPoints pair{world.truth.views[a].image, world.truth.views[b].image, {}};
      pair.xy.resize(std::ssize(rows), 4);
      for (std::size_t k = 0; k < rows.size(); ++k) pair.xy.row(k) = rows[k].transpose();
      if (!rows.empty()) pairs.push_back(std::move(pair));
    }
  return pairs;
}

PointsX3 Centers(const RingModel& model) {
  PointsX3 centers(std::ssize(model.views), 3);
  for (std::size_t v = 0; v < model.views.size(); ++v)
    centers.row(v) = model.CameraFromTable(model.views[v]).Inverse().translation.transpose();
  return centers;
}

PointsX3 Centers(const Scene& scene) {
  PointsX3 centers(std::ssize(scene.views), 3);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    centers.row(v) = scene.views[v].Center().transpose();
  return centers;
}

/// Largest distance of camera centres over the ring's radius, after a similarity.
double CenterError(const PointsX3& found, const PointsX3& truth) {
  return (Transformed(FitSimilarity(found, truth), found) - truth).rowwise().norm().maxCoeff() / 4;
}

struct BundleStart {
  RingModel model;
  std::vector<SparsePoint> points;
  std::vector<Observation> observations;
};

/// Observations of all visible points, and an inexact start.
BundleStart MakeStart(RingWorld& world, double noise) {
  BundleStart start{world.truth, {}, {}};
  for (std::size_t p = 0; p < world.points.size(); ++p) {
    SparsePoint point;
    point.position =
        world.points[p] + 0.02 * Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1));
    point.color.setZero();
    start.points.push_back(point);
    for (std::size_t v = 0; v < world.truth.views.size(); ++v)
      if (world.Sees(v, p))
        start.observations.push_back(
            {static_cast<int>(v), static_cast<int>(p), world.Pixel(v, p, noise)});
  }
  for (RingView& view : start.model.views)
    view.angle_rad = view.index * world.truth.step_rad[view.ring];
  for (Rigid3& ring : start.model.rings) {
    ring.rotation = ring.rotation * Eigen::Quaterniond(Eigen::AngleAxisd(
                                        0.01, Vector3d(0.3, 0.8, 0.5).normalized()));
    ring.translation += Vector3d(0.02, -0.03, 0.05);
  }
  start.model.camera.fx = start.model.camera.fy = 1.02 * world.truth.camera.fx;
  return start;
}

// The known answer of a rendered ring: 0.3 px of noise, centres accurate to a thousandth of the
// radius, and a table that stops 0.2 degrees off its marks, estimated to a tenth of that. 1,000
// points, each seen by some nine views; a photograph of clay has more.
TEST(AdjustRingBundle, RecoversCentersToAThousandthAndSlopToATenthOfIt) {
  RingWorld world = MakeWorld({25}, 24, 1000, 0.2);
  const BundleStart start = MakeStart(world, 0.3);
  const RingBundleResult result =
      AdjustRingBundle(start.model, start.points, start.observations, {});
  EXPECT_LT(CenterError(Centers(result.model), Centers(world.truth)), 1e-3);
  EXPECT_LT(result.mean_error_px,
            0.45);  // the mean length of a 2D error of 0.3 px each way is 0.376
  // Angles are known up to a common rotation, which changes nothing.
  double turn = 0;
  for (std::size_t v = 0; v < 24; ++v)
    turn += (result.model.views[v].angle_rad - world.truth.views[v].angle_rad) / 24;
  for (std::size_t v = 0; v < 24; ++v)
    EXPECT_NEAR(result.model.views[v].angle_rad - turn, world.truth.views[v].angle_rad,
                0.02 * kDegree)
        << v;
}

// 25 tracks in all: too few for poses of six unknowns each, enough for a ring.
TEST(AdjustRingBundle, TwentyFiveTracksHoldARing) {
  RingWorld world = MakeWorld({25}, 24, 25, 0.2);
  const BundleStart start = MakeStart(world, 0.3);
  const RingBundleResult result =
      AdjustRingBundle(start.model, start.points, start.observations, {});
  EXPECT_LT(CenterError(Centers(result.model), Centers(world.truth)), 3e-3);
  EXPECT_LT(result.unknowns, 24 + 12);
}

TEST(AdjustRingBundle, BadIndicesThrow) {
  RingWorld world = MakeWorld({25}, 8, 20, 0);
  BundleStart start = MakeStart(world, 0);
  EXPECT_THROW(AdjustRingBundle(start.model, start.points, {{8, 0, Vector2d::Zero()}}, {}),
               InputError);
  start.model.views[2].ring = 1;
  EXPECT_THROW(AdjustRingBundle(start.model, start.points, start.observations, {}), InputError);
}

// 12 matches per pair, a third of them wrong: no pair could be verified on its own.
TEST(FindRingModel, FewMatchesOfTwoRingsWithWrongOnesAmongThem) {
  RingWorld world = MakeWorld({12, 40}, 18, 200, 0.5);
  const auto pairs = MakePairs(world, 0.5, 0.33, 12);
  const RingStart start = FindRingModel(world.truth.camera, LayoutOfSizes(36, {18, 18}), pairs);
  EXPECT_TRUE(start.IsPlausible());
  EXPECT_NEAR(start.inlier_share, 0.67, 0.05);
  EXPECT_LT(CenterError(Centers(start.model), Centers(world.truth)), 0.02);
}

TEST(FindRingModel, MatchesOfNothingAreNotBelieved) {
  RingWorld world = MakeWorld({25}, 12, 100, 0);
  const auto pairs = MakePairs(world, 0.5, 1.0, 12);
  EXPECT_FALSE(FindRingModel(world.truth.camera, LayoutOfSizes(12, {12}), pairs).IsPlausible());
}

TEST(FindRingModel, SameBitsForAnyThreadCount) {
  RingWorld world = MakeWorld({25}, 12, 60, 0.3);
  const auto pairs = MakePairs(world, 0.5, 0.2, 10);
  SetThreadCount(1);
  const RingStart one = FindRingModel(world.truth.camera, LayoutOfSizes(12, {12}), pairs);
  SetThreadCount(3);
  const RingStart three = FindRingModel(world.truth.camera, LayoutOfSizes(12, {12}), pairs);
  SetThreadCount(0);
  EXPECT_EQ(Centers(one.model), Centers(three.model));
}

/// Features whose descriptors identify the points, and their true matches except those that `each`
/// leaves out.
struct FeatureSet {
  std::vector<Features> features;
  std::vector<PairMatches> matches;
};

FeatureSet MakeFeatures(RingWorld& world, double noise) {
  FeatureSet set;
  std::vector<std::vector<std::int16_t>> descriptors(world.points.size());
  for (auto& d : descriptors) {
    Eigen::VectorXd v(128);
    for (int k = 0; k < 128; ++k)
      v(k) = std::pow(std::uniform_real_distribution<double>(0, 1)(world.random), 4);
    v *= 512 / v.norm();
    for (int k = 0; k < 128; ++k)
      d.push_back(static_cast<std::int16_t>(std::min(255.0, std::round(v(k)))));
  }
  for (std::size_t v = 0; v < world.truth.views.size(); ++v) {
    std::vector<std::size_t> seen;
    for (std::size_t p = 0; p < world.points.size(); ++p)
      if (world.Sees(v, p)) seen.push_back(p);
    Features f;
    f.positions.resize(std::ssize(seen), 2);
    f.scales = Eigen::VectorXf::Ones(std::ssize(seen));
    for (std::size_t k = 0; k < seen.size(); ++k) {
      f.positions.row(k) = world.Pixel(v, seen[k], noise).transpose().cast<float>();
      f.descriptors.insert(f.descriptors.end(), descriptors[seen[k]].begin(),
                           descriptors[seen[k]].end());
    }
    set.features.push_back(std::move(f));
  }
  // The matches for the ring's start: a few of each pair.
  for (int a = 0; a < std::ssize(set.features); ++a)
    for (int b = a + 1; b < std::ssize(set.features); ++b) {
      PairMatches pair{a, b, MatchDescriptors(set.features[a], set.features[b], {})};
      if (pair.features.size() > 9) pair.features.resize(9);
      if (!pair.features.empty()) set.matches.push_back(std::move(pair));
    }
  return set;
}

TEST(ReconstructRing, ClosesWithFiveViewsMissing) {
  RingWorld world = MakeWorld({25}, 24, 120, 0.2);
  for (const int gone : {19, 12, 11, 6, 2}) {
    world.truth.views.erase(world.truth.views.begin() + gone);
    world.names.erase(world.names.begin() + gone);
  }
  for (std::size_t v = 0; v < world.truth.views.size(); ++v)
    world.truth.views[v].image = static_cast<int>(v);
  const FeatureSet set = MakeFeatures(world, 0.3);
  const RingSfmResult ring = ReconstructRing(world.truth.camera, world.names, set.features,
                                             set.matches, LikelyLayouts(world.names), {});
  ASSERT_TRUE(ring.found);
  EXPECT_THAT(ring.layout.reason, HasSubstr("1 ring of 24"));
  EXPECT_EQ(ring.scene.views.size(), 19U);
  EXPECT_LT(CenterError(Centers(ring.scene), Centers(world.truth)), 1e-3);
  EXPECT_FALSE(ring.freed);
}

TEST(ReconstructRing, CamerasThatStandOffTheRingAreSetFree) {
  RingWorld world = MakeWorld({25}, 16, 150, 0.2);
  const FeatureSet even = MakeFeatures(world, 0.3);
  EXPECT_FALSE(ReconstructRing(world.truth.camera, world.names, even.features, even.matches,
                               LikelyLayouts(world.names), {})
                   .freed);
  // Held in the hand: for the projection, each view has a ring of its own.
  RingWorld shaky = world;
  shaky.truth.rings.clear();
  for (RingView& view : shaky.truth.views) {
    Rigid3 pose = world.truth.rings[0];
    pose.translation += 0.012 * Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1));
    view.ring = SizeOf(shaky.truth.rings);
    shaky.truth.rings.push_back(pose);
  }
  const FeatureSet set = MakeFeatures(shaky, 0.3);
  const RingSfmResult ring = ReconstructRing(world.truth.camera, world.names, set.features,
                                             set.matches, LikelyLayouts(world.names), {});
  ASSERT_TRUE(ring.found);
  EXPECT_TRUE(ring.freed);
  EXPECT_LT(ring.chi2_ratio, 0.5);
  // Some 50 points per view at 0.3 px, with free focal length and distortion.
  EXPECT_LT(CenterError(Centers(ring.scene), Centers(shaky.truth)), 6e-3);
}

/// Photographs whose names give no order, and the approximate cameras of some of them.
struct Shuffled {
  std::vector<std::string> names;
  std::vector<PairPoints> pairs;
  Scene part;
  std::vector<std::size_t> view_of_image;
};

Shuffled Shuffle(RingWorld& world, const std::vector<std::size_t>& known, double wrong) {
  Shuffled shuffled;
  std::vector<int> image_of_view(world.names.size());
  std::iota(image_of_view.begin(), image_of_view.end(), 0);
  std::shuffle(image_of_view.begin(), image_of_view.end(), world.random);
  shuffled.names = world.names;
  shuffled.view_of_image.resize(world.names.size());
  for (std::size_t v = 0; v < image_of_view.size(); ++v)
    shuffled.view_of_image[image_of_view[v]] = v;
  for (PairPoints& pair : MakePairs(world, 0.5, wrong, 15)) {
    pair.first = image_of_view[pair.first], pair.second = image_of_view[pair.second];
    if (pair.first > pair.second) {
      std::swap(pair.first, pair.second);
      const Eigen::MatrixXd xy = pair.xy;
      pair.xy << xy.rightCols<2>(), xy.leftCols<2>();
    }
    shuffled.pairs.push_back(std::move(pair));
  }
  for (const std::size_t v : known) {
    View view;
    view.name = world.names[image_of_view[v]];
    view.camera = world.truth.camera;
    view.camera_from_world = world.truth.CameraFromTable(world.truth.views[v]);
    view.camera_from_world.translation +=
        0.01 * Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1));
    shuffled.part.views.push_back(view);
  }
  for (const Vector3d& x : world.points) {
    SparsePoint point;
    point.position = x;
    point.color.setZero();
    shuffled.part.points.push_back(point);
  }
  return shuffled;
}

/// Photographs whose position in the order is wrong; each ring is counted from its first photograph
/// in its direction of rotation.
int Misplaced(const RingOrder& order, const Shuffled& shuffled, const RingWorld& world) {
  int wrong = 0;
  for (std::size_t r = 0; r < order.layout.rings.size(); ++r) {
    const auto& ring = order.layout.rings[r];
    const auto true_view = [&](std::size_t k) {
      return world.truth.views[shuffled.view_of_image[ring[k].image]];
    };
    int best = 0;
    for (const double sense : {1.0, -1.0}) {
      int right = 0;
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const double turn = 2 * kPi / order.layout.positions[r] * (ring[k].index - ring[0].index),
                     truth = true_view(k).angle_rad - true_view(0).angle_rad;
        right += true_view(k).ring == true_view(0).ring &&
                 std::abs(std::remainder(sense * turn - truth, 2 * kPi)) < 4 * kDegree;
      }
      best = std::max(best, right);
    }
    wrong += SizeOf(ring) - best;
  }
  return wrong;
}

// A mapper that placed nine of 24: the others get positions, and the gaps of five missing ones stay
// gaps.
TEST(OrderOnRings, SortsShuffledPhotographsOfTwoRingsAndKeepsTheGaps) {
  RingWorld world = MakeWorld({12, 40}, 12, 250, 0.6);
  for (const int gone : {22, 17, 11, 6, 5})
    world.truth.views.erase(world.truth.views.begin() + gone), world.names.pop_back();
  for (std::size_t v = 0; v < world.truth.views.size(); ++v)
    world.truth.views[v].image = static_cast<int>(v);
  const Shuffled shuffled = Shuffle(world, {0, 1, 2, 3, 4, 9, 10, 11, 12}, 0.3);
  const auto order = OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->sorted, 19);
  EXPECT_TRUE(order->even);
  EXPECT_THAT(order->layout.positions, ::testing::UnorderedElementsAre(12, 12));
  EXPECT_EQ(Misplaced(*order, shuffled, world), 0);
}

TEST(OrderOnRings, FindsTheRingOfWhichThePartHasNone) {
  RingWorld world = MakeWorld({12, 40}, 12, 250, 0.6);
  const Shuffled shuffled = Shuffle(world, {0, 1, 2, 3, 4, 5, 6}, 0.2);
  SetThreadCount(1);
  const auto order = OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs);
  SetThreadCount(3);
  const auto again = OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs);
  SetThreadCount(0);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->sorted, 24);
  ASSERT_EQ(order->layout.rings.size(), 2U);
  EXPECT_EQ(Misplaced(*order, shuffled, world), 0);
  ASSERT_TRUE(again);
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t k = 0; k < order->layout.rings[r].size(); ++k)
      EXPECT_EQ(order->layout.rings[r][k].image, again->layout.rings[r][k].image);
}

TEST(OrderOnRings, MatchesOfNothingSortNothing) {
  RingWorld world = MakeWorld({25}, 16, 100, 0.3);
  const Shuffled shuffled = Shuffle(world, {0, 1, 2, 3, 4, 5}, 1.0);
  EXPECT_FALSE(OrderOnRings(shuffled.part, shuffled.names, shuffled.pairs));
}

TEST(LayoutOfAngles, PutsPhotographsOnTheirRingsAtTheirAngles) {
  const auto layout = LayoutOfAngles({2, 1, 1, 2, 1, 2, 1}, {0, 30, 0, 120, 15, 240, 345});
  ASSERT_TRUE(layout);
  ASSERT_EQ(layout->rings.size(), 2u);
  EXPECT_EQ(layout->positions, (std::vector<int>{24, 3}));
  const int images[] = {2, 4, 1, 6}, index[] = {0, 1, 2, 23};
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(layout->rings[0][k].image, images[k]);
    EXPECT_DOUBLE_EQ(layout->rings[0][k].index, index[k]);
  }
  EXPECT_DOUBLE_EQ(layout->rings[1][2].index, 2);
}

TEST(LayoutOfAngles, OfTwoPhotographsOrOfEqualAnglesIsNothing) {
  EXPECT_FALSE(LayoutOfAngles({1, 1}, {0, 90}));
  EXPECT_FALSE(LayoutOfAngles({1, 1, 1, 2}, {0, 90, 180, 0}));
  EXPECT_FALSE(LayoutOfAngles({1, 1, 1}, {0, 90, 90}));
}

TEST(LikelyLayouts, NumbersInNamesTellTheGaps) {
  const auto layouts =
      LikelyLayouts({"a0007.jpg", "a0008.jpg", "a0010.jpg", "a0011.jpg", "a0012.jpg", "a0014.jpg"});
  ASSERT_EQ(layouts.size(), 2U);
  EXPECT_THAT(layouts[0].positions, ElementsAre(8));
  EXPECT_EQ(layouts[0].rings[0][2].index, 3);
  EXPECT_THAT(layouts[1].positions, ElementsAre(4, 4));
  EXPECT_EQ(layouts[1].rings[1][0].image, 3);
  EXPECT_EQ(LikelyLayouts({"x.jpg", "b.jpg", "c.jpg", "d.jpg"}).at(0).rings[0][3].index, 3);
}

TEST(LayoutOfSizes, SizesThatDoNotAddUpThrow) {
  EXPECT_THROW(LayoutOfSizes(30, {18, 18}), InputError);
}

TEST(BuildTracks, JoinsThroughImagesAndDropsWhatDisagrees) {
  std::vector<Features> features(3);
  for (Features& f : features) f.scales.resize(5), f.positions.resize(5, 2);
  const auto tracks =
      BuildTracks({{0, 1, {{0, 1}, {2, 2}}}, {1, 2, {{1, 3}}}, {0, 2, {{2, 4}, {3, 4}}}}, features);
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_EQ(tracks[0].elements.size(), 3U);  // 0:0 - 1:1 - 2:3
  EXPECT_EQ(tracks[1].elements.size(),
            2U);  // features 2 and 3 of image 0 both match 2:4, so only 1:2 and 2:4 remain
}

TEST(MinimizeSimplex, FindsTheBananaValleysEnd) {
  const auto banana = [](const Eigen::VectorXd& x) {
    return 100 * std::pow(x(1) - x(0) * x(0), 2) + std::pow(1 - x(0), 2);
  };
  const Eigen::VectorXd x = MinimizeSimplex(banana, Vector2d(-1.2, 1), Vector2d(0.5, 0.5), 400);
  EXPECT_LT((x - Vector2d(1, 1)).norm(), 1e-3);
}

}  // namespace keypose::reconstruct::ring_test
