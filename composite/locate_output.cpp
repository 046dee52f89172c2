#include "composite/locate_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "composite/plan/camera_path.h"
#include "core/numbers/rotations.h"
#include "core/numbers/statistics.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr int kMostPictures = 6, kColumns = 3;
constexpr double kFullColour = 3;  // px
constexpr int kJitterStep = 23;    // of the vertices

/// The camera of the whole pictures, with the lens that was found on reduced ones.
Camera WholeCamera(const LocateInput& input, const Camera& found) {
  Camera camera = input.camera;
  const double factor = found.fx / input.shot.camera.fx;
  camera.fx *= factor;
  camera.fy *= factor;
  camera.k1 = found.k1;
  return camera;
}

/// A length in the character's frame for each pixel of the whole picture.
double FootprintOf(const LocateInput& input, const LocatedFrame& frame, int i) {
  const PointsX3& points = input.shot.poses[input.shot.frames[i].pose];
  const Eigen::Vector3d middle = points.colwise().mean();
  return (frame.at.camera_from_mesh * middle).z() * input.scale / frame.at.camera.fx;
}

struct Drift {
  double mean = 0, p95 = 0;  ///< px of the whole picture
};
Drift DriftOf(const LocatedFrame& frame, double scale) {
  std::vector<double> sizes;
  for (const OutlineMatch& match : frame.outlines)
    sizes.push_back(std::abs(match.distance_px) / scale);
  Drift drift;
  if (sizes.empty()) return drift;
  for (const double size : sizes) drift.mean += size / SizeOf(sizes);
  drift.p95 = QuantileAbove(std::move(sizes), 0.95);
  return drift;
}

void Dot(Image8& picture, const Eigen::Vector2d& at, const Eigen::Vector3d& colour) {
  const int x = static_cast<int>(std::floor(at.x() - 0.5));
  const int y = static_cast<int>(std::floor(at.y() - 0.5));
  for (int k = 0; k < 4; ++k) {
    const int px = x + k % 2, py = y + k / 2;
    if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
    for (int c = 0; c < 3; ++c)
      picture.at(px, py)[c] = static_cast<std::uint8_t>(std::lround(colour[c]));
  }
}

Eigen::Vector3d ColourOf(double distance_px) {
  const Eigen::Vector3d same(70, 220, 90), larger(255, 130, 20), smaller(50, 110, 255);
  const double t = std::min(1.0, std::abs(distance_px) / kFullColour);
  return (1 - t) * same + t * (distance_px > 0 ? larger : smaller);
}

/// The largest change of a pixel between frames of one pose, where one place would do.
double JitterOf(const LocateInput& input, const LocatedShot& located) {
  double jitter = 0;
  for (int i = 1; i < SizeOf(located.frames); ++i) {
    if (input.shot.frames[i].pose != input.shot.frames[i - 1].pose) continue;
    const PointsX3& points = input.shot.poses[input.shot.frames[i].pose];
    double sum = 0;
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
      const Eigen::Vector3d x = points.row(v);
      sum += (located.frames[i].at.Project(x) - located.frames[i - 1].at.Project(x)).squaredNorm();
    }
    jitter = std::max(jitter, std::sqrt(sum / static_cast<double>(points.rows())) / input.scale);
  }
  return jitter;
}

/// How much the camera trembles: the deviation of its places from a smooth way, as the pictures
/// show it; the root of the mean square over the mesh and the frames with two others on each side.
double CameraJitterOf(const LocateInput& input, const FilmedShot& shot) {
  std::vector<CameraKnot> knots;
  for (const ShotFrame& frame : shot.frames)
    knots.push_back({1.0 * frame.frame, frame.camera_from_world});
  const CameraPath path(knots);
  double sum = 0;
  int count = 0;
  for (int i = 2; i + 2 < SizeOf(knots); ++i) {
    const CameraPath::Smooth smooth = path.SmoothAt(i);
    const View found{"", shot.camera, knots[i].camera_from_world},
        even{"", shot.camera, smooth.camera_from_world};
    for (Eigen::Index v = 0; v < input.mesh.points.rows(); v += kJitterStep, ++count) {
      const Eigen::Vector3d x = input.mesh.points.row(v);
      sum += (found.Project(x) - even.Project(x)).squaredNorm() / (smooth.gain * smooth.gain);
    }
  }
  return count ? std::sqrt(sum / count) : 0;
}

/// Where plates and pictures without a place of the character show the camera.
void SetBetween(const LocatedShot& located, std::vector<CameraBetween> cameras, FilmedShot* shot) {
  if (located.set)
    for (const TimedCamera& camera : located.set->between)
      cameras.push_back({camera.time, camera.camera_from_world});
  std::sort(cameras.begin(), cameras.end(),
            [](const CameraBetween& a, const CameraBetween& b) { return a.frame < b.frame; });
  for (const CameraBetween& camera : cameras)
    if (!shot->frames.empty() && camera.frame > shot->frames.front().frame &&
        camera.frame < shot->frames.back().frame)
      shot->between.push_back(camera);
}

}  // namespace

bool IsBetween(const LocateInput& input, int frame) {
  return !input.shot.still && input.pose_names[input.shot.frames[frame].pose].empty() &&
         !input.pose_names[input.shot.frames[0].pose].empty();
}

