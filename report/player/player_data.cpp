#include "report/player/player_data.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "core/values/size_of.h"
#include "report/html/html.h"

namespace keypose::report {
namespace {

/// Little-endian integers of two or four bytes.
template <class Integer>
std::string Packed(const std::vector<std::uint32_t>& values) {
  std::string bytes;
  bytes.reserve(values.size() * sizeof(Integer));
  for (const std::uint32_t value : values)
    for (std::size_t i = 0; i < sizeof(Integer); ++i)
      bytes += static_cast<char>(value >> (8 * i) & 255U);
  return Base64(bytes);
}

/// The drawn vertices: one per pair of mesh vertex and texture coordinate.
struct DrawnVertices {
  std::vector<std::uint32_t> source, uv, faces;
};

std::uint32_t Quantised(double value) {
  return static_cast<std::uint32_t>(std::lround(65535 * std::clamp(value, 0.0, 1.0)));
}

DrawnVertices Draw(const Mesh& mesh) {
  DrawnVertices drawn;
  std::map<std::pair<int, int>, std::uint32_t> known;
  const bool has_uvs = mesh.has_uvs();
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.faces(f, k), corner = has_uvs ? mesh.uv_faces(f, k) : -1;
      const auto [found, fresh] =
          known.try_emplace({vertex, corner}, static_cast<std::uint32_t>(known.size()));
      drawn.faces.push_back(found->second);
      if (!fresh) continue;
      drawn.source.push_back(static_cast<std::uint32_t>(vertex));
      for (int c = 0; c < 2; ++c) drawn.uv.push_back(has_uvs ? Quantised(mesh.uvs(corner, c)) : 0);
    }
  return drawn;
}

}  // namespace

std::vector<int> FramesToStore(const std::vector<int>& repeats, const std::vector<char>& keys,
                               std::size_t most) {
  std::vector<int> stored, between;
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    if (repeats[i] != static_cast<int>(i)) continue;
    const bool must = keys[i] || i == 0;
    (must ? stored : between).push_back(static_cast<int>(i));
  }
  const std::size_t room =
      most > stored.size() ? std::min(most - stored.size(), between.size()) : 0;
  for (std::size_t k = 0; k < room; ++k)
    stored.push_back(between[(2 * k + 1) * between.size() / (2 * room)]);
  std::sort(stored.begin(), stored.end());
  return stored;
}

std::vector<PlayerMoment> MomentsOf(const std::vector<int>& repeats,
                                    const std::vector<int>& stored) {
  std::vector<PlayerMoment> moments;
  for (const int frame : repeats) {
    const auto after = std::lower_bound(stored.begin(), stored.end(), frame);
    PlayerMoment moment;
    moment.b =
        static_cast<int>(std::min<std::ptrdiff_t>(after - stored.begin(), std::ssize(stored) - 1));
    const bool exact = stored[moment.b] <= frame;
    moment.a = exact ? moment.b : moment.b - 1;
    if (!exact) {
      const int from = stored[moment.a], to = stored[moment.b];
      moment.share = static_cast<double>(frame - from) / (to - from);
    }
    moments.push_back(moment);
  }
  return moments;
}

std::vector<double> TextureWeights(double t, const std::vector<int>& pose_of_key,
                                   std::size_t poses) {
  std::vector<double> weights(poses, 0.0);
  if (pose_of_key.empty()) {
    if (poses > 0) weights[0] = 1;
    return weights;
  }
  const int last = SizeOf(pose_of_key) - 1;
  const int key = std::clamp(static_cast<int>(std::floor(t + 1e-9)), 0, last),
            next = std::min(key + 1, last);
  const double share = std::clamp(t - key, 0.0, 1.0);
  weights[pose_of_key[key]] += 1 - share;
  weights[pose_of_key[next]] += share;
  return weights;
}

namespace {

/// Positions as 16-bit numbers: low + step * number.
struct RoundedFrames {
  Eigen::RowVector3d low;
  double step = 0;
  std::vector<std::uint32_t> positions;
};

RoundedFrames RoundFrames(const std::vector<PointsX3>& frames) {
  RoundedFrames rounded;
  Eigen::RowVector3d low = frames.front().colwise().minCoeff(),
                     high = frames.front().colwise().maxCoeff();
  for (const PointsX3& points : frames) {
    low = low.cwiseMin(points.colwise().minCoeff());
    high = high.cwiseMax(points.colwise().maxCoeff());
  }
  rounded.low = low;
  rounded.step = std::max((high - low).maxCoeff(), 1e-12) / 65535;
  for (const PointsX3& points : frames)
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      for (int c = 0; c < 3; ++c)
        rounded.positions.push_back(
            static_cast<std::uint32_t>(std::lround((points(i, c) - low[c]) / rounded.step)));
  return rounded;
}

}  // namespace

std::string PlayerJson(const PlayerData& data,
                       const std::function<std::string(const Image8&)>& encode) {
  using nlohmann::json;
  const RoundedFrames frames = RoundFrames(data.frames);
  const DrawnVertices drawn = Draw(data.mesh);
  const bool wide = drawn.source.size() > 65535;
  const auto indices = [&](const std::vector<std::uint32_t>& values) {
    return wide ? Packed<std::uint32_t>(values) : Packed<std::uint16_t>(values);
  };
  json moments = json::array(), textures = json::array();
  const auto rounded = [](double x) { return std::round(1e4 * x) / 1e4; };
  for (const PlayerMoment& m : data.moments) {
    json weights = json::array();
    for (const double w : m.weights) weights.push_back(rounded(w));
    moments.push_back({{"a", m.a}, {"b", m.b}, {"share", rounded(m.share)}, {"weights", weights}});
  }
  for (const Image8& texture : data.textures) textures.push_back(encode(texture));
  return json{{"vertices", data.frames.front().rows()},
              {"low", {frames.low[0], frames.low[1], frames.low[2]}},
              {"step", frames.step},
              {"up", {data.up[0], data.up[1], data.up[2]}},
              {"fps", data.fps},
              {"wide", wide},
              {"positions", Packed<std::uint16_t>(frames.positions)},
              {"faces", indices(drawn.faces)},
              {"source", indices(drawn.source)},
              {"uv", Packed<std::uint16_t>(drawn.uv)},
              {"moments", moments},
              {"keys", data.keys},
              {"textures", textures}}
      .dump();
}

}  // namespace keypose::report
