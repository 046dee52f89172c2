#include "core/io/project/rig_calibration.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/io/project/lens_use.h"
#include "core/io/project/metashape_io.h"
#include "core/io/project/opencv_lens.h"
#include "core/io/project/poses_io.h"
#include "core/io/project/qualisys_calibration.h"
#include "core/io/project/rig_parts.h"
#include "core/io/project/rig_programs.h"
#include "core/io/project/yaml_numbers.inc"
#include "core/io/text/files.h"
#include "core/io/text/text_file.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;
using yaml_numbers::FirstOf;
using yaml_numbers::YamlNumbers;

// ---- OpenCV YAML ----

/// What the file calls its lens model, in one of the ways in which programs say it.
std::string ModelOf(const YAML::Node& node) {
  const YAML::Node flag = FirstOf(node, {"fisheye_model", "fisheye", "is_fisheye"});
  if (flag && flag.IsScalar()) {
    const std::string said = flag.as<std::string>();
    if (said != "0" && said != "false" && said != "False" && said != "no") return "fisheye";
  }
  if (const YAML::Node name = FirstOf(node, {"distortion_model", "distortion_type"});
      name && name.IsScalar())
    return name.as<std::string>();
  for (const char* key : {"camera_model", "model", "model_type", "lens_model"})
    if (node[key] && node[key].IsScalar() && IsLensModelName(node[key].as<std::string>()))
      return node[key].as<std::string>();
  return "";
}

void PutSize(const YAML::Node& node, Lens* lens) {
  const std::vector<double> size =
      YamlNumbers(FirstOf(node, {"image_size", "resolution", "size", "img_size"}));
  if (size.size() == 2) {
    lens->width = SideOf(size[0]);
    lens->height = SideOf(size[1]);
  }
  if (const YAML::Node w = FirstOf(node, {"image_width", "width", "img_width"}))
    lens->width = w.as<int>();
  if (const YAML::Node h = FirstOf(node, {"image_height", "height", "img_height"}))
    lens->height = h.as<int>();
}

Lens LensOfYaml(const YAML::Node& node, const std::string& where) {
  const std::vector<double> k =
      YamlNumbers(FirstOf(node, {"camera_matrix", "K", "intrinsic_matrix", "intrinsics"}));
  if (k.size() != 9) throw InputError(where + ": `camera_matrix` must hold 9 numbers");
  RequireUpperTriangle(k.data(), where);
  const std::vector<double> d =
      YamlNumbers(FirstOf(node, {"distortion_coefficients", "D", "dist_coeffs", "distortion",
                                 "dist", "distortion_coeffs", "distCoeffs", "distortions"}));
  Lens lens = OpenCvLens(ModelOf(node), {k[0], k[4], k[2], k[5], k[1]}, d, where);
  PutSize(node, &lens);
  return lens;
}

View ViewOfYaml(const YAML::Node& node, const std::string& name, const std::string& where,
                bool lens_only) {
  View view;
  view.name = name;
  view.camera = UsableCamera(LensOfYaml(node, where), where);
  const YAML::Node translation =
      FirstOf(node, {"translation", "T", "tvec", "translation_vector", "t"});
  const YAML::Node rotation =
      FirstOf(node, {"rotation", "R", "rotation_matrix", "rvec", "rotation_vector"});
  if (!translation && !rotation) {
    if (lens_only) return view;
    throw InputError(where +
                     " has a lens but no place: `keypose calibrate --lenses` takes it, with films "
                     "of a board or points of known place");
  }
  const std::vector<double> t = YamlNumbers(translation);
  if (t.size() != 3) throw InputError(where + ": `translation` must hold 3 numbers");
  view.camera_from_world = {ExactRotation(RotationOf(YamlNumbers(rotation), where), where),
                            {t[0], t[1], t[2]}};
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

bool IsCameraNode(const YAML::Node& node) {
  return node.IsMap() && FirstOf(node, {"camera_matrix", "K", "intrinsic_matrix"});
}

void AddOpenCvNodes(const YAML::Node& root, const fs::path& path, bool lens_only,
                    RigCalibration* rig) {
  const std::string file = PrintableName(path.filename());
  const double unit = root.IsMap() ? UnitOf(root, file) : 0;
  if (IsCameraNode(root)) {
    rig->views.push_back(ViewOfYaml(root, path.stem().string(), file, lens_only));
  } else if (root.IsMap()) {
    for (const auto& item : root) {
      const std::string name = item.first.as<std::string>();
      if (IsCameraNode(item.second))
        rig->views.push_back(ViewOfYaml(item.second, name, file + ", " + name, lens_only));
    }
  }
  if (rig->metres_per_unit != 0 && unit != 0 && unit != rig->metres_per_unit)
    throw InputError(file + ": its unit is not that of the other files; give one unit to all");
  if (unit != 0) rig->metres_per_unit = unit;
}

/// OpenCV's, or what other programs make of it.
void AddYamlFile(const fs::path& path, bool lens_only, RigCalibration* rig) {
  const std::string file = PrintableName(path.filename()), text = ReadTextFile(path);
  if (path.extension() == ".json") RequireShallowJson(text, file);
  if (IsKalibr(text)) return AddKalibr(text, file, rig);
  if (IsMcCalib(text)) return AddMcCalib(text, file, rig);
  rig->format = "OpenCV YAML";
  try {
    AddOpenCvNodes(yaml_numbers::Parsed(text), path, lens_only, rig);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{} is not YAML that OpenCV writes ({})", file, error.what()));
  }
}

// ---- matrices ----

/// How far the skew of K shifts a pixel at the picture's top, which is about as far as at its
/// bottom.
double SkewShift_px(double skew, double fy, double cy) { return std::abs(skew / fy * cy); }

/// More skew than calibrations of real rigs have needs cameras that Keypose has not.
void RequireLittleSkew(double shift_px, const std::string& where) {
  constexpr double kMostSkew_px = 1;
  if (!(shift_px <= kMostSkew_px))
    throw InputError(
        fmt::format("{}: its K has skewed pixels, which move by up to {:.1f} px, but Keypose's "
                    "cameras are not skewed; calibrate without skew, or warp the pictures so that "
                    "K's second number is 0",
                    where, shift_px));
}

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
    RequireUpperTriangle(n.data(), where);
    View view;
    view.name = name;
    view.camera.fx = n[0];
    view.camera.fy = n[4];
    view.camera.cx = n[2] + 0.5;
    view.camera.cy = n[5] + 0.5;
    view.camera.k1 = n[9];
    view.camera.k2 = n[10];
    Eigen::Matrix3d r;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) r(i, j) = n[11 + 4 * i + j];
    view.camera_from_world = {ExactRotation(r, where), {n[14], n[18], n[22]}};
    RequireUsable(view, where);
    const double shift_px = SkewShift_px(n[1], n[4], n[5]);
    RequireLittleSkew(shift_px, where);
    largest_skew_px = std::max(largest_skew_px, shift_px);
    rig->views.push_back(view);
  }
  if (largest_skew_px > kSameLens_px)
    rig->notes.push_back(
        fmt::format("{}: skewed pixels are taken as square, which moves a pixel "
                    "by up to {:.1f} px",
                    file, largest_skew_px));
  rig->format = "matrices";
}

