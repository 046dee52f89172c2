// The evidence for cameras, upside-down photographs, and sets without overlap, on exact rings.
#include "reconstruct/evidence/camera_evidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/size_of.h"
#include "reconstruct/matching/testing/ball_figure.h"

namespace keypose::reconstruct::camera_evidence_test {

using Eigen::Vector3d;

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

}  // namespace keypose::reconstruct::camera_evidence_test
