#include "capture/rig/lens_calibration.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <set>

#include "core/numbers/rotations.h"
#include "core/numbers/statistics.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

constexpr int kGridX = 8, kGridY = 6;
constexpr int kLeastBoards = 5;

std::vector<cv::Point3f> PointsOf(const BoardSighting& s, const BoardLayout& board) {
  std::vector<cv::Point3f> points;
  for (const BoardCorner& c : s.corners) {
    const Eigen::Vector3d x = board.Corner(c.id);
    points.emplace_back(static_cast<float>(x.x()), static_cast<float>(x.y()),
                        static_cast<float>(x.z()));
  }
  return points;
}

std::vector<cv::Point2f> PixelsOf(const BoardSighting& s) {
  std::vector<cv::Point2f> pixels;  // OpenCV's pixel centres are whole numbers
  for (const BoardCorner& c : s.corners)
    pixels.emplace_back(static_cast<float>(c.pixel.x() - 0.5),
                        static_cast<float>(c.pixel.y() - 0.5));
  return pixels;
}

/// Sightings spread evenly over those of a camera.
std::vector<const BoardSighting*> Spread(const std::vector<const BoardSighting*>& all, int most) {
  if (SizeOf(all) <= most) return all;
  std::vector<const BoardSighting*> some;
  for (int i = 0; i < most; ++i)
    some.push_back(all[static_cast<std::size_t>(i) * all.size() / most]);
  return some;
}

struct Fitted {
  Camera camera;
  std::vector<double> rms_px;  // of each board
};

Fitted FitLens(const std::vector<const BoardSighting*>& sightings, const RigCamera& size,
               const BoardLayout& board) {
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardSighting* s : sightings) {
    points.push_back(PointsOf(*s, board));
    pixels.push_back(PixelsOf(*s));
  }
  cv::Mat k = cv::Mat::eye(3, 3, CV_64F), d = cv::Mat::zeros(1, 5, CV_64F);
  std::vector<cv::Mat> r, t;
  std::vector<double> errors;
  cv::calibrateCamera(points, pixels, {size.width, size.height}, k, d, r, t, cv::noArray(),
                      cv::noArray(), errors, cv::CALIB_FIX_K3);
  Fitted fitted;
  Camera& camera = fitted.camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = k.at<double>(0, 0);
  camera.fy = k.at<double>(1, 1);
  camera.cx = k.at<double>(0, 2) + 0.5;
  camera.cy = k.at<double>(1, 2) + 0.5;
  camera.k1 = d.at<double>(0);
  camera.k2 = d.at<double>(1);
  camera.p1 = d.at<double>(2);
  camera.p2 = d.at<double>(3);
  fitted.rms_px = errors;
  return fitted;
}

/// Boards that the lens explains.
std::vector<const BoardSighting*> Explained(const std::vector<const BoardSighting*>& sightings,
                                            const std::vector<double>& rms_px) {
  constexpr double kMost_px = 1, kOverMedian = 3;
  const double most = std::max(kMost_px, kOverMedian * UpperMedian(rms_px));
  std::vector<const BoardSighting*> kept;
  for (int i = 0; i < SizeOf(sightings); ++i)
    if (rms_px[i] <= most) kept.push_back(sightings[i]);
  return kept;
}

}  // namespace

double CornerCoverage(const std::vector<BoardSighting>& sightings, int camera,
                      const RigCamera& size) {
  std::set<int> cells;
  for (const BoardSighting& s : sightings) {
    if (s.camera != camera) continue;
    for (const BoardCorner& corner : s.corners) {
      const int x = static_cast<int>(corner.pixel.x() * kGridX / size.width);
      const int y = static_cast<int>(corner.pixel.y() * kGridY / size.height);
      cells.insert(std::clamp(y, 0, kGridY - 1) * kGridX + std::clamp(x, 0, kGridX - 1));
    }
  }
  return static_cast<double>(cells.size()) / (kGridX * kGridY);
}

CalibratedLens CalibrateLens(const std::vector<BoardSighting>& sightings, int camera,
                             const RigCamera& size, const BoardLayout& board, int most) {
  std::vector<const BoardSighting*> own;
  for (const BoardSighting& s : sightings)
    if (s.camera == camera) own.push_back(&s);
  if (SizeOf(own) < kLeastBoards)
    throw InputError("calibrate: camera " + size.name + " saw the board in only " +
                     std::to_string(own.size()) + " frames; at least " +
                     std::to_string(kLeastBoards) +
                     " are needed, 30 at changing distances and tilts are good");
  std::vector<const BoardSighting*> used = Spread(own, most);
  Fitted fitted = FitLens(used, size, board);
  CalibratedLens lens;
  const std::vector<const BoardSighting*> kept = Explained(used, fitted.rms_px);
  if (kept.size() < used.size() && SizeOf(kept) >= kLeastBoards) {
    lens.left_out = SizeOf(used) - SizeOf(kept);
    used = kept;
    fitted = FitLens(used, size, board);
  }
  lens.camera = fitted.camera;
  for (int i = 0; i < SizeOf(used); ++i) {
    const int corners = SizeOf(used[i]->corners);
    lens.rms_px += fitted.rms_px[i] * fitted.rms_px[i] * corners;
    lens.worst_px = std::max(lens.worst_px, fitted.rms_px[i]);
    lens.corners += corners;
    ++lens.boards;
  }
  lens.rms_px = std::sqrt(lens.rms_px / lens.corners);
  lens.coverage = CornerCoverage(sightings, camera, size);
  return lens;
}

Rigid3 BoardPose(const BoardSighting& s, const Camera& camera, const BoardLayout& board) {
  const cv::Mat k = (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx - 0.5, 0, camera.fy,
                     camera.cy - 0.5, 0, 0, 1);
  const cv::Mat d = (cv::Mat_<double>(1, 4) << camera.k1, camera.k2, camera.p1, camera.p2);
  cv::Mat r, t;
  cv::solvePnP(PointsOf(s, board), PixelsOf(s), k, d, r, t);
  const auto at = [](const cv::Mat& m) {
    return Eigen::Vector3d(m.at<double>(0), m.at<double>(1), m.at<double>(2));
  };
  return {QuaternionOf(at(r)), at(t)};
}

}  // namespace keypose::capture
