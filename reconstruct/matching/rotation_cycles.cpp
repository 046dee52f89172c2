#include "reconstruct/matching/rotation_cycles.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <random>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

double Degrees(double radians) { return radians * 180 / 3.14159265358979; }

/// Closed and open loops of each pair.
struct Loops {
  std::vector<int> closed, open;
};

Loops CountLoops(int images, const std::vector<PairRotation>& pairs, double loop_deg) {
  const auto n = static_cast<std::size_t>(images);
  std::vector<int> at(n * n, -1);
  for (std::size_t e = 0; e < pairs.size(); ++e)
    at[static_cast<std::size_t>(pairs[e].first) * n + static_cast<std::size_t>(pairs[e].second)] =
        static_cast<int>(e);
  Loops loops{std::vector<int>(pairs.size(), 0), std::vector<int>(pairs.size(), 0)};
  for (std::size_t e = 0; e < pairs.size(); ++e) {
    const auto i = static_cast<std::size_t>(pairs[e].first),
               j = static_cast<std::size_t>(pairs[e].second);
    for (std::size_t k = j + 1; k < n; ++k) {
      const int ik = at[i * n + k], jk = at[j * n + k];
      if (ik < 0 || jk < 0) continue;
      const double off =
          Degrees(pairs[ik].rotation.angularDistance(pairs[jk].rotation * pairs[e].rotation));
      std::vector<int>& count = off < loop_deg ? loops.closed : loops.open;
      ++count[e];
      ++count[ik];
      ++count[jk];
    }
  }
  return loops;
}

/// How much each pair is worth, mostly by the share of its loops that close.
std::vector<double> Worth(const std::vector<PairRotation>& pairs, const Loops& loops) {
  constexpr double kMany = 200;  // matches
  std::vector<double> worth;
  for (std::size_t e = 0; e < pairs.size(); ++e) {
    const double share = (loops.closed[e] + 0.3) / (loops.closed[e] + loops.open[e] + 1.0);
    worth.push_back(std::pow(share, 4) *
                    std::sqrt(std::min(kMany, static_cast<double>(pairs[e].matches))));
  }
  return worth;
}

/// Indices of pairs in a random order in which those of more worth mostly come first.
/// Source: Efraimidis and Spirakis, "Weighted random sampling with a reservoir", 2006.
std::vector<std::size_t> RandomOrder(const std::vector<double>& worth, std::mt19937& random) {
  std::vector<std::pair<double, std::size_t>> keys;
  for (std::size_t e = 0; e < worth.size(); ++e) {
    const double unit = (static_cast<double>(random()) + 1) / 4294967297.0;
    keys.emplace_back(-std::log(unit) / worth[e], e);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> order;
  for (const auto& [key, e] : keys) order.push_back(e);
  return order;
}

/// One rotation for each image, along a tree of pairs.
struct Rotations {
  std::vector<Quaterniond> of_image;
  std::vector<int> component;
};

void Join(const PairRotation& pair, Rotations& rotations) {
  const int keep = rotations.component[pair.first], join = rotations.component[pair.second];
  // Turns all that hangs on the second image so that this pair agrees.
  const Quaterniond turn = rotations.of_image[pair.second].conjugate() *
                           (pair.rotation * rotations.of_image[pair.first]);
  for (std::size_t k = 0; k < rotations.of_image.size(); ++k)
    if (rotations.component[k] == join) {
      rotations.of_image[k] = rotations.of_image[k] * turn;
      rotations.component[k] = keep;
    }
}

/// @param flat  of these pairs only
void GrowTree(const std::vector<PairRotation>& pairs, const std::vector<std::size_t>& order,
              bool flat, Rotations& rotations) {
  for (const std::size_t e : order) {
    const PairRotation& pair = pairs[e];
    if (pair.flat != flat || rotations.component[pair.first] == rotations.component[pair.second])
      continue;
    Join(pair, rotations);
  }
}

Rotations NoRotations(int images) {
  Rotations rotations;
  rotations.of_image.assign(static_cast<std::size_t>(images), Quaterniond::Identity());
  rotations.component.resize(static_cast<std::size_t>(images));
  std::iota(rotations.component.begin(), rotations.component.end(), 0);
  return rotations;
}

/// How far image j is from where the pair puts it, in j's frame.
Eigen::AngleAxisd Residual(const PairRotation& pair, const std::vector<Quaterniond>& of_image) {
  return Eigen::AngleAxisd(pair.rotation * of_image[pair.first] *
                           of_image[pair.second].conjugate());
}

void Average(const std::vector<PairRotation>& pairs, int rounds,
             std::vector<Quaterniond>& of_image) {
  constexpr double kLeast = 0.02;  // radians; pairs that agree better weigh alike
  for (int round = 0; round < rounds; ++round)
    for (std::size_t image = 0; image < of_image.size(); ++image) {
      Vector3d sum = Vector3d::Zero();
      double weights = 0;
      for (const PairRotation& pair : pairs) {
        const bool is_second = pair.second == static_cast<int>(image);
        if (!is_second && pair.first != static_cast<int>(image)) continue;
        const Eigen::AngleAxisd off = Residual(pair, of_image);
        Vector3d step = off.angle() * off.axis();
        // The first image's step, in its own frame.
        if (!is_second) step = -(pair.rotation.conjugate() * step);
        const double weight = 1 / std::max(kLeast, step.norm());
        sum += weight * step;
        weights += weight;
      }
      if (weights <= 0) continue;
      const Vector3d mean = sum / weights;
      if (mean.norm() > 1e-12)
        of_image[image] =
            (Quaterniond(Eigen::AngleAxisd(mean.norm(), mean.normalized())) * of_image[image])
                .normalized();
    }
}

/// Matched rays of two photographs, z = 1.
struct Rays {
  std::vector<cv::Point2d> first, second;
};

Rays RaysOf(const Features& first, const Features& second, const Camera& camera_first,
            const Camera& camera_second, const PairMatches& pair) {
  Rays rays;
  for (const auto& [i, j] : pair.features) {
    const Vector3d x = camera_first.Unproject(first.positions.row(i).transpose().cast<double>()),
                   y = camera_second.Unproject(second.positions.row(j).transpose().cast<double>());
    rays.first.emplace_back(x.x(), x.y());
    rays.second.emplace_back(y.x(), y.y());
  }
  return rays;
}

/// By samples of five matches, for a first idea.
std::optional<Rigid3> RelativePose(const Rays& rays, double max_error) {
  constexpr double kConfidence = 0.999;
  const cv::Mat unit = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat inside, rotation, translation;
  const cv::Mat essential = cv::findEssentialMat(rays.first, rays.second, unit, cv::RANSAC,
                                                 kConfidence, max_error, inside);
  if (essential.rows != 3) return std::nullopt;
  cv::recoverPose(essential, rays.first, rays.second, unit, rotation, translation, inside);
  Eigen::Matrix3d matrix;
  Rigid3 pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix(r, c) = rotation.at<double>(r, c);
    pose.translation[r] = translation.at<double>(r, 0);
  }
  if (!matrix.allFinite() || pose.translation.norm() < 0.5) return std::nullopt;
  pose.rotation = matrix;
  return pose;
}

