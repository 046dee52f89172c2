#include "core/io/project/rig_programs.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <set>

#include "core/io/project/lens_use.h"
#include "core/io/project/opencv_lens.h"
#include "core/io/project/yaml_numbers.inc"
#include "core/values/errors.h"

namespace keypose {
namespace {

using yaml_numbers::YamlNumbers;

Rigid3 RigidOf(const std::vector<double>& n, const std::string& what, const std::string& where) {
  if (n.size() != 16) throw InputError(where + ": `" + what + "` must hold 16 numbers");
  const Eigen::Matrix4d m =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(n.data());
  return {ExactRotation(m.topLeftCorner<3, 3>(), where), m.topRightCorner<3, 1>()};
}

std::string WordOf(const YAML::Node& node, const std::string& none) {
  return node && node.IsScalar() ? node.as<std::string>() : none;
}

void AddView(const std::string& name, const Lens& lens, const Rigid3& camera_from_world,
             const std::string& where, RigCalibration* rig) {
  View view{name, UsableCamera(lens, where), camera_from_world};
  RequireUsable(view, where);
  rig->views.push_back(view);
}

// ---- Kalibr ----

/// Kalibr's projection numbers stand before fx, fy, cx, cy.
Lens KalibrLens(const YAML::Node& node, const std::string& where) {
  const std::string model = WordOf(node["camera_model"], "pinhole"),
                    distortion = WordOf(node["distortion_model"], "none");
  std::size_t shapes = 0;
  LensProjection projection = LensProjection::kPerspective;
  if (model == "omni") {
    shapes = 1;
    projection = LensProjection::kUnified;
  } else if (model == "eucm" || model == "ds") {
    shapes = 2;
    projection = model == "ds" ? LensProjection::kDoubleSphere : LensProjection::kEnhanced;
  } else if (model != "pinhole") {
    RefuseModel(model, where);
  }
  const std::vector<double> n = YamlNumbers(node["intrinsics"]);
  if (n.size() != 4 + shapes)
    throw InputError(
        fmt::format("{}: `intrinsics` of {} must hold {} numbers", where, model, 4 + shapes));
  Lens lens = OpenCvLens(distortion, {n.begin() + static_cast<std::ptrdiff_t>(shapes), n.end()},
                         YamlNumbers(node["distortion_coeffs"]), where);
  if (shapes > 0 && lens.projection != LensProjection::kPerspective)
    RefuseModel(model + " with " + distortion, where);
  if (shapes > 0) lens.projection = projection;
  for (std::size_t i = 0; i < shapes; ++i) lens.shape[i] = n[i];
  lens.model = model + "-" + distortion;
  const std::vector<double> size = YamlNumbers(node["resolution"]);
  if (size.size() != 2) throw InputError(where + ": `resolution` must hold 2 numbers");
  lens.width = SideOf(size[0]);
  lens.height = SideOf(size[1]);
  return lens;
}

/// @throws InputError  no YAML: says so of the program's file
template <class Body>
void WithYaml(const std::string& file, const std::string& program, Body&& body) {
  try {
    body();
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{} is not YAML that {} writes ({})", file, program, error.what()));
  }
}

bool Has(const std::string& text, const char* word) { return text.find(word) != std::string::npos; }

void AddKalibrCameras(const YAML::Node& root, const std::string& file, RigCalibration* rig) {
  Rigid3 camera_from_world;
  for (int i = 0; root["cam" + std::to_string(i)]; ++i) {
    const std::string name = "cam" + std::to_string(i), where = file + ", " + name;
    const YAML::Node node = root[name];
    if (i > 0) {
      const YAML::Node step = node["T_cn_cnm1"];
      if (!step) throw InputError(where + " has no T_cn_cnm1, its place beside the camera before");
      camera_from_world =
          Compose(RigidOf(YamlNumbers(step), "T_cn_cnm1", where), camera_from_world);
    }
    AddView(name, KalibrLens(node, where), camera_from_world, where, rig);
  }
  rig->format = "Kalibr";
  rig->metres_per_unit = 1;
}

void AddMcCalibCameras(const YAML::Node& root, const std::string& file, RigCalibration* rig) {
  std::set<std::string> groups;
  for (int i = 0; root["camera_" + std::to_string(i)]; ++i) {
    const std::string name = "camera_" + std::to_string(i), where = file + ", " + name;
    const YAML::Node node = root[name];
    const std::string type = WordOf(node["distortion_type"], "0");
    if (type != "0" && type != "1")
      throw InputError(where + ": MC-Calib's distortion_type " + type +
                       " is not known; 0 (OpenCV's) and 1 (fisheye) are");
    const std::vector<double> k = YamlNumbers(node["camera_matrix"]);
    if (k.size() != 9) throw InputError(where + ": `camera_matrix` must hold 9 numbers");
    RequireUpperTriangle(k.data(), where);
    Lens lens = OpenCvLens(type == "1" ? "fisheye" : "", {k[0], k[4], k[2], k[5], k[1]},
                           YamlNumbers(node["distortion_vector"]), where);
    lens.width = node["img_width"] ? node["img_width"].as<int>() : 0;
    lens.height = node["img_height"] ? node["img_height"].as<int>() : 0;
    const Rigid3 world_from_camera =
        RigidOf(YamlNumbers(node["camera_pose_matrix"]), "camera_pose_matrix", where);
    AddView(name, lens, world_from_camera.Inverse(), where, rig);
    groups.insert(WordOf(node["camera_group"], "0"));
  }
  if (groups.size() > 1)
    throw InputError(file + " has " + std::to_string(groups.size()) +
                     " camera groups, and nothing says how they lie; let cameras share boards");
  rig->format = "MC-Calib";
}

void AddEasyMocapCameras(const YAML::Node& intri, const YAML::Node& extri, const std::string& file,
                         RigCalibration* rig) {
  const YAML::Node names = intri["names"];
  if (!names || !names.IsSequence())
    throw InputError(file + ": intri.yml has no list `names`; EasyMocap writes one");
  for (const YAML::Node& item : names) {
    const std::string name = item.as<std::string>(), where = file + ", camera " + name;
    const auto numbers = [&](const YAML::Node& root, const char* first, const char* second) {
      const YAML::Node node = root[first + name];
      return YamlNumbers(node ? node : root[second + name]);
    };
    const std::vector<double> k = numbers(intri, "K_", "K_"), d = numbers(intri, "dist_", "D_"),
                              t = numbers(extri, "T_", "T_");
    if (k.size() != 9) throw InputError(where + ": intri.yml has no K_" + name + " of 9 numbers");
    if (t.size() != 3) throw InputError(where + ": extri.yml has no T_" + name + " of 3 numbers");
    RequireUpperTriangle(k.data(), where);
    Lens lens = OpenCvLens("", {k[0], k[4], k[2], k[5], k[1]}, d, where);
    const std::vector<double> w = numbers(intri, "W_", "W_"), h = numbers(intri, "H_", "H_");
    if (w.size() == 1 && h.size() == 1 && w[0] > 0 && h[0] > 0) {
      lens.width = SideOf(w[0]);
      lens.height = SideOf(h[0]);
    }
    const Eigen::Matrix3d r = RotationOf(numbers(extri, "Rot_", "R_"), where);
    AddView(name, lens, {ExactRotation(r, where), {t[0], t[1], t[2]}}, where, rig);
  }
  rig->format = "EasyMocap";
}

}  // namespace

bool IsKalibr(const std::string& text) {
  return Has(text, "cam0:") && Has(text, "intrinsics:") && !Has(text, "camera_matrix");
}

void AddKalibr(const std::string& text, const std::string& file, RigCalibration* rig) {
  WithYaml(file, "Kalibr", [&] { AddKalibrCameras(yaml_numbers::Parsed(text), file, rig); });
}

bool IsMcCalib(const std::string& text) {
  return Has(text, "nb_camera") && Has(text, "camera_pose_matrix");
}

void AddMcCalib(const std::string& text, const std::string& file, RigCalibration* rig) {
  WithYaml(file, "MC-Calib", [&] { AddMcCalibCameras(yaml_numbers::Parsed(text), file, rig); });
}

void AddEasyMocap(const std::string& intri, const std::string& extri, const std::string& file,
                  RigCalibration* rig) {
  WithYaml(file, "EasyMocap", [&] {
    AddEasyMocapCameras(yaml_numbers::Parsed(intri), yaml_numbers::Parsed(extri), file, rig);
  });
}

}  // namespace keypose
