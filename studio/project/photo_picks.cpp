#include "studio/project/photo_picks.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "studio/project/changes.h"
#include "studio/project/originals.h"
#include "studio/project/picks.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostPicks = 10'000, kLongestName = 200;

struct PhotoPick {
  std::string name, image;
  Eigen::Vector2d pixel;
  std::string photograph;  ///< SHA-256 of the one it was picked in; empty: not known
};

/// A photograph as capture has written it, which picks are made in.
struct CapturedPhotograph {
  int width = 0, height = 0;
  std::string hash;
  bool shot_again = false;  ///< there is a newer one, which capture has not read yet
};
using CapturedPhotographs = std::map<std::string, CapturedPhotograph>;

void RequireFitted(Snapshot& snapshot, const std::string& pose) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  if (!snapshot.IsFitted(pose))
    throw UsageError(fmt::format("pose '{}' is scanned: it is picked on its mesh", pose));
}

/// @throws UsageError  in words that follow the pick's name
PhotoPick PickOf(const json& value) {
  if (!value.is_object()) throw UsageError("is not an object");
  const json name = value.value("name", json()), image = value.value("image", json()),
             pixel = value.value("pixel", json());
  if (!name.is_string() || name == "" || name.get<std::string>().size() > kLongestName ||
      !IsValidUtf8(name.get<std::string>()))
    throw UsageError("has no name");
  if (!image.is_string() || !IsOneName(image.get<std::string>()))
    throw UsageError("does not say in which photograph it is");
  if (!pixel.is_array() || pixel.size() != 2 || !pixel[0].is_number() || !pixel[1].is_number())
    throw UsageError("needs 'pixel': two numbers");
  const Eigen::Vector2d at(pixel[0].get<double>(), pixel[1].get<double>());
  if (!at.allFinite()) throw UsageError("needs 'pixel': two numbers");
  const json photograph = value.value("photograph", json(""));
  if (!photograph.is_string() || photograph.get<std::string>().size() > kLongestName)
    throw UsageError("has a 'photograph' that is no SHA-256");
  return {name, image, at, photograph};
}

json PixelJson(const Eigen::Vector2d& pixel) {
  const auto rounded = [](double value) { return std::round(100 * value) / 100; };
  return {rounded(pixel.x()), rounded(pixel.y())};
}

json PickJson(const PhotoPick& pick) {
  json value = {{"name", pick.name}, {"image", pick.image}, {"pixel", PixelJson(pick.pixel)}};
  if (!pick.photograph.empty()) value["photograph"] = pick.photograph;
  return value;
}

/// The file's content; an empty object without a file. @throws InputError  it cannot be read
json Written(const fs::path& file) {
  if (!fs::is_regular_file(file)) return json::object();
  const json root = JsonOfFile(file);
  const bool fine = root.is_object() && root.value("pixels", json::array()).is_array();
  if (!fine) throw InputError(file.filename().string() + " holds no picks in photographs");
  return root;
}

/// The pose's picks; `fault(name, words)` is told of those that cannot be read.
template <class Fault>
std::vector<PhotoPick> PicksIn(const json& root, const Fault& fault) {
  std::vector<PhotoPick> picks;
  for (const json& value : root.value("pixels", json::array())) try {
      picks.push_back(PickOf(value));
    } catch (const UsageError& error) {
      const json name = value.is_object() ? value.value("name", json()) : json();
      fault(name.is_string() ? name.get<std::string>() : "", error.what());
    }
  return picks;
}

CapturedPhotographs Captured(Snapshot& snapshot, const std::string& pose) {
  CapturedPhotographs by_name;
  const auto result = snapshot.Result("capture", pose);
  if (!result || !result->outputs.contains("images")) return by_name;
  const Originals originals(snapshot, pose);
  const auto& hashes = result->outputs.at("images").content.files;
  for (const CapturedImage& image : ReadImageSet(result->Path("images")).images) {
    const auto hash = hashes.find(image.name);
    by_name[image.name] = {image.width, image.height, hash == hashes.end() ? "" : hash->second,
                           originals.WasShotAgain(image.name)};
  }
  return by_name;
}

/// Whether the pick was made in another photograph of that name, so that fit leaves it out.
bool IsInAnother(const PhotoPick& pick, const CapturedPhotographs& photographs) {
  const auto found = photographs.find(pick.image);
  return found != photographs.end() && !pick.photograph.empty() &&
         pick.photograph != found->second.hash;
}

