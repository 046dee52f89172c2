#include "reconstruct/evidence/camera_evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "reconstruct/numerics/epipolar.h"
#include "views/hull/silhouettes.h"
#include "views/hull/visual_hull.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

/// The point nearest to two rays, if it is in front of both cameras.
std::optional<Vector3d> Meeting(const Vector3d& from_a, const Vector3d& along_a,
                                const Vector3d& from_b, const Vector3d& along_b) {
  Eigen::Matrix2d system;
  system << along_a.squaredNorm(), -along_a.dot(along_b), along_a.dot(along_b),
      -along_b.squaredNorm();
  const Vector3d between = from_b - from_a;
  if (std::abs(system.determinant()) < 1e-9 * along_a.squaredNorm() * along_b.squaredNorm())
    return std::nullopt;
  const Eigen::Vector2d depth =
      system.inverse() * Eigen::Vector2d(between.dot(along_a), between.dot(along_b));
  if (depth.x() <= 0 || depth.y() <= 0) return std::nullopt;
  return 0.5 * (from_a + depth.x() * along_a + from_b + depth.y() * along_b);
}

bool IsIn(const HullBox& box, const Vector3d& x) {
  return (x.array() >= box.low.array()).all() && (x.array() <= box.high.array()).all();
}

/// Whether most matches of a pair agree with its two cameras.
bool PairAgrees(const View& a, const View& b, const Features& first, const Features& second,
                const PairMatches& pair, const HullBox* near, double max_error_px) {
  const Eigen::Matrix3d ra = a.camera_from_world.rotation.toRotationMatrix(),
                        rb = b.camera_from_world.rotation.toRotationMatrix();
  const Eigen::Matrix3d essential =
      EssentialOf(ra, a.camera_from_world.translation, rb, b.camera_from_world.translation);
  const double limit = max_error_px / a.camera.fx;
  const Vector3d from_a = a.Center(), from_b = b.Center();
  constexpr std::size_t kMost = 200;
  const std::size_t count = std::min(kMost, pair.features.size());
  std::size_t agree = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto [f, s] = pair.features[k * pair.features.size() / count];
    const Vector3d x = a.camera.Unproject(first.positions.row(f).transpose().cast<double>());
    const Vector3d y = b.camera.Unproject(second.positions.row(s).transpose().cast<double>());
    if (SquaredSampson(essential, x, y) > limit * limit) continue;
    const auto met = Meeting(from_a, ra.transpose() * x, from_b, rb.transpose() * y);
    agree += met && (!near || IsIn(*near, *met));
  }
  return 2 * agree > count;
}

/// Sets the mask where it has no way to the picture's sides.
/// @return how many pixels
long FillHoles(GreyMask& mask) {
  cv::Mat1b figure(mask.height + 2, mask.width + 2, std::uint8_t{0});  // with a margin around it
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) figure(y + 1, x + 1) = InMask(*mask.at(x, y));
  constexpr std::uint8_t kAround = 2;
  cv::floodFill(figure, {0, 0}, kAround, nullptr, {}, {}, 4);
  long filled = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (figure(y + 1, x + 1) != 0) continue;
      *mask.at(x, y) |= 1;
      ++filled;
    }
  return filled;
}

/// The same views with the holes of their masks filled; nothing where there are hardly any.
std::vector<PreparedView> WithoutHoles(const std::vector<PreparedView>& views) {
  constexpr double kHardly = 0.005;  // of all masks
  std::vector<PreparedView> filled = views;
  long holes = 0, all = 0;
  for (PreparedView& view : filled) {
    const long added = FillHoles(view.levels.front().grey);
    view.masked_pixels += added;
    holes += added;
    all += view.masked_pixels;
  }
  if (static_cast<double>(holes) < kHardly * static_cast<double>(all)) filled.clear();
  return filled;
}

struct OutlineAgreement {
  HullCheck check;
  HullBox hull;
};

