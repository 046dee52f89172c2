#include "interpolate/sequence.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/camera.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "interpolate/arap.h"
#include "interpolate/paper_arap.h"

namespace keypose::interpolation {

namespace {

/// The turn about z and translation with least squares.
Similarity3 FitUpright(const PointsX3& a, const PointsX3& b) {
  const Eigen::RowVector3d ca = a.colwise().mean(), cb = b.colwise().mean();
  double dot = 0, cross = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const Eigen::RowVector3d x = a.row(i) - ca, y = b.row(i) - cb;
    dot += x[0] * y[0] + x[1] * y[1];
    cross += x[0] * y[1] - x[1] * y[0];
  }
  Similarity3 s;
  s.rotation = Eigen::AngleAxisd(std::atan2(cross, dot), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  s.translation = cb.transpose() - s.rotation * ca.transpose();
  return s;
}

void CheckKeys(const std::vector<PointsX3>& keys, const FacesX3& faces) {
  if (keys.size() < 2) throw InputError("interpolate: needs at least two keys");
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (keys[k].rows() != keys[0].rows())
      throw InputError("interpolate: key " + std::to_string(k) + " has " + std::to_string(keys[k].rows()) + " vertices, the first has " +
                       std::to_string(keys[0].rows()) + "; register all poses from one template first");
    Mesh mesh;
    mesh.points = keys[k];
    mesh.faces = faces;
    RequireUsable(mesh, "interpolate: key " + std::to_string(k));
  }
}

std::vector<PointsX3> InBetweens(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const std::vector<double>& times,
                                 Method method, Sequence& sequence) {
  std::vector<PointsX3> frames;
  if (times.empty()) return frames;
  if (method == Method::kArap) {
    const ArapInterpolator arap(v, u, faces);
    sequence.degenerate_faces = std::max(sequence.degenerate_faces, arap.degenerate_faces());
    sequence.largest_turn = std::max(sequence.largest_turn, arap.largest_turn());
    return arap.At(times);
  }
  if (method == Method::kPaper) {
    const PaperInterpolator paper(v, u, faces);
    for (double t : times) frames.push_back(paper.At(t));
    return frames;
  }
  for (double t : times) frames.push_back(InterpolateLinearly(v, u, t));
  return frames;
}

}  // namespace

std::vector<PointsX3> AlignedKeys(const std::vector<PointsX3>& keys, AlignKeys align) {
  std::vector<PointsX3> aligned = keys;
  for (std::size_t k = 1; k < keys.size() && align != AlignKeys::kNone; ++k)
    aligned[k] = Transformed(
        align == AlignKeys::kUpright ? FitUpright(keys[k], keys[0]) : FitSimilarity(keys[k], keys[0], {}, align == AlignKeys::kSimilarity),
        keys[k]);
  return aligned;
}

Sequence Interpolate(const std::vector<PointsX3>& keys, const FacesX3& faces, const std::vector<int>& in_betweens, Method method,
                     Progress* progress) {
  CheckKeys(keys, faces);
  if (in_betweens.size() + 1 != keys.size()) throw InputError("interpolate: one number of in-betweens is needed for each pair of keys");
  Sequence sequence;
  for (std::size_t s = 0; s + 1 < keys.size(); ++s) {
    Step(progress, static_cast<double>(s) / static_cast<double>(in_betweens.size()), "frames between keys");
    std::vector<double> times;
    for (int k = 1; k <= in_betweens[s]; ++k) times.push_back(static_cast<double>(k) / (in_betweens[s] + 1));
    const std::vector<PointsX3> between = InBetweens(keys[s], keys[s + 1], faces, times, method, sequence);
    const int segment = static_cast<int>(s);
    sequence.key_frames.push_back(static_cast<int>(sequence.frames.size()));
    sequence.frames.push_back({segment, 0, keys[s], keys[s]});
    for (std::size_t k = 0; k < times.size(); ++k) {
      if (!between[k].allFinite())
        throw SolverError("interpolate: frame at t = " + std::to_string(times[k]) + " after key " + std::to_string(s) + " is not finite");
      sequence.frames.push_back({segment, times[k], between[k], InterpolateLinearly(keys[s], keys[s + 1], times[k])});
    }
  }
  sequence.key_frames.push_back(static_cast<int>(sequence.frames.size()));
  sequence.frames.push_back({static_cast<int>(keys.size()) - 2, 1, keys.back(), keys.back()});
  return sequence;
}

std::vector<int> InBetweensFromTimeline(const std::string& text, const std::string& name, int key_count) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("keys") || !json["keys"].is_array())
    throw InputError(name + ": not a timeline; write {\"schema\":1,\"fps\":24,\"keys\":[{\"pose\":\"rest\",\"time\":0},...]}");
  if (!json.contains("fps") || !json["fps"].is_number() || !(json["fps"].get<double>() > 0))
    throw InputError(name + ": fps must be a number above 0");
  const auto& keys = json["keys"];
  if (static_cast<int>(keys.size()) != key_count)
    throw InputError(name + ": has " + std::to_string(keys.size()) + " keys, but " + std::to_string(key_count) + " key meshes were given");
  std::vector<double> times;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (!keys[k].is_object() || !keys[k].contains("time") || !keys[k]["time"].is_number() || !std::isfinite(keys[k]["time"].get<double>()))
      throw InputError(name + ": key " + std::to_string(k) + " has no time in seconds");
    times.push_back(keys[k]["time"].get<double>());
  }
  const double fps = json["fps"].get<double>();
  std::vector<int> in_betweens;
  for (std::size_t k = 0; k + 1 < times.size(); ++k) {
    const double frames = std::round((times[k + 1] - times[0]) * fps) - std::round((times[k] - times[0]) * fps);
    if (!(frames >= 1) || frames > 1e6)
      throw InputError(name + ": key " + std::to_string(k + 1) +
                       " must come at least one frame, and at most a million, after the key before it");
    in_betweens.push_back(static_cast<int>(frames) - 1);
  }
  return in_betweens;
}

}  // namespace keypose::interpolation
