#include "core/io/project/regions_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/project/binding_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose {

using nlohmann::json;

namespace {

constexpr double kMayBeLost = 0.1;  // share of a region's vertices

struct BoundRegion {
  std::vector<int> vertices;
  std::vector<SurfacePlace> places;  // of the vertices
  double spacing = 0;                // between neighbouring vertices
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;
};

struct RegionsFile {
  MeshBinding binding;
  std::map<std::string, BoundRegion> regions;
};

double MeanEdge(const Mesh& mesh) {
  double sum = 0;
  const auto edges = UndirectedEdges(mesh.faces);
  for (const auto& [a, b] : edges) sum += (mesh.points.row(a) - mesh.points.row(b)).norm();
  return sum / static_cast<double>(std::max<std::size_t>(1, edges.size()));
}

/// A face and corner of each vertex; -1 when no face uses it.
std::vector<std::pair<int, int>> CornersOfVertices(const Mesh& mesh) {
  std::vector<std::pair<int, int>> corners(static_cast<std::size_t>(mesh.vertex_count()), {-1, 0});
  for (Eigen::Index f = mesh.faces.rows() - 1; f >= 0; --f)
    for (int k = 0; k < 3; ++k) corners[mesh.faces(f, k)] = {static_cast<int>(f), k};
  return corners;
}

RegionsFile ReadRegions(const std::filesystem::path& path) {
  RegionsFile file;
  const std::string text = ReadFile(path);
  RequireShallowJson(text, path.string());
  try {
    const json root = json::parse(text);
    file.binding = BindingFrom(root.at("mesh"), path);
    if (!file.binding.known())
      throw InputError(path.string() +
                       " does not say which mesh its regions are of; bind them again");
    for (const json& entry : root.at("regions")) {
      BoundRegion region;
      region.vertices = entry.value("vertices", std::vector<int>());
      region.spacing = entry.value("spacing", 0.0);
      region.radius = entry.value("radius", 0.0);
      if (entry.contains("center"))
        for (std::size_t k = 0; k < 3; ++k)
          region.center[static_cast<Eigen::Index>(k)] = entry["center"].at(k);
      for (const json& place : entry.value("places", json::array()))
        if (const auto read = PlaceFrom(place)) region.places.push_back(*read);
      if (region.places.size() != region.vertices.size())
        throw InputError(path.string() + ": a region does not have one place for each vertex");
      file.regions[entry.at("name").get<std::string>()] = std::move(region);
    }
  } catch (const json::exception& error) {
    throw InputError(
        fmt::format("{} is not a file of regions: {}", path.string(), JsonFault(error)));
  }
  return file;
}

bool SameSet(std::vector<int> a, std::vector<int> b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  return a == b;
}

/// The vertices of the new mesh at the region's places: the corner nearest to each place, and all
/// vertices within half an edge length of a place.
std::vector<int> CarriedVertices(const BoundRegion& region, const Carrier& carrier, const Mesh& now,
                                 const std::string& name, std::vector<std::string>& lost) {
  std::set<int> found;
  PointsX3 places(std::ssize(region.places), 3);
  int missing = 0;
  std::string why;
  for (std::size_t i = 0; i < region.places.size(); ++i) {
    places.row(i) = region.places[i].position.transpose();
    const CarriedPlace carried = carrier.Carry(region.places[i]);
    if (carried.grade == CarriedPlace::Grade::kLost) {
      ++missing;
      why = carried.why;
      continue;
    }
    Eigen::Index corner = 0;
    carried.barycentric.maxCoeff(&corner);
    found.insert(now.faces(carried.face, corner));
  }
  if (missing > kMayBeLost * static_cast<double>(region.places.size())) {
    lost.push_back(
        fmt::format("'{}' ({} of {} vertices: {})", name, missing, region.places.size(), why));
    return {};
  }
  const KdTree tree(places);
  const PointsX3 normals = VertexNormals(now.points, now.faces);
  const Eigen::Matrix3d& turn = carrier.change().now_from_before.rotation;
  for (int v = 0; v < now.vertex_count(); ++v) {
    const KdTree::Neighbor near = tree.Nearest(carrier.BackFrom(now.points.row(v)));
    if (std::sqrt(near.squared_distance) > 0.5 * region.spacing) continue;
    const Eigen::Vector3d normal = turn * region.places[near.index].normal;
    if (normal.dot(normals.row(v)) > 0) found.insert(v);
  }
  return {found.begin(), found.end()};
}

void Unbound(const TimelineRegion& region, CarryLog* log) {
  if (!log || region.vertices.empty()) return;
  log->warnings.push_back(
      fmt::format("the timeline's region '{}' is a list of vertices that is not bound to a mesh: "
                  "after the template is rebuilt, these numbers mean other vertices. Bind it "
                  "(keypose landmarks bind --mesh "
                  "FIRST_KEY --timeline "
                  "pipeline.yaml --bound regions.json), or give it as a ball (center, radius)",
                  region.name));
}

void CarryRegion(const BoundRegion& bound, const Carrier& carrier, const Mesh& now,
                 TimelineRegion& region, std::vector<std::string>& lost) {
  if (!region.vertices.empty()) {
    region.vertices = CarriedVertices(bound, carrier, now, region.name, lost);
    return;
  }
  if (!carrier.change().found()) {
    lost.push_back(fmt::format("'{}'", region.name));
    return;
  }
  region.center = carrier.change().now_from_before * region.center;
  region.radius *= carrier.change().now_from_before.scale;
}

}  // namespace

