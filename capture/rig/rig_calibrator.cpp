#include "capture/rig/rig_calibrator.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "capture/rig/board_turns.h"
#include "capture/rig/rig_adjustment.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

int Shared(const std::map<int, Rigid3>& a, const std::map<int, Rigid3>& b) {
  return static_cast<int>(
      std::count_if(a.begin(), a.end(), [&](const auto& item) { return b.count(item.first) > 0; }));
}

/// Joins cameras, each to the placed one that it shares most boards with.
void PlaceCameras(const BoardPoses& boards, int turns, std::vector<View>* views) {
  std::vector<bool> placed(views->size(), false);
  placed[0] = true;
  for (std::size_t round = 1; round < views->size(); ++round) {
    int from = -1, to = -1, most = 0;
    for (int a = 0; a < SizeOf(*views); ++a)
      for (int b = 0; b < SizeOf(*views); ++b)
        if (placed[a] && !placed[b])
          if (const int shared = Shared(boards[a], boards[b]); shared > most) {
            most = shared;
            from = a;
            to = b;
          }
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
    const std::optional<Rigid3> between = CameraBetween(boards[from], boards[to], turns);
    if (!between)
      throw InputError(
          "calibrate: the checkerboard looks the same after a half turn, and cameras " +
          (*views)[from].name + " and " + (*views)[to].name +
          " saw it in too few places together to tell; move it through more, or print "
          "one with an even and an odd number of squares, or a ChArUco board");
    (*views)[to].camera_from_world = Compose(*between, (*views)[from].camera_from_world);
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
      report.rms_px += error * error;
      report.worst_px = std::max(report.worst_px, error);
      sum += error * error;
    }
    ++report.boards;
    report.corners += SizeOf(s.corners);
    count += SizeOf(s.corners);
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
    View view;
    view.name = cameras[c].name;
    view.camera = options.lenses.empty()
                      ? CalibrateLens(sightings, c, cameras[c], board, options.most_boards).camera
                      : options.lenses[c];
    for (const BoardSighting& s : sightings)
      if (s.camera == c && !s.partial) poses[c][s.frame] = BoardPose(s, view.camera, board);
    result.views.push_back(view);
  }
  std::erase_if(sightings, [](const BoardSighting& s) { return s.partial; });
  PlaceCameras(poses, options.turns, &result.views);
  SettleTurns(options.turns, result.views, board, &poses, &sightings);
  std::map<int, Rigid3> world_from_board = PlaceBoards(poses, result.views);
  ReportProgress(progress, 0.5, "all together");
  AdjustRig(sightings, board, !options.lenses.empty(), &result.views, &world_from_board);
  MoveToFloor(options.floor_frame, &result.views, &world_from_board);
  Measure(sightings, cameras, board, world_from_board, poses, &result);
  ReportProgress(progress, 1, "done");
  return result;
}

}  // namespace keypose::capture
