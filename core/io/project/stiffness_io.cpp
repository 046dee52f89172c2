#include "core/io/project/stiffness_io.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/binding_io.h"
#include "core/io/project/stiffness_map.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {

namespace {

using nlohmann::json;

// of the diagonal: a vertex of the source farther than this from all painted vertices has no
// counterpart
constexpr double kNoCounterpart = 0.02;
constexpr double kMayLackCounterpart = 0.1;  // share of vertices

struct Painted {
  MeshBinding binding;
  PointsX3 points;
  Eigen::VectorXd stiffness;
};

Painted PaintedFromJson(const std::string& text, const std::string& name) {
  Painted painted;
  RequireShallowJson(text, name);
  try {
    const json root = json::parse(text);
    painted.binding = BindingFrom(root.at("mesh"), name);
    const json& lines = root.at("stiffness");
    painted.points.resize(std::ssize(lines), 3);
    painted.stiffness.resize(painted.points.rows());
    for (Eigen::Index i = 0; i < painted.points.rows(); ++i) {
      std::istringstream line(lines[i].get<std::string>());
      double factor = 0;
      for (int k = 0; k < 3; ++k) line >> painted.points(i, k);
      const bool near = painted.points.row(i).cwiseAbs().maxCoeff() <= kMostCoordinate;
      if (!(line >> factor) || !near || !std::isfinite(factor) || factor <= 0)
        throw InputError(fmt::format(
            "{}: entry {} of `stiffness` must be a place and a positive number", name, i));
      painted.stiffness[i] = factor;
    }
  } catch (const json::exception& error) {
    throw InputError(name + " is not a bound stiffness: " + JsonFault(error));
  }
  if (!painted.binding.known() || painted.points.rows() != painted.binding.vertex_count)
    throw InputError(
        name +
        ": it does not have one entry for each vertex of the mesh that it names; bind it again");
  return painted;
}

/// @param share  of the vertices that have no counterpart
std::string WhyNot(const FrameChange& change, double share) {
  if (change.found()) return fmt::format("{:.0f} % of it has no painted place near", 100 * share);
  if (change.ambiguous) return "the object looks the same from several sides";
  return fmt::format("at best {:.0f} % of the two shapes agree", 100 * change.agreeing);
}

Eigen::VectorXd CarriedOver(const Painted& painted, const Mesh& source, const std::string& name,
                            CarryLog* log) {
  const Carrier carrier(painted.binding, source);
  const FrameChange& change = carrier.change();
  const KdTree tree(painted.points);
  Eigen::VectorXd stiffness(source.vertex_count());
  const double limit = kNoCounterpart * painted.binding.diagonal;
  int far = 0;
  for (int v = 0; v < source.vertex_count() && change.found(); ++v) {
    const KdTree::Neighbor near = tree.Nearest(carrier.BackFrom(source.points.row(v)));
    stiffness[v] = painted.stiffness[near.index];
    far += std::sqrt(near.squared_distance) > limit;
  }
  const double share = static_cast<double>(far) / source.vertex_count();
  if (!change.found() || share > kMayLackCounterpart)
    throw InputError(fmt::format(
        "the template was rebuilt after {} was painted, and the stiffness could not follow: {}; "
        "paint it again on the template",
        name, WhyNot(change, share)));
  if (!log) return stiffness;
  const std::string how =
      fmt::format("{}: the template was rebuilt since then ({}); the stiffness was carried over",
                  name, change.Words());
  if (far == 0)
    log->notes.push_back(how);
  else
    log->warnings.push_back(
        fmt::format("{}, but {:.1f} % of the template's vertices have no painted place near them; "
                    "check that stiff parts are still stiff",
                    how, 100 * share));
  return stiffness;
}

}  // namespace

std::string BoundStiffnessText(const Mesh& mesh, const Eigen::VectorXd& stiffness) {
  json root = {
      {"schema", 2}, {"mesh", BindingJson<json>(BindTo(mesh))}, {"stiffness", json::array()}};
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const auto p = mesh.points.row(v);
    root["stiffness"].push_back(
        fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}", p[0], p[1], p[2], stiffness[v]));
  }
  return root.dump(1) + "\n";
}

Eigen::VectorXd StiffnessOn(const Mesh& source, const std::string& text, const Mesh& painted,
                            const std::string& name, CarryLog* log) {
  if (text.starts_with("ply")) {
    const Eigen::VectorXd stiffness = StiffnessFromColors(painted, painted.vertex_count(), name);
    if (GeometryHash(painted) == GeometryHash(source)) return stiffness;
    Mesh shape;  // without colours: the greys are not the colours of the clay
    shape.points = painted.points;
    shape.faces = painted.faces;
    return CarriedOver({BindTo(shape), painted.points, stiffness}, source, name, log);
  }
  if (text.find_first_not_of(" \t\r\n") != std::string::npos &&
      text[text.find_first_not_of(" \t\r\n")] == '{') {
    const Painted bound = PaintedFromJson(text, name);
    if (bound.binding.geometry == GeometryHash(source)) return bound.stiffness;
    return CarriedOver(bound, source, name, log);
  }
  if (log)
    log->warnings.push_back(name +
                            " does not say on which mesh its stiffness was painted; if the source "
                            "was rebuilt since then, the stiff parts are in other places now. Bind "
                            "it: keypose landmarks bind --mesh SOURCE "
                            "--stiffness FILE --bound FILE.json");
  return ParseStiffness(text, source.vertex_count(), name);
}

Eigen::VectorXd ReadStiffness(const std::filesystem::path& path, const Mesh& source,
                              CarryLog* log) {
  const std::string text = ReadFile(path);
  const Mesh painted = text.starts_with("ply") ? ReadMesh(path) : Mesh();
  return StiffnessOn(source, text, painted, path.filename().string(), log);
}

}  // namespace keypose
