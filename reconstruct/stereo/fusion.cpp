#include "reconstruct/stereo/fusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "reconstruct/stereo/window_bias.h"

namespace keypose::reconstruct {
namespace {

struct Member {
  int view = -1;
  std::size_t pixel = 0;
};

// Maps one view's pixels to another's and back, and the other view's normals to the first. As
// Transfer of PatchMatch, but in both directions and in double precision.
struct ViewMapping {
  Eigen::Matrix3d there, back, turn;
  Eigen::Vector3d there_depth, back_depth;
};

ViewMapping PassageOf(const PreparedView& from, const PreparedView& to) {
  const Rigid3 motion = Compose(to.camera_from_world, from.camera_from_world.Inverse()),
               back = motion.Inverse();
  const Eigen::Matrix3d k = from.camera().K(), other = to.camera().K();
  return {other * motion.rotation.toRotationMatrix() * k.inverse(),
          k * back.rotation.toRotationMatrix() * other.inverse(), back.rotation.toRotationMatrix(),
          other * motion.translation, k * back.translation};
}

constexpr char kConfirmed = 1, kUsed = 2;

// A point of the cloud in little memory: there are a million.
struct FusedPoint {
  Eigen::Vector3d point;
  Eigen::Vector3f normal;
  float confidence = 0;
  std::array<std::uint8_t, 3> color;
};

struct Group {
  std::array<Member, stereo::kMaxSources + 1> members;
  int count = 0;
};

// On fur, or out of focus, no depth is accurate. Then half of the matched pixels are used in any
// case.
float ErrorLimit(const std::vector<stereo::PlaneMap>& maps, const FusionOptions& options) {
  std::vector<float> errors;
  for (const stereo::PlaneMap& map : maps) {
    map.ForEachPlane([&](std::size_t pixel, std::size_t place) {
      if (pixel % 16 == 0 && map.Cost(place) <= options.largest_cost)
        errors.push_back(map.ExpectedError(place));
    });
  }
  if (errors.empty()) return static_cast<float>(options.largest_error);
  return std::max(static_cast<float>(options.largest_error), UpperMedian(std::move(errors)));
}

class Fuser {
 public:
  Fuser(const std::vector<PreparedView>& views, const std::vector<std::vector<int>>& sources,
        std::vector<stereo::PlaneMap> maps, const FusionOptions& options)
      : views_(views),
        sources_(sources),
        maps_(std::move(maps)),
        options_(options),
        error_limit_(ErrorLimit(maps_, options)),
        least_cosine_(std::cos(options.normal_tolerance_deg * M_PI / 180)),
        passages_(views.size()),
        state_(views.size()),
        points_(views.size()) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      rotations_.push_back(views[i].camera_from_world.rotation.toRotationMatrix());
      centers_.push_back(views[i].Center());
      for (const int s : sources[i]) passages_[i].push_back(PassageOf(views[i], views[s]));
    }
    const WindowBiasOptions bias{options.window_variance, options.largest_cost, error_limit_};
    ParallelFor(std::ssize(views),
                [&](std::int64_t i) { CorrectWindowBias(views[i].camera(), bias, &maps_[i]); });
  }

