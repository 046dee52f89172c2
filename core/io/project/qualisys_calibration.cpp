#include "core/io/project/qualisys_calibration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/io/project/lens_use.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

using Attributes = std::map<std::string, std::string>;

/// Elements of a simple XML text, in order: name and attributes.
std::vector<std::pair<std::string, Attributes>> Elements(const std::string& text) {
  std::vector<std::pair<std::string, Attributes>> elements;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::size_t end = std::min(text.find('>', at), text.size());
    const std::size_t name_end = std::min(text.find_first_of(" \t\r\n/>", at + 1), end);
    if (name_end == at + 1) continue;  // a closing tag
    Attributes attributes;
    std::size_t i = name_end;
    while (true) {
      const std::size_t equals = text.find('=', i);
      if (equals == std::string::npos || equals >= end) break;
      const std::size_t name_at = text.find_first_not_of(" \t\r\n", i);
      const std::size_t open = text.find('"', equals);
      const std::size_t close = open == std::string::npos ? open : text.find('"', open + 1);
      if (close == std::string::npos || close > end) break;
      std::string name = text.substr(name_at, equals - name_at);
      while (!name.empty() && std::isspace(static_cast<unsigned char>(name.back())))
        name.pop_back();
      attributes[name] = text.substr(open + 1, close - open - 1);
      i = close + 1;
    }
    elements.emplace_back(text.substr(at + 1, name_end - at - 1), attributes);
  }
  return elements;
}

double Attribute(const Attributes& attributes, const std::string& name, const std::string& where,
                 std::optional<double> none = {}) {
  const auto found = attributes.find(name);
  if (found == attributes.end()) {
    if (none) return *none;
    throw InputError(fmt::format("{} has no {}", where, name));
  }
  try {
    return std::stod(found->second);
  } catch (const std::exception&) {
    throw InputError(fmt::format("{}: {} is '{}', not a number", where, name, found->second));
  }
}

struct QualisysCamera {
  View view;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Attributes window;  // of the film in the sensor, in pixels
  bool has_lens = false, has_place = false;
};

constexpr double kParts = 64;  // of a pixel, the unit of lengths on the sensor

/// How many pixels there are from the first to the last one, which is meant. The last one is named
/// by its place (64 * 1087), or by its last 64th (64 * 1088 - 1).
int PixelsTo(double first, double last) { return SideOf(std::floor((last - first) / kParts) + 1); }

/// The sensor, and where the film's first pixel lies in it.
void ReadQualisysLens(const Attributes& a, const std::string& where, Lens* camera) {
  // from the centre of the first pixel
  const auto pixels = [&](const char* name) { return Attribute(a, name, where) / kParts; };
  camera->width = PixelsTo(Attribute(a, "sensorMinU", where, 0), Attribute(a, "sensorMaxU", where));
  camera->height =
      PixelsTo(Attribute(a, "sensorMinV", where, 0), Attribute(a, "sensorMaxV", where));
  camera->fx = pixels("focalLengthU");
  camera->fy = pixels("focalLengthV");
  camera->cx = pixels("centerPointU") + 0.5;
  camera->cy = pixels("centerPointV") + 0.5;
  camera->model = "Qualisys' with skew or radialDistortion3";
  camera->skew = Attribute(a, "skew", where, 0) / kParts;
  camera->radial = {Attribute(a, "radialDistortion1", where, 0),
                    Attribute(a, "radialDistortion2", where, 0),
                    Attribute(a, "radialDistortion3", where, 0),
                    0,
                    0,
                    0};
  camera->p1 = Attribute(a, "tangentalDistortion1", where, 0);
  camera->p2 = Attribute(a, "tangentalDistortion2", where, 0);
}

/// The camera of a film that shows only a window of the sensor.
void CutToWindow(const Attributes& window, const std::string& where, Lens* camera) {
  if (window.empty()) return;
  const double left = Attribute(window, "left", where, 0), top = Attribute(window, "top", where, 0),
               right = Attribute(window, "right", where, -1),
               bottom = Attribute(window, "bottom", where, -1);
  const bool inside = left >= 0 && top >= 0 && right > left && bottom > top &&
                      right < camera->width && bottom < camera->height;
  if (!inside) return;
  camera->width = SideOf(right - left + 1);
  camera->height = SideOf(bottom - top + 1);
  camera->cx -= left;
  camera->cy -= top;
}

