#include "core/io/project/transforms_write.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

using nlohmann::ordered_json;

void PutIntrinsics(const Camera& camera, ordered_json* scope) {
  ordered_json& to = *scope;
  to["w"] = camera.width;
  to["h"] = camera.height;
  to["fl_x"] = camera.fx;
  to["fl_y"] = camera.fy;
  to["cx"] = camera.cx;
  to["cy"] = camera.cy;
  to["k1"] = camera.k1;
  to["k2"] = camera.k2;
  to["p1"] = camera.p1;
  to["p2"] = camera.p2;
}

bool SameCamera(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 &&
         a.p2 == b.p2;
}

/// Camera to world, the camera's y up and its z backwards.
ordered_json MatrixOf(const Rigid3& camera_from_world) {
  const Rigid3 world_from_camera = camera_from_world.Inverse();
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = world_from_camera.rotation.toRotationMatrix();
  matrix.block<3, 2>(0, 1) *= -1;
  matrix.topRightCorner<3, 1>() = world_from_camera.translation;
  ordered_json rows = ordered_json::array();
  for (int r = 0; r < 4; ++r)
    rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  return rows;
}

}  // namespace

std::string TransformsText(const std::vector<View>& views,
                           const std::vector<TransformsFrame>& frames, const std::string& points) {
  ordered_json root;
  root["camera_model"] = "OPENCV";
  const bool one_camera = std::all_of(views.begin(), views.end(), [&](const View& view) {
    return SameCamera(view.camera, views.front().camera);
  });
  if (one_camera && !views.empty()) PutIntrinsics(views.front().camera, &root);
  if (!points.empty()) root["ply_file_path"] = points;
  root["frames"] = ordered_json::array();
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!IsValidUtf8(frames[v].image))
      throw InputError(fmt::format("{}: the name is not UTF-8, which JSON cannot hold; rename it",
                                   PrintableName(frames[v].image)));
    ordered_json frame;
    frame["file_path"] = frames[v].image;
    if (!frames[v].mask.empty()) frame["mask_path"] = frames[v].mask;
    PutIntrinsics(views[v].camera, &frame);
    frame["transform_matrix"] = MatrixOf(views[v].camera_from_world);
    root["frames"].push_back(std::move(frame));
  }
  return root.dump(1) + "\n";
}

std::string SparsePlyText(const std::vector<SparsePoint>& points) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty "
      "float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      points.size());
  for (const SparsePoint& point : points)
    text += fmt::format("{:.9g} {:.9g} {:.9g} {} {} {}\n", point.position.x(), point.position.y(),
                        point.position.z(), int{point.color(0)}, int{point.color(1)},
                        int{point.color(2)});
  return text;
}

}  // namespace keypose
