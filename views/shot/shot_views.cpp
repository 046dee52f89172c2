#include "views/shot/shot_views.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/values/errors.h"

namespace keypose {

using Eigen::Vector3d;

std::vector<View> MatchedViews(const RigCalibration& rig, const std::vector<std::string>& cameras,
                               const std::string& stage) {
  const std::vector<int> match = MatchCameraNames(cameras, rig.views);
  std::vector<std::string> missing, known;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (match[c] < 0) missing.push_back(cameras[c]);
  for (const View& view : rig.views) known.push_back(view.name);
  if (!missing.empty())
    throw InputError(stage + ": the calibration has no camera " + Listed(missing) + "; it has " +
                     Listed(known) + ": give folders and calibration the same names");
  std::vector<View> views;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    views.push_back(rig.views[match[c]]);
    views.back().name = cameras[c];
  }
  return views;
}

namespace {

/// Whether name or number of a film are those of a camera; one film and one camera need none.
bool IsNamed(const std::string& film, const RigCalibration& rig) {
  return rig.views.size() > 1 && MatchCameraNames({film}, rig.views).front() >= 0;
}

/// "cam01 = front, cam02 = left" where films are matched by nothing but their order; else empty.
std::string TakenInOrder(const RigCalibration& rig, const std::vector<ShotCamera>& cameras) {
  if (cameras.size() != rig.views.size() || cameras.size() < 2) return "";
  std::string text;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (IsNamed(cameras[c].name, rig)) return "";
    text += (c > 0 ? ", " : "") + cameras[c].name + " = " + rig.views[c].name;
  }
  return text;
}

}  // namespace

std::vector<std::string> TakeOutUncalibrated(const RigCalibration& rig,
                                             std::vector<ShotCamera>& cameras) {
  constexpr int kShort = 4;  // times shorter than the longest film is no film of the shot
  int longest = 0;
  for (const ShotCamera& camera : cameras) longest = std::max(longest, camera.frames());
  std::vector<std::string> out;
  std::vector<ShotCamera> kept;
  for (ShotCamera& camera : cameras) {
    if (IsNamed(camera.name, rig) || !camera.pictures.video.empty() ||
        kShort * camera.frames() >= longest)
      kept.push_back(std::move(camera));
    else
      out.push_back(camera.name);
  }
  cameras = std::move(kept);
  return out;
}

void LeaveOutUncalibrated(StageContext& stage, const RigCalibration& rig,
                          std::vector<ShotCamera>& cameras) {
  const std::vector<std::string> out = TakeOutUncalibrated(rig, cameras);
  if (!out.empty())
    stage.Warn(Listed(out) +
               " is left out: the calibration has no such camera, and there are few pictures for a "
               "film of this shot");
  if (const std::string order = TakenInOrder(rig, cameras); !order.empty())
    stage.Warn(
        "no film has the name or number of a camera of the calibration, so they are taken "
        "in order: " +
        order + "; where that is wrong, give them the same names");
}

Vector3d UpOfCameras(const std::vector<View>& views) {
  Vector3d sum = Vector3d::Zero();
  for (const View& view : views)
    sum -= view.camera_from_world.rotation.conjugate() * Vector3d::UnitY();
  int axis = 0;
  sum.cwiseAbs().maxCoeff(&axis);
  const Vector3d snapped = (sum[axis] > 0 ? 1 : -1) * Vector3d::Unit(axis);
  // Cameras that all look down lean the mean; an axis within 40 degrees is meant.
  return sum.normalized().dot(snapped) > 0.77 ? snapped : Vector3d(sum.normalized());
}

Vector3d UpOf(const std::string& name, const std::vector<View>& views) {
  if (name == "auto") return UpOfCameras(views);
  const double sign = name[0] == '-' ? -1 : 1;
  return sign * Vector3d::Unit(name.back() - 'x');
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace keypose
