// The evidence for cameras, upside-down photographs, and sets without overlap, on exact rings.
#include "reconstruct/evidence/camera_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include "core/pictures/image_turns.h"
#include "core/pictures/joined_images.h"
#include "core/pictures/render.h"
#include "core/values/size_of.h"
#include "reconstruct/turntable/upside_down.h"

namespace keypose::reconstruct::camera_evidence_test {

using Eigen::Vector3d;

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr int kWidth = 320, kHeight = 240;

struct Ball {
  Vector3d center;
  double radius;
};

/// A figure of balls, asymmetric in all directions: trunk, head, arms, a nose, feet.
const std::vector<Ball> kFigure = {{{0.02, 0.03, 0}, 0.3},     {{0, 0.05, 0.38}, 0.2},
                                   {{0.34, 0.1, 0.12}, 0.12},  {{-0.42, -0.05, 0.2}, 0.1},
                                   {{0.05, -0.22, 0.4}, 0.08}, {{0.15, -0.1, -0.38}, 0.13},
                                   {{-0.16, 0.08, -0.4}, 0.14}};

Image8 MaskOf(const View& view, const std::vector<Ball>& figure = kFigure) {
  Image8 mask(kWidth, kHeight, 1, 0);
  for (const Ball& ball : figure) {
    const Vector3d center = view.camera_from_world * ball.center;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Vector3d ray((x + 0.5 - view.camera.cx) / view.camera.fx,
                           (y + 0.5 - view.camera.cy) / view.camera.fy, 1);
        if ((center - center.dot(ray) / ray.squaredNorm() * ray).norm() <= ball.radius)
          *mask.at(x, y) = 255;
      }
  }
  return mask;
}

Scene Ring(int count, double step_deg) {
  Scene scene;
  for (int k = 0; k < count; ++k) {
    const double turn = k * step_deg * kDegree, raised = 20 * kDegree;
    View view;
    view.name = "v" + std::to_string(100 + k);
    view.camera = {.width = kWidth,
                   .height = kHeight,
                   .fx = 500,
                   .fy = 500,
                   .cx = kWidth / 2.0,
                   .cy = kHeight / 2.0};
    view.camera_from_world =
        LookAt(3 * Vector3d(std::cos(turn) * std::cos(raised), std::sin(turn) * std::cos(raised),
                            std::sin(raised)),
               Vector3d::Zero());
    scene.views.push_back(view);
  }
  return scene;
}

/// Points on the balls, each a feature of all images, with matches of neighbours.
struct Matched {
  std::vector<Features> features;
  std::vector<PairMatches> pairs;
};

Matched MatchesOf(const Scene& truth) {
  std::vector<Vector3d> points;
  for (const Ball& ball : kFigure)
    for (int k = 0; k < 10; ++k)
      points.push_back(ball.center +
                       ball.radius *
                           Vector3d(std::cos(k), std::sin(k), std::cos(3.0 * k)).normalized());
  Matched matched;
  for (const View& view : truth.views) {
    Features features;
    features.positions.resize(std::ssize(points), 2);
    features.scales = Eigen::VectorXf::Ones(features.positions.rows());
    for (std::size_t p = 0; p < points.size(); ++p)
      features.positions.row(p) = view.Project(points[p]).transpose().cast<float>();
    matched.features.push_back(std::move(features));
  }
  const int images = SizeOf(truth.views);
  for (int i = 0; i < images; ++i)
    for (int j = i + 1; j < std::min(images, i + 3); ++j) {
      PairMatches pair{i, j, {}};
      for (std::uint32_t p = 0; p < points.size(); ++p) pair.features.emplace_back(p, p);
      matched.pairs.push_back(std::move(pair));
    }
  return matched;
}

std::vector<int> Counted(std::size_t count) {
  std::vector<int> numbers(count);
  for (std::size_t k = 0; k < count; ++k) numbers[k] = static_cast<int>(k);
  return numbers;
}