/// The pose turned and shifted a little; the translation has length 1.
Rigid3 Stepped(const Rigid3& pose, const Eigen::Matrix<double, 6, 1>& step) {
  const Vector3d turn = step.head<3>();
  Rigid3 out = pose;
  if (turn.norm() > 0)
    out.rotation = Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * pose.rotation;
  out.translation = (pose.translation + step.tail<3>()).normalized();
  return out;
}

/// Signed Sampson distances of the matches over the error at which they count half (Geman-McClure).
Eigen::VectorXd Residuals(const Rays& rays, const Rigid3& pose, double max_error) {
  Eigen::Matrix3d cross;
  const Vector3d& t = pose.translation;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d essential = cross * pose.rotation.toRotationMatrix();
  Eigen::VectorXd residuals(std::ssize(rays.first));
  for (Eigen::Index m = 0; m < residuals.size(); ++m) {
    const Vector3d x(rays.first[m].x, rays.first[m].y, 1), y(rays.second[m].x, rays.second[m].y, 1);
    const Vector3d line = essential * x, back = essential.transpose() * y;
    const double off = y.dot(line) / std::sqrt(line.head<2>().squaredNorm() +
                                               back.head<2>().squaredNorm() + 1e-300);
    residuals[m] = off / std::sqrt(max_error * max_error + off * off);
  }
  return residuals;
}

/// Least squares of the distances, from a minimal sample's pose, which its noise moves by degrees.
Rigid3 Polished(const Rays& rays, Rigid3 pose, double max_error) {
  constexpr int kSteps = 30;
  constexpr double kSmall = 1e-6;
  double damping = 1e-4;
  Eigen::VectorXd residuals = Residuals(rays, pose, max_error);
  for (int k = 0; k < kSteps && damping < 1e4; ++k) {
    Eigen::MatrixXd jacobian(residuals.size(), 6);
    for (int c = 0; c < 6; ++c)
      jacobian.col(c) =
          (Residuals(rays, Stepped(pose, kSmall * Eigen::Matrix<double, 6, 1>::Unit(c)),
                     max_error) -
           residuals) /
          kSmall;
    Eigen::Matrix<double, 6, 6> normal = jacobian.transpose() * jacobian;
    normal.diagonal() *= 1 + damping;
    normal.diagonal().array() += 1e-12 * normal.trace();
    const Rigid3 next = Stepped(pose, -normal.ldlt().solve(jacobian.transpose() * residuals));
    const Eigen::VectorXd then = Residuals(rays, next, max_error);
    if (then.squaredNorm() >= residuals.squaredNorm()) {
      damping *= 10;
      continue;
    }
    pose = next;
    residuals = then;
    damping /= 5;
  }
  return pose;
}

