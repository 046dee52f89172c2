#include "export/fbx/fbx_error.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/values/progress.h"
#include "core/values/size_of.h"
#include "export/fbx/fbx_document.h"

namespace keypose::exporting {
namespace {

constexpr int kFramesPerRound = 64;

struct WeightCurve {
  std::vector<std::int64_t> ticks;
  std::vector<float> percents;

  double At(std::int64_t tick) const {
    const auto after = std::upper_bound(ticks.begin(), ticks.end(), tick);
    if (after == ticks.begin()) return percents.front();
    if (after == ticks.end()) return percents.back();
    const auto k = after - ticks.begin();
    const double share =
        static_cast<double>(tick - ticks[k - 1]) / static_cast<double>(ticks[k] - ticks[k - 1]);
    return percents[k - 1] + share * (percents[k] - percents[k - 1]);
  }
};

struct AnimatedShape {
  const FbxRecord* geometry = nullptr;
  WeightCurve curve;
};

/// Mesh and shapes, found by the connections from child to parent.
struct Decoded {
  std::vector<FbxRecord> records;
  PointsX3 base;
  std::vector<AnimatedShape> shapes;
};

PointsX3 Points(const FbxRecord& record) {
  const std::vector<double> numbers = record.values.at(0).AsDoubles();
  return Eigen::Map<const PointsX3>(numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3),
                                    3);
}

const FbxRecord& Section(const std::vector<FbxRecord>& records, const std::string& name) {
  return *std::find_if(records.begin(), records.end(),
                       [&](const FbxRecord& record) { return record.name == name; });
}

Decoded Decode(const std::string& fbx) {
  Decoded out;
  out.records = ReadFbx(fbx);
  std::multimap<std::int64_t, std::int64_t> parents;
  for (const FbxRecord& link : Section(out.records, "Connections").records)
    parents.emplace(link.values.at(1).AsInteger(), link.values.at(2).AsInteger());
  // A shape belongs to a channel, whose weight a curve drives through a curve node.
  std::map<std::int64_t, AnimatedShape> by_channel;
  const auto& objects = Section(out.records, "Objects").records;
  for (const FbxRecord& object : objects) {
    const std::int64_t id = object.values.at(0).AsInteger();
    if (object.name == "Geometry" && object.values.at(2).AsText() == "Mesh")
      out.base = Points(object.Inner("Vertices"));
    if (object.name == "Geometry" && object.values.at(2).AsText() == "Shape")
      by_channel[parents.find(id)->second].geometry = &object;
    if (object.name != "AnimationCurve") continue;
    const WeightCurve curve{object.Inner("KeyTime").values.at(0).AsTimes(),
                            object.Inner("KeyValueFloat").values.at(0).AsFloats()};
    const auto [begin, end] = parents.equal_range(parents.find(id)->second);
    for (auto link = begin; link != end; ++link) {
      const auto channel = by_channel.find(link->second);
      if (channel != by_channel.end()) channel->second.curve = curve;
    }
  }
  for (auto& [channel, shape] : by_channel) out.shapes.push_back(std::move(shape));
  return out;
}

PointsX3 PointsAt(const Decoded& decoded, std::int64_t tick) {
  PointsX3 points = decoded.base;
  for (const AnimatedShape& shape : decoded.shapes) {
    const double weight = shape.curve.At(tick) / 100;
    if (weight == 0) continue;
    const auto vertices = shape.geometry->Inner("Indexes").values.at(0).AsIntegers();
    const PointsX3 moves = Points(shape.geometry->Inner("Vertices"));
    for (int i = 0; i < SizeOf(vertices); ++i) points.row(vertices[i]) += weight * moves.row(i);
  }
  return points;
}

}  // namespace

double FbxErrorOverDiagonal(const std::string& fbx, const Scene& scene, Progress* progress) {
  const Decoded decoded = Decode(fbx);
  const std::vector<int> shown = ShownFrames(scene);
  const int count = SizeOf(shown);
  std::vector<double> distances(count);
  for (int begin = 0; begin < count; begin += kFramesPerRound) {
    ReportProgress(progress, static_cast<double>(begin) / count, "FBX: measuring");
    ParallelFor(std::min(kFramesPerRound, count - begin), [&](std::int64_t i) {
      const int k = begin + static_cast<int>(i);
      const PointsX3 expected = WithYUp(scene.frames[shown[k]].points, scene.z_up);
      const PointsX3 points = PointsAt(decoded, FbxTicks(k / scene.playback.fps));
      distances[k] = (points - expected).rowwise().norm().maxCoeff();
    });
  }
  const double largest = *std::max_element(distances.begin(), distances.end());
  return largest > 0 ? largest / SceneDiagonal(scene) : 0;
}

}  // namespace keypose::exporting
