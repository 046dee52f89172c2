#include "views/shot/rig.h"

#include <cstddef>
#include <utility>

#include "core/errors.h"

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

std::vector<std::string> TakeOutUncalibrated(const RigCalibration& rig,
                                             std::vector<ShotCamera>& cameras) {
  std::vector<std::string> names, out;
  for (const ShotCamera& camera : cameras) names.push_back(camera.name);
  const std::vector<int> match = MatchCameraNames(names, rig.views);
  std::vector<ShotCamera> kept;
  for (std::size_t c = 0; c < cameras.size(); ++c)
    if (match[c] >= 0)
      kept.push_back(cameras[c]);
    else
      out.push_back(cameras[c].name);
  if (kept.size() != rig.views.size()) return {};
  cameras = std::move(kept);
  return out;
}

void LeaveOutUncalibrated(StageContext& stage, const RigCalibration& rig,
                          std::vector<ShotCamera>& cameras) {
  const std::vector<std::string> out = TakeOutUncalibrated(rig, cameras);
  if (!out.empty())
    stage.Warn("the calibration has no camera " + Listed(out) +
               ", and what is there is left out: if it is a film of the shot, calibrate its camera "
               "as well");
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