Eigen::Matrix3d Rows(const Eigen::Matrix3d& matrix, int convention) {
  return convention & 1 ? Eigen::Matrix3d(matrix.transpose()) : matrix;
}

/// How far the cameras' optical axes miss a common point in front of them, over their distance.
double AxesMiss(const std::vector<QualisysCamera>& cameras, int convention) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Identity() * 1e-9;
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto axis = [&](const QualisysCamera& c) {
    const Eigen::Matrix3d rows = Rows(c.matrix, convention);
    return Eigen::Vector3d((convention & 2 ? -1 : 1) * rows.row(2));
  };
  for (const QualisysCamera& c : cameras) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis(c) * axis(c).transpose();
    sum += across;
    right += across * c.center;
  }
  const Eigen::Vector3d meeting = sum.ldlt().solve(right);
  double miss = 0;
  for (const QualisysCamera& c : cameras)
    miss += 1 - axis(c).dot((meeting - c.center).normalized());
  return miss;
}

/// Qualisys' own pages do not say which way its matrix turns, and versions differ in the direction
/// of z. Cameras of a capture look at one place, which decides.
void PlaceQualisys(std::vector<QualisysCamera>& cameras, RigCalibration* rig) {
  int best = 0;
  for (int convention = 1; convention < 4; ++convention)
    if (AxesMiss(cameras, convention) < AxesMiss(cameras, best)) best = convention;
  for (QualisysCamera& c : cameras) {
    Eigen::Matrix3d rows = Rows(c.matrix, best);
    if (best & 2) {
      rows.row(1) *= -1;
      rows.row(2) *= -1;
    }
    const Eigen::Quaterniond turn = ExactRotation(rows, c.view.name);
    c.view.camera_from_world = {turn, -(turn * (c.center / 1000))};
    rig->views.push_back(c.view);
  }
}

void ReadPlace(const Attributes& a, const std::string& where, QualisysCamera* camera) {
  for (int r = 0; r < 3; ++r) {
    camera->center[r] = Attribute(a, std::string(1, "xyz"[r]), where);
    for (int c = 0; c < 3; ++c)
      camera->matrix(r, c) = Attribute(a, fmt::format("r{}{}", r + 1, c + 1), where);
  }
  camera->has_place = true;
}

std::vector<QualisysCamera> CamerasOf(const std::string& text, const std::string& file) {
  std::vector<QualisysCamera> cameras;
  for (const auto& [name, attributes] : Elements(text)) {
    if (name == "camera") {
      cameras.emplace_back();
      const auto serial = attributes.find("serial");
      cameras.back().view.name =
          serial == attributes.end() ? std::to_string(cameras.size()) : serial->second;
    }
    if (cameras.empty()) continue;
    QualisysCamera& camera = cameras.back();
    const std::string where = fmt::format("{}, camera {}", file, camera.view.name);
    if (name == "fov_video") camera.window = attributes;
    if (name == "transform") ReadPlace(attributes, where, &camera);
    if (name == "intrinsic") {
      Lens lens;
      ReadQualisysLens(attributes, where, &lens);
      CutToWindow(camera.window, where, &lens);
      camera.view.camera = UsableCamera(lens, where);
      RequireUsable(camera.view, where);
      camera.has_lens = true;
    }
  }
  return cameras;
}

}  // namespace

void AddQualisys(const std::string& text, const std::string& file, RigCalibration* rig) {
  if (text.find("</calibration>") == std::string::npos)
    throw InputError(file + " ends in the middle, before </calibration>; export or copy it again");
  std::vector<QualisysCamera> cameras = CamerasOf(text, file), usable;
  for (QualisysCamera& camera : cameras)
    if (camera.has_lens && camera.has_place)
      usable.push_back(std::move(camera));
    else
      rig->notes.push_back(fmt::format("{}: camera {} has no lens or no place and is left out",
                                       file, camera.view.name));
  PlaceQualisys(usable, rig);
  rig->format = "Qualisys";
  rig->metres_per_unit = 1;  // its millimetres were converted
  rig->up = Eigen::Vector3d::UnitZ();
}

}  // namespace keypose
