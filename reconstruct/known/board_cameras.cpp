#include "reconstruct/known/board_cameras.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

struct PlanePose {
  Rigid3 camera_from_board;
  double rms_px = std::numeric_limits<double>::infinity();
};

double RmsOf(const View& view, const BoardLayout& board, const std::vector<BoardCorner>& corners) {
  double sum = 0;
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector3d x = view.camera_from_world * board.Corner(corner.id);
    if (x.z() <= 0) return std::numeric_limits<double>::infinity();
    sum += (view.camera.Project(x) - corner.pixel).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(corners.size()));
}

Rigid3 FromOpenCv(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  cv::Mat matrix;
  cv::Rodrigues(rotation_vector, matrix);
  Eigen::Matrix3d rotation;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rotation(r, c) = matrix.at<double>(r, c);
  return {Eigen::Quaterniond(rotation),
          Eigen::Vector3d(translation.at<double>(0), translation.at<double>(1),
                          translation.at<double>(2))};
}

/// The better of the plane's two poses among those with the camera above the board: a print cannot
/// be seen from below.
std::optional<PlanePose> PoseOf(const Camera& camera, const BoardLayout& board,
                                const std::vector<BoardCorner>& corners) {
  std::vector<cv::Point3d> on_board;
  std::vector<cv::Point2d> rays;
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector3d x = board.Corner(corner.id), ray = camera.Unproject(corner.pixel);
    on_board.emplace_back(x.x(), x.y(), x.z());
    rays.emplace_back(ray.x(), ray.y());
  }
  std::vector<cv::Mat> rotations, translations;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  try {
    cv::solvePnPGeneric(on_board, rays, identity, cv::noArray(), rotations, translations, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return std::nullopt;  // collinear corners
  }
  PlanePose best;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    cv::Mat rotation = rotations[i], translation = translations[i];
    cv::solvePnPRefineLM(on_board, rays, identity, cv::noArray(), rotation, translation);
    View view;
    view.camera = camera;
    view.camera_from_world = FromOpenCv(rotation, translation);
    if (!view.camera_from_world.translation.allFinite() || view.Center().z() <= 0) continue;
    const double rms = RmsOf(view, board, corners);
    if (rms < best.rms_px) best = {view.camera_from_world, rms};
  }
  if (!std::isfinite(best.rms_px)) return std::nullopt;
  return best;
}

bool InOneLine(const BoardLayout& board, const std::vector<BoardCorner>& corners) {
  std::map<int, int> columns, rows;
  for (const BoardCorner& corner : corners) {
    ++columns[corner.id % (board.columns - 1)];
    ++rows[corner.id / (board.columns - 1)];
  }
  return columns.size() < 2 || rows.size() < 2;
}

/// The focal length with the best fit to the board, over a range of values. The sum is robust,
/// since some views may be wrong.
double SoughtFocal(Camera camera, const BoardLayout& board,
                   const std::vector<const BoardSighting*>& sightings) {
  constexpr int kTrials = 24;
  const double longer = std::max(camera.width, camera.height);
  double best = 1.2 * longer, least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kTrials; ++k) {
    camera.fx = camera.fy = 0.6 * longer * std::pow(10.0, static_cast<double>(k) / (kTrials - 1));
    double sum = 0;
    for (const BoardSighting* sighting : sightings) {
      const auto pose = PoseOf(camera, board, sighting->corners);
      sum += std::min(20.0, pose ? pose->rms_px : 20.0);
    }
    if (sum < least) {
      least = sum;
      best = camera.fx;
    }
  }
  return best;
}

}  // namespace

std::vector<BodyObservation> BoardObservations(const Scene& scene, const BoardLayout& board,
                                               const std::vector<BoardSighting>& sightings,
                                               int body, int min_corners) {
  std::map<std::string, int> index;
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    index[scene.views[v].name] = static_cast<int>(v);
  std::vector<BodyObservation> observations;
  for (const BoardSighting& sighting : sightings) {
    const auto found = index.find(sighting.name);
    if (found == index.end() || SizeOf(sighting.corners) < min_corners) continue;
    for (const BoardCorner& corner : sighting.corners)
      observations.push_back({found->second, body, board.Corner(corner.id), corner.pixel});
  }
  return observations;
}

namespace {

/// The sightings with enough corners; the names of the others go to `too_few`.
std::vector<const BoardSighting*> UsableSightings(const BoardLayout& board,
                                                  const std::vector<BoardSighting>& sightings,
                                                  int min_corners,
                                                  std::vector<std::string>& too_few) {
  std::vector<const BoardSighting*> usable;
  for (const BoardSighting& sighting : sightings) {
    for (const BoardCorner& corner : sighting.corners)
      if (corner.id < 0 || corner.id >= board.CornerCount())
        throw InputError("sfm: " + sighting.name + " shows a board corner " +
                         std::to_string(corner.id) + ", which the board does not have");
    if (SizeOf(sighting.corners) < min_corners || InOneLine(board, sighting.corners))
      too_few.push_back(sighting.name);
    else
      usable.push_back(&sighting);
  }
  return usable;
}

/// The views that fit their corners from above the board; the names of the others go to `rejected`.
std::vector<View> FittingViews(const std::vector<View>& views, const BoardLayout& board,
                               const std::vector<const BoardSighting*>& sightings,
                               double max_rms_px, std::vector<std::string>& rejected) {
  std::vector<View> kept;
  for (const View& view : views) {
    const auto sighting =
        std::find_if(sightings.begin(), sightings.end(),
                     [&](const BoardSighting* s) { return s->name == view.name; });
    if (RmsOf(view, board, (*sighting)->corners) <= max_rms_px && view.Center().z() > 0)
      kept.push_back(view);
    else
      rejected.push_back(view.name);
  }
  return kept;
}

}  // namespace

