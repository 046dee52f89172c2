#include "reconstruct/turntable/ring_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numeric>

#include "core/values/errors.h"

namespace keypose::reconstruct {
namespace {

/// The number before the name's extension; -1 if there is none or it is too long.
long TrailingNumber(const std::string& name) {
  const std::size_t dot = name.find_last_of('.');
  std::size_t end = dot == std::string::npos ? name.size() : dot, begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1]))) --begin;
  if (begin == end || end - begin > 9) return -1;
  return std::stol(name.substr(begin, end - begin));
}

/// Position of each photograph in the shooting order, gaps included; 0, 1, 2, ... if the names do
/// not give it.
std::vector<long> ShootingOrder(const std::vector<std::string>& names) {
  std::vector<long> order;
  for (const std::string& name : names) order.push_back(TrailingNumber(name));
  bool rising = !order.empty() && order[0] >= 0;
  for (std::size_t i = 1; i < order.size(); ++i) rising = rising && order[i] > order[i - 1];
  // Numbers with gaps of more than half a set are not positions (times of day, two cameras).
  if (rising && order.back() - order[0] < static_cast<long>(order.size() + order.size() / 2)) {
    const long first = order[0];
    for (long& number : order) number -= first;
    return order;
  }
  std::iota(order.begin(), order.end(), 0L);
  return order;
}

}  // namespace

Eigen::Matrix3d RotationAboutZ(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Rigid3 RingModel::CameraFromTable(const RingView& view) const {
  const Rigid3& ring = rings[view.ring];
  return {(ring.rotation * Eigen::Quaterniond(RotationAboutZ(view.angle_rad))).normalized(),
          ring.translation};
}

Rigid3 SecondFromFirst(const RingModel& model, const RingView& first, const RingView& second) {
  return Compose(model.CameraFromTable(second), model.CameraFromTable(first).Inverse());
}

Eigen::Matrix3d FundamentalMatrix(const Camera& camera, const Rigid3& second_from_first) {
  const Eigen::Vector3d& t = second_from_first.translation;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d k_inverse = camera.K().inverse();
  return k_inverse.transpose() * cross * second_from_first.rotation.toRotationMatrix() * k_inverse;
}

RingLayout LayoutOfSizes(int images, const std::vector<int>& sizes) {
  RingLayout layout;
  int next = 0;
  for (const int size : sizes) {
    layout.reason += (layout.reason.empty() ? "rings of " : ", ") + std::to_string(size);
    layout.positions.push_back(size);
    layout.rings.emplace_back();
    for (int k = 0; k < size; ++k) layout.rings.back().push_back({next++, static_cast<double>(k)});
  }
  if (next != images)
    throw InputError(
        "sfm: option rings describes " + std::to_string(next) + " photographs, but there are " +
        std::to_string(images) +
        "; name the size of each ring in the order of the names, or leave the option out");
  return layout;
}

std::vector<RingLayout> LikelyLayouts(const std::vector<std::string>& names) {
  const std::vector<long> order = ShootingOrder(names);
  const long total = order.empty() ? 0 : order.back() + 1;
  std::vector<RingLayout> layouts;
  for (int count = 1; count <= 4; ++count) {
    const long size = (total + count - 1) / count;
    if (size < 4) break;
    RingLayout layout;
    layout.reason = std::to_string(count) + (count == 1 ? " ring of " : " rings of ") +
                    std::to_string(size) + " positions in the order of names";
    layout.rings.resize(static_cast<std::size_t>(count));
    layout.positions.assign(static_cast<std::size_t>(count), static_cast<int>(size));
    for (std::size_t i = 0; i < order.size(); ++i)
      layout.rings[order[i] / size].push_back(
          {static_cast<int>(i), static_cast<double>(order[i] % size)});
    bool enough = true;
    for (const auto& ring : layout.rings) enough = enough && ring.size() >= 3;
    if (enough) layouts.push_back(std::move(layout));
  }
  return layouts;
}

std::optional<RingLayout> LayoutOfAngles(const std::vector<int>& rings,
                                         const std::vector<double>& angles_deg) {
  std::map<int, std::vector<int>> images_of_ring;
  for (std::size_t i = 0; i < rings.size(); ++i)
    images_of_ring[rings[i]].push_back(static_cast<int>(i));
  RingLayout layout;
  layout.reason = "table angles of the shooting session";
  for (auto& [ring, images] : images_of_ring) {
    std::sort(images.begin(), images.end(),
              [&](int a, int b) { return angles_deg[a] < angles_deg[b]; });
    if (images.size() < 3) return std::nullopt;
    double step_deg = 360 + angles_deg[images.front()] - angles_deg[images.back()];
    for (std::size_t k = 1; k < images.size(); ++k)
      step_deg = std::min(step_deg, angles_deg[images[k]] - angles_deg[images[k - 1]]);
    if (!(step_deg > 0.1)) return std::nullopt;
    const int positions = static_cast<int>(std::lround(360 / step_deg));
    layout.positions.push_back(positions);
    layout.rings.emplace_back();
    for (const int image : images)
      layout.rings.back().push_back({image, angles_deg[image] * positions / 360});
  }
  return layout;
}

}  // namespace keypose::reconstruct
