#include "reconstruct/refinement/photo_profile.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace keypose::reconstruct {
namespace {

constexpr int kSide = 8, kSamples = kSide * kSide;
constexpr double kLeastNoise = 0.6;  // grey levels
constexpr int kProfileGrain = 128;

// Position of a patch in a view's picture: affine, since a patch is small compared to its distance.
struct Placement {
  const GreyMask* grey = nullptr;
  float x = 0, y = 0;        // of the patch's middle at offset 0
  float ax = 0, ay = 0;      // for a sample along the first tangent
  float bx = 0, by = 0;      // along the second
  float ex = 0, ey = 0;      // for one step of offset
  float noise_variance = 0;  // grey levels squared
};

struct alignas(32) Patch {
  float value[kSamples];
};

// Bilinear grey values of the patch, in kGreyScale; samples outside of the picture take its
// border's values.
void SamplePlain(const Placement& at, float x, float y, Patch* patch) {
  const GreyMask& grey = *at.grey;
  const float right = static_cast<float>(grey.width) - 1.01f,
              bottom = static_cast<float>(grey.height) - 1.01f;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const float u = static_cast<float>(i) - 3.5f, w = static_cast<float>(j) - 3.5f;
      const float px = std::clamp(x + u * at.ax + w * at.bx, 0.0f, right),
                  py = std::clamp(y + u * at.ay + w * at.by, 0.0f, bottom);
      const int ix = static_cast<int>(px), iy = static_cast<int>(py);
      const float fx = px - static_cast<float>(ix), fy = py - static_cast<float>(iy);
      const std::uint16_t* p = grey.at(ix, iy);
      const float p00 = p[0], p10 = p[1], p01 = p[grey.width], p11 = p[grey.width + 1];
      const float top = p00 + fx * (p10 - p00), low = p01 + fx * (p11 - p01);
      patch->value[j * kSide + i] = top + fy * (low - top);
    }
}

// Sums lanes in the same order as the vector code.
float Lanes(const float* lane) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

float DotPlain(const Patch& a, const Patch& b) {
  float lane[kSide] = {};
  for (int k = 0; k < kSamples; ++k) lane[k % kSide] += a.value[k] * b.value[k];
  return Lanes(lane);
}

void NormalizePlain(float noise_variance, Patch* patch) {
  float lane[kSide] = {};
  for (int k = 0; k < kSamples; ++k) lane[k % kSide] += patch->value[k];
  const float mean = Lanes(lane) / kSamples;
  for (float& v : patch->value) v = (v - mean) * kGreyScale;
  const float scale = 1 / std::sqrt(DotPlain(*patch, *patch) + kSamples * noise_variance);
  for (float& v : patch->value) v *= scale;
}

void AddPlain(const Patch& patch, Patch* sum) {
  for (int k = 0; k < kSamples; ++k) sum->value[k] += patch.value[k];
}

struct Plain {
  static void Sample(const Placement& at, float x, float y, Patch* patch) {
    SamplePlain(at, x, y, patch);
    NormalizePlain(at.noise_variance, patch);
  }
  static float Dot(const Patch& a, const Patch& b) { return DotPlain(a, b); }
  static void Add(const Patch& patch, Patch* sum) { AddPlain(patch, sum); }
};

#if defined(__x86_64__)
#define KEYPOSE_AVX2 __attribute__((target("avx2,fma")))

