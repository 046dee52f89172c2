#include "core/io/project/mending_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/io/project/binding_io.h"
#include "core/io/text/files.h"
#include "core/io/text/json_pick.h"
#include "core/surfaces/mesh_binding.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {

using Eigen::Vector3d;
using nlohmann::json;

namespace {

// A stroke that has lost more of its places than this is not the same stroke any more.
constexpr double kMostPlacesLost = 0.25;
// How far a written point may lie off the mesh, of the brush's radius.
constexpr double kMostOff = 0.5;

std::string TitleOf(std::size_t index, const MendStroke& stroke) {
  return fmt::format("stroke {} ({})", index + 1, NameOf(stroke.tool));
}

/// Finds the places of strokes on the present mesh.
class StrokePlaces {
 public:
  StrokePlaces(const json& root, const std::filesystem::path& path, const Mesh& mesh)
      : mesh_(mesh),
        binding_(BindingFrom(root.value("mesh", json::object()), path)),
        scene_(mesh.points, mesh.faces) {
    if (binding_.known() && binding_.geometry != GeometryHash(mesh))
      carrier_.emplace(binding_, mesh);
  }

  const Carrier* carrier() const { return carrier_ ? &*carrier_ : nullptr; }
  double scale() const {
    return carrier_ && carrier_->change().found() ? carrier_->change().now_from_before.scale : 1;
  }

  struct Found {
    std::optional<MendStroke::Place> place;
    bool doubtful = false;
    std::string why;  ///< without a place
  };
  /// @param radius  of the brush
  Found Find(const json& written, double radius) const {
    if (written.is_array()) return Nearest(written, radius);
    if (carrier_) return Carried(written);
    if (!binding_.known()) return {{}, false, "the file does not say which mesh its faces are of"};
    const json& weights = written.at("barycentric");
    MendStroke::Place place{written.at("face"), Vector3d()};
    for (std::size_t k = 0; k < 3; ++k)
      place.barycentric[static_cast<Eigen::Index>(k)] = weights.at(k);
    if (place.face < 0 || place.face >= mesh_.face_count())
      return {{}, false, fmt::format("the mesh has no face {}", place.face)};
    if (!IsInTriangle(place.barycentric)) return {{}, false, "a place is not on its face"};
    return {place, false, ""};
  }

 private:
  Found Nearest(const json& written, double radius) const {
    const Vector3d point(written.at(0), written.at(1), written.at(2));
    if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kMostCoordinate)
      return {{}, false, "a place is no point"};
    const RayScene::Foot foot = scene_.ClosestPoint(point);
    const double off = std::sqrt(foot.squared_distance);
    if (off > kMostOff * radius)
      return {{},
              false,
              fmt::format("a place is {:.3g} off the mesh, with a brush of {:.3g}", off, radius)};
    return {MendStroke::Place{foot.face, foot.barycentric}, false, ""};
  }

  Found Carried(const json& written) const {
    const std::optional<SurfacePlace> before = PlaceFrom(written);
    if (!before) return {{}, false, "the file does not have its position and normal"};
    const CarriedPlace now = carrier_->Carry(*before);
    if (now.grade == CarriedPlace::Grade::kLost) return {{}, false, now.why};
    return {MendStroke::Place{now.face, now.barycentric},
            now.grade == CarriedPlace::Grade::kDoubtful, now.why};
  }

  const Mesh& mesh_;
  MeshBinding binding_;
  RayScene scene_;
  std::optional<Carrier> carrier_;
};

MendStroke StrokeFrom(const json& entry, std::size_t index, const std::filesystem::path& path) {
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("{}: stroke {} {}", path.string(), index + 1, what));
  };
  MendStroke stroke;
  const std::optional<MendTool> tool = MendToolNamed(entry.at("tool").get<std::string>());
  if (!tool)
    fail(fmt::format("has the tool '{}'; there are smooth, pull and fill",
                     entry.at("tool").get<std::string>()));
  stroke.tool = *tool;
  stroke.radius = entry.at("radius");
  if (!(stroke.radius > 0 && stroke.radius <= kMostCoordinate)) fail("needs a radius above 0");
  stroke.strength = entry.value("strength", 1.0);
  const double least = stroke.tool == MendTool::kPull ? -1 : 0;
  if (!(stroke.strength >= least && stroke.strength <= 1))
    fail(fmt::format("needs a strength from {:.0f} to 1", least));
  if (!entry.at("places").is_array() || entry.at("places").empty()) fail("has no place");
  return stroke;
}