/// @throws UsageError
void RequirePick(const PhotoPick& pick, const CapturedPhotographs& photographs) {
  const auto found = photographs.find(pick.image);
  if (found == photographs.end())
    throw UsageError(
        fmt::format("landmark '{}' is in photograph '{}', which the pose does not have", pick.name,
                    pick.image));
  if (IsInAnother(pick, photographs))
    throw UsageError(
        fmt::format("landmark '{}' was picked in an older photograph '{}'", pick.name, pick.image));
  const auto [width, height, hash, shot_again] = found->second;
  if (pick.pixel.minCoeff() < 0 || pick.pixel.x() > width || pick.pixel.y() > height)
    throw UsageError(
        fmt::format("landmark '{}' is outside of photograph '{}', which has {} x {} pixels",
                    pick.name, pick.image, width, height));
}

/// What the file says of a pick beside what the page shows: found by name, or, where that has
/// changed, by its place.
json OldEntry(const json& old, const PhotoPick& pick) {
  for (const bool by_name : {true, false})
    for (const json& entry : old) {
      const PhotoPick other = PickOf(entry);
      const bool same = by_name ? other.name == pick.name : other.pixel == pick.pixel;
      if (same && other.image == pick.image) return entry;
    }
  return json::object();
}

/// Whether that is an entry of the same place.
bool IsAt(const json& entry, const PhotoPick& pick) {
  return entry.contains("pixel") && PixelJson(PickOf(entry).pixel) == PixelJson(pick.pixel);
}

/// A pick a line: small changes are small in a comparison, too.
std::string PicksText(const json& root) {
  std::string text = "{";
  for (const auto& [key, value] : root.items()) {
    text += (text.size() > 1 ? ",\n " : "") + json(key).dump() + ": ";
    if (!value.is_array()) {
      text += value.dump();
      continue;
    }
    text += "[";
    for (std::size_t i = 0; i < value.size(); ++i) text += (i ? ",\n  " : "\n  ") + value[i].dump();
    text += "\n ]";
  }
  return text + "}\n";
}

/// A pick that is new or was moved was made in the photograph that is captured now.
json WithPicks(json root, const std::vector<PhotoPick>& picks,
               const CapturedPhotographs& photographs) {
  const json old = root.value("pixels", json::array());
  json pixels = json::array();
  for (const PhotoPick& pick : picks) {
    json entry = OldEntry(old, pick);
    const auto captured = photographs.find(pick.image);
    if (!IsAt(entry, pick) && captured != photographs.end())
      entry["photograph"] = captured->second.hash;
    entry.update(PickJson(pick));
    pixels.push_back(entry);
  }
  root["schema"] = 2;
  root["pixels"] = pixels;
  return root;
}

/// What the last fit found, ready for questions.
struct Fitted {
  Mesh mesh;
  std::map<std::string, View> views;
  std::vector<Landmark> marks;  // of the template
  json measurements = json::object();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double radius = 0;
};

std::optional<Fitted> LastFit(Snapshot& snapshot, const std::string& pose) {
  const auto mesh = snapshot.MeshPath(pose, MeshKind::kMesh), model = snapshot.CamerasPath(pose);
  const auto result = snapshot.Result("fit", pose);
  if (!mesh || !model || !result) return std::nullopt;
  Fitted fitted;
  fitted.mesh = ReadMesh(*mesh);
  for (const View& view : ReadColmapModel(*model).views) fitted.views[view.name] = view;
  const json report = json::parse(ReadFile(result->folder / "report.json"), nullptr, false);
  if (report.is_object()) fitted.measurements = report.value("measurements", json::object());
  fitted.middle = fitted.mesh.points.colwise().mean();
  fitted.radius = BoundingDiagonal(fitted.mesh.points) / 2;
  Mesh rest;
  std::vector<Landmark> marks = TemplatePicks(snapshot, &rest);
  // A template that was made anew since has other faces than the fitted one.
  if (rest.faces.rows() == fitted.mesh.faces.rows()) fitted.marks = std::move(marks);
  return fitted;
}