KEYPOSE_AVX2 inline float Sum(__m256 lanes) {
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(lanes), _mm256_extractf128_ps(lanes, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
}

struct Avx2 {
  KEYPOSE_AVX2 static void Sample(const Placement& at, float x, float y, Patch* patch) {
    const int width = at.grey->width;
    const int* base = reinterpret_cast<const int*>(at.grey->data.data());
    const __m256 zero = _mm256_setzero_ps(),
                 right = _mm256_set1_ps(static_cast<float>(width) - 1.01f),
                 bottom = _mm256_set1_ps(static_cast<float>(at.grey->height) - 1.01f);
    const __m256 u = _mm256_setr_ps(-3.5f, -2.5f, -1.5f, -0.5f, 0.5f, 1.5f, 2.5f, 3.5f);
    const __m256 row_x = _mm256_fmadd_ps(u, _mm256_set1_ps(at.ax), _mm256_set1_ps(x));
    const __m256 row_y = _mm256_fmadd_ps(u, _mm256_set1_ps(at.ay), _mm256_set1_ps(y));
    const __m256i low16 = _mm256_set1_epi32(0xFFFF), stride = _mm256_set1_epi32(width);
    __m256 total = zero;
    for (int j = 0; j < kSide; ++j) {
      const __m256 w = _mm256_set1_ps(static_cast<float>(j) - 3.5f);
      const __m256 px = _mm256_max_ps(
          _mm256_min_ps(_mm256_fmadd_ps(w, _mm256_set1_ps(at.bx), row_x), right), zero);
      const __m256 py = _mm256_max_ps(
          _mm256_min_ps(_mm256_fmadd_ps(w, _mm256_set1_ps(at.by), row_y), bottom), zero);
      const __m256i ix = _mm256_cvttps_epi32(px), iy = _mm256_cvttps_epi32(py);
      const __m256 fx = _mm256_sub_ps(px, _mm256_cvtepi32_ps(ix)),
                   fy = _mm256_sub_ps(py, _mm256_cvtepi32_ps(iy));
      const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(iy, stride), ix);
      // One read gives both neighbours of a row.
      const __m256i top = _mm256_i32gather_epi32(base, index, 2),
                    low = _mm256_i32gather_epi32(base, _mm256_add_epi32(index, stride), 2);
      const __m256 p00 = _mm256_cvtepi32_ps(_mm256_and_si256(top, low16)),
                   p10 = _mm256_cvtepi32_ps(_mm256_srli_epi32(top, 16));
      const __m256 p01 = _mm256_cvtepi32_ps(_mm256_and_si256(low, low16)),
                   p11 = _mm256_cvtepi32_ps(_mm256_srli_epi32(low, 16));
      const __m256 t = _mm256_fmadd_ps(fx, _mm256_sub_ps(p10, p00), p00),
                   l = _mm256_fmadd_ps(fx, _mm256_sub_ps(p11, p01), p01);
      const __m256 value = _mm256_fmadd_ps(fy, _mm256_sub_ps(l, t), t);
      _mm256_store_ps(patch->value + kSide * j, value);
      total = _mm256_add_ps(total, value);
    }
    Normalize(at.noise_variance, Sum(total) / kSamples, patch);
  }
  KEYPOSE_AVX2 static void Normalize(float noise_variance, float mean, Patch* patch) {
    __m256 squares = _mm256_setzero_ps();
    const __m256 middle = _mm256_set1_ps(mean), unit = _mm256_set1_ps(kGreyScale);
    for (int j = 0; j < kSamples; j += kSide) {
      const __m256 value =
          _mm256_mul_ps(_mm256_sub_ps(_mm256_load_ps(patch->value + j), middle), unit);
      _mm256_store_ps(patch->value + j, value);
      squares = _mm256_fmadd_ps(value, value, squares);
    }
    const __m256 scale = _mm256_set1_ps(1 / std::sqrt(Sum(squares) + kSamples * noise_variance));
    for (int j = 0; j < kSamples; j += kSide)
      _mm256_store_ps(patch->value + j, _mm256_mul_ps(_mm256_load_ps(patch->value + j), scale));
  }
  KEYPOSE_AVX2 static float Dot(const Patch& a, const Patch& b) {
    __m256 lanes = _mm256_setzero_ps();
    for (int j = 0; j < kSamples; j += kSide)
      lanes = _mm256_fmadd_ps(_mm256_load_ps(a.value + j), _mm256_load_ps(b.value + j), lanes);
    return Sum(lanes);
  }
  KEYPOSE_AVX2 static void Add(const Patch& patch, Patch* sum) {
    for (int j = 0; j < kSamples; j += kSide)
      _mm256_store_ps(sum->value + j, _mm256_add_ps(_mm256_load_ps(sum->value + j),
                                                    _mm256_load_ps(patch.value + j)));
  }
};
#endif

class Placer {
 public:
  Placer(const std::vector<PreparedView>& views, int level, double step)
      : views_(views), level_(level), step_(step) {
    for (const PreparedView& view : views)
      turns_.push_back(view.camera_from_world.rotation.toRotationMatrix());
  }