BoardPoses PlaceByBoard(const Camera& camera, bool focal_known, const BoardLayout& board,
                        const std::vector<BoardSighting>& sightings,
                        const BoardPosesOptions& options) {
  BoardPoses placed;
  const std::vector<const BoardSighting*> usable =
      UsableSightings(board, sightings, options.min_corners, placed.too_few);
  Camera start = camera;
  if (!focal_known && !usable.empty()) start.fx = start.fy = SoughtFocal(camera, board, usable);
  // The joint solution removes errors from a wrong focal length; the remaining errors then show
  // wrong views.
  for (const BoardSighting* sighting : usable) {
    const auto pose = PoseOf(start, board, sighting->corners);
    if (!pose || pose->rms_px > 10 * options.max_rms_px) {
      placed.rejected.push_back(sighting->name);
      continue;
    }
    View view;
    view.name = sighting->name;
    view.camera = start;
    view.camera_from_world = pose->camera_from_board;
    placed.scene.views.push_back(view);
  }
  for (int round = 0; round < 2 && placed.scene.views.size() >= 2; ++round) {
    placed.bodies.world_from_body = {Rigid3{}};
    placed.bodies.observations =
        BoardObservations(placed.scene, board, sightings, 0, options.min_corners);
    BundleResult result = AdjustBundle(placed.scene, {}, options.bundle, nullptr, placed.bodies);
    placed.scene = std::move(result.scene);
    placed.rms_px = result.bodies_rms_px;
    std::vector<View> kept =
        FittingViews(placed.scene.views, board, usable, options.max_rms_px, placed.rejected);
    if (kept.size() == placed.scene.views.size()) break;
    placed.scene.views = std::move(kept);
  }
  placed.bodies.observations =
      BoardObservations(placed.scene, board, sightings, 0, options.min_corners);
  std::sort(placed.rejected.begin(), placed.rejected.end());
  return placed;
}

BoardPoses PlaceByBoard(const std::vector<BoardLens>& lenses, const BoardLayout& board,
                        const std::vector<BoardSighting>& sightings,
                        const BoardPosesOptions& options) {
  if (lenses.size() == 1)
    return PlaceByBoard(lenses[0].camera, lenses[0].focal_known, board, sightings, options);
  BoardPoses all;
  double sum = 0, corners = 0;
  for (int lens = 0; lens < SizeOf(lenses); ++lens) {
    std::vector<BoardSighting> own = sightings;
    std::erase_if(own, [&](const BoardSighting& sighting) { return sighting.lens != lens; });
    if (own.empty()) continue;
    BoardPoses part =
        PlaceByBoard(lenses[lens].camera, lenses[lens].focal_known, board, own, options);
    const auto add = [](auto& to, auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    add(all.scene.views, part.scene.views);
    add(all.too_few, part.too_few);
    add(all.rejected, part.rejected);
    const auto count = static_cast<double>(part.bodies.observations.size());
    sum += part.rms_px * part.rms_px * count;
    corners += count;
  }
  std::sort(all.scene.views.begin(), all.scene.views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
  std::sort(all.too_few.begin(), all.too_few.end());
  std::sort(all.rejected.begin(), all.rejected.end());
  all.bodies.world_from_body = {Rigid3{}};
  all.bodies.observations = BoardObservations(all.scene, board, sightings, 0, options.min_corners);
  all.rms_px = corners > 0 ? std::sqrt(sum / corners) : 0;
  return all;
}

Similarity3 BoardFromScene(const Scene& board, const Scene& scene) {
  std::map<std::string, const View*> by_name;
  for (const View& view : board.views) by_name[view.name] = &view;
  std::vector<std::pair<const View*, const View*>> common;
  for (const View& view : scene.views)
    if (const auto found = by_name.find(view.name); found != by_name.end())
      common.emplace_back(&view, found->second);
  if (common.size() < 3)
    throw InputError("sfm: only " + std::to_string(common.size()) +
                     " of the placed photographs show the board; 3 are needed for its scale");
  PointsX3 from(std::ssize(common), 3), to = from;
  for (std::size_t i = 0; i < common.size(); ++i) {
    from.row(i) = common[i].first->Center().transpose();
    to.row(i) = common[i].second->Center().transpose();
  }
  return FitSimilarity(from, to);
}

}  // namespace keypose::reconstruct
