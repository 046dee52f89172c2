#include "core/io/project/poses_io.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A number from the frame, else from the file, else `none`.
double Number(const json& root, const json& frame, const char* name, double none) {
  if (frame.contains(name)) return frame.at(name).get<double>();
  return root.contains(name) ? root.at(name).get<double>() : none;
}

Camera CameraOfFrame(const json& root, const json& frame, const std::string& where) {
  constexpr double kMostSide = 1e6;
  Camera camera;
  const auto pixels = [&](const char* name) {
    const double number = Number(root, frame, name, 0);
    if (!(number >= 0 && number <= kMostSide))
      throw InputError(where + ": `" + name + "` is not a number of pixels");
    return static_cast<int>(number);
  };
  camera.width = pixels("w");
  camera.height = pixels("h");
  camera.fx = Number(root, frame, "fl_x", 0);
  const double angle = Number(root, frame, "camera_angle_x", 0);
  if (camera.fx <= 0 && angle > 0 && camera.width > 0)
    camera.fx = camera.width / (2 * std::tan(angle / 2));
  if (camera.fx <= 0 && angle > 0)
    camera.fx =
        -1 / (2 * std::tan(angle / 2));  // to be multiplied by the width, which the caller knows
  camera.fy = Number(root, frame, "fl_y", camera.fx);
  camera.cx = Number(root, frame, "cx", camera.width / 2.0);
  camera.cy = Number(root, frame, "cy", camera.height / 2.0);
  camera.k1 = Number(root, frame, "k1", 0);
  camera.k2 = Number(root, frame, "k2", 0);
  camera.p1 = Number(root, frame, "p1", 0);
  camera.p2 = Number(root, frame, "p2", 0);
  Camera sized = camera;  // when the file gives no size, or only an angle, the caller takes the
                          // photograph's size
  if (sized.width == 0 || sized.height == 0) sized.width = sized.height = 1;
  sized.fx = std::abs(sized.fx);
  sized.fy = std::abs(sized.fy);
  if (camera.fx != 0) RequireUsableCamera(sized, where);
  return camera;
}

Rigid3 CameraFromWorld(const json& matrix, const std::string& where) {
  Eigen::Matrix4d world_from_gl;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c)
      world_from_gl(r, c) = matrix.size() == 3 && r == 3 ? static_cast<double>(c == 3)
                                                         : matrix.at(static_cast<std::size_t>(r))
                                                               .at(static_cast<std::size_t>(c))
                                                               .get<double>();
  Eigen::Matrix3d rotation = world_from_gl.topLeftCorner<3, 3>();
  const double off =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!world_from_gl.allFinite() || world_from_gl.cwiseAbs().maxCoeff() > kMostCoordinate ||
      !(off < 1e-3) || rotation.determinant() < 0)
    throw InputError(where + ": transform_matrix is not a rotation and translation (off by " +
                     std::to_string(off) + "); write the camera-to-world matrix without scale");
  rotation.col(1) = -rotation.col(1).eval();  // y down and z forward
  rotation.col(2) = -rotation.col(2).eval();
  const Rigid3 world_from_camera{Eigen::Quaterniond(rotation).normalized(),
                                 world_from_gl.topRightCorner<3, 1>()};
  return world_from_camera.Inverse();
}

std::vector<View> ReadTransforms(const fs::path& path) {
  std::vector<View> views;
  const std::string text = ReadFile(path);
  RequireShallowJson(text, path.string());
  try {
    const json root = json::parse(text);
    for (const json& frame : root.at("frames")) {
      View view;
      view.name = fs::path(frame.at("file_path").get<std::string>()).filename().string();
      const std::string where = path.string() + ", frame " + view.name;
      view.camera = CameraOfFrame(root, frame, where);
      if (view.camera.fx == 0)
        throw InputError(where + " has no focal length; give fl_x or camera_angle_x");
      view.camera_from_world = CameraFromWorld(frame.at("transform_matrix"), where);
      views.push_back(std::move(view));
    }
  } catch (const json::exception& error) {
    throw InputError(path.string() + " is not a transforms.json (" + JsonFault(error) + ")");
  }
  return views;
}

}  // namespace

std::vector<View> ReadPoses(const fs::path& path) {
  std::vector<View> views;
  const fs::path inside = path / "transforms.json";
  const bool has_model = fs::exists(path / "cameras.bin") || fs::exists(path / "cameras.txt");
  if (fs::is_directory(path) && !has_model && fs::exists(inside)) return ReadPoses(inside);
  if (fs::is_directory(path))
    views = ReadColmapModel(path).views;
  else if (path.extension() == ".json")
    views = ReadTransforms(path);
  else
    throw InputError(path.string() +
                     " is neither a transforms.json nor a folder with one or with a COLMAP model");
  if (views.empty()) throw InputError(path.string() + " holds no camera");
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
  for (std::size_t i = 1; i < views.size(); ++i)
    if (views[i].name == views[i - 1].name)
      throw InputError(path.string() + " has two cameras for " + views[i].name);
  return views;
}

}  // namespace keypose
