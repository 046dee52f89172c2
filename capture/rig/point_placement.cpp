#include "capture/rig/point_placement.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "core/numbers/rotations.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLeastClicks = 4, kLeastWithoutLens = 6;
constexpr double kWrong = 0.006;         // of the picture's longer side
constexpr double kWrongOverOthers = 4;   // times the rms of the other clicks
constexpr double kMostFocalError = 0.1;  // relative standard deviation
constexpr int kRefined = 4;              // places that are adjusted before one is taken

double LimitOf(const Camera& lens) { return kWrong * std::max(lens.width, lens.height); }

/// One click, with focal length, rotation vector and translation free.
struct ClickResidual {
  Camera lens;
  Vector3d point;
  Vector2d pixel;

  template <class T>
  bool operator()(const T* focal, const T* camera, T* error) const {
    const T x[3] = {T(point.x()), T(point.y()), T(point.z())};
    T seen[3];
    ceres::AngleAxisRotatePoint(camera, x, seen);
    for (int i = 0; i < 3; ++i) seen[i] += camera[3 + i];
    const T u = seen[0] / seen[2], v = seen[1] / seen[2], r2 = u * u + v * v;
    const T radial = T(1) + r2 * (T(lens.k1) + r2 * T(lens.k2));
    const T du = T(2 * lens.p1) * u * v + T(lens.p2) * (r2 + T(2) * u * u);
    const T dv = T(lens.p1) * (r2 + T(2) * v * v) + T(2 * lens.p2) * u * v;
    error[0] = focal[0] * T(lens.fx) * (radial * u + du) + T(lens.cx - pixel.x());
    error[1] = focal[0] * T(lens.fy) * (radial * v + dv) + T(lens.cy - pixel.y());
    return true;
  }
};

/// A place, and a factor on the lens's focal length.
struct Guess {
  std::array<double, 6> motion{};  // rotation vector, translation
  double focal = 1;
  double cost = 1e300;  // squared errors, each at most that of the limit
};

class Placer {
 public:
  Placer(const ClickedPicture& camera, const std::optional<Camera>& lens,
         const std::vector<KnownPoint>& points)
      : camera_(camera), points_(points), estimate_(!lens) {
    if (lens) lens_ = *lens;
    lens_.width = camera.width;
    lens_.height = camera.height;
    if (!estimate_) return;
    lens_.fx = lens_.fy = std::max(camera.width, camera.height);
    lens_.cx = camera.width / 2.0;
    lens_.cy = camera.height / 2.0;
  }

  PlacedCamera Place() {
    Check();
    std::vector<Guess> guesses = Guesses();
    if (guesses.empty())
      throw InputError(fmt::format(
          "calibrate: no place of camera {} explains three of its clicks; compare their names with "
          "the points, and the picture's size with its lens",
          camera_.camera));
    for (Guess& guess : guesses) Refine(&guess);
    Guess best = *std::min_element(guesses.begin(), guesses.end(), Less);
    SettleWrong(&best);
    return Report(best);
  }

 private:
  static bool Less(const Guess& a, const Guess& b) { return a.cost < b.cost; }

  void Check() const {
    const int least = estimate_ ? kLeastWithoutLens : kLeastClicks;
    if (SizeOf(camera_.clicks) < least)
      throw InputError(
          fmt::format("calibrate: camera {} has {} clicks; {} are needed{}, eight all over its "
                      "picture are good",
                      camera_.camera, camera_.clicks.size(), least,
                      estimate_ ? " without board pictures of its lens (--lenses)" : ""));
    Eigen::MatrixXd places(SizeOf(camera_.clicks), 3);
    for (int i = 0; i < SizeOf(camera_.clicks); ++i)
      places.row(i) = points_[camera_.clicks[i].point].place.transpose();
    places.rowwise() -= places.colwise().mean().eval();
    const Vector3d spread = places.jacobiSvd().singularValues();
    if (spread[1] < 1e-3 * spread[0])
      throw InputError(fmt::format(
          "calibrate: the points clicked in camera {} lie on a line, which tells no place; click "
          "some beside it",
          camera_.camera));
  }

  Camera LensOf(double focal) const {
    Camera lens = lens_;
    lens.fx *= focal;
    lens.fy *= focal;
    return lens;
  }
  static View ViewOf(const Camera& lens, const Guess& guess) {
    View view;
    view.camera = lens;
    const auto& m = guess.motion;
    view.camera_from_world = {QuaternionOf({m[0], m[1], m[2]}), {m[3], m[4], m[5]}};
    return view;
  }
  double ErrorOf(const View& view, int click) const {
    const Vector3d x = view.camera_from_world * points_[camera_.clicks[click].point].place;
    if (x.z() <= 1e-6) return 1e6;
    return (view.camera.Project(x) - camera_.clicks[click].pixel).norm();
  }
  double CostOf(const Guess& guess) const {
    const View view = ViewOf(LensOf(guess.focal), guess);
    double sum = 0;
    for (int i = 0; i < SizeOf(camera_.clicks); ++i)
      sum += std::pow(std::min(ErrorOf(view, i), LimitOf(lens_)), 2);
    return sum;
  }

