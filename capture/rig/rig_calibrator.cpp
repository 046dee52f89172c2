#include "capture/rig/rig_calibrator.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <set>

#include "capture/rig/rig_adjustment.h"
#include "core/errors.h"
#include "core/rotations.h"
#include "core/size_of.h"

namespace keypose::capture {
namespace {

constexpr int kGridX = 8, kGridY = 6;
constexpr int kLeastBoards = 5;  // for a lens

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

Camera LensOf(const std::vector<const BoardSighting*>& sightings, const RigCamera& size,
              const BoardLayout& board, int most) {
  if (SizeOf(sightings) < kLeastBoards)
    throw InputError("calibrate: camera " + size.name + " saw the board in only " +
                     std::to_string(sightings.size()) + " frames; at least " +
                     std::to_string(kLeastBoards) +
                     " are needed, 30 at changing distances and tilts are good");
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardSighting* s : Spread(sightings, most))
    points.push_back(PointsOf(*s, board)), pixels.push_back(PixelsOf(*s));
  cv::Mat k = cv::Mat::eye(3, 3, CV_64F), d = cv::Mat::zeros(1, 5, CV_64F);
  std::vector<cv::Mat> r, t;
  cv::calibrateCamera(points, pixels, {size.width, size.height}, k, d, r, t, cv::CALIB_FIX_K3);
  Camera camera;
  camera.width = size.width, camera.height = size.height;
  camera.fx = k.at<double>(0, 0), camera.fy = k.at<double>(1, 1);
  camera.cx = k.at<double>(0, 2) + 0.5, camera.cy = k.at<double>(1, 2) + 0.5;
  camera.k1 = d.at<double>(0), camera.k2 = d.at<double>(1), camera.p1 = d.at<double>(2),
  camera.p2 = d.at<double>(3);
  return camera;
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

/// Boards as each camera sees them: [camera][frame].
using BoardPoses = std::vector<std::map<int, Rigid3>>;

/// One camera from another, by boards that both saw: the one that the others differ least from.
std::optional<Rigid3> Between(const std::map<int, Rigid3>& a, const std::map<int, Rigid3>& b) {
  std::vector<Rigid3> all;
  for (const auto& [frame, board] : a)
    if (const auto other = b.find(frame); other != b.end())
      all.push_back(Compose(other->second, board.Inverse()));
  if (all.empty()) return {};
  const auto apart = [](const Rigid3& x, const Rigid3& y) {
    return std::min(0.5, x.rotation.angularDistance(y.rotation)) +
           std::min(0.5, (x.translation - y.translation).norm());
  };
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t i = 0; i < all.size(); ++i) {
    double sum = 0;
    for (const Rigid3& other : all) sum += apart(all[i], other);
    if (sum < least) least = sum, best = i;
  }
  return all[best];
}

int Shared(const std::map<int, Rigid3>& a, const std::map<int, Rigid3>& b) {
  return static_cast<int>(
      std::count_if(a.begin(), a.end(), [&](const auto& item) { return b.count(item.first) > 0; }));
}

/// Joins cameras, each to the placed one that it shares most boards with.
void PlaceCameras(const BoardPoses& boards, std::vector<View>* views) {
  std::vector<bool> placed(views->size(), false);
  placed[0] = true;
  for (std::size_t round = 1; round < views->size(); ++round) {
    int from = -1, to = -1, most = 0;
    for (int a = 0; a < SizeOf(*views); ++a)
      for (int b = 0; b < SizeOf(*views); ++b)
        if (placed[a] && !placed[b])
          if (const int shared = Shared(boards[a], boards[b]); shared > most)
            most = shared, from = a, to = b;
    if (to < 0) {
      std::string names;
      for (int c = 0; c < SizeOf(*views); ++c)
        if (!placed[c]) names += (names.empty() ? "" : ", ") + (*views)[c].name;
      throw InputError(
          "calibrate: " + names +
          " never saw the board at the same moment as the other "
          "cameras; move it through the places that neighbours share, and check that the "
          "films begin together");
    }
    (*views)[to].camera_from_world =
        Compose(*Between(boards[from], boards[to]), (*views)[from].camera_from_world);
    placed[to] = true;
  }
}

std::map<int, Rigid3> PlaceBoards(const BoardPoses& boards, const std::vector<View>& views) {
  std::map<int, Rigid3> world_from_board;
  for (int c = 0; c < SizeOf(views); ++c)
    for (const auto& [frame, pose] : boards[c])
      world_from_board.emplace(frame, Compose(views[c].camera_from_world.Inverse(), pose));
  return world_from_board;
}

void Measure(const std::vector<BoardSighting>& sightings, const std::vector<RigCamera>& cameras,
             const BoardLayout& board, const std::map<int, Rigid3>& world_from_board,
             const BoardPoses& poses, RigResult* result) {
  double sum = 0;
  int count = 0;
  result->cameras.assign(cameras.size(), {});
  for (const BoardSighting& s : sightings) {
    RigCameraReport& report = result->cameras[s.camera];
    const Rigid3& motion = world_from_board.at(s.frame);
    for (const BoardCorner& corner : s.corners) {
      const double error =
          (result->views[s.camera].Project(motion * board.Corner(corner.id)) - corner.pixel).norm();
      report.rms_px += error * error, report.worst_px = std::max(report.worst_px, error);
      sum += error * error;
    }
    ++report.boards, report.corners += SizeOf(s.corners), count += SizeOf(s.corners);
    for (int other = 0; other < SizeOf(cameras); ++other)
      if (other != s.camera && poses[other].count(s.frame)) {
        ++report.shared;
        break;
      }
  }
  for (int c = 0; c < SizeOf(cameras); ++c) {
    RigCameraReport& report = result->cameras[c];
    report.rms_px = std::sqrt(report.rms_px / std::max(1, report.corners));
    report.coverage = CornerCoverage(sightings, c, cameras[c]);
  }
  result->rms_px = std::sqrt(sum / std::max(1, count));
}

/// The world becomes the board that lies on the floor.
void MoveToFloor(int frame, std::vector<View>* views, std::map<int, Rigid3>* world_from_board) {
  const auto floor = world_from_board->find(frame);
  if (floor == world_from_board->end())
    throw InputError("calibrate: no camera saw the board in frame " + std::to_string(frame) +
                     ", in which it should lie on the floor; give another --floor_frame");
  const Rigid3 world_from_floor = floor->second, floor_from_world = world_from_floor.Inverse();
  for (View& view : *views)
    view.camera_from_world = Compose(view.camera_from_world, world_from_floor);
  for (auto& [f, motion] : *world_from_board) motion = Compose(floor_from_world, motion);
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

RigResult CalibrateRig(const std::vector<BoardSighting>& all, const std::vector<RigCamera>& cameras,
                       const BoardLayout& board, const RigCalibratorOptions& options,
                       Progress* progress) {
  std::vector<BoardSighting> sightings;
  for (const BoardSighting& s : all)
    if (SizeOf(s.corners) >= options.least_corners) sightings.push_back(s);
  RigResult result;
  BoardPoses poses(cameras.size());
  for (int c = 0; c < SizeOf(cameras); ++c) {
    if (progress && progress->cancelled()) throw Cancelled();
    ReportProgress(progress, 0.5 * c / SizeOf(cameras), "lenses");
    std::vector<const BoardSighting*> own;
    for (const BoardSighting& s : sightings)
      if (s.camera == c) own.push_back(&s);
    View view;
    view.name = cameras[c].name;
    view.camera = LensOf(own, cameras[c], board, options.most_boards);
    for (const BoardSighting* s : own) poses[c][s->frame] = BoardPose(*s, view.camera, board);
    result.views.push_back(view);
  }
  PlaceCameras(poses, &result.views);
  std::map<int, Rigid3> world_from_board = PlaceBoards(poses, result.views);
  ReportProgress(progress, 0.5, "all together");
  AdjustRig(sightings, board, &result.views, &world_from_board);
  MoveToFloor(options.floor_frame, &result.views, &world_from_board);
  Measure(sightings, cameras, board, world_from_board, poses, &result);
  ReportProgress(progress, 1, "done");
  return result;
}

}  // namespace keypose::capture
