#include "core/io/project/metashape_io.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/io/project/lens_use.h"
#include "core/io/project/rig_parts.h"
#include "core/io/text/xml_depth.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

using boost::property_tree::ptree;

std::vector<double> NumbersIn(const std::string& text) {
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

std::string AttributeOf(const ptree& node, const char* name) {
  return node.get(std::string("<xmlattr>.") + name, std::string());
}

double NumberOf(const ptree& node, const std::string& where, const std::string& name) {
  const std::vector<double> numbers = NumbersIn(node.data());
  if (numbers.size() != 1)
    throw InputError(fmt::format("{}: `{}` is '{}', not a number", where, name, node.data()));
  return numbers[0];
}

/// A chunk's or component's own transform, of its parts; none: it has none.
std::optional<Similarity3> TransformOf(const ptree& node, const std::string& where) {
  const auto transform = node.get_child_optional("transform");
  if (!transform) return std::nullopt;
  Similarity3 similarity;
  if (const auto r = NumbersIn(transform->get("rotation", std::string())); r.size() == 9)
    similarity.rotation =
        ExactRotation(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data()),
                      where)
            .toRotationMatrix();
  if (const auto t = NumbersIn(transform->get("translation", std::string())); t.size() == 3)
    similarity.translation = {t[0], t[1], t[2]};
  if (const auto s = NumbersIn(transform->get("scale", std::string())); s.size() == 1)
    similarity.scale = s[0];
  if (!(similarity.scale > 0)) throw InputError(where + ": its scale is not positive");
  return similarity;
}

/// The adjusted calibration, or the one that there is.
const ptree& CalibrationOf(const ptree& sensor, const std::string& where) {
  const ptree* best = nullptr;
  int rank = -1;
  for (const auto& [name, node] : sensor) {
    if (name != "calibration") continue;
    const std::string kind = AttributeOf(node, "class");
    int found = 1;
    if (kind == "adjusted") found = 2;
    if (kind == "initial") found = 0;
    if (found > rank) best = &node;
    rank = std::max(rank, found);
  }
  if (!best) throw InputError(where + " has no calibration; align the photographs first");
  return *best;
}

void PutSize(const ptree& calibration, const ptree& sensor, Lens* lens) {
  const ptree none;
  const ptree& own = calibration.get_child("resolution", none);
  const ptree& size = own.empty() ? sensor.get_child("resolution", none) : own;
  lens->width = SideOf(size.get("<xmlattr>.width", 0.0));
  lens->height = SideOf(size.get("<xmlattr>.height", 0.0));
}

/// The numbers of a calibration, which count cx and cy from the picture's middle.
class CalibrationNumbers {
 public:
  CalibrationNumbers(const ptree& calibration, const std::string& where) {
    // what a calibration holds beside numbers of the lens
    const std::set<std::string> others{"<xmlattr>", "<xmlcomment>", "resolution", "covariance",
                                       "date"};
    const std::set<std::string> known{"f",  "cx", "cy", "b1", "b2", "k1", "k2",
                                      "k3", "k4", "p1", "p2", "p3", "p4"};
    for (const auto& [name, node] : calibration) {
      if (others.contains(name)) continue;
      if (name == "fx" || name == "fy" || name == "skew")
        RefuseModel("of PhotoScan before 1.3 (fx, fy, skew)", where);
      const double number = NumberOf(node, where, name);
      if (!known.contains(name) && number != 0) RefuseModel("with " + name, where);
      numbers_[name] = number;
    }
    if (!numbers_.contains("f")) throw InputError(where + ": its calibration has no f");
  }
  double operator[](const char* name) const {
    const auto found = numbers_.find(name);
    return found == numbers_.end() ? 0.0 : found->second;
  }

 private:
  std::map<std::string, double> numbers_;
};

LensProjection ProjectionOf(const std::string& type, const std::string& where) {
  if (type.empty() || type == "frame") return LensProjection::kPerspective;
  if (type == "fisheye" || type == "equidistant_fisheye") return LensProjection::kEquidistant;
  if (type == "equisolid_fisheye") return LensProjection::kEquisolid;
  RefuseModel("of type " + type, where);
}

Lens LensOfSensor(const ptree& sensor, const std::string& where) {
  const ptree& calibration = CalibrationOf(sensor, where);
  std::string type = AttributeOf(calibration, "type");
  if (type.empty()) type = AttributeOf(sensor, "type");
  Lens lens;
  lens.projection = ProjectionOf(type, where);
  const CalibrationNumbers n(calibration, where);
  PutSize(calibration, sensor, &lens);
  if (lens.width < 1 || lens.height < 1) throw InputError(where + " has no resolution");
  lens.model = "Metashape's " + (type.empty() ? "frame" : type);
  lens.fx = n["f"] + n["b1"];
  lens.fy = n["f"];
  lens.skew = n["b2"];
  lens.cx = 0.5 * lens.width + n["cx"];
  lens.cy = 0.5 * lens.height + n["cy"];
  lens.radial = {n["k1"], n["k2"], n["k3"], n["k4"], 0, 0};
  lens.p1 = n["p2"];  // Metashape's P1 bends along x
  lens.p2 = n["p1"];
  lens.p3 = n["p3"];
  lens.p4 = n["p4"];
  RequireUsableLens(lens, where);
  return lens;
}