  /// The best places of all triples of clicks, for each focal length.
  std::vector<Guess> Guesses() const {
    constexpr double kLowest = 0.45, kHighest = 4, kStep = 1.1;
    std::vector<Guess> guesses;
    if (!estimate_) AddGuesses(1, &guesses);
    for (double f = kLowest; estimate_ && f < kHighest; f *= kStep) AddGuesses(f, &guesses);
    std::sort(guesses.begin(), guesses.end(), Less);
    if (SizeOf(guesses) > kRefined) guesses.resize(kRefined);
    return guesses;
  }
  void AddGuesses(double focal, std::vector<Guess>* guesses) const {
    constexpr int kMostClicks = 14;  // 364 triples
    const Camera lens = LensOf(focal);
    const int count = std::min(kMostClicks, SizeOf(camera_.clicks));
    std::vector<cv::Point2d> rays;
    for (int i = 0; i < count; ++i) {
      const Vector3d ray = lens.Unproject(camera_.clicks[i].pixel);
      rays.emplace_back(ray.x(), ray.y());
    }
    for (int i = 0; i < count; ++i)
      for (int j = i + 1; j < count; ++j)
        for (int k = j + 1; k < count; ++k) AddTriple({i, j, k}, rays, focal, guesses);
  }
  void AddTriple(const std::array<int, 3>& clicks, const std::vector<cv::Point2d>& rays,
                 double focal, std::vector<Guess>* guesses) const {
    std::vector<cv::Point3d> places;
    std::vector<cv::Point2d> seen;
    for (const int i : clicks) {
      const Vector3d& x = points_[camera_.clicks[i].point].place;
      places.emplace_back(x.x(), x.y(), x.z());
      seen.push_back(rays[i]);
    }
    const cv::Point3d a = places[1] - places[0], b = places[2] - places[0];
    if (cv::norm(a.cross(b)) < 1e-4 * cv::norm(a) * cv::norm(b) + 1e-12) return;
    std::vector<cv::Mat> rotations, translations;
    cv::solveP3P(places, seen, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations, translations,
                 cv::SOLVEPNP_AP3P);
    for (std::size_t s = 0; s < rotations.size(); ++s) {
      Guess guess;
      for (int i = 0; i < 3; ++i) {
        guess.motion[i] = rotations[s].at<double>(i);
        guess.motion[3 + i] = translations[s].at<double>(i);
      }
      guess.focal = focal;
      if (!std::all_of(guess.motion.begin(), guess.motion.end(),
                       [](double x) { return std::isfinite(x); }))
        continue;
      guess.cost = CostOf(guess);
      Keep(guess, guesses);
    }
  }
  /// The best guesses only, so that a series of focal lengths does not pile them up.
  static void Keep(const Guess& guess, std::vector<Guess>* guesses) {
    constexpr std::size_t kMost = 40;
    if (guesses->size() < kMost) return guesses->push_back(guess);
    const auto worst = std::max_element(guesses->begin(), guesses->end(), Less);
    if (guess.cost < worst->cost) *worst = guess;
  }