  int Place(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, const VertexViews& chosen,
            Placement* out) const {
    const Eigen::Vector3d first = normal.unitOrthogonal(), second = normal.cross(first);
    const double spacing = chosen.footprint * (1 << level_);
    int count = 0;
    for (int i = 0; i < chosen.count; ++i) {
      const PreparedView& view = views_[chosen.view[i]];
      const Eigen::Matrix3d& turn = turns_[chosen.view[i]];
      const Pinhole& camera = view.camera(level_);
      const Eigen::Vector3d y = turn * x + view.camera_from_world.translation;
      Eigen::Matrix<double, 2, 3> slope;  // derivative of the pixel with respect to the position
      slope << camera.fx / y.z(), 0, -camera.fx * y.x() / (y.z() * y.z()), 0, camera.fy / y.z(),
          -camera.fy * y.y() / (y.z() * y.z());
      slope = (slope * turn).eval();
      const Eigen::Vector2d p = camera.Project(y), a = slope * first * spacing,
                            b = slope * second * spacing, e = slope * normal * step_;
      Placement place{&view.levels[level_].grey, 0, 0, 0, 0, 0, 0, 0, 0, 0};
      place.x = static_cast<float>(p.x());
      place.y = static_cast<float>(p.y());
      place.ax = static_cast<float>(a.x());
      place.ay = static_cast<float>(a.y());
      place.bx = static_cast<float>(b.x());
      place.by = static_cast<float>(b.y());
      place.ex = static_cast<float>(e.x());
      place.ey = static_cast<float>(e.y());
      const double noise = std::clamp(view.noise, kLeastNoise, 4 * kLeastNoise) / (1 << level_);
      place.noise_variance = static_cast<float>(noise * noise);
      if (WithinMask(place)) out[count++] = place;
    }
    return count;
  }

 private:
  // Patches over an outline contain background, which does not move with the surface.
  static bool WithinMask(const Placement& at) {
    constexpr float kReach = 3;
    for (int corner = 0; corner < 4; ++corner) {
      const float u = corner & 1 ? kReach : -kReach, w = corner & 2 ? kReach : -kReach;
      const float x = at.x + u * at.ax + w * at.bx, y = at.y + u * at.ay + w * at.by;
      if (!(x >= 0 && y >= 0 && x < static_cast<float>(at.grey->width - 1) &&
            y < static_cast<float>(at.grey->height - 1)))
        return false;
      if (!InMask(*at.grey->at(static_cast<int>(x + 0.5f), static_cast<int>(y + 0.5f))))
        return false;
    }
    return true;
  }

  const std::vector<PreparedView>& views_;
  int level_;
  double step_;
  std::vector<Eigen::Matrix3d> turns_;
};

template <class Kernel>
void FillRow(const Placement* places, int count, int steps, float* row) {
  Patch patches[kBestViews];
  for (int k = -steps; k <= steps; ++k) {
    Patch sum{};
    const float offset = static_cast<float>(k);
    for (int i = 0; i < count; ++i) {
      Kernel::Sample(places[i], places[i].x + offset * places[i].ex,
                     places[i].y + offset * places[i].ey, &patches[i]);
      Kernel::Add(patches[i], &sum);
    }
    float agreement = 0;
    for (int i = 0; i < count; ++i)
      agreement +=
          std::max(0.0f, Kernel::Dot(patches[i], sum) - Kernel::Dot(patches[i], patches[i])) /
          static_cast<float>(count - 1);
    row[k + steps] = 1 - agreement / static_cast<float>(count);
  }
}

template <class Kernel>
Profiles Fill(const PointsX3& points, const PointsX3& normals,
              const std::vector<VertexViews>& chosen, const std::vector<PreparedView>& views,
              int level, int steps, double step) {
  Profiles out{steps, step, {}};
  out.cost.assign(static_cast<std::size_t>(points.rows()) * out.count(), 1.0f);
  const Placer placer(views, level, step);
  ParallelFor(
      points.rows(),
      [&](std::int64_t v) {
        Placement places[kBestViews];
        const int count = placer.Place(points.row(v), normals.row(v), chosen[v], places);
        if (count >= 2) FillRow<Kernel>(places, count, steps, out.Row(v));
      },
      kProfileGrain);
  return out;
}

}  // namespace

Profiles CostProfilesPlain(const PointsX3& points, const PointsX3& normals,
                           const std::vector<VertexViews>& chosen,
                           const std::vector<PreparedView>& views, int level, int steps,
                           double step) {
  return Fill<Plain>(points, normals, chosen, views, level, steps, step);
}

Profiles CostProfiles(const PointsX3& points, const PointsX3& normals,
                      const std::vector<VertexViews>& chosen,
                      const std::vector<PreparedView>& views, int level, int steps, double step) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    return Fill<Avx2>(points, normals, chosen, views, level, steps, step);
#endif
  return CostProfilesPlain(points, normals, chosen, views, level, steps, step);
}

}  // namespace keypose::reconstruct
