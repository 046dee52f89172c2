#include "capture/rig/board_turns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

double Apart(const Rigid3& x, const Rigid3& y) {
  return std::min(0.5, x.rotation.angularDistance(y.rotation)) +
         std::min(0.5, (x.translation - y.translation).norm());
}

/// A board turned about its middle by so many of its equal turns.
Rigid3 Turn(int k, int turns) {
  if (k == 0) return {};
  const double angle = 2 * std::numbers::pi * k / turns;
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
          Eigen::Vector3d::Zero()};
}

/// The turn of a board, seen by a placed camera, that brings it nearest to where it is.
int NearestTurn(const Rigid3& seen, const Rigid3& expected, int turns) {
  int best = 0;
  for (int k = 1; k < turns; ++k)
    if (Apart(Compose(seen, Turn(k, turns)), expected) <
        Apart(Compose(seen, Turn(best, turns)), expected))
      best = k;
  return best;
}

/// The corner that a turned board has where `id` is.
int TurnedId(int id, int k, int turns, const BoardLayout& board) {
  const Eigen::Vector3d at = Turn(k, turns).Inverse() * board.Corner(id);
  const int column =
      static_cast<int>(std::lround((at.x() + board.Width() / 2) / board.square_m - 1));
  const int row = static_cast<int>(std::lround((board.Height() / 2 - at.y()) / board.square_m - 1));
  return row * (board.columns - 1) + column;
}

}  // namespace

std::optional<Rigid3> CameraBetween(const std::map<int, Rigid3>& a, const std::map<int, Rigid3>& b,
                                    int turns) {
  std::vector<std::vector<Rigid3>> all;  // of each frame, one for each turn
  for (const auto& [frame, board] : a)
    if (const auto other = b.find(frame); other != b.end()) {
      all.emplace_back();
      for (int k = 0; k < turns; ++k)
        all.back().push_back(Compose(Compose(other->second, Turn(k, turns)), board.Inverse()));
    }
  if (all.empty()) return {};
  const Rigid3* best = nullptr;
  double least = 1e300, next = 1e300;  // next: of a motion that is clearly another one
  constexpr double kAnother = 0.3;
  for (const std::vector<Rigid3>& frame : all)
    for (const Rigid3& motion : frame) {
      double sum = 0;
      for (const std::vector<Rigid3>& other : all) {
        double nearest = 1e300;
        for (const Rigid3& turned : other) nearest = std::min(nearest, Apart(motion, turned));
        sum += nearest;
      }
      if (sum < least) {
        if (best && Apart(*best, motion) > kAnother) next = least;
        least = sum;
        best = &motion;
      } else if (Apart(*best, motion) > kAnother) {
        next = std::min(next, sum);
      }
    }
  // Without a second place of the board, a half turn explains it as well.
  constexpr double kClear = 0.1;
  if (turns > 1 && next < 2 * least + kClear) return {};
  return *best;
}

void SettleTurns(int turns, const std::vector<View>& views, const BoardLayout& board,
                 BoardPoses* poses, std::vector<BoardSighting>* sightings) {
  if (turns == 1) return;
  std::map<int, Rigid3> world_from_board;  // as the first camera sees it
  for (int c = 0; c < SizeOf(views); ++c)
    for (auto& [frame, pose] : (*poses)[c]) {
      const Rigid3 seen = Compose(views[c].camera_from_world.Inverse(), pose);
      const auto [first, is_first] = world_from_board.emplace(frame, seen);
      if (is_first) continue;
      const int k = NearestTurn(seen, first->second, turns);
      if (k == 0) continue;
      pose = Compose(pose, Turn(k, turns));
      for (BoardSighting& s : *sightings) {
        if (s.camera != c || s.frame != frame || s.partial) continue;
        for (BoardCorner& corner : s.corners) corner.id = TurnedId(corner.id, k, turns, board);
      }
    }
}

}  // namespace keypose::capture