/// World is here the chunk's, or the component's, own frame.
Rigid3 CameraFromWorld(const std::vector<double>& n, const std::string& where) {
  if (n.size() != 16) throw InputError(where + ": its transform must hold 16 numbers");
  const Eigen::Matrix4d m =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(n.data());
  if (!m.allFinite() || m.cwiseAbs().maxCoeff() > kMostCoordinate)
    throw InputError(where + ": its place is not finite or beyond 1e12");
  const Rigid3 world_from_camera{ExactRotation(m.topLeftCorner<3, 3>(), where),
                                 m.topRightCorner<3, 1>()};
  return world_from_camera.Inverse();
}

/// The chunk's parts, and the views that they make.
class ChunkReader {
 public:
  ChunkReader(const ptree& chunk, const std::string& file) : file_(file) {
    const ptree none;
    for (const auto& [name, node] : chunk.get_child("sensors", none))
      if (name == "sensor") sensors_[AttributeOf(node, "id")] = &node;
    for (const auto& [name, node] : chunk.get_child("components", none))
      if (name == "component")
        components_[AttributeOf(node, "id")] =
            TransformOf(node, fmt::format("{}, component {}", file, AttributeOf(node, "id")));
    ReadCameras(chunk.get_child("cameras", none));
  }
  std::vector<LensView> Views() {
    if (views_.empty())
      throw InputError(file_ + " holds no camera with a place; align the photographs, then export");
    JoinComponents();
    return views_;
  }

 private:
  /// Cameras lie in the list itself, or in groups of it.
  void ReadCameras(const ptree& list) {
    for (const auto& [name, node] : list) {
      if (name == "group") ReadCameras(node);
      if (name == "camera") ReadCamera(node);
    }
  }
  void ReadCamera(const ptree& node) {
    const std::string label = AttributeOf(node, "label"), enabled = AttributeOf(node, "enabled");
    const std::string where = fmt::format("{}, camera {}", file_, label);
    const auto transform = node.get_child_optional("transform");
    const bool off = enabled == "false" || enabled == "0";
    if (!transform || off) {
      if (!off && !AttributeOf(node, "master_id").empty())
        RefuseModel("of a multi-camera system (a camera placed by its master)", where);
      return;
    }
    RequireUpright(node, where);
    LensView view;
    view.name = label;
    view.camera_from_world = CameraFromWorld(NumbersIn(transform->data()), where);
    view.lens = LensOfId(AttributeOf(node, "sensor_id"), where);
    component_of_.push_back(AttributeOf(node, "component_id"));
    views_.push_back(std::move(view));
  }
  void RequireUpright(const ptree& node, const std::string& where) const {
    const int orientation = node.get("orientation", 1);
    if (orientation > 1)
      throw InputError(
          fmt::format("{}: its photograph is turned by its EXIF orientation ({}), but "
                      "Metashape's cameras are those of the stored pixels; turn the "
                      "photographs themselves, such as by `exiftran -a`, and align again",
                      where, orientation));
  }
  const Lens& LensOfId(const std::string& id, const std::string& where) {
    const auto known = lenses_.find(id);
    if (known != lenses_.end()) return known->second;
    const auto sensor = sensors_.find(id);
    if (sensor == sensors_.end())
      throw InputError(
          fmt::format("{} names the sensor {}, which the file does not have", where, id));
    const std::string name =
        fmt::format("{}, sensor {}", file_, AttributeOf(*sensor->second, "label"));
    return lenses_.emplace(id, LensOfSensor(*sensor->second, name)).first->second;
  }
  /// Each component has a frame of its own.
  void JoinComponents() {
    const std::string& first = component_of_.front();
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (component_of_[v] == first) continue;
      const auto to = components_.find(first), from = components_.find(component_of_[v]);
      if (to == components_.end() || from == components_.end() || !to->second || !from->second)
        throw InputError(
            fmt::format("{}, camera {} is in another component than {}, and nothing says "
                        "how they lie; export one component",
                        file_, views_[v].name, views_.front().name));
      Move(*to->second, *from->second, &views_[v]);
    }
  }
  static void Move(const Similarity3& world_from_first, const Similarity3& world_from_own,
                   LensView* view) {
    const Eigen::Vector3d center = view->camera_from_world.Inverse().translation;
    const Eigen::Matrix3d first_from_own =
        world_from_first.rotation.transpose() * world_from_own.rotation;
    Rigid3& pose = view->camera_from_world;
    pose.rotation = (pose.rotation * Eigen::Quaterniond(first_from_own).conjugate()).normalized();
    pose.translation = -(pose.rotation * (world_from_first.Inverse() * (world_from_own * center)));
  }

  const std::string& file_;
  std::map<std::string, const ptree*> sensors_;
  std::map<std::string, std::optional<Similarity3>> components_;
  std::map<std::string, Lens> lenses_;
  std::vector<LensView> views_;
  std::vector<std::string> component_of_;  ///< of each view
};

}  // namespace

bool IsMetashape(const std::string& text) {
  return text.find("<document") != std::string::npos && text.find("<chunk") != std::string::npos;
}

std::vector<LensView> ParseMetashape(const std::string& text, const std::string& file) {
  RequireShallowXml(text, file);
  ptree tree;
  std::istringstream in(text);
  try {
    boost::property_tree::read_xml(in, tree);
  } catch (const boost::property_tree::xml_parser_error& error) {
    throw InputError(fmt::format("{}:{}: not whole XML ({}); export the cameras again", file,
                                 error.line(), error.message()));
  }
  const ptree none;
  std::vector<const ptree*> chunks;
  for (const auto& [name, node] : tree.get_child("document", none))
    if (name == "chunk") chunks.push_back(&node);
  if (chunks.size() != 1)
    throw InputError(
        fmt::format("{} has {} chunks; export the cameras of one", file, chunks.size()));
  return ChunkReader(*chunks.front(), file).Views();
}

}  // namespace keypose
