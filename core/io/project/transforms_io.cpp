#include "core/io/project/transforms_io.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/io/project/lens_use.h"
#include "core/io/text/files.h"
#include "core/io/text/text_file.h"
#include "core/values/angles.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A frame's own words and numbers, and where it has none, the file's.
class FrameWords {
 public:
  FrameWords(const json& root, const json& frame, const std::string& where)
      : root_(root), frame_(frame), where_(where) {}

  const json* Find(const char* name) const {
    for (const json* scope : {&frame_, &root_})
      if (scope->contains(name) && !scope->at(name).is_null()) return &scope->at(name);
    return nullptr;
  }
  double Number(const char* name, double none = 0) const {
    const json* found = Find(name);
    return found ? found->get<double>() : none;
  }
  /// A coefficient by its name, or by its place in nerfstudio's `distortion_params`.
  double Coefficient(const char* name) const {
    static constexpr std::array kOrder{"k1", "k2", "k3", "k4", "p1", "p2"};
    const auto place = static_cast<std::size_t>(
        std::find(kOrder.begin(), kOrder.end(), std::string_view(name)) - kOrder.begin());
    for (const json* scope : {&frame_, &root_}) {
      if (scope->contains(name) && !scope->at(name).is_null()) return scope->at(name).get<double>();
      if (!scope->contains("distortion_params")) continue;
      const json& list = scope->at("distortion_params");
      if (!list.is_array() || list.size() > kOrder.size())
        throw InputError(where_ + ": `distortion_params` is not a list of k1 k2 k3 k4 p1 p2");
      if (place < list.size()) return list[place].get<double>();
    }
    return 0;
  }
  /// Some programs write 0 and 1.
  bool Flag(const char* name) const {
    const json* found = Find(name);
    if (!found) return false;
    return found->is_boolean() ? found->get<bool>() : found->get<double>() != 0;
  }
  int Pixels(const char* name) const {
    constexpr double kMostSide = 1e6;
    const double number = Number(name);
    if (!(number >= 0 && number <= kMostSide))
      throw InputError(where_ + ": `" + name + "` is not a number of pixels");
    return static_cast<int>(number);
  }
  std::string Model() const {
    const json* found = Find("camera_model");
    return found ? found->get<std::string>() : "";
  }
  const json& frame() const { return frame_; }
  const json& root() const { return root_; }
  const std::string& where() const { return where_; }

 private:
  const json &root_, &frame_;
  const std::string& where_;
};

/// One length of a scope, in pixels; of an angle alone, -1 over the size of the side that it spans;
/// 0: the scope does not tell.
double FocalOf(const json& scope, const std::string& axis, double side, const std::string& where) {
  const auto number = [&](const std::string& name) {
    return scope.contains(name) && !scope.at(name).is_null() ? scope.at(name).get<double>() : 0.0;
  };
  if (const double length = number("fl_" + axis); length > 0) return length;
  double angle = number("camera_angle_" + axis);
  if (angle <= 0) angle = number(axis + "_fov") * kDegree;
  if (angle <= 0) return 0;
  if (angle >= M_PI)
    throw InputError(fmt::format(
        "{}: an angle of view along {} of {:.5g} degrees is none of a picture; camera_angle_{} is "
        "in radians, {}_fov in degrees",
        where, axis, angle / kDegree, axis, axis));
  return (side > 0 ? side : -1) / (2 * std::tan(angle / 2));
}

void PutFocal(const FrameWords& words, Lens* lens) {
  for (const json* scope : {&words.frame(), &words.root()}) {
    const double fx = FocalOf(*scope, "x", lens->width, words.where()),
                 fy = FocalOf(*scope, "y", lens->height, words.where());
    if (fx == 0 && fy == 0) continue;
    // an angle of y without a height has no length in widths
    if (fx == 0 && fy < 0) continue;
    lens->fx = fx != 0 ? fx : fy;
    lens->fy = fy > 0 ? fy : lens->fx;
    return;
  }
  throw InputError(words.where() + " has no focal length; give fl_x or camera_angle_x");
}