FilmedShot ShotOf(const LocateInput& input, const LocatedShot& located) {
  FilmedShot shot;
  shot.camera = WholeCamera(input, located.camera);
  shot.focal = located.focal;
  shot.focal_uncertainty = located.focal_deviation;
  shot.still = input.shot.still;
  shot.fps = input.fps;
  const Rigid3 world_camera = located.frames[0].at.camera_from_mesh;
  std::vector<CameraBetween> left_out;  // the set shows the camera all the same
  for (int i = 0; i < SizeOf(located.frames); ++i) {
    const LocatedFrame& found = located.frames[i];
    if (found.left_out) {
      if (found.camera_from_world)
        left_out.push_back({1.0 * input.pictures[i].frame, *found.camera_from_world});
      continue;
    }
    ShotFrame frame;
    frame.frame = input.pictures[i].frame;
    frame.picture = input.pictures[i].path.filename().string();
    frame.pose = input.pose_names[input.shot.frames[i].pose];
    frame.camera_from_world =
        shot.still ? world_camera : found.camera_from_world.value_or(found.at.camera_from_mesh);
    const Rigid3 place = Compose(frame.camera_from_world.Inverse(), found.at.camera_from_mesh);
    frame.world_from_character = {1, place.rotation.toRotationMatrix(), place.translation};
    frame.method = found.method;
    if (!found.matte.empty()) {
      frame.contour_px = found.contour_px / input.scale;
      frame.iou = found.iou;
    }
    if (found.inliers > 0) frame.inliers = found.inliers;
    shot.frames.push_back(frame);
  }
  SetBetween(located, std::move(left_out), &shot);
  return shot;
}

void ReportShot(StageContext& stage, const LocateInput& input, const LocatedShot& located) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  double contour = 0, iou = 1, drift_share = 0;
  int features = 0;
  for (int i = 0; i < SizeOf(located.frames); ++i) {
    const LocatedFrame& frame = located.frames[i];
    const Drift drift = DriftOf(frame, input.scale);
    const double diagonal = BoundingDiagonal(input.shot.poses[input.shot.frames[i].pose]);
    const double share = drift.p95 * FootprintOf(input, frame, i) / diagonal;
    list.push_back({{"frame", input.pictures[i].frame},
                    {"picture", input.shot.frames[i].name},
                    {"method", frame.method},
                    {"inliers", frame.inliers},
                    {"contour_px", frame.contour_px / input.scale},
                    {"iou", frame.iou},
                    {"correlation", frame.correlation},
                    {"turn_ratio", frame.turn_ratio},
                    {"rival_ratio", frame.rival_ratio},
                    {"drift_mean_px", drift.mean},
                    {"drift_p95_px", drift.p95},
                    {"drift_p95_over_diag", share}});
    contour += frame.contour_px / input.scale / SizeOf(located.frames);
    iou = std::min(iou, frame.iou);
    drift_share = std::max(drift_share, share);
    features += frame.method == "features";
  }
  stage.ReportJson("frames", list.dump());
  stage.Report("frames_located", SizeOf(located.frames));
  stage.Report("by_features", features);
  stage.Report("contour_px", contour);
  stage.Report("iou_least", iou);
  stage.Report("drift_p95_over_diag", drift_share);
  stage.Report("focal", located.focal);
  stage.Report("focal_px", WholeCamera(input, located.camera).fx);
  stage.Report("focal_uncertainty", located.focal_deviation);
  stage.Report("focal_seen", located.profile_deviation);
  stage.Report("k1", located.camera.k1);
  stage.Report("matte_offset_px", located.matte_offset_px / input.scale);
  if (located.center_deviation_px > 0 && std::isfinite(located.center_deviation_px))
    stage.Report("center_seen_px", located.center_deviation_px / input.scale);
  stage.Report("one_place", located.one_place);
  if (located.set) {
    stage.Report("set_places", located.set->places);
    stage.Report("set_places_on_table", located.set->on_table);
    stage.Report("set_rms_px", located.set->rms_px / input.scale);
    stage.Report("set_plates_between", SizeOf(located.set->between));
  }
  stage.Report("jitter_px", JitterOf(input, located));
  if (!input.shot.still)
    stage.Report("camera_jitter_px", CameraJitterOf(input, ShotOf(input, located)));
}

Image8 DriftPicture(const LocateInput& input, const LocatedShot& located) {
  std::vector<Image8> pictures;
  const int count = SizeOf(located.frames), step = (count + kMostPictures - 1) / kMostPictures;
  for (int i = 0; i < count; i += step) {
    Image8 picture = input.shot.frames[i].picture;
    // Dimmed, so that the lines stand out.
    for (std::uint8_t& value : picture.data) value = static_cast<std::uint8_t>(value * 6 / 10);
    for (const OutlineMatch& match : located.frames[i].outlines)
      Dot(picture, match.pixel, ColourOf(match.distance_px / input.scale));
    pictures.push_back(std::move(picture));
  }
  return TileImages(pictures, std::min(kColumns, SizeOf(pictures)));
}

}  // namespace keypose::composite
