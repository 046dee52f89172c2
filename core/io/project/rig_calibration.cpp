#include "core/io/project/rig_calibration.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/io/project/colmap_io.h"
#include "core/io/project/poses_io.h"
#include "core/io/project/qualisys_calibration.h"
#include "core/io/project/rig_parts.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

// ---- OpenCV YAML ----

YAML::Node FirstOf(const YAML::Node& node, const std::vector<const char*>& names) {
  for (const char* name : names)
    if (node[name]) return node[name];
  return YAML::Node(YAML::NodeType::Undefined);
}

/// All numbers of a matrix node ({rows, cols, dt, data}) or of nested lists.
/// @param left  how many nodes may follow: an alias (*name) can contain itself, and a few of them
/// can stand for more numbers than fit in memory
void Collect(const YAML::Node& node, int depth, int* left, std::vector<double>* numbers) {
  constexpr int kDeepest = 8;
  if (depth > kDeepest || --*left < 0)
    throw YAML::RepresentationException(node.Mark(), "more lists or numbers than any matrix has");
  if (node.IsMap() && node["data"]) return Collect(node["data"], depth + 1, left, numbers);
  if (node.IsScalar()) return numbers->push_back(node.as<double>());
  for (const YAML::Node& part : node) Collect(part, depth + 1, left, numbers);
}

std::vector<double> Numbers(const YAML::Node& node) {
  int left = 1000;
  std::vector<double> numbers;
  if (node && !node.IsNull()) Collect(node, 0, &left, &numbers);
  return numbers;
}

Eigen::Matrix3d RowMajor(const std::vector<double>& n) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(n.data());
}