json ShownJson(const Fitted& fitted) {
  const RayScene scene(fitted.mesh.points, fitted.mesh.faces);
  json shown = json::array();
  for (const Landmark& mark : fitted.marks)
    for (const auto& [name, view] : fitted.views) {
      const Eigen::Vector3d x = PositionOf(mark, fitted.mesh), eye = view.Center();
      if ((view.camera_from_world * x).z() <= 0) continue;
      constexpr double kBefore = 0.995;  // of the way: the place does not hide itself
      shown.push_back({{"name", mark.name},
                       {"image", name},
                       {"pixel", PixelJson(view.Project(x))},
                       {"hidden", scene.Occluded(eye, x - eye, 0, kBefore)}});
    }
  return shown;
}

bool IsInPicture(const Eigen::Vector2d& pixel, const Camera& camera) {
  return pixel.minCoeff() >= 0 && pixel.x() <= camera.width && pixel.y() <= camera.height;
}

Eigen::Vector3d RayOf(const View& view, const Eigen::Vector2d& pixel) {
  return (view.camera_from_world.rotation.conjugate() * view.camera.Unproject(pixel)).normalized();
}

/// Where `other` may show what `view` shows at a pixel, as far as the figure reaches.
json LineJson(const Fitted& fitted, const View& view, const Eigen::Vector2d& pixel,
              const View& other) {
  constexpr int kSteps = 40;
  constexpr double kMargin = 1.1;
  const Eigen::Vector3d eye = view.Center(), ray = RayOf(view, pixel);
  const double way = ray.dot(fitted.middle - eye), reach = kMargin * fitted.radius;
  json points = json::array();
  for (int i = 0; i <= kSteps; ++i) {
    const double along = std::max(0.0, way + reach * (2.0 * i / kSteps - 1));
    const Eigen::Vector3d x = other.camera_from_world * (eye + along * ray);
    if (x.z() <= 0) continue;
    const Eigen::Vector2d seen = other.camera.Project(x);
    if (IsInPicture(seen, other.camera)) points.push_back(PixelJson(seen));
  }
  return points;
}

/// The place nearest to all rays; none where they are nearly parallel.
std::optional<Eigen::Vector3d> Meeting(const std::vector<std::pair<View, Eigen::Vector2d>>& picks) {
  Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  for (const auto& [view, pixel] : picks) {
    const Eigen::Vector3d ray = RayOf(view, pixel);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    h += across;
    g += across * view.Center();
  }
  constexpr double kLeastAngle = 1e-4;  // squared sine, about half a degree
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(h);
  if (axes.eigenvalues()[0] < kLeastAngle * static_cast<double>(picks.size())) return std::nullopt;
  return h.ldlt().solve(g);
}

void AddHints(const Fitted& fitted, const std::vector<PhotoPick>& picks,
              const CapturedPhotographs& photographs, json& answer) {
  std::map<std::string, std::vector<std::pair<View, Eigen::Vector2d>>> by_name;
  for (const PhotoPick& pick : picks)
    if (IsInAnother(pick, photographs))
      continue;
    else if (const auto view = fitted.views.find(pick.image); view != fitted.views.end())
      by_name[pick.name].emplace_back(view->second, pick.pixel);
  for (const auto& [name, of] : by_name) {
    const auto place = of.size() > 1 ? Meeting(of) : std::nullopt;
    for (const auto& [image, view] : fitted.views) {
      if (place && (view.camera_from_world * *place).z() > 0)
        answer["meets"].push_back(
            {{"name", name}, {"image", image}, {"pixel", PixelJson(view.Project(*place))}});
      if (of.size() > 1 || of[0].first.name == image) continue;
      if (const json points = LineJson(fitted, of[0].first, of[0].second, view); points.size() > 1)
        answer["lines"].push_back({{"name", name}, {"image", image}, {"points", points}});
    }
  }
}

json RefusedJson(const json& measurements) {
  json refused = json::array();
  for (const json& mark : measurements.value("landmarks_off", json::array()))
    if (mark.value("refused", false) && mark.contains("image"))
      refused.push_back({{"name", mark.at("name")}, {"image", mark.at("image")}});
  return refused;
}

json PhotographsOfFit(const CapturedPhotographs& captured, const Fitted* fitted) {
  std::map<std::string, json> quality;
  if (fitted)
    for (const json& view : fitted->measurements.value("views", json::array()))
      quality[view.at("image")] = view;
  json all = json::array();
  for (const auto& [name, photograph] : captured) {
    const json& view = quality[name];
    const auto of = [&](const char* key) {
      return view.is_object() ? view.value(key, json()) : json();
    };
    all.push_back({{"name", name},
                   {"width", photograph.width},
                   {"height", photograph.height},
                   {"photograph", photograph.hash},
                   {"shot_again", photograph.shot_again},
                   {"placed", fitted && fitted->views.contains(name)},
                   {"iou", of("iou")},
                   {"worst", of("worst")}});
  }
  return all;
}

}  // namespace