void RequireCameras(const RigCalibration& rig, const fs::path& path) {
  if (rig.views.empty())
    throw InputError(
        PrintableName(path) +
        " holds no camera that is known: OpenCV's YAML or JSON, what Kalibr, MC-Calib, "
        "EasyMocap, anipose or FreeMoCap write, a COLMAP model, a transforms.json, "
        "Metashape's XML, Qualisys' text, or numbers with K, distortion and camera from "
        "world");
  std::set<std::string> names;
  for (const View& view : rig.views)
    if (!names.insert(view.name).second)
      throw InputError(PrintableName(path) + " has two cameras named " + view.name);
}

/// Cameras as photographs' programs write them; the world's unit is theirs.
void ReadAsPoses(const fs::path& path, RigCalibration* rig) {
  for (const View& view : ReadPoses(path)) {
    if (view.camera.fx < 0)
      throw InputError(PrintableName(path) + ", camera " + view.name +
                       " has an angle of view but no size; give w and h");
    rig->views.push_back(view);
  }
  rig->format = "COLMAP model";
}

/// transforms.json has `frames`; OpenCV's JSON has not.
bool IsTransforms(const fs::path& path) {
  return path.extension() == ".json" && ReadTextFile(path).find("\"frames\"") != std::string::npos;
}

bool IsYaml(const fs::path& path) {
  return path.extension() == ".yml" || path.extension() == ".yaml";
}

void ReadFolder(const fs::path& path, bool lens_only, RigCalibration* rig) {
  if (fs::exists(path / "intri.yml") && fs::exists(path / "extri.yml"))
    return AddEasyMocap(ReadTextFile(path / "intri.yml"), ReadTextFile(path / "extri.yml"),
                        PrintableName(path.filename()), rig);
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (IsYaml(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NumberedBefore(a.stem().string(), b.stem().string());
  });
  for (const fs::path& file : files) AddYamlFile(file, lens_only, rig);
  if (!files.empty()) return;
  if (fs::exists(path / "calibration.toml"))
    return AddAnipose(ReadTextFile(path / "calibration.toml"), "calibration.toml", rig);
  ReadAsPoses(path, rig);
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

/// One file, by its content.
void ReadText(const fs::path& path, bool lens_only, RigCalibration* rig) {
  const std::string text = ReadTextFile(path);
  const std::string file = PrintableName(path.filename());
  const std::size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (path.extension() == ".toml")
    AddAnipose(text, file, rig);
  else if (IsYaml(path) || path.extension() == ".json" || text.starts_with("%YAML"))
    AddYamlFile(path, lens_only, rig);
  else if (IsMetashape(text))
    ReadAsPoses(path, rig);
  else if (first != std::string::npos && text[first] == '<')
    AddQualisys(text, file, rig);
  else
    ReadMatrices(text, file, rig);
}

RigCalibration ReadCalibration(const fs::path& path, bool lens_only) {
  RigCalibration rig;
  if (fs::is_directory(path)) {
    ReadFolder(path, lens_only, &rig);
  } else if (IsTransforms(path)) {
    ReadAsPoses(path, &rig);
  } else {
    ReadText(path, lens_only, &rig);
  }
  RequireCameras(rig, path);
  return rig;
}

/// A camera's name as a key: plain where it may be, since OpenCV's own reader takes no quotes round
/// keys (4.6 finds no such node, or refuses the file).
std::string KeyOf(const std::string& name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; };
  if (!name.empty() && name[0] != '-' && std::all_of(name.begin(), name.end(), plain)) return name;
  return '"' + name + '"';
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
    text += fmt::format("{}:\n  image_width: {}\n  image_height: {}\n", KeyOf(view.name), c.width,
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