  /// Least squares over the clicks within the limit.
  void Refine(Guess* guess) const {
    for (int round = 0; round < 3; ++round) {
      const View view = ViewOf(LensOf(guess->focal), *guess);
      std::vector<bool> used;
      for (int i = 0; i < SizeOf(camera_.clicks); ++i)
        used.push_back(ErrorOf(view, i) < 2 * LimitOf(lens_));
      Solve(used, guess);
    }
    guess->cost = CostOf(*guess);
  }
  void Solve(const std::vector<bool>& used, Guess* guess) const {
    if (std::count(used.begin(), used.end(), true) < (estimate_ ? 4 : 3)) return;
    ceres::Problem problem;
    for (int i = 0; i < SizeOf(camera_.clicks); ++i)
      if (used[i])
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<ClickResidual, 2, 1, 6>(new ClickResidual{
                lens_, points_[camera_.clicks[i].point].place, camera_.clicks[i].pixel}),
            nullptr, &guess->focal, guess->motion.data());
    if (!estimate_) problem.SetParameterBlockConstant(&guess->focal);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 60;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
  }

  /// Adjusts to the clicks that agree, and takes in those that agree then.
  void SettleWrong(Guess* best) {
    constexpr int kRounds = 10;
    for (int round = 0; round < kRounds; ++round) {
      const View view = ViewOf(LensOf(best->focal), *best);
      const double others = used_.empty() ? 0 : RmsOf(*best, used_);
      const double most = std::max(LimitOf(lens_), kWrongOverOthers * others);
      std::vector<bool> used;
      for (int i = 0; i < SizeOf(camera_.clicks); ++i) used.push_back(ErrorOf(view, i) <= most);
      if (std::count(used.begin(), used.end(), true) < kLeastClicks)
        used.assign(camera_.clicks.size(), true);  // none agree; the error will say so
      if (used == used_) return;
      used_ = used;
      Solve(used_, best);
    }
  }
  double RmsOf(const Guess& guess, const std::vector<bool>& used) const {
    const View view = ViewOf(LensOf(guess.focal), guess);
    double sum = 0;
    int count = 0;
    for (int i = 0; i < SizeOf(used); ++i)
      if (used[i]) {
        sum += std::pow(ErrorOf(view, i), 2);
        ++count;
      }
    return std::sqrt(sum / std::max(1, count));
  }

  PlacedCamera Report(const Guess& best) const {
    PlacedCamera placed;
    placed.view = ViewOf(LensOf(best.focal), best);
    placed.view.name = camera_.camera;
    placed.rms_px = RmsOf(best, used_);
    for (int i = 0; i < SizeOf(camera_.clicks); ++i) {
      ClickError error;
      error.point = camera_.clicks[i].point;
      error.expected = placed.view.Project(points_[error.point].place);
      error.px = ErrorOf(placed.view, i);
      error.wrong = !used_[i];
      placed.clicks.push_back(error);
    }
    FindErrors(best, &placed);
    if (placed.rms_px > 2 * LimitOf(lens_))
      throw InputError(
          fmt::format("calibrate: the clicks of camera {} agree with no place: they miss it by "
                      "{:.0f} pixels in "
                      "the mean; compare their names with the points, and the points' places",
                      camera_.camera, placed.rms_px));
    if (placed.focal_error > kMostFocalError)
      throw InputError(fmt::format(
          "calibrate: the points clicked in camera {} do not tell its focal length (+-{:.0f} %): "
          "give board pictures of its lens (--lenses), or click points at other heights and "
          "distances",
          camera_.camera, 100 * placed.focal_error));
    return placed;
  }

  /// Standard deviations from the clicks' own errors, a pixel at least.
  void FindErrors(const Guess& best, PlacedCamera* placed) const {
    const int unknowns = estimate_ ? 7 : 6;
    std::vector<int> used;
    for (int i = 0; i < SizeOf(used_); ++i)
      if (used_[i]) used.push_back(i);
    const auto stacked = [&](const Eigen::VectorXd& step) {
      Guess guess = best;
      for (int i = 0; i < 6; ++i) guess.motion[i] += step[i];
      if (estimate_) guess.focal *= 1 + step[6];
      const View view = ViewOf(LensOf(guess.focal), guess);
      Eigen::VectorXd pixels(2 * SizeOf(used));
      for (int i = 0; i < SizeOf(used); ++i)
        pixels.segment<2>(2 * i) = view.Project(points_[camera_.clicks[used[i]].point].place);
      return pixels;
    };
    const auto centre = [&](const Eigen::VectorXd& step) {
      Guess guess = best;
      for (int i = 0; i < 6; ++i) guess.motion[i] += step[i];
      return ViewOf(lens_, guess).Center();
    };
    constexpr double kStep = 1e-6;
    Eigen::MatrixXd jacobian(2 * SizeOf(used), unknowns), moves(3, unknowns);
    for (int i = 0; i < unknowns; ++i) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(unknowns, i);
      jacobian.col(i) = (stacked(step) - stacked(-step)) / (2 * kStep);
      moves.col(i) = (centre(step) - centre(-step)) / (2 * kStep);
    }
    const int free = std::max(1, 2 * SizeOf(used) - unknowns);
    const double sigma =
        std::max(1.0, placed->rms_px * std::sqrt(static_cast<double>(SizeOf(used)) / free));
    const Eigen::MatrixXd covariance =
        sigma * sigma *
        (jacobian.transpose() * jacobian).completeOrthogonalDecomposition().pseudoInverse();
    placed->place_error_m = std::sqrt((moves * covariance * moves.transpose()).trace());
    if (estimate_) placed->focal_error = std::sqrt(covariance(6, 6));
  }

  const ClickedPicture& camera_;
  const std::vector<KnownPoint>& points_;
  bool estimate_;
  Camera lens_;
  std::vector<bool> used_;
};

}  // namespace

PlacedCamera PlaceCamera(const ClickedPicture& camera, const std::optional<Camera>& lens,
                         const std::vector<KnownPoint>& points) {
  return Placer(camera, lens, points).Place();
}

std::vector<SeenPoint> SeePoints(const std::vector<ClickedPicture>& cameras,
                                 const std::vector<PlacedCamera>& placed,
                                 const std::vector<KnownPoint>& points) {
  std::vector<SeenPoint> seen;
  for (int p = 0; p < SizeOf(points); ++p) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    int count = 0;
    for (int c = 0; c < SizeOf(cameras); ++c)
      for (int i = 0; i < SizeOf(cameras[c].clicks); ++i) {
        if (placed[c].clicks[i].point != p || placed[c].clicks[i].wrong) continue;
        const View& view = placed[c].view;
        const Vector3d ray = (view.camera_from_world.rotation.conjugate() *
                              view.camera.Unproject(cameras[c].clicks[i].pixel))
                                 .normalized();
        const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
        sum += across;
        right += across * view.Center();
        ++count;
      }
    if (count < 2) continue;
    SeenPoint point;
    point.point = p;
    point.seen = sum.ldlt().solve(right);
    point.cameras = count;
    point.apart_m = (point.seen - points[p].place).norm();
    seen.push_back(point);
  }
  return seen;
}

}  // namespace keypose::capture