json PhotoPicksJson(Snapshot& snapshot, const std::string& pose) {
  RequireFitted(snapshot, pose);
  json answer = {{"pose", pose},
                 {"revision", ""},
                 {"picks", json::array()},
                 {"pixels", json::array()},
                 {"problems", json::array()}};
  const auto problem = [&](const std::string& name, const std::string& text) {
    answer["problems"].push_back({{"name", name}, {"text", text}});
  };
  try {
    const fs::path file = PicksFile(snapshot, pose);
    answer["revision"] = RevisionOf(file);
    const CapturedPhotographs photographs = Captured(snapshot, pose);
    const auto unread = [&](const std::string& name, const std::string& words) {
      problem(name, fmt::format("A pick of {} {}.", file.filename().string(), words));
    };
    for (const PhotoPick& pick : PicksIn(Written(file), unread)) {
      answer["pixels"].push_back(PickJson(pick));
      if (photographs.empty()) continue;
      try {
        RequirePick(pick, photographs);
      } catch (const UsageError& error) {
        problem(pick.name, error.what());
      }
    }
  } catch (const Error& error) {
    problem("", error.what());
  }
  return answer;
}

void SavePhotoPicks(Snapshot& snapshot, const std::string& pose, const json& body) {
  RequireFitted(snapshot, pose);
  const fs::path file = PicksFile(snapshot, pose);
  if (RevisionOf(file) != body.at("revision").get<std::string>())
    throw ChangedMeanwhile(file.filename().string() + " was changed elsewhere; it was read again");
  if (body.at("pixels").size() > kMostPicks) throw UsageError("more than 10000 picks");
  const json root = Written(file);
  PicksIn(root, [&](const std::string& name, const std::string& words) {
    throw InputError(fmt::format("{}: a pick{} {}; mend or delete it in an editor first",
                                 file.filename().string(), name.empty() ? "" : " '" + name + "'",
                                 words));
  });
  const CapturedPhotographs photographs = Captured(snapshot, pose);
  const json old = root.value("pixels", json::array());
  std::vector<PhotoPick> picks;
  std::set<std::pair<std::string, std::string>> taken;
  for (const json& value : body.at("pixels")) {
    PhotoPick pick;
    try {
      pick = PickOf(value);
    } catch (const UsageError& error) {
      throw UsageError(std::string("a landmark ") + error.what());
    }
    // What stands in the file already may be of a photograph that is gone or was shot again.
    if (!IsAt(OldEntry(old, pick), pick)) RequirePick(pick, photographs);
    if (!taken.emplace(pick.name, pick.image).second)
      throw UsageError(
          fmt::format("landmark '{}' is twice in photograph '{}'", pick.name, pick.image));
    picks.push_back(std::move(pick));
  }
  json changed = WithPicks(root, picks, photographs);
  if (picks.empty()) {
    changed.erase("pixels");
    changed.erase("schema");
  }
  if (changed.empty()) return RemovePicks(snapshot, pose);
  if (picks.empty()) changed["schema"] = 2;
  fs::create_directories(file.parent_path());
  WriteFileAtomically(file, PicksText(changed));
}

json PhotoFitJson(Snapshot& snapshot, const std::string& pose) {
  RequireFitted(snapshot, pose);
  json answer = {{"shown", json::array()},
                 {"lines", json::array()},
                 {"meets", json::array()},
                 {"refused", json::array()}};
  const CapturedPhotographs photographs = Captured(snapshot, pose);
  const std::optional<Fitted> fitted = LastFit(snapshot, pose);
  answer["photographs"] = PhotographsOfFit(photographs, fitted ? &*fitted : nullptr);
  if (!fitted) return answer;
  answer["shown"] = ShownJson(*fitted);
  answer["refused"] = RefusedJson(fitted->measurements);
  const auto unread = [](const std::string&, const std::string&) {};
  try {
    AddHints(*fitted, PicksIn(Written(PicksFile(snapshot, pose)), unread), photographs, answer);
  } catch (const Error&) {
    // PhotoPicksJson tells of it.
  }
  return answer;
}

}  // namespace keypose::studio