  FusionResult Run() {
    ParallelFor(std::ssize(views_), [&](std::int64_t i) { Confirm(static_cast<int>(i)); });
    for (std::size_t i = 0; i < views_.size(); ++i) Emit(static_cast<int>(i));
    FusionResult result;
    result.cells.resize(views_.size());
    ParallelFor(std::ssize(views_), [&](std::int64_t i) {
      for (char& state : state_[i]) state &= kConfirmed;
      if (!maps_[i].empty()) result.cells[i] = CellsOf(views_[i], maps_[i], state_[i]);
    });
    maps_.clear();
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const double found =
          static_cast<double>(std::count(state_[i].begin(), state_[i].end(), kConfirmed));
      result.completeness.push_back(
          views_[i].masked_pixels > 0 ? found / static_cast<double>(views_[i].masked_pixels) : 0);
    }
    result.cloud = Cloud();
    result.confirmed = std::move(state_);
    return result;
  }

 private:
  // `place` is the plane's index in the map.
  bool Usable(const stereo::PlaneMap& map, std::size_t place) const {
    return map.Cost(place) <= options_.largest_cost && map.ExpectedError(place) <= error_limit_;
  }
  Eigen::Vector3d World(int view, std::size_t pixel) const {
    const int x = static_cast<int>(pixel % maps_[view].width),
              y = static_cast<int>(pixel / maps_[view].width);
    return rotations_[view].transpose() * (views_[view].camera().Ray(x, y) /
                                           maps_[view].InverseDepth(maps_[view].Find(pixel))) +
           centers_[view];
  }
  Eigen::Vector3d Normal(int view, std::size_t pixel) const {
    const int x = static_cast<int>(pixel % maps_[view].width),
              y = static_cast<int>(pixel / maps_[view].width);
    return rotations_[view].transpose() *
           PlaneNormal(views_[view].camera(), x, y, maps_[view].Plane(maps_[view].Find(pixel)));
  }

  // In the camera's frame, of any length, towards the camera.
  Eigen::Vector3d PlainNormal(int view, double x, double y,
                              const stereo::PlaneHypothesis& plane) const {
    const Pinhole& camera = views_[view].camera();
    const double gx = plane.gx, gy = plane.gy;
    return -Eigen::Vector3d(camera.fx * gx, camera.fy * gy,
                            plane.inverse_depth - gx * (x - camera.cx) - gy * (y - camera.cy));
  }

  // The pixels of the sources that show the same surface; the first member is the pixel itself.
  // Stops after `enough` members.
  Group Agreeing(int view, std::size_t pixel, int enough) const {
    Group group;
    group.members[group.count++] = {view, pixel};
    const stereo::PlaneMap& own = maps_[view];
    const stereo::PlaneHypothesis own_plane = own.Plane(own.Find(pixel));
    const double x = static_cast<double>(pixel % own.width),
                 y = static_cast<double>(pixel / own.width), w = own_plane.inverse_depth;
    const Eigen::Vector3d normal = PlainNormal(view, x, y, own_plane);
    const double least_dot2 = least_cosine_ * least_cosine_ * normal.squaredNorm();
    for (std::size_t k = 0; k < sources_[view].size(); ++k) {
      const int s = sources_[view][k];
      const stereo::PlaneMap& map = maps_[s];
      if (map.empty()) continue;
      const ViewMapping& passage = passages_[view][k];
      const Eigen::Vector3d there = passage.there * Eigen::Vector3d(x, y, 1) +
                                    passage.there_depth * w;  // z: its depth over this one's
      if (there.z() <= 0) continue;
      const double px = there.x() / there.z(), py = there.y() / there.z();
      if (!(px > -0.5 && py > -0.5 && px < map.width - 0.5 && py < map.height - 0.5)) continue;
      const int ox = static_cast<int>(px + 0.5), oy = static_cast<int>(py + 0.5);
      const std::size_t other = static_cast<std::size_t>(oy) * map.width + ox;
      const std::size_t place = map.Find(other);
      if (place == stereo::PlaneMap::kNone || !Usable(map, place)) continue;
      const stereo::PlaneHypothesis plane = map.Plane(place);
      if (std::abs(w - there.z() * plane.inverse_depth) > options_.depth_tolerance * w) continue;
      const Eigen::Vector3d back =
          passage.back * Eigen::Vector3d(ox, oy, 1) + passage.back_depth * plane.inverse_depth;
      const double miss_x = back.x() - x * back.z(), miss_y = back.y() - y * back.z(),
                   reach = options_.reprojection_px * back.z();
      if (back.z() <= 0 || miss_x * miss_x + miss_y * miss_y > reach * reach) continue;
      const Eigen::Vector3d turned = passage.turn * PlainNormal(s, ox, oy, plane);
      const double dot = turned.dot(normal);
      if (dot < 0 || dot * dot < least_dot2 * turned.squaredNorm()) continue;
      group.members[group.count++] = {s, other};
      if (group.count >= enough) break;
    }
    return group;
  }

  void Confirm(int view) {
    const stereo::PlaneMap& map = maps_[view];
    state_[view].assign(static_cast<std::size_t>(map.width) * map.height, 0);
    map.ForEachPlane([&](std::size_t pixel, std::size_t place) {
      if (Usable(map, place) &&
          Agreeing(view, pixel, options_.least_views).count >= options_.least_views)
        state_[view][pixel] = kConfirmed;
    });
  }

  void Emit(int view) {
    for (std::size_t pixel = 0; pixel < state_[view].size(); ++pixel) {
      if (state_[view][pixel] != kConfirmed) continue;
      const Group group = Agreeing(view, pixel, stereo::kMaxSources + 1);
      int used = 0;
      for (int k = 1; k < group.count; ++k)
        used += (state_[group.members[k].view][group.members[k].pixel] & kUsed) != 0;
      if (used >= 2) continue;
      for (int k = 0; k < group.count; ++k)
        state_[group.members[k].view][group.members[k].pixel] |= kUsed;
      Merge(group, &points_[view]);
    }
  }

  // Weighted by how frontally and how closely a view sees the surface.
  void Merge(const Group& group, std::vector<FusedPoint>* points) const {
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = point, color = point;
    double total = 0, match = 0;
    for (int k = 0; k < group.count; ++k) {
      const auto [view, pixel] = group.members[k];
      const Eigen::Vector3d x = World(view, pixel), n = Normal(view, pixel);
      const Eigen::Vector3d to_camera = centers_[view] - x;
      const double weight = std::max(0.05, n.dot(to_camera.normalized())) / to_camera.squaredNorm();
      const std::uint8_t* rgb = views_[view].color.data.data() + pixel * 3;
      point += weight * x;
      normal += weight * n;
      color += weight * Eigen::Vector3d(rgb[0], rgb[1], rgb[2]);
      match += weight * std::max(0.0, 1.0 - maps_[view].Cost(maps_[view].Find(pixel)));
      total += weight;
    }
    const double views = std::min(1.0, (group.count - 1) / 4.0);
    FusedPoint out;
    out.point = point / total;
    out.normal = normal.normalized().cast<float>();
    for (int c = 0; c < 3; ++c)
      out.color[c] =
          static_cast<std::uint8_t>(std::lround(std::clamp(color[c] / total, 0.0, 255.0)));
    out.confidence = static_cast<float>(std::clamp(views * (0.3 + 0.7 * match / total), 0.05, 1.0));
    points->push_back(out);
  }

  // View by view, so that copied points are freed.
  PointCloud Cloud() {
    std::size_t count = 0;
    for (const std::vector<FusedPoint>& points : points_) count += points.size();
    PointCloud cloud;
    const auto rows = static_cast<Eigen::Index>(count);
    cloud.points.resize(rows, 3);
    cloud.normals.resize(rows, 3);
    cloud.colors.resize(rows, 3);
    cloud.confidence.resize(rows);
    Eigen::Index row = 0;
    for (std::vector<FusedPoint>& points : points_) {
      for (const FusedPoint& p : points) {
        cloud.points.row(row) = p.point;
        cloud.normals.row(row) = p.normal.cast<double>();
        for (int c = 0; c < 3; ++c) cloud.colors(row, c) = p.color[c];
        cloud.confidence[row++] = p.confidence;
      }
      std::vector<FusedPoint>().swap(points);
    }
    return cloud;
  }

  const std::vector<PreparedView>& views_;
  const std::vector<std::vector<int>>& sources_;
  std::vector<stereo::PlaneMap> maps_;
  const FusionOptions& options_;
  const float error_limit_;
  const double least_cosine_;
  std::vector<Eigen::Matrix3d> rotations_;
  std::vector<Eigen::Vector3d> centers_;
  std::vector<std::vector<ViewMapping>> passages_;  // as sources_
  std::vector<std::vector<char>> state_;            // kConfirmed, kUsed
  std::vector<std::vector<FusedPoint>> points_;     // by the view that they were found in
};

}  // namespace

FusionResult FuseDepthMaps(const std::vector<PreparedView>& views,
                           const std::vector<std::vector<int>>& sources,
                           std::vector<stereo::PlaneMap> maps, const FusionOptions& options) {
  for (stereo::PlaneMap& map : maps)
    if (!map.packed()) map.Pack();
  return Fuser(views, sources, std::move(maps), options).Run();
}

}  // namespace keypose::reconstruct