void WriteRegions(const std::filesystem::path& path, const Mesh& mesh,
                  const std::vector<TimelineRegion>& regions) {
  const SurfacePlaces places(mesh);
  const auto corners = CornersOfVertices(mesh);
  const double spacing = MeanEdge(mesh);
  json root = {
      {"schema", 2}, {"mesh", BindingJson<json>(BindTo(mesh))}, {"regions", json::array()}};
  for (const TimelineRegion& region : regions) {
    json entry = {{"name", region.name}};
    if (region.vertices.empty()) {
      entry["center"] = {region.center[0], region.center[1], region.center[2]};
      entry["radius"] = region.radius;
    } else {
      entry["vertices"] = region.vertices;
      entry["spacing"] = spacing;
      entry["places"] = json::array();
    }
    for (const int v : region.vertices) {
      if (v < 0 || v >= mesh.vertex_count() || corners[v].first < 0)
        throw InputError(
            fmt::format("region '{}' has vertex {}, but the mesh has no such vertex on a face ({} "
                        "vertices); it was counted on "
                        "another mesh",
                        region.name, v, mesh.vertex_count()));
      const auto [face, corner] = corners[v];
      json place = json::object();
      AddPlace(places.At(face, Eigen::Vector3d::Unit(corner)), place);
      entry["places"].push_back(std::move(place));
    }
    root["regions"].push_back(std::move(entry));
  }
  WriteFileAtomically(path, root.dump() + "\n");
}

std::vector<TimelineRegion> RegionsOn(const std::filesystem::path& path, const Mesh* mesh) {
  Timeline timeline;
  for (const auto& [name, bound] : ReadRegions(path).regions)
    timeline.regions.push_back({name, bound.vertices, bound.center, bound.radius});
  if (mesh) FollowRegions(path, *mesh, timeline, nullptr);
  return timeline.regions;
}

void FollowRegions(const std::filesystem::path& path, const Mesh& first_key, Timeline& timeline,
                   CarryLog* log) {
  if (timeline.regions.empty()) return;
  if (path.empty()) {
    for (const TimelineRegion& region : timeline.regions) Unbound(region, log);
    return;
  }
  const RegionsFile file = ReadRegions(path);
  std::optional<Carrier> carrier;
  if (file.binding.numbering != NumberingHash(first_key)) carrier.emplace(file.binding, first_key);
  std::vector<std::string> lost, carried;
  for (TimelineRegion& region : timeline.regions) {
    const auto bound = file.regions.find(region.name);
    if (bound == file.regions.end()) {
      Unbound(region, log);
      continue;
    }
    const bool moved_ball =
        (bound->second.center - region.center).norm() > 0 || bound->second.radius != region.radius;
    if (!SameSet(bound->second.vertices, region.vertices) ||
        (region.vertices.empty() && moved_ball))
      throw InputError(
          fmt::format("the timeline's region '{}' was changed since {} was written; bind the "
                      "regions again: keypose landmarks "
                      "bind --mesh FIRST_KEY --timeline pipeline.yaml --bound {}",
                      region.name, path.filename().string(), path.filename().string()));
    if (!carrier) continue;
    CarryRegion(bound->second, *carrier, first_key, region, lost);
    carried.push_back("'" + region.name + "'");
  }
  if (!lost.empty())
    throw InputError(
        fmt::format("{}: the template was rebuilt since then, and these regions of the timeline "
                    "could not follow: {}; list their "
                    "vertices again and bind them (keypose landmarks bind --timeline)",
                    path.filename().string(), fmt::join(lost, ", ")));
  if (!carried.empty() && log)
    log->notes.push_back(fmt::format(
        "{}: the template was rebuilt since then ({}); the regions {} were carried over",
        path.filename().string(), carrier->change().Words(), fmt::join(carried, ", ")));
}

}  // namespace keypose