bool Agrees(const PairRotation& pair, const std::vector<Quaterniond>& of_image,
            const RotationCycleOptions& options) {
  return Degrees(Residual(pair, of_image).angle()) < options.apart_deg;
}

/// Rotations that a tree of pairs gives, a little averaged.
struct Candidate {
  std::vector<Quaterniond> of_image;
  std::vector<char> counts;  ///< by pair: it has depth, or joins parts that no such pair does
  std::vector<PairRotation> counted;
  int agreeing = 0;  ///< pairs
};

Candidate Try(int images, const std::vector<PairRotation>& pairs,
              const std::vector<std::size_t>& order, const RotationCycleOptions& options) {
  constexpr int kRounds = 6;
  Rotations rotations = NoRotations(images);
  GrowTree(pairs, order, false, rotations);
  const std::vector<int> with_depth = rotations.component;
  GrowTree(pairs, order, true, rotations);
  Candidate candidate;
  candidate.of_image = std::move(rotations.of_image);
  for (const PairRotation& pair : pairs) {
    candidate.counts.push_back(!pair.flat || with_depth[pair.first] != with_depth[pair.second]);
    if (candidate.counts.back()) candidate.counted.push_back(pair);
  }
  Average(candidate.counted, kRounds, candidate.of_image);
  for (const PairRotation& pair : candidate.counted)
    candidate.agreeing += Agrees(pair, candidate.of_image, options);
  return candidate;
}

}  // namespace

std::optional<PairRotation> RotationOf(const Features& first, const Features& second,
                                       const Camera& camera_first, const Camera& camera_second,
                                       const PairMatches& pair, double max_error_px) {
  const Rays rays = RaysOf(first, second, camera_first, camera_second, pair);
  const auto start = RelativePose(rays, max_error_px / camera_first.fx);
  if (!start) return std::nullopt;
  const Rigid3 pose = Polished(rays, *start, max_error_px / camera_first.fx);
  return PairRotation{pair.first, pair.second, pose.rotation.normalized(), SizeOf(pair.features)};
}

std::vector<char> AgreeInRotation(int images, const std::vector<PairRotation>& pairs,
                                  const RotationCycleOptions& options) {
  const std::vector<double> worth = Worth(pairs, CountLoops(images, pairs, options.loop_deg));
  std::mt19937 random(1);
  std::vector<char> best(pairs.size(), 0);
  int most = -1;
  std::vector<Quaterniond> rotations;
  std::vector<PairRotation> counted;
  for (int tree = 0; tree < options.trees; ++tree) {
    Candidate candidate = Try(images, pairs, RandomOrder(worth, random), options);
    if (candidate.agreeing <= most) continue;
    most = candidate.agreeing;
    rotations = std::move(candidate.of_image);
    counted = std::move(candidate.counted);
    best = std::move(candidate.counts);
  }
  Average(counted, options.rounds, rotations);
  for (std::size_t e = 0; e < pairs.size(); ++e)
    best[e] = best[e] && Agrees(pairs[e], rotations, options);
  return best;
}

int LeaveOutContradictedTurns(const std::vector<Features>& features,
                              const std::vector<Camera>& lens, const std::vector<char>& flat,
                              double max_error_px, const RotationCycleOptions& options,
                              std::vector<Verified>& verified) {
  std::vector<std::optional<PairRotation>> found(verified.size());
  ParallelFor(std::ssize(verified), [&](std::int64_t k) {
    const PairMatches& pair = verified[k].inliers;
    found[k] = RotationOf(features[pair.first], features[pair.second], lens[pair.first],
                          lens[pair.second], pair, max_error_px);
    if (found[k]) found[k]->flat = flat[k] != 0;
  });
  std::vector<PairRotation> pairs;
  for (const auto& rotation : found)
    if (rotation) pairs.push_back(*rotation);
  const std::vector<char> agree = AgreeInRotation(SizeOf(features), pairs, options);
  std::size_t k = 0, e = 0;
  return static_cast<int>(std::erase_if(
      verified, [&](const Verified&) { return found[k++] ? agree[e++] == 0 : true; }));
}

}  // namespace keypose::reconstruct