bool IsOneOf(const std::string& word, const std::vector<const char*>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Conventions of instant-ngp that change what the other numbers mean.
void RequireKnownConventions(const FrameWords& words) {
  for (const char* name : {"from_na", "from_mitsuba", "fix_premult_camera", "latlong",
                           "equirectangular", "orthographic"})
    if (words.Flag(name)) RefuseModel(name, words.where());
  for (const char* name : {"ftheta_p0", "ftheta_p1", "omega"})
    if (words.Find(name)) RefuseModel(name, words.where());
  const json* shutter = words.Find("rolling_shutter");
  if (!shutter) return;
  for (const json& number : shutter->is_array() ? *shutter : json::array({*shutter}))
    if (number.is_number() && number.get<double>() != 0)
      RefuseModel("rolling_shutter", words.where());
}

void PutDistortion(const FrameWords& words, Lens* lens) {
  RequireKnownConventions(words);
  const std::string model = LowerCase(words.Model());
  const bool fisheye = words.Flag("is_fisheye") ||
                       IsOneOf(model, {"opencv_fisheye", "fisheye", "simple_radial_fisheye",
                                       "radial_fisheye", "simple_fisheye"});
  const bool plain = IsOneOf(
      model, {"", "opencv", "pinhole", "simple_pinhole", "perspective", "simple_radial", "radial"});
  lens->model = words.Model();
  if (lens->model.empty()) lens->model = fisheye ? "is_fisheye" : "OPENCV";
  if (!fisheye && !plain && model != "full_opencv") RefuseModel(lens->model, words.where());
  const double k3 = words.Coefficient("k3"), k4 = words.Coefficient("k4"), k5 = words.Number("k5"),
               k6 = words.Number("k6");
  lens->radial = {words.Coefficient("k1"), words.Coefficient("k2"), k3, k4, 0, 0};
  lens->p1 = words.Coefficient("p1");
  lens->p2 = words.Coefficient("p2");
  if (model == "full_opencv") {
    lens->radial[3] = 0;
    lens->divisor = {k4, k5, k6};
  } else if (k5 != 0 || k6 != 0) {
    RefuseModel(lens->model + " with k5 or k6", words.where());
  }
  if (!fisheye) return;
  lens->projection = LensProjection::kEquidistant;
  if (lens->p1 != 0 || lens->p2 != 0) RefuseModel(lens->model + " with p1 or p2", words.where());
}

Lens LensOfFrame(const json& root, const json& frame, const std::string& where) {
  const FrameWords words(root, frame, where);
  Lens lens;
  lens.width = words.Pixels("w");
  lens.height = words.Pixels("h");
  PutDistortion(words, &lens);
  PutFocal(words, &lens);
  lens.cx = words.Number("cx", lens.width / 2.0);
  lens.cy = words.Number("cy", lens.height / 2.0);
  Lens sized = lens;  // what is missing, the caller takes from the photograph
  if (sized.width == 0 || sized.height == 0) sized.width = sized.height = 1;
  sized.fx = std::abs(sized.fx);
  sized.fy = std::abs(sized.fy);
  RequireUsableLens(sized, where);
  return lens;
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
  if (off < 1e-3 && rotation.determinant() < 0)
    throw InputError(where +
                     ": transform_matrix mirrors (its determinant is -1); the axes of a camera are "
                     "x right, y up, z backwards");
  if (!world_from_gl.allFinite() || world_from_gl.cwiseAbs().maxCoeff() > kMostCoordinate ||
      !(off < 1e-3))
    throw InputError(where + ": transform_matrix is not a rotation and translation (off by " +
                     std::to_string(off) + "); write the camera-to-world matrix without scale");
  rotation.col(1) = -rotation.col(1).eval();  // y down and z forward
  rotation.col(2) = -rotation.col(2).eval();
  const Rigid3 world_from_camera{Eigen::Quaterniond(rotation).normalized(),
                                 world_from_gl.topRightCorner<3, 1>()};
  return world_from_camera.Inverse();
}

/// "./a/b.jpg" and "a\b.jpg" are a/b.jpg.
std::string PathOf(std::string text) {
  std::replace(text.begin(), text.end(), '\\', '/');
  return fs::path(text).lexically_normal().generic_string();
}

/// The file's name alone, where no other view has it.
void ShortenNames(std::vector<LensView>* views) {
  std::map<std::string, int> count;
  for (const LensView& view : *views) ++count[fs::path(view.name).filename().string()];
  for (LensView& view : *views) {
    const std::string name = fs::path(view.name).filename().string();
    if (count[name] == 1) view.name = name;
  }
}

}  // namespace

std::vector<LensView> ReadTransforms(const fs::path& path) {
  std::vector<LensView> views;
  const std::string text = ReadTextFile(path);
  RequireShallowJson(text, path.string());
  try {
    const json root = json::parse(text);
    for (const json& frame : root.at("frames")) {
      LensView view;
      view.name = PathOf(frame.at("file_path").get<std::string>());
      const std::string where =
          path.string() + ", frame " + fs::path(view.name).filename().string();
      view.lens = LensOfFrame(root, frame, where);
      if (!frame.contains("transform_matrix"))
        throw InputError(
            where +
            " has no transform_matrix; leave the frame out, or write its camera-to-world matrix");
      view.camera_from_world = CameraFromWorld(frame.at("transform_matrix"), where);
      views.push_back(std::move(view));
    }
  } catch (const json::exception& error) {
    throw InputError(path.string() + " is not a transforms.json (" + JsonFault(error) + ")");
  }
  ShortenNames(&views);
  return views;
}

}  // namespace keypose
