#include "capture/agreement/space_grid.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>

#include "capture/pictures/cv_image.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct SharedSpaceTuning {
  KEYPOSE_TUNED(double, kRoom, 1.5);  ///< half the space's side, over half the masks' diagonal
};

constexpr std::uint8_t kHidden = 2;

/// Pixels that show something else, behind which anything may be.
void MarkHidden(const Image8& hidden, const Image8& mask, Image8& contradicted) {
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y) <= 127 &&
          *hidden.at(x * hidden.width / mask.width, y * hidden.height / mask.height) > 127)
        *contradicted.at(x, y) = kHidden;
}

/// The point where the rays through the masks' centroids meet, and the masks' extent around it.
struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;
};

Ball FigureBall(const std::vector<View>& views, const std::vector<Image8>& masks,
                const std::vector<MaskSampler>& samplers) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Identity() * 1e-12;
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  std::vector<std::pair<std::size_t, double>> extents;  // view, half its mask's diagonal over fx
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!samplers[i].inlier) continue;
    const cv::Moments moments = cv::moments(MatOf(masks[i]), true);
    if (moments.m00 <= 0) continue;
    const Eigen::Vector2d middle(moments.m10 / moments.m00 + 0.5, moments.m01 / moments.m00 + 0.5);
    const Eigen::Vector3d ray = views[i].camera_from_world.rotation.conjugate() *
                                views[i].camera.Unproject(middle).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    a += across;
    b += across * views[i].Center();
    const cv::Rect box = cv::boundingRect(MatOf(masks[i]));
    extents.emplace_back(i, 0.5 * std::hypot(box.width, box.height) / views[i].camera.fx);
  }
  Ball ball;
  ball.center = a.ldlt().solve(b);
  std::vector<double> reach;
  for (const auto& [i, extent] : extents)
    reach.push_back(extent * std::max(0.0, (views[i].camera_from_world * ball.center).z()));
  if (reach.empty()) return ball;
  // A quantile, so that a few masks that include half the room do not enlarge the space.
  ball.radius = SharedSpaceTuning::kRoom * QuantileAbove(std::move(reach), 0.75);
  return ball;
}

/// Counts contradictions in every voxel; below the floor all views contradict. Views far apart come
/// first, because they decide most voxels early.
void Count(const std::vector<MaskSampler>& all, int most, const SpaceOptions& options, Grid& grid) {
  std::vector<const MaskSampler*> samplers;
  for (const MaskSampler& sampler : all)
    if (sampler.inlier) samplers.push_back(&sampler);
  const std::size_t n = samplers.size();
  const auto share = static_cast<std::size_t>(options.least_seen * static_cast<double>(n) + 1e-9);
  const std::size_t least_seen = std::max<std::size_t>(2, share);
  std::size_t step = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(0.382 * static_cast<double>(n))));
  while (std::gcd(step, n) != 1) ++step;
  grid.contradictions.assign(static_cast<std::size_t>(grid.size.prod()), 0);
  ParallelFor(grid.size.z(), [&](std::int64_t slice) {
    const int z = static_cast<int>(slice);
    for (int y = 0; y < grid.size.y(); ++y)
      for (int x = 0; x < grid.size.x(); ++x) {
        const Eigen::Vector3d center = grid.Center(x, y, z);
        if (center.z() < options.floor) {
          grid.contradictions[grid.At(x, y, z)] = static_cast<std::uint8_t>(most + 1);
          continue;
        }
        Eigen::Vector3d pixel;
        std::size_t seen = 0;
        int contradictions = 0;
        for (std::size_t k = 0; k < n && contradictions <= most; ++k) {
          const MaskSample sample = samplers[k * step % n]->At(center, &pixel);
          seen += sample != MaskSample::kUnseen;
          contradictions += sample == MaskSample::kContradicted;
        }
        // One more than the limit, so that a voxel stays contradicted after a view subtracts its
        // own sample.
        grid.contradictions[grid.At(x, y, z)] = static_cast<std::uint8_t>(
            seen < least_seen ? most + 1 : std::min(contradictions, most + 1));
      }
  });
}

}  // namespace

MaskSample MaskSampler::At(const Eigen::Vector3d& x_in_world, Eigen::Vector3d* pixel) const {
  const Eigen::Vector3d x = view->camera_from_world * x_in_world;
  if (x.z() <= 0) return MaskSample::kUnseen;
  const Eigen::Vector2d p = view->camera.Project(x);
  const int px = static_cast<int>(std::floor(p.x())), py = static_cast<int>(std::floor(p.y()));
  if (px < 0 || py < 0 || px >= contradicted.width || py >= contradicted.height)
    return MaskSample::kUnseen;
  const std::uint8_t value = *contradicted.at(px, py);
  if (value == kHidden) return MaskSample::kUnseen;
  *pixel = {p.x(), p.y(), x.z()};
  return value ? MaskSample::kContradicted : MaskSample::kConsistent;
}