Eigen::Matrix3d RotationOf(const YAML::Node& node, const std::string& where) {
  const std::vector<double> n =
      Numbers(FirstOf(node, {"rotation", "R", "rotation_matrix", "rvec", "rotation_vector"}));
  if (n.size() == 9) return RowMajor(n);
  if (n.size() != 3)
    throw InputError(where + ": `rotation` must hold 9 numbers, or 3 (Rodrigues); it has " +
                     std::to_string(n.size()));
  const Eigen::Vector3d turn(n[0], n[1], n[2]);
  if (turn.norm() < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

void ReadLens(const YAML::Node& node, const std::string& where, Camera* camera,
              std::vector<std::string>* notes) {
  const std::vector<double> k =
      Numbers(FirstOf(node, {"camera_matrix", "K", "intrinsic_matrix", "intrinsics"}));
  if (k.size() != 9) throw InputError(where + ": `camera_matrix` must hold 9 numbers");
  // OpenCV counts pixels from the centre of the first one.
  camera->fx = k[0];
  camera->fy = k[4];
  camera->cx = k[2] + 0.5;
  camera->cy = k[5] + 0.5;
  const std::vector<double> d =
      Numbers(FirstOf(node, {"distortion_coefficients", "D", "dist_coeffs", "distortion", "dist"}));
  const auto at = [&](std::size_t i) { return i < d.size() ? d[i] : 0.0; };
  camera->k1 = at(0);
  camera->k2 = at(1);
  camera->p1 = at(2);
  camera->p2 = at(3);
  for (std::size_t i = 4; i < d.size(); ++i)
    if (std::abs(d[i]) > 1e-9) {
      notes->push_back(where + ": only k1, k2, p1, p2 of its distortion are used");
      break;
    }
  const std::vector<double> size = Numbers(FirstOf(node, {"image_size", "resolution", "size"}));
  if (size.size() == 2) {
    camera->width = SideOf(size[0]);
    camera->height = SideOf(size[1]);
  }
  if (const YAML::Node w = FirstOf(node, {"image_width", "width"})) camera->width = w.as<int>();
  if (const YAML::Node h = FirstOf(node, {"image_height", "height"})) camera->height = h.as<int>();
}

View ViewOfYaml(const YAML::Node& node, const std::string& name, const std::string& where,
                bool lens_only, std::vector<std::string>* notes) {
  View view;
  view.name = name;
  ReadLens(node, where, &view.camera, notes);
  const YAML::Node translation =
      FirstOf(node, {"translation", "T", "tvec", "translation_vector", "t"});
  if (!translation && !FirstOf(node, {"rotation", "R", "rotation_matrix", "rvec"})) {
    RequireUsable(view, where);
    if (lens_only) return view;
    throw InputError(where +
                     " has a lens but no place: `keypose calibrate --lenses` takes it, with films "
                     "of a board or points of known place");
  }
  const std::vector<double> t = Numbers(translation);
  if (t.size() != 3) throw InputError(where + ": `translation` must hold 3 numbers");
  view.camera_from_world = {ExactRotation(RotationOf(node, where), where), {t[0], t[1], t[2]}};
  RequireUsable(view, where);
  return view;
}

double UnitOf(const YAML::Node& node, const std::string& where) {
  if (!node["unit"]) return 0;
  const std::string unit = node["unit"].as<std::string>();
  const std::map<std::string, double> lengths{{"m", 1}, {"cm", 0.01}, {"mm", 0.001}};
  const auto found = lengths.find(unit);
  if (found == lengths.end())
    throw InputError(where + ": `unit` is '" + unit + "'; m, cm and mm are known");
  return found->second;
}

YAML::Node LoadYaml(const fs::path& path) {
  std::string text = ReadFile(path);
  // OpenCV's first line, %YAML:1.0, is not YAML's.
  if (text.starts_with("%YAML")) text.erase(0, std::min(text.find('\n'), text.size()));
  return YAML::Load(text);
}

bool IsCameraNode(const YAML::Node& node) {
  return node.IsMap() && FirstOf(node, {"camera_matrix", "K", "intrinsic_matrix"});
}

/// The unit of a view: one whose translation is in other units than metres says so.
void AddYamlFile(const fs::path& path, bool lens_only, RigCalibration* rig) {
  const std::string file = PrintableName(path.filename());
  try {
    const YAML::Node root = LoadYaml(path);
    double unit = root.IsMap() ? UnitOf(root, file) : 0;
    if (IsCameraNode(root)) {
      rig->views.push_back(ViewOfYaml(root, path.stem().string(), file, lens_only, &rig->notes));
    } else if (root.IsMap()) {
      for (const auto& item : root) {
        const std::string name = item.first.as<std::string>();
        if (IsCameraNode(item.second))
          rig->views.push_back(
              ViewOfYaml(item.second, name, file + ", " + name, lens_only, &rig->notes));
      }
    }
    if (rig->metres_per_unit != 0 && unit != 0 && unit != rig->metres_per_unit)
      throw InputError(file + ": its unit is not that of the other files; give one unit to all");
    if (unit != 0) rig->metres_per_unit = unit;
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{} is not YAML that OpenCV writes ({})", file, error.what()));
  }
}

// ---- matrices ----

void ReadMatrices(const std::string& text, const std::string& file, RigCalibration* rig) {
  constexpr int kNumbers = 9 + 2 + 12;
  std::istringstream stream(text);
  double largest_skew_px = 0;
  for (std::string name; stream >> name;) {
    const std::string where = fmt::format("{}, camera {}", file, name);
    std::array<double, kNumbers> n;
    for (double& number : n)
      if (!(stream >> number))
        throw InputError(where +
                         ": it needs K (9 numbers), two radial coefficients and camera "
                         "from world (12 numbers)");
    View view;
    view.name = name;
    view.camera.fx = n[0];
    view.camera.fy = n[4];
    view.camera.cx = n[2] + 0.5;
    view.camera.cy = n[5] + 0.5;
    view.camera.k1 = n[9];
    view.camera.k2 = n[10];
    // a skew shifts a pixel at the picture's top or bottom by this much
    largest_skew_px = std::max(largest_skew_px, std::abs(n[1] / n[4] * n[5]));
    Eigen::Matrix3d r;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) r(i, j) = n[11 + 4 * i + j];
    view.camera_from_world = {ExactRotation(r, where), {n[14], n[18], n[22]}};
    RequireUsable(view, where);
    rig->views.push_back(view);
  }
  if (largest_skew_px > 0.1)
    rig->notes.push_back(
        fmt::format("{}: skewed pixels are taken as square, which moves a pixel "
                    "by up to {:.1f} px",
                    file, largest_skew_px));
  rig->format = "matrices";
}

void RequireCameras(const RigCalibration& rig, const fs::path& path) {
  if (rig.views.empty())
    throw InputError(PrintableName(path) +
                     " holds no camera that is known: OpenCV YAML, a COLMAP model, Qualisys' text, "
                     "or numbers with K, distortion and camera from world");
  std::set<std::string> names;
  for (const View& view : rig.views)
    if (!names.insert(view.name).second)
      throw InputError(PrintableName(path) + " has two cameras named " + view.name);
}

bool IsYaml(const fs::path& path) {
  return path.extension() == ".yml" || path.extension() == ".yaml";
}

void ReadFolder(const fs::path& path, bool lens_only, RigCalibration* rig) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (IsYaml(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NumberedBefore(a.stem().string(), b.stem().string());
  });
  for (const fs::path& file : files) AddYamlFile(file, lens_only, rig);
  rig->format = "OpenCV YAML";
  if (!files.empty()) return;
  rig->views = ReadPoses(path);
  rig->format = "COLMAP model";
}

std::string Digits(const std::string& name) {
  std::string digits;
  for (const char c : name)
    if (std::isdigit(static_cast<unsigned char>(c))) digits += c;
  while (digits.size() > 1 && digits.front() == '0') digits.erase(0, 1);
  return digits;
}