/// Nothing when the masks have no common space.
std::optional<OutlineAgreement> Compare(const std::vector<PreparedView>& views) {
  VisualHullOptions options;
  options.resolution = 96;
  try {
    const VisualHull hull = CarveVisualHull(views, options);
    return OutlineAgreement{
        CheckAgainstHull(views, hull, Silhouettes(views, options.outside_votes)),
        {hull.origin, hull.origin + hull.cell * hull.size.cast<double>()}};
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

namespace {

std::vector<char> Agreement(const Scene& scene, const std::vector<int>& view_of_image,
                            const std::vector<Features>& features,
                            const std::vector<PairMatches>& verified, const HullBox* near,
                            double max_error_px) {
  std::vector<char> agrees(verified.size(), -1);
  ParallelFor(std::ssize(verified), [&](std::int64_t k) {
    const PairMatches& pair = verified[k];
    const int a = view_of_image[pair.first], b = view_of_image[pair.second];
    if (a < 0 || b < 0 || pair.features.empty()) return;
    agrees[k] = PairAgrees(scene.views[a], scene.views[b], features[pair.first],
                           features[pair.second], pair, near, max_error_px);
  });
  return agrees;
}

}  // namespace

double CameraEvidence::Score() const {
  const double share = images > 0 ? static_cast<double>(placed) / images : 0;
  // A few pairs are not conclusive: kFewestPairs pairs of which half agree are added.
  const double agree = (pairs_agree + 0.5 * CameraEvidenceTuning::kFewestPairs) /
                       (pairs + CameraEvidenceTuning::kFewestPairs);
  return share * (outlines && !by_surroundings ? hull_iou : 1) *
         (1 - CameraEvidenceTuning::kPairWeight + CameraEvidenceTuning::kPairWeight * agree);
}

namespace {

/// Of the pairs that agree. Chains of photographs that hang on single pairs are easily wrong.
int FewestPairsInRoom(int placed) {
  const double of_each = CameraEvidenceTuning::kPairsOfEach * placed,
               of_all = CameraEvidenceTuning::kShareOfAll * placed * (placed - 1) / 2;
  return static_cast<int>(std::min(of_each, of_all));
}

}  // namespace

bool IsPlausible(const CameraEvidence& evidence) {
  if (evidence.by_surroundings)
    return evidence.placed > 0 && evidence.pairs_agree >= FewestPairsInRoom(evidence.placed) &&
           evidence.pairs_agree_share() >= CameraEvidenceTuning::kSurePairShare;
  return evidence.placed > 0 &&
         (!evidence.outlines || evidence.hull_iou >= CameraEvidenceTuning::kLeastHullOverlap);
}

bool IsSure(const CameraEvidence& evidence) {
  if (evidence.by_surroundings) return IsPlausible(evidence);
  if (!evidence.outlines) return evidence.placed > 0;
  return evidence.hull_iou >= CameraEvidenceTuning::kSureHullOverlap &&
         (evidence.pairs < CameraEvidenceTuning::kFewestPairs ||
          evidence.pairs_agree_share() >= CameraEvidenceTuning::kSurePairShare);
}

bool IsBetter(const CameraEvidence& other, const CameraEvidence& best) {
  if (other.placed == 0) return false;
  if (best.placed == 0) return true;
  const bool other_can = IsPlausible(other), best_can = IsPlausible(best);
  if (other_can != best_can) return other_can;
  if (other_can && IsSure(other) == IsSure(best) && other.placed != best.placed)
    return other.placed > best.placed;
  return other.Score() > best.Score() + CameraEvidenceTuning::kClearly;
}

std::vector<char> AgreementOfPairs(const Scene& scene, const std::vector<int>& view_of_image,
                                   const std::vector<Features>& features,
                                   const std::vector<PairMatches>& verified, double max_error_px) {
  return Agreement(scene, view_of_image, features, verified, nullptr, max_error_px);
}

void CountAgreeingPairs(const Scene& scene, const std::vector<int>& view_of_image,
                        const std::vector<Features>& features,
                        const std::vector<PairMatches>& verified, const HullBox& hull,
                        double max_error_px, CameraEvidence& evidence) {
  const Vector3d margin = CameraEvidenceTuning::kAround * (hull.high - hull.low);
  const HullBox near{hull.low - margin, hull.high + margin};
  const std::vector<char> agrees =
      Agreement(scene, view_of_image, features, verified, &near, max_error_px);
  evidence.pairs =
      static_cast<int>(std::count_if(agrees.begin(), agrees.end(), [](char a) { return a >= 0; }));
  evidence.pairs_agree = static_cast<int>(std::count(agrees.begin(), agrees.end(), 1));
}

std::optional<HullBox> MeasureOutlines(const std::vector<PreparedView>& views,
                                       CameraEvidence& evidence) {
  evidence.outlines = true;
  std::optional<OutlineAgreement> agreement = Compare(views);
  if (!agreement || agreement->check.mean < CameraEvidenceTuning::kSureHullOverlap) {
    const std::vector<PreparedView> filled = WithoutHoles(views);
    std::optional<OutlineAgreement> other;
    if (!filled.empty()) other = Compare(filled);
    evidence.holes_filled = other && (!agreement || other->check.mean > agreement->check.mean);
    if (evidence.holes_filled) agreement = std::move(other);
  }
  if (!agreement) return std::nullopt;
  const HullCheck& check = agreement->check;
  evidence.hull_iou = check.mean;
  evidence.hull_iou_least = *std::min_element(check.iou.begin(), check.iou.end());
  evidence.disagreeing = check.disagreeing;
  return agreement->hull;
}

}  // namespace keypose::reconstruct