std::vector<Ball> WithHandles() {
  std::vector<Ball> figure = kFigure;
  for (Ball& ball : figure) ball.radius *= 0.5;  // so that gaps are much of the picture
  constexpr int kBalls = 20;
  for (const double side : {0.0, 90 * kDegree, 180 * kDegree})
    for (int k = 0; k < kBalls; ++k) {
      const double turn = 2 * M_PI * k / kBalls, away = 0.5 + 0.36 * std::cos(turn);
      figure.push_back(
          {Vector3d(away * std::cos(side), away * std::sin(side), 0.05 + 0.36 * std::sin(turn)),
           0.06});
    }
  return figure;
}

/// The mask with what has no way to the picture's sides.
Image8 Filled(const Image8& mask) {
  Image8 filled(mask.width, mask.height, 1, 255);
  std::vector<std::pair<int, int>> open = {{0, 0}};
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    if (x < 0 || y < 0 || x >= mask.width || y >= mask.height || *mask.at(x, y) > 0 ||
        *filled.at(x, y) == 0)
      continue;
    *filled.at(x, y) = 0;
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
      open.emplace_back(x + dx, y + dy);
  }
  return filled;
}

/// Masks of a figure with handles, in most of which the gaps of the handles are dark.
std::vector<Image8> MasksWithDarkGaps(const Scene& truth) {
  std::vector<Image8> masks;
  for (int v = 0; v < SizeOf(truth.views); ++v) {
    const Image8 mask = MaskOf(truth.views[v], WithHandles());
    masks.push_back(v % 3 > 0 ? Filled(mask) : mask);
  }
  return masks;
}

CameraEvidence EvidenceOf(const std::vector<Image8>& masks, const Scene& cameras) {
  const int count = SizeOf(masks);
  std::vector<PreparedView> views;
  for (int v = 0; v < count; ++v)
    views.push_back(
        PrepareView(cameras.views[v], v, Image8(kWidth, kHeight, 3, 128), masks[v], 1, 1));
  CameraEvidence evidence{.images = count, .placed = count};
  MeasureOutlines(views, evidence);
  return evidence;
}

/// The evidence for `cameras`, for photographs taken by `truth`.
CameraEvidence EvidenceOf(const Scene& truth, const Scene& cameras, const Matched& matched) {
  CameraEvidence evidence;
  evidence.images = SizeOf(truth.views);
  evidence.placed = SizeOf(cameras.views);
  std::vector<PreparedView> views;
  for (std::size_t v = 0; v < cameras.views.size(); ++v)
    views.push_back(PrepareView(cameras.views[v], static_cast<int>(v),
                                Image8(kWidth, kHeight, 3, 128), MaskOf(truth.views[v]), 1, 1));
  if (const auto hull = MeasureOutlines(views, evidence))
    CountAgreeingPairs(cameras, Counted(cameras.views.size()), matched.features, matched.pairs,
                       *hull, 4, evidence);
  return evidence;
}

TEST(CameraEvidence, TrueCamerasAreSureAndEveryWrongRingIsNot) {
  const Scene truth = Ring(15, 24);
  const Matched matched = MatchesOf(truth);
  const CameraEvidence right = EvidenceOf(truth, truth, matched);
  EXPECT_GT(right.hull_iou, 0.95);  // pixels of 1/60 of the figure, carved from two views
  EXPECT_EQ(right.pairs_agree, right.pairs);
  EXPECT_TRUE(IsSure(right));
  // Rotated in the wrong direction, half as far, a third too far.
  for (const double step_deg : {-24.0, 12.0, 32.0}) {
    const CameraEvidence wrong = EvidenceOf(truth, Ring(15, step_deg), matched);
    EXPECT_FALSE(IsPlausible(wrong)) << step_deg << " degrees: " << wrong.hull_iou;
    EXPECT_FALSE(IsSure(wrong));
    EXPECT_TRUE(IsBetter(right, wrong));
    EXPECT_FALSE(IsBetter(wrong, right));
  }
}

