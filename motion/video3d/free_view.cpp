#include "motion/video3d/free_view.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/pictures/render.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

constexpr double kFovDeg = 32;
constexpr double kCalmFrames = 12;  // standard deviation of the smoothing of the actor's place

View Looking(const Vector3d& eye, const Vector3d& at, double fov_deg,
             const FreeViewOptions& options) {
  View view;
  view.camera_from_world = LookAt(eye, at, options.up);
  Camera& c = view.camera;
  c.width = options.width;
  c.height = options.height;
  c.fx = c.fy = 0.5 * options.height / std::tan(0.5 * fov_deg * kDegree);
  c.cx = 0.5 * options.width;
  c.cy = 0.5 * options.height;
  return view;
}

/// Middles of the bounding boxes, smoothed over time.
std::vector<Vector3d> CalmMiddles(const std::vector<Mesh>& frames) {
  std::vector<Vector3d> middles, calm;
  for (const Mesh& frame : frames)
    middles.push_back(
        0.5 * (frame.points.colwise().minCoeff() + frame.points.colwise().maxCoeff()).transpose());
  for (int f = 0; f < SizeOf(middles); ++f) {
    Vector3d sum = Vector3d::Zero();
    double total = 0;
    for (int g = 0; g < SizeOf(middles); ++g) {
      const double way = (g - f) / kCalmFrames, w = std::exp(-0.5 * way * way);
      sum += w * middles[g];
      total += w;
    }
    calm.push_back(sum / total);
  }
  return calm;
}

/// Hermite's curve through keys at times of their own; slopes from the neighbours.
template <class Value>
Vector3d Between(const std::vector<CameraKey>& keys, int i, double t, const Value& value) {
  const int n = SizeOf(keys);
  const auto slope = [&](int k) -> Vector3d {
    const int a = std::max(0, k - 1), b = std::min(n - 1, k + 1);
    if (a == b) return Vector3d::Zero();
    return (value(keys[b]) - value(keys[a])) / (keys[b].frame - keys[a].frame);
  };
  const double span = keys[i + 1].frame - keys[i].frame, t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * value(keys[i]) + (t3 - 2 * t2 + t) * span * slope(i) +
         (3 * t2 - 2 * t3) * value(keys[i + 1]) + (t3 - t2) * span * slope(i + 1);
}

Vector3d Place(const nlohmann::json& key, const char* field, const std::string& what) {
  const auto fail = [&] { throw InputError(what + " needs three numbers in `" + field + "`"); };
  if (!key.contains(field) || !key[field].is_array() || key[field].size() != 3) fail();
  Vector3d place;
  for (int c = 0; c < 3; ++c) {
    if (!key[field][c].is_number()) fail();
    place[c] = key[field][c];
  }
  if (!place.allFinite()) fail();
  return place;
}

}  // namespace

std::vector<View> OrbitViews(const std::vector<Mesh>& frames, const FreeViewOptions& options) {
  const std::vector<Vector3d> middles = CalmMiddles(frames);
  double radius = 0;
  for (int f = 0; f < SizeOf(frames); ++f)
    radius = std::max(
        radius, (frames[f].points.rowwise() - middles[f].transpose()).rowwise().norm().maxCoeff());
  const double narrow = std::min(1.0, static_cast<double>(options.width) / options.height);
  const double distance = 1.03 * radius / (narrow * std::sin(0.5 * kFovDeg * kDegree));
  const Vector3d up = options.up.normalized();
  // Across and to the front, as -y is where z is up.
  const Vector3d side = std::abs(up.x()) < 0.9 ? Vector3d(Vector3d::UnitX() - up.x() * up)
                                               : Vector3d(Vector3d::UnitY() - up.y() * up);
  const Vector3d right = side.normalized(), front = right.cross(up);
  const double e = options.elevation_deg * kDegree;
  std::vector<View> views;
  for (int f = 0; f < SizeOf(frames); ++f) {
    const double a = 2 * kPi * options.turns * f / SizeOf(frames);
    const Vector3d flat = std::cos(a) * front + std::sin(a) * right;
    views.push_back(Looking(middles[f] + distance * (std::cos(e) * flat + std::sin(e) * up),
                            middles[f], kFovDeg, options));
  }
  return views;
}

std::vector<View> PathViews(const std::vector<CameraKey>& keys, int count,
                            const FreeViewOptions& options) {
  std::vector<View> views;
  const int last = SizeOf(keys) - 1;
  for (int f = 0; f < count; ++f) {
    if (f <= keys.front().frame || f >= keys.back().frame) {
      const CameraKey& key = f <= keys.front().frame ? keys.front() : keys.back();
      views.push_back(Looking(key.eye, key.look_at, key.fov_deg, options));
      continue;
    }
    int i = 0;
    while (i + 1 < last && keys[i + 1].frame <= f) ++i;
    const double t = (f - keys[i].frame) / (keys[i + 1].frame - keys[i].frame);
    const double fov =
        Between(keys, i, t, [](const CameraKey& key) { return Vector3d(key.fov_deg, 0, 0); }).x();
    views.push_back(Looking(Between(keys, i, t, [](const CameraKey& key) { return key.eye; }),
                            Between(keys, i, t, [](const CameraKey& key) { return key.look_at; }),
                            std::clamp(fov, 1.0, 170.0), options));
  }
  return views;
}

std::vector<CameraKey> ParseCameraPath(const std::string& text, const std::string& name) {
  const nlohmann::json root = nlohmann::json::parse(text, nullptr, false);
  if (!root.is_object() || !root.contains("keys") || !root["keys"].is_array() ||
      root["keys"].empty())
    throw InputError("video3d: " + name + " is not JSON with a list `keys` of cameras");
  std::vector<CameraKey> keys;
  for (const nlohmann::json& entry : root["keys"]) {
    const std::string what = "video3d: " + name + ": key " + std::to_string(keys.size());
    if (!entry.is_object() || !entry.contains("frame") || !entry["frame"].is_number())
      throw InputError(what + " needs a number `frame`");
    CameraKey key;
    key.frame = entry["frame"];
    key.eye = Place(entry, "eye", what);
    key.look_at = Place(entry, "look_at", what);
    if (entry.contains("fov_deg")) {
      if (!entry["fov_deg"].is_number() || !(entry["fov_deg"] > 1) || !(entry["fov_deg"] < 170))
        throw InputError(what + " has a `fov_deg` that is not between 1 and 170");
      key.fov_deg = entry["fov_deg"];
    }
    if (!keys.empty() && !(key.frame > keys.back().frame))
      throw InputError(what + " does not come after the one before; order keys by `frame`");
    keys.push_back(key);
  }
  return keys;
}

}  // namespace keypose::motion
