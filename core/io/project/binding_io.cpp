#include "core/io/project/binding_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {

using nlohmann::json;

namespace {

json Numbers(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

std::optional<Eigen::Vector3d> VectorFrom(const json& object, const char* name) {
  const auto it = object.find(name);
  if (it == object.end()) return std::nullopt;
  Eigen::Vector3d v;
  for (std::size_t k = 0; k < 3; ++k) v[static_cast<Eigen::Index>(k)] = it->at(k).get<double>();
  return v;
}

/// One line of numbers for each point keeps the file short and readable.
std::string LineOf(const MeshBinding& binding, Eigen::Index i) {
  const auto p = binding.points.row(i), n = binding.normals.row(i);
  std::string line =
      fmt::format("{:.7g} {:.7g} {:.7g} {:.3f} {:.3f} {:.3f}", p[0], p[1], p[2], n[0], n[1], n[2]);
  if (binding.colors.rows() > 0) {
    const auto c = binding.colors.row(i);
    line += fmt::format(" {:.0f} {:.0f} {:.0f}", c[0], c[1], c[2]);
  }
  return line;
}

void ShapeFrom(const json& shape, MeshBinding& binding, const std::filesystem::path& file) {
  const auto count = std::ssize(shape);
  binding.points.resize(count, 3);
  binding.normals.resize(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    std::istringstream line(shape[i].get<std::string>());
    std::vector<double> values;
    for (double value; line >> value;) values.push_back(value);
    const bool colored = values.size() == 9;
    const bool usable = std::all_of(values.begin(), values.end(), [](double value) {
      return std::abs(value) <= kMostCoordinate;
    });
    if (!usable || !line.eof() || (values.size() != 6 && !colored) ||
        (i > 0 && colored != (binding.colors.rows() > 0)))
      throw InputError(fmt::format(
          "{}: line {} of `shape` does not hold a point, its normal and its colour; pick again",
          file.string(), i));
    if (colored) binding.colors.conservativeResize(count, 3);
    for (Eigen::Index k = 0; k < 3; ++k) {
      binding.points(i, k) = values[k];
      binding.normals(i, k) = values[k + 3];
      if (colored) binding.colors(i, k) = values[k + 6];
    }
  }
}

}  // namespace

template <>
json BindingJson(const MeshBinding& binding) {
  json shape = json::array();
  for (Eigen::Index i = 0; i < binding.points.rows(); ++i) shape.push_back(LineOf(binding, i));
  return {{"vertices", binding.vertex_count}, {"faces", binding.face_count},
          {"sha256", binding.geometry},       {"faces_sha256", binding.numbering},
          {"diagonal", binding.diagonal},     {"shape", std::move(shape)}};
}

template <>
MeshBinding BindingFrom(const json& object, const std::filesystem::path& file) {
  MeshBinding binding;
  binding.vertex_count = object.value("vertices", -1);
  binding.face_count = object.value("faces", -1);
  binding.geometry = object.value("sha256", "");
  binding.numbering = object.value("faces_sha256", "");
  binding.diagonal = object.value("diagonal", 0.0);
  if (!binding.known()) return binding;
  if (!object.contains("shape") || object["shape"].size() < 50)
    throw InputError(
        file.string() +
        ": `shape` must hold 50 points or more of the mesh that was picked on; pick again");
  if (!(binding.diagonal > 0 && binding.diagonal <= kMostCoordinate))
    throw InputError(file.string() +
                     ": `diagonal` of the picked mesh is not a positive number; pick again");
  ShapeFrom(object["shape"], binding, file);
  // Points far outside of the mesh would make each search for their closest points look at all
  // faces.
  const double extent =
      (binding.points.colwise().maxCoeff() - binding.points.colwise().minCoeff()).norm();
  if (extent > 1.01 * binding.diagonal)
    throw InputError(
        fmt::format("{}: the points of `shape` extend over {:.4g}, but `diagonal` of the picked "
                    "mesh is {:.4g}; "
                    "pick again",
                    file.string(), extent, binding.diagonal));
  return binding;
}

template <>
void AddPlace(const SurfacePlace& place, json& pick) {
  pick["position"] = Numbers(place.position);
  pick["normal"] = Numbers(place.normal);
  if (place.color) pick["color"] = Numbers(*place.color);
}

template <>
std::optional<SurfacePlace> PlaceFrom(const json& pick) {
  const auto position = VectorFrom(pick, "position"), normal = VectorFrom(pick, "normal");
  if (!position || !normal || !position->allFinite() ||
      position->cwiseAbs().maxCoeff() > kMostCoordinate || !normal->allFinite() ||
      normal->norm() < 1e-9)
    return std::nullopt;
  return SurfacePlace{*position, normal->normalized(), VectorFrom(pick, "color")};
}

FollowPicks::FollowPicks(MeshBinding binding, const Mesh& mesh, std::string file, std::string side)
    : binding_(std::move(binding)), file_(std::move(file)), side_(std::move(side)) {
  if (binding_.known()) {
    if (binding_.geometry != GeometryHash(mesh))
      carrier_ = std::make_unique<Carrier>(binding_, mesh);
    return;
  }
  const bool says_counts = binding_.vertex_count >= 0 && binding_.face_count >= 0;
  if (says_counts &&
      (binding_.vertex_count != mesh.vertex_count() || binding_.face_count != mesh.face_count()))
    throw InputError(
        fmt::format("{}: picked on a {} with {} vertices and {} faces, but this one has {} "
                    "vertices, {} faces; pick them "
                    "again. Or, while you still have that mesh: keypose landmarks bind --mesh "
                    "THAT_MESH --picks {} --bound {}",
                    file_, side_, binding_.vertex_count, binding_.face_count, mesh.vertex_count(),
                    mesh.face_count(), file_, file_));
}

CarriedPlace FollowPicks::Carry(const std::string& name, const std::optional<SurfacePlace>& place,
                                bool needed) {
  CarriedPlace carried;
  if (place)
    carried = carrier_->Carry(*place);
  else
    carried.why = "the file does not have its position and normal";
  if (carried.grade == CarriedPlace::Grade::kLost) {
    if (!needed) return carried;
    const bool all_for_one_reason = carrier_ && !carrier_->change().found();
    lost_.push_back(all_for_one_reason ? fmt::format("'{}'", name)
                                       : fmt::format("'{}' ({})", name, carried.why));
    if (all_for_one_reason) why_all_ = carried.why;
    return carried;
  }
  ++carried_;
  furthest_ = std::max(furthest_, carried.off);
  if (carried.grade == CarriedPlace::Grade::kDoubtful)
    doubtful_.push_back(fmt::format("'{}' ({})", name, carried.why));
  return carried;
}

void FollowPicks::Finish(CarryLog* log) const {
  if (!lost_.empty())
    throw InputError(
        fmt::format("{}: the {} was rebuilt after these were picked, and {} of {} could not "
                    "follow: {}{}; pick them again on it under the same names (keypose landmarks "
                    "suggest, or MeshLab), or delete them from the file",
                    file_, side_, lost_.size(), static_cast<std::size_t>(carried_) + lost_.size(),
                    fmt::join(lost_, ", "), why_all_.empty() ? "" : "; " + why_all_));
  if (!log) return;
  if (!known()) {
    log->unbound = true;
    log->warnings.push_back(
        fmt::format("{} does not say on which {} it was picked; its numbers are used unchanged, "
                    "which is wrong if it was rebuilt since then. Check that the picks lie where "
                    "they should, then bind them to it: keypose landmarks bind --help",
                    file_, side_));
    return;
  }
  if (!carrier_ || carried_ == 0) return;
  const std::string how = fmt::format(
      "{}: the {} was rebuilt since then ({}); {} picks were carried over, at most {:.2f} % of the "
      "diagonal from where they were",
      file_, side_, carrier_->change().Words(), carried_, 100 * furthest_);
  if (doubtful_.empty())
    log->notes.push_back(how);
  else
    log->warnings.push_back(
        fmt::format("{}. These are doubtful: {}; check them, and pick the wrong ones again", how,
                    fmt::join(doubtful_, ", ")));
}

}  // namespace keypose
