#include "views/hull/mask_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace keypose {
namespace {

// Lower envelope of parabolas: Felzenszwalb & Huttenlocher, Theory of Computing 2012.
void SquaredDistance1d(const std::vector<float>& f, int n, std::vector<float>* d,
                       std::vector<int>* v, std::vector<float>* z) {
  int k = 0;
  (*v)[0] = 0;
  (*z)[0] = -std::numeric_limits<float>::infinity();
  (*z)[1] = std::numeric_limits<float>::infinity();
  for (int q = 1; q < n; ++q) {
    float s = 0;
    while (true) {
      const int p = (*v)[k];
      s = ((f[q] + static_cast<float>(q) * q) - (f[p] + static_cast<float>(p) * p)) /
          (2.0f * (q - p));
      if (s > (*z)[k] || k == 0) break;
      --k;
    }
    if (s <= (*z)[k]) s = (*z)[k];
    (*v)[++k] = q;
    (*z)[k] = s;
    (*z)[k + 1] = std::numeric_limits<float>::infinity();
  }
  k = 0;
  for (int q = 0; q < n; ++q) {
    while ((*z)[k + 1] < q) ++k;
    const float delta = static_cast<float>(q - (*v)[k]);
    (*d)[q] = delta * delta + f[(*v)[k]];
  }
}

// Distance of each pixel to the nearest pixel where `set` is true.
std::vector<float> DistanceTo(const std::vector<char>& set, int width, int height) {
  constexpr float kFar = 1e8f;
  std::vector<float> out(set.size());
  const int longest = std::max(width, height);
  std::vector<float> f(longest), d(longest), z(longest + 1);
  std::vector<int> v(longest);
  for (int x = 0; x < width; ++x) {
    for (int y = 0; y < height; ++y) f[y] = set[static_cast<std::size_t>(y) * width + x] ? 0 : kFar;
    SquaredDistance1d(f, height, &d, &v, &z);
    for (int y = 0; y < height; ++y) out[static_cast<std::size_t>(y) * width + x] = d[y];
  }
  for (int y = 0; y < height; ++y) {
    float* row = out.data() + static_cast<std::size_t>(y) * width;
    std::copy(row, row + width, f.begin());
    SquaredDistance1d(f, width, &d, &v, &z);
    for (int x = 0; x < width; ++x) row[x] = std::sqrt(d[x]);
  }
  return out;
}

// The crop has a margin around the mask wherever the photograph continues. So a mask that touches
// the crop's side touches the photograph's side.
std::array<bool, 4> MaskEdges(const GreyMask& grey) {
  std::array<bool, 4> edges{};
  for (int y = 0; y < grey.height; ++y)
    edges[0] |= InMask(*grey.at(0, y)), edges[1] |= InMask(*grey.at(grey.width - 1, y));
  for (int x = 0; x < grey.width; ++x)
    edges[2] |= InMask(*grey.at(x, 0)), edges[3] |= InMask(*grey.at(x, grey.height - 1));
  return edges;
}

}  // namespace

MaskField MakeMaskField(const PreparedView& view, int level) {
  const PreparedView::Level& source = view.levels[level];
  MaskField field;
  field.width = source.camera.width, field.height = source.camera.height;
  field.focal = source.camera.fx;
  field.edges = MaskEdges(view.levels[0].grey);
  Eigen::Matrix<double, 3, 4> motion;
  motion.leftCols<3>() = view.camera_from_world.rotation.toRotationMatrix();
  motion.col(3) = view.camera_from_world.translation;
  field.from_world = source.camera.K() * motion;
  std::vector<char> inside(source.grey.data.size()), outside(inside.size());
  for (std::size_t i = 0; i < inside.size(); ++i)
    inside[i] = InMask(source.grey.data[i]), outside[i] = !inside[i];
  field.distance = DistanceTo(inside, field.width, field.height);
  const std::vector<float> depth = DistanceTo(outside, field.width, field.height);
  for (std::size_t i = 0; i < depth.size(); ++i)
    field.distance[i] += inside[i] ? 0.5f - depth[i] : -0.5f;
  return field;
}

}  // namespace keypose