std::vector<MaskSampler> MaskSamplersOf(const std::vector<View>& views,
                                        const std::vector<Image8>& masks,
                                        const SpaceOptions& options,
                                        const std::vector<char>& inlier) {
  std::vector<MaskSampler> samplers(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    cv::Mat distance;
    cv::distanceTransform(MatOf(masks[i]) == 0, distance, cv::DIST_L2, 3);
    samplers[i].view = &views[i];
    samplers[i].inlier = inlier.empty() || inlier[i];
    samplers[i].contradicted = Image8(masks[i].width, masks[i].height, 1, 0);
    for (int y = 0; y < distance.rows; ++y)
      for (int x = 0; x < distance.cols; ++x)
        *samplers[i].contradicted.at(x, y) = distance.at<float>(y, x) > options.margin_px;
    if (i < options.hidden.size() && !options.hidden[i].empty())
      MarkHidden(options.hidden[i], masks[i], samplers[i].contradicted);
  });
  return samplers;
}

std::pair<Eigen::Vector3i, Eigen::Vector3i> BoundsOf(const Grid& grid, int contradictions) {
  Eigen::Vector3i low = grid.size, high = Eigen::Vector3i::Constant(-1);
  for (int z = 0; z < grid.size.z(); ++z)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int x = 0; x < grid.size.x(); ++x) {
        if (grid.contradictions[grid.At(x, y, z)] >= contradictions) continue;
        low = low.cwiseMin(Eigen::Vector3i(x, y, z));
        high = high.cwiseMax(Eigen::Vector3i(x, y, z));
      }
  return {low, high};
}

Grid SharedSpace(const std::vector<View>& views, const std::vector<Image8>& masks,
                 const std::vector<MaskSampler>& samplers, const SpaceOptions& options,
                 int told_apart) {
  const Ball ball = FigureBall(views, masks, samplers);
  Grid grid{ball.center - Eigen::Vector3d::Constant(ball.radius),
            2 * ball.radius / 48,
            Eigen::Vector3i::Constant(48),
            {}};
  const char* nothing =
      "the masks have no common space: they or the cameras are wrong; look at the masks and at the "
      "picture of the cameras";
  if (!(ball.radius > 0) || !std::isfinite(ball.radius) || !ball.center.allFinite())
    throw InputError(std::string("masks: ") + nothing);
  Count(samplers, options.most_contradictions, options, grid);
  const auto [low, high] = BoundsOf(grid, options.most_contradictions);
  if (high.x() < 0) throw InputError(std::string("masks: ") + nothing);
  const Eigen::Vector3d extent =
      grid.cell * (high - low + Eigen::Vector3i::Constant(3)).cast<double>();
  Grid fine;
  fine.low = grid.low + grid.cell * (low.cast<double>() - Eigen::Vector3d::Ones());
  fine.cell = extent.maxCoeff() / options.resolution;
  fine.size = (extent / fine.cell).array().ceil().cast<int>().max(1);
  Count(samplers, told_apart, options, fine);
  return fine;
}

int LongestSide(const Grid& grid) {
  const auto [low, high] = BoundsOf(grid, 1);
  return std::max(1, (high - low).maxCoeff() + 1);
}

int ChordOf(const MaskSampler& sampler, int x, int y, const Grid& grid, bool others_only) {
  const View& view = *sampler.view;
  const Eigen::Vector3d from = (view.Center() - grid.low) / grid.cell;
  const Eigen::Vector3d middle = 0.5 * grid.size.cast<double>();
  const Eigen::Vector3d ray =
      (view.camera_from_world.rotation.conjugate() * view.camera.Unproject({x + 0.5, y + 0.5}))
          .normalized();
  const double nearest = ray.dot(middle - from), reach = grid.size.cast<double>().norm() / 2;
  int count = 0;
  for (double t = nearest - reach; t < nearest + reach; t += 1) {
    const Eigen::Vector3i at = (from + t * ray).array().floor().cast<int>();
    if ((at.array() < 0).any() || (at.array() >= grid.size.array()).any()) continue;
    int contradictions = grid.contradictions[grid.At(at.x(), at.y(), at.z())];
    Eigen::Vector3d pixel;
    if (contradictions > 0 && others_only && sampler.inlier &&
        sampler.At(grid.Center(at.x(), at.y(), at.z()), &pixel) == MaskSample::kContradicted)
      --contradictions;
    count += contradictions == 0;
  }
  return count;
}

}  // namespace keypose::capture