// Seen on a ruined temple between whose columns the backdrop was as dark as the shadows: right
// cameras were refused with an overlap of 0.79.
TEST(CameraEvidence, GapsThatOnlySomeMasksFillSayNothingAgainstTrueCameras) {
  const Scene truth = Ring(15, 24);
  const std::vector<Image8> masks = MasksWithDarkGaps(truth);
  const CameraEvidence right = EvidenceOf(masks, truth);
  EXPECT_TRUE(right.holes_filled) << right.hull_iou;
  EXPECT_TRUE(right.hull_iou > CameraEvidenceTuning::kSureHullOverlap) << right.hull_iou;
  for (const double step_deg : {-24.0, 12.0, 32.0}) {
    const CameraEvidence wrong = EvidenceOf(masks, Ring(15, step_deg));
    EXPECT_FALSE(IsPlausible(wrong)) << step_deg << " degrees: " << wrong.hull_iou;
  }
}

TEST(CameraEvidence, TheFirstStrategyStaysUnlessAnotherIsClearlyBetter) {
  CameraEvidence first{.images = 16,
                       .placed = 16,
                       .outlines = true,
                       .hull_iou = 0.95,
                       .pairs = 40,
                       .pairs_agree = 40};
  CameraEvidence other = first;
  other.hull_iou = 0.955;
  EXPECT_FALSE(IsBetter(other, first));
  first.hull_iou = 0.56;  // small residuals, but outlines of no single figure
  EXPECT_TRUE(IsBetter(other, first));
  other.placed = 12;
  EXPECT_TRUE(IsBetter(other, first));
  first.hull_iou = 0.95;
  first.placed = 11;
  EXPECT_TRUE(IsBetter(other, first));
}

TEST(UpsideDown, MatchesTellThePhotographsThatWereTurnedOver) {
  const Scene truth = Ring(15, 24);
  Matched matched = MatchesOf(truth);
  for (const std::size_t i : {3, 10}) {
    matched.features[i].positions.col(0) = kWidth - matched.features[i].positions.col(0).array();
    matched.features[i].positions.col(1) = kHeight - matched.features[i].positions.col(1).array();
  }
  const std::vector<int> found = UpsideDownByMatches(15, PointsOf(matched.pairs, matched.features));
  for (int i = 0; i < 15; ++i) EXPECT_EQ(found[i], i == 3 || i == 10) << i;
}

TEST(UpsideDown, OutlinesTellWhereNoMatchDoes) {
  std::vector<Image8> masks;
  for (int i = 0; i < 12; ++i) {  // pears: wider towards the bottom
    Image8 mask(kWidth, kHeight, 1, 0);
    for (int y = 40; y < 200; ++y)
      for (int x = 160 - (y - 40) / 3 - i % 3; x < 160 + (y - 40) / 3; ++x) *mask.at(x, y) = 255;
    masks.push_back(i == 4 ? TurnedOver(mask) : mask);
  }
  const std::vector<int> found = UpsideDownByOutlines(std::vector<int>(12, -1), masks);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(found[i], i == 4) << i;
}

TEST(FallsApart, SixSidesShotManyTimesDoAndRingsOrBareClayDoNot) {
  std::vector<ImageTie> sides, rings, chain;
  for (int i = 0; i + 6 < 34; ++i)
    sides.push_back({i, i + 6, 300});  // six sides, 60 degrees apart, each from several heights
  EXPECT_EQ(JoinedImages(34, sides).size(), 6U);
  EXPECT_TRUE(FallsApart(34, sides, 60));
  for (int ring = 0; ring < 4; ++ring)  // four rings of twelve without common features yet
    for (int k = 0; k < 12; ++k)
      rings.push_back(
          {12 * ring + std::min(k, (k + 1) % 12), 12 * ring + std::max(k, (k + 1) % 12), 300});
  EXPECT_FALSE(FallsApart(48, rings, 60));
  for (int i = 0; i + 1 < 24; ++i)
    if (i % 3 != 2)
      chain.push_back({i, i + 1, 25});  // weak texture: few matches between some neighbours
  EXPECT_EQ(JoinedImages(24, chain).size(), 8U);
  EXPECT_FALSE(FallsApart(24, chain, 60));
  EXPECT_FALSE(FallsApart(24, {}, 60));  // no texture: left to the outlines
}

}  // namespace keypose::reconstruct::camera_evidence_test