/// What the log says of strokes that were carried to a rebuilt mesh.
void LogCarried(const Carrier& carrier, const std::filesystem::path& path,
                const std::vector<std::string>& doubtful, CarryLog* log) {
  const std::string how = fmt::format(
      "{}: the mesh was rebuilt since it was mended ({}); the strokes were carried over",
      path.filename().string(), carrier.change().Words());
  if (doubtful.empty())
    log->notes.push_back(how);
  else
    log->warnings.push_back(
        fmt::format("{}. These are doubtful: {}; look at them in the studio (Poses, Mend)", how,
                    fmt::join(doubtful, ", ")));
}

MendStrokes StrokesFrom(const json& root, const std::filesystem::path& path, const Mesh& mesh,
                        CarryLog* log) {
  const StrokePlaces places(root, path, mesh);
  MendStrokes read;
  std::vector<std::string> doubtful;
  for (const json& entry : root.at("strokes")) {
    MendStroke stroke = StrokeFrom(entry, read.strokes.size(), path);
    std::string why;
    bool sure = true;
    for (const json& written : entry.at("places")) {
      const StrokePlaces::Found found = places.Find(written, stroke.radius);
      if (found.place)
        stroke.places.push_back(*found.place);
      else
        why = found.why;
      if (found.doubtful) sure = false;
    }
    const double lost = static_cast<double>(entry.at("places").size() - stroke.places.size());
    if (lost <= kMostPlacesLost * static_cast<double>(entry.at("places").size())) why.clear();
    if (!sure && why.empty()) doubtful.push_back(TitleOf(read.strokes.size(), stroke));
    stroke.radius *= places.scale();
    read.strokes.push_back(std::move(stroke));
    read.faults.push_back(why);
  }
  if (places.carrier() && log && !read.strokes.empty())
    LogCarried(*places.carrier(), path, doubtful, log);
  return read;
}

}  // namespace

MendStrokes ReadMendStrokes(const std::filesystem::path& path, const Mesh& mesh, CarryLog* log) {
  const std::string text = ReadFile(path);
  RequireShallowJson(text, path.string());
  try {
    return StrokesFrom(json::parse(text), path, mesh, log);
  } catch (const json::exception& error) {
    throw InputError(
        fmt::format("{} is not a file of strokes: {}", path.string(), JsonFault(error)));
  }
}

void RequireOnMesh(const MendStrokes& read, const std::filesystem::path& path) {
  std::vector<std::string> lost;
  for (std::size_t i = 0; i < read.strokes.size(); ++i)
    if (!read.faults[i].empty())
      lost.push_back(fmt::format("{}: {}", TitleOf(i, read.strokes[i]), read.faults[i]));
  if (lost.empty()) return;
  throw InputError(
      fmt::format("{}: {} of {} strokes do not lie on the mesh any more ({}); take them out and "
                  "paint them again in the studio (Poses, Mend), or delete them from the file",
                  path.string(), lost.size(), read.strokes.size(), fmt::join(lost, "; ")));
}

std::string MendStrokesText(const Mesh& mesh, const std::vector<MendStroke>& strokes) {
  const SurfacePlaces on(mesh);
  json root = {
      {"schema", 1}, {"mesh", BindingJson<json>(BindTo(mesh))}, {"strokes", json::array()}};
  for (const MendStroke& stroke : strokes) {
    json entry = {{"tool", NameOf(stroke.tool)},
                  {"radius", stroke.radius},
                  {"strength", stroke.strength},
                  {"places", json::array()}};
    for (const MendStroke::Place& place : stroke.places) {
      const Vector3d& b = place.barycentric;
      json written = {{"face", place.face}, {"barycentric", {b[0], b[1], b[2]}}};
      AddPlace(on.At(place.face, b), written);
      entry["places"].push_back(std::move(written));
    }
    root["strokes"].push_back(std::move(entry));
  }
  return root.dump(1) + "\n";
}

}  // namespace keypose
