#include "core/io/project/metashape_write.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

std::string XmlWord(const std::string& text) {
  const bool control =
      std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < ' '; });
  if (!IsValidUtf8(text) || control)
    throw InputError(fmt::format(
        "{}: XML cannot hold this name (it is not UTF-8, or has control characters); rename it",
        PrintableName(text)));
  const std::map<char, const char*> escapes{
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string word;
  for (const char c : text) {
    const auto found = escapes.find(c);
    word += found == escapes.end() ? std::string(1, c) : found->second;
  }
  return word;
}

using SensorKey = std::array<double, 10>;
SensorKey SensorKeyOf(const Camera& c) {
  return {double(c.width), double(c.height), c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
}

std::string SensorText(int id, const Camera& camera) {
  const std::string size =
      fmt::format("<resolution width=\"{}\" height=\"{}\"/>", camera.width, camera.height);
  const std::vector<std::pair<const char*, double>> numbers{
      {"f", camera.fy},
      {"cx", camera.cx - 0.5 * camera.width},
      {"cy", camera.cy - 0.5 * camera.height},
      {"b1", camera.fx - camera.fy},
      {"k1", camera.k1},
      {"k2", camera.k2},
      {"p1", camera.p2},  // Metashape's P1 bends along x
      {"p2", camera.p1}};
  std::string text = fmt::format(
      "   <sensor id=\"{0}\" label=\"camera {0}\" type=\"frame\">\n    {1}\n    <calibration "
      "type=\"frame\" class=\"adjusted\">\n     {1}\n",
      id, size);
  for (const auto& [name, number] : numbers)
    text += fmt::format("     <{0}>{1}</{0}>\n", name, number);
  return text + "    </calibration>\n   </sensor>\n";
}

/// Camera to world, x right, y down, z forwards.
std::string MatrixText(const Rigid3& camera_from_world) {
  const Rigid3 world_from_camera = camera_from_world.Inverse();
  const Eigen::Matrix3d r = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = world_from_camera.translation;
  std::string text;
  for (int i = 0; i < 3; ++i) text += fmt::format("{} {} {} {} ", r(i, 0), r(i, 1), r(i, 2), t(i));
  return text + "0 0 0 1";
}

/// Newer releases read a component's transform, older ones the chunk's.
constexpr const char* kIdentity =
    "<transform><rotation>1 0 0 0 1 0 0 0 1</rotation><translation>0 0 "
    "0</translation><scale>1</scale></transform>";

}  // namespace

std::string MetashapeText(const std::vector<View>& views, const std::vector<std::string>& labels,
                          const std::string& chunk) {
  std::map<SensorKey, int> ids;
  std::string sensors, cameras;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto [sensor, added] =
        ids.emplace(SensorKeyOf(views[v].camera), static_cast<int>(ids.size()));
    if (added) sensors += SensorText(sensor->second, views[v].camera);
    cameras += fmt::format(
        "   <camera id=\"{}\" sensor_id=\"{}\" component_id=\"0\" label=\"{}\" enabled=\"true\">\n"
        "    <transform>{}</transform>\n    <orientation>1</orientation>\n   </camera>\n",
        v, sensor->second, XmlWord(labels[v]), MatrixText(views[v].camera_from_world));
  }
  return fmt::format(
      R"xml(<?xml version="1.0" encoding="UTF-8"?>
<document version="2.0.0">
 <chunk label="{}" enabled="true">
  <sensors next_id="{}">
{}  </sensors>
  <components next_id="1" active_id="0">
   <component id="0" label="Component 1">{}</component>
  </components>
  <cameras next_id="{}" next_group_id="0">
{}  </cameras>
  <reference>LOCAL_CS["Local Coordinates (m)",LOCAL_DATUM["Local Datum",0],UNIT["metre",1,AUTHORITY["EPSG","9001"]]]</reference>
  {}
 </chunk>
</document>
)xml",
      XmlWord(chunk), ids.size(), sensors, kIdentity, views.size(), cameras, kIdentity);
}

}  // namespace keypose
