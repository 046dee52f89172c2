#include "core/io/project/known_points_io.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/io/text/json_pick.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

using nlohmann::json;

/// A list of points.json.
const json& PointsList(const json& root, const char* name, const std::string& file) {
  if (!root.contains(name) || !root[name].is_array())
    throw InputError(file + ": `" + name + "` must be a list");
  return root[name];
}

double PointsUnit(const json& root, const std::string& file) {
  if (!root.contains("unit")) return 1;
  const std::map<std::string, double> lengths{{"m", 1}, {"cm", 0.01}, {"mm", 0.001}};
  const auto found = root["unit"].is_string() ? lengths.find(root["unit"]) : lengths.end();
  if (found == lengths.end())
    throw InputError(file + ": `unit` must be m, cm or mm, the unit of the points' places");
  return found->second;
}

/// The index of the item of this name; -1: none.
template <class List, class NameOf>
int IndexOfName(const List& list, const std::string& name, NameOf&& name_of) {
  const auto found = std::find_if(list.begin(), list.end(),
                                  [&](const auto& item) { return name_of(item) == name; });
  return found == list.end() ? -1 : static_cast<int>(found - list.begin());
}

int PointNamed(const KnownPoints& points, const std::string& name) {
  return IndexOfName(points.points, name, [](const KnownPoint& p) { return p.name; });
}

int CameraNamed(const KnownPoints& points, const std::string& name) {
  return IndexOfName(points.cameras, name, [](const ClickedPicture& c) { return c.camera; });
}

std::string TextOf(const json& item, const char* name, const JsonPick<json>& pick) {
  if (!item.contains(name) || !item[name].is_string())
    pick.Fail(std::string("has no `") + name + "`");
  return item[name];
}

void ReadPointCameras(const json& root, const std::filesystem::path& path, const std::string& file,
                      KnownPoints* points) {
  int number = 0;
  for (const json& item : PointsList(root, "cameras", file)) {
    const JsonPick<json> pick(item, file, "camera", ++number);
    ClickedPicture camera;
    camera.camera = pick.Name();
    if (CameraNamed(*points, camera.camera) >= 0) pick.Fail("is there twice");
    if (item.contains("picture")) camera.picture = TextOf(item, "picture", pick);
    if (item.contains("size")) {
      const std::vector<double> size = pick.Numbers("size", 2);
      constexpr double kMost = 1e5;
      for (const double side : size)
        if (!(side >= 1 && side <= kMost)) pick.Fail("has a `size` that no picture has");
      camera.width = static_cast<int>(size[0]);
      camera.height = static_cast<int>(size[1]);
    } else if (!camera.picture.empty()) {
      const Image8 picture = ReadImage(path.parent_path() / camera.picture, 1);
      camera.width = picture.width;
      camera.height = picture.height;
    } else {
      pick.Fail("needs `size`, its pictures' width and height, or `picture`");
    }
    points->cameras.push_back(camera);
  }
}

void ReadPointClicks(const json& root, const std::string& file, KnownPoints* points) {
  int number = 0;
  for (const json& item : PointsList(root, "clicks", file)) {
    const JsonPick<json> pick(item, file, "click", ++number);
    const std::string camera = TextOf(item, "camera", pick), point = TextOf(item, "point", pick);
    const int c = CameraNamed(*points, camera), p = PointNamed(*points, point);
    if (c < 0) pick.Fail("names camera '" + camera + "', which is not in `cameras`");
    if (p < 0) pick.Fail("names point '" + point + "', which is not in `points`");
    ClickedPicture& clicked = points->cameras[c];
    if (std::any_of(clicked.clicks.begin(), clicked.clicks.end(),
                    [&](const PointClick& click) { return click.point == p; }))
      pick.Fail("is the second one of '" + point + "' in camera " + camera);
    clicked.clicks.push_back(
        {p, pick.Pixel(clicked.width, clicked.height, "picture of camera " + camera)});
  }
}

}  // namespace

KnownPoints ReadKnownPoints(const std::filesystem::path& path) {
  const std::string file = PrintableName(path.filename());
  const json root = ReadJson<json>(path);
  if (!root.is_object()) throw InputError(file + " holds no object");
  if (!root.contains("schema") || root["schema"] != 1)
    throw InputError(file + ": `schema` must be 1");
  KnownPoints points;
  const double unit = PointsUnit(root, file);
  int number = 0;
  for (const json& item : PointsList(root, "points", file)) {
    const JsonPick<json> pick(item, file, "point", ++number);
    KnownPoint point;
    point.name = pick.Name();
    if (PointNamed(points, point.name) >= 0) pick.Fail("is there twice");
    const std::vector<double> place = pick.Numbers("place", 3);
    constexpr double kMost = 1e6;
    for (int i = 0; i < 3; ++i) {
      if (std::abs(place[i]) > kMost) pick.Fail("has a `place` beyond all rooms");
      point.place[i] = unit * place[i];
    }
    points.points.push_back(point);
  }
  ReadPointCameras(root, path, file, &points);
  ReadPointClicks(root, file, &points);
  return points;
}

std::string KnownPointsText(const KnownPoints& points) {
  nlohmann::ordered_json root{{"schema", 1}, {"unit", "m"}};
  root["points"] = json::array();
  root["cameras"] = json::array();
  root["clicks"] = json::array();
  for (const KnownPoint& p : points.points)
    root["points"].push_back(
        {{"name", p.name}, {"place", {p.place.x(), p.place.y(), p.place.z()}}});
  for (const ClickedPicture& c : points.cameras) {
    nlohmann::ordered_json camera{{"name", c.camera}};
    if (!c.picture.empty()) camera["picture"] = c.picture;
    camera["size"] = {c.width, c.height};
    root["cameras"].push_back(camera);
    for (const PointClick& click : c.clicks)
      root["clicks"].push_back({{"camera", c.camera},
                                {"point", points.points[click.point].name},
                                {"pixel", {click.pixel.x(), click.pixel.y()}}});
  }
  return root.dump(1) + "\n";
}

}  // namespace keypose
