#include "views/stereo/patch_match_warp.h"

#include <cstring>

namespace keypose::stereo {
namespace {
constexpr float kFarOutside = -1e6f;
constexpr float kSteepest =
    0.75f /
    kPatchRadius;  // the nearest sample of a window has a quarter of the depth of its centre
}  // namespace

Transfer MakeTransfer(const PreparedView& from, const PreparedView& to, int level) {
  const Rigid3 to_from = Compose(to.camera_from_world, from.camera_from_world.Inverse());
  const Eigen::Matrix3d k = to.camera(level).K();
  return {
      (k * to_from.rotation.toRotationMatrix() * from.camera(level).K().inverse()).cast<float>(),
      (k * to_from.translation).cast<float>()};
}

void TransferLanes::Set(int lane, const Transfer& transfer) {
  for (int i = 0; i < 3; ++i) {
    x[i][lane] = transfer.a(i, 0);
    y[i][lane] = transfer.a(i, 1);
    one[i][lane] = transfer.a(i, 2);
    depth[i][lane] = transfer.b[i];
  }
}

WarpLanes WarpsOf(const TransferLanes& t, const PixelLanes& pixel, const PlaneHypothesis& plane,
                  float scale) {
  Lanes h[3], hx[3], hy[3];
  for (int i = 0; i < 3; ++i) {
    h[i] = pixel.base[i] + t.depth[i] * plane.inverse_depth;
    hx[i] = scale * (t.x[i] + t.depth[i] * plane.gx);
    hy[i] = scale * (t.y[i] + t.depth[i] * plane.gy);
  }
  const Lanes inverse = 1.0f / h[2], x = h[0] * inverse, y = h[1] * inverse, ex = hx[2] * inverse,
              ey = hy[2] * inverse;
  const Lanes ex_size = ex < 0.0f ? -ex : ex, ey_size = ey < 0.0f ? -ey : ey;
  // false for NaN
  const auto good = (h[2] > 0.0f) & (ex_size + ey_size < kSteepest);
  const Lanes outside = Lanes{} + kFarOutside, none = Lanes{};
  WarpLanes out;
  auto store = [](const Lanes& lanes, float* to) { std::memcpy(to, &lanes, sizeof lanes); };
  store(good ? x + 1.0f : outside, out.x);
  store(good ? y + 1.0f : outside, out.y);  // the border of SampleImage
  store((hx[0] - x * hx[2]) * inverse, out.ax);
  store((hy[0] - x * hy[2]) * inverse, out.bx);
  store((hx[1] - y * hx[2]) * inverse, out.ay);
  store((hy[1] - y * hy[2]) * inverse, out.by);
  store(good ? ex : none, out.ex);
  store(good ? ey : none, out.ey);
  return out;
}

}  // namespace keypose::stereo
