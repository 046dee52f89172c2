#include "capture/rig/rig_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>

#include "core/numbers/rotations.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Motion = std::array<double, 6>;  // rotation vector, translation

Motion MotionOf(const Rigid3& rigid) {
  const Eigen::Vector3d turn = LogOf(rigid.rotation);
  return {turn.x(),
          turn.y(),
          turn.z(),
          rigid.translation.x(),
          rigid.translation.y(),
          rigid.translation.z()};
}

Rigid3 RigidOf(const Motion& m) { return {QuaternionOf({m[0], m[1], m[2]}), {m[3], m[4], m[5]}}; }

void SetLens(const std::array<double, 8>& lens, Camera* camera) {
  camera->fx = lens[0];
  camera->fy = lens[1];
  camera->cx = lens[2];
  camera->cy = lens[3];
  camera->k1 = lens[4];
  camera->k2 = lens[5];
  camera->p1 = lens[6];
  camera->p2 = lens[7];
}

/// Distance of a projected corner from where it was seen [px].
struct CornerError {
  Eigen::Vector3d corner;
  Eigen::Vector2d pixel;

  template <class T>
  bool operator()(const T* lens, const T* camera, const T* board, T* error) const {
    const T x[3] = {T(corner.x()), T(corner.y()), T(corner.z())};
    T world[3], in_camera[3];
    ceres::AngleAxisRotatePoint(board, x, world);
    for (int i = 0; i < 3; ++i) world[i] += board[3 + i];
    ceres::AngleAxisRotatePoint(camera, world, in_camera);
    for (int i = 0; i < 3; ++i) in_camera[i] += camera[3 + i];
    const T u = in_camera[0] / in_camera[2], v = in_camera[1] / in_camera[2], r2 = u * u + v * v;
    const T radial = T(1) + r2 * (lens[4] + r2 * lens[5]);
    const T du = T(2) * lens[6] * u * v + lens[7] * (r2 + T(2) * u * u);
    const T dv = lens[6] * (r2 + T(2) * v * v) + T(2) * lens[7] * u * v;
    error[0] = lens[0] * (radial * u + du) + lens[2] - T(pixel.x());
    error[1] = lens[1] * (radial * v + dv) + lens[3] - T(pixel.y());
    return true;
  }
};

}  // namespace

void AdjustRig(const std::vector<BoardSighting>& sightings, const BoardLayout& board,
               bool fixed_lenses, std::vector<View>* views,
               std::map<int, Rigid3>* world_from_board) {
  std::vector<std::array<double, 8>> lenses;
  std::vector<Motion> cameras;
  for (const View& view : *views) {
    const Camera& c = view.camera;
    lenses.push_back({c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2});
    cameras.push_back(MotionOf(view.camera_from_world));
  }
  std::map<int, Motion> boards;
  for (const auto& [frame, motion] : *world_from_board) boards[frame] = MotionOf(motion);
  ceres::Problem problem;
  for (const BoardSighting& s : sightings) {
    if (!boards.count(s.frame)) continue;
    for (const BoardCorner& corner : s.corners)
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CornerError, 2, 8, 6, 6>(
                                   new CornerError{board.Corner(corner.id), corner.pixel}),
                               new ceres::HuberLoss(1), lenses[s.camera].data(),
                               cameras[s.camera].data(), boards[s.frame].data());
  }
  problem.SetParameterBlockConstant(cameras[0].data());
  if (fixed_lenses)
    for (std::array<double, 8>& lens : lenses)
      if (problem.HasParameterBlock(lens.data())) problem.SetParameterBlockConstant(lens.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = 60;
  options.num_threads = 1;  // sums in one order
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw SolverError("calibrate: the adjustment failed: " + summary.message);
  for (int c = 0; c < SizeOf(*views); ++c) {
    SetLens(lenses[c], &(*views)[c].camera);
    (*views)[c].camera_from_world = RigidOf(cameras[c]);
  }
  for (auto& [frame, motion] : *world_from_board) motion = RigidOf(boards[frame]);
}

}  // namespace keypose::capture