/// "cam1/000.jpg", "cam1.jpg" and "cam1" are one name.
std::string CameraName(const std::string& view_name) {
  const std::string first = *fs::path(view_name).begin();
  return fs::path(view_name).has_parent_path() ? first : fs::path(view_name).stem().string();
}

RigCalibration ReadCalibration(const fs::path& path, bool lens_only) {
  RigCalibration rig;
  if (fs::is_directory(path)) {
    ReadFolder(path, lens_only, &rig);
  } else if (path.extension() == ".json") {
    rig.views = ReadPoses(path);
    rig.format = "COLMAP model";
  } else {
    const std::string text = ReadFile(path);
    const std::string file = PrintableName(path.filename());
    const std::size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    if (IsYaml(path) || text.starts_with("%YAML")) {
      AddYamlFile(path, lens_only, &rig);
      rig.format = "OpenCV YAML";
    } else if (first != std::string::npos && text[first] == '<')
      AddQualisys(text, file, &rig);
    else
      ReadMatrices(text, file, &rig);
  }
  RequireCameras(rig, path);
  return rig;
}

std::string YamlOf(const std::vector<View>& views, bool places, bool metres) {
  std::string text = std::string("%YAML:1.0\n---\n") + (metres ? "unit: m\n" : "");
  const auto matrix = [&](const char* name, int rows, int cols, const std::vector<double>& data) {
    text +=
        fmt::format("  {}: !!opencv-matrix\n    rows: {}\n    cols: {}\n    dt: d\n    data: [ ",
                    name, rows, cols);
    for (std::size_t i = 0; i < data.size(); ++i)
      text += fmt::format("{}{:.17g}", i ? ", " : "", data[i]);
    text += " ]\n";
  };
  for (const View& view : views) {
    const Camera& c = view.camera;
    text += fmt::format("\"{}\":\n  image_width: {}\n  image_height: {}\n", view.name, c.width,
                        c.height);
    matrix("camera_matrix", 3, 3, {c.fx, 0, c.cx - 0.5, 0, c.fy, c.cy - 0.5, 0, 0, 1});
    matrix("distortion_coefficients", 1, 4, {c.k1, c.k2, c.p1, c.p2});
    if (!places) continue;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> r =
        view.camera_from_world.rotation.toRotationMatrix();
    matrix("rotation", 3, 3, std::vector<double>(r.data(), r.data() + 9));
    const Eigen::Vector3d& t = view.camera_from_world.translation;
    matrix("translation", 3, 1, {t.x(), t.y(), t.z()});
  }
  return text;
}

}  // namespace

RigCalibration ReadRigCalibration(const fs::path& path) { return ReadCalibration(path, false); }

RigCalibration ReadLensCalibration(const fs::path& path) { return ReadCalibration(path, true); }

std::string OpenCvYaml(const std::vector<View>& views, bool metres) {
  return YamlOf(views, true, metres);
}

std::string OpenCvLensYaml(const std::vector<View>& views) { return YamlOf(views, false, true); }

std::vector<int> MatchCameraNames(const std::vector<std::string>& cameras,
                                  const std::vector<View>& views) {
  const auto by = [&](auto&& key) {
    std::vector<int> found(cameras.size(), -1);
    std::set<int> used;
    for (std::size_t c = 0; c < cameras.size(); ++c)
      for (std::size_t v = 0; v < views.size(); ++v)
        if (const std::string name = key(cameras[c]); found[c] < 0 && !name.empty() &&
                                                      name == key(CameraName(views[v].name)) &&
                                                      used.insert(static_cast<int>(v)).second)
          found[c] = static_cast<int>(v);
    return found;
  };
  const auto complete = [](const std::vector<int>& found) {
    return std::find(found.begin(), found.end(), -1) == found.end();
  };
  const std::vector<int> named = by([](const std::string& name) { return name; });
  if (complete(named)) return named;
  const std::vector<int> numbered = by(Digits);
  if (complete(numbered)) return numbered;
  std::vector<int> ordered(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) ordered[c] = static_cast<int>(c);
  const bool any_named = std::any_of(named.begin(), named.end(), [](int v) { return v >= 0; });
  return !any_named && cameras.size() == views.size() ? ordered : named;
}

bool NumberedBefore(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      std::size_t ie = i, je = j;
      while (ie < a.size() && digit(a[ie])) ++ie;
      while (je < b.size() && digit(b[je])) ++je;
      while (i + 1 < ie && a[i] == '0') ++i;
      while (j + 1 < je && b[j] == '0') ++j;
      if (ie - i != je - j) return ie - i < je - j;
      const int order = a.compare(i, ie - i, b, j, je - j);
      if (order != 0) return order < 0;
      i = ie;
      j = je;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

}  // namespace keypose
