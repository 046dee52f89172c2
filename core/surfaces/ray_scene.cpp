#include "core/surfaces/ray_scene.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>

#include <cmath>
#include <string>

#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

/// Closest point of triangle abc to p, with its barycentric coordinates.
/// Source: Ericson, Real-Time Collision Detection, 5.1.5.
RayScene::Foot ClosestOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto foot = [&](double wa, double wb, double wc) {
    RayScene::Foot result;
    result.barycentric = {wa, wb, wc};
    result.point = wa * a + wb * b + wc * c;
    result.squared_distance = (p - result.point).squaredNorm();
    return result;
  };
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return foot(1, 0, 0);
  const Eigen::Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return foot(0, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double v = d1 - d3 > 0 ? d1 / (d1 - d3) : 0;
    return foot(1 - v, v, 0);
  }
  const Eigen::Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return foot(0, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double w = d2 - d6 > 0 ? d2 / (d2 - d6) : 0;
    return foot(1 - w, 0, w);
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double span = (d4 - d3) + (d5 - d6);
    const double w = span > 0 ? (d4 - d3) / span : 0;
    return foot(0, 1 - w, w);
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return foot(1, 0, 0);  // no area: take corner a
  return foot(va / sum, vb / sum, vc / sum);
}

/// One thread builds all trees, so that a tree, and the face that is chosen in a tie, do not depend
/// on timing. The device exists as long as the process: after the last device is released, TBB may
/// start a worker thread, which could take part in the next build.
RTCDevice Device() {
  static const RTCDevice device = rtcNewDevice("threads=1");
  return device;
}

}  // namespace

struct RayScene::Impl {
  Impl(const PointsX3& p, const FacesX3& f) : points(p), faces(f), scene(rtcNewScene(Device())) {
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(Device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertex = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), static_cast<std::size_t>(points.rows())));
    for (Eigen::Index v = 0; v < points.rows(); ++v)
      for (int k = 0; k < 3; ++k) vertex[3 * v + k] = static_cast<float>(points(v, k));
    auto* index = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), static_cast<std::size_t>(faces.rows())));
    for (Eigen::Index face = 0; face < faces.rows(); ++face)
      for (int k = 0; k < 3; ++k) index[3 * face + k] = static_cast<unsigned>(faces(face, k));
    rtcSetGeometryPointQueryFunction(geometry, &Impl::Visit);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    magnitude = points.rows() ? points.cwiseAbs().maxCoeff() : 0;
  }
  ~Impl() { rtcReleaseScene(scene); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  struct Query {
    const Impl* scene;
    Eigen::Vector3d point;
    Foot best;
  };

  static bool Visit(RTCPointQueryFunctionArguments* args) {
    auto& query = *static_cast<Query*>(args->userPtr);
    const int face = static_cast<int>(args->primID);
    const FacesX3& faces = query.scene->faces;
    const PointsX3& points = query.scene->points;
    Foot foot = ClosestOnTriangle(query.point, points.row(faces(face, 0)),
                                  points.row(faces(face, 1)), points.row(faces(face, 2)));
    if (foot.squared_distance > query.best.squared_distance) return false;
    if (foot.squared_distance == query.best.squared_distance && query.best.face >= 0 &&
        query.best.face < face)
      return false;
    foot.face = face;
    query.best = foot;
    // The tree holds floats. A margin for their rounding ensures that no face that is closer in
    // double precision is missed.
    const auto radius = static_cast<float>(std::sqrt(foot.squared_distance) * (1 + 1e-6) +
                                           4e-7 * query.scene->magnitude);
    if (radius < args->query->radius) {
      args->query->radius = radius;
      return true;
    }
    return false;
  }

  /// Embree asks for rays that are finite, and whose squares are. Others hit nothing.
  static bool CanBeCast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        double near) {
    constexpr double kMost = 1e18;
    return origin.allFinite() && direction.allFinite() && origin.cwiseAbs().maxCoeff() < kMost &&
           direction.cwiseAbs().maxCoeff() < kMost && near < kMost;
  }

  static RTCRay MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        double near, double far) {
    RTCRay ray{};
    ray.org_x = static_cast<float>(origin.x());
    ray.org_y = static_cast<float>(origin.y());
    ray.org_z = static_cast<float>(origin.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tnear = static_cast<float>(near);
    ray.tfar = static_cast<float>(far);
    ray.mask = ~0u;
    return ray;
  }

  PointsX3 points;
  FacesX3 faces;
  RTCScene scene;
  double magnitude = 0;
};

RayScene::RayScene(const PointsX3& points, const FacesX3& faces) {
  if (faces.rows() == 0) throw InputError("ray casting: the mesh has no faces");
  RequireIndices(points.rows(), faces, "ray casting");
  impl_ = std::make_unique<Impl>(points, faces);
}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

RayScene::Hit RayScene::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                             double near, double far) const {
  if (!Impl::CanBeCast(origin, direction, near)) return {};
  RTCRayHit query{};
  query.ray = Impl::MakeRay(origin, direction, near, far);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {static_cast<int>(query.hit.primID), query.ray.tfar, query.hit.u, query.hit.v};
}

bool RayScene::Occluded(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        double near, double far) const {
  if (!Impl::CanBeCast(origin, direction, near)) return false;
  RTCRay ray = Impl::MakeRay(origin, direction, near, far);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0;
}

RayScene::Foot RayScene::ClosestPoint(const Eigen::Vector3d& point, double radius) const {
  if (!Impl::CanBeCast(point, Eigen::Vector3d::UnitX(), 0)) return {};
  Impl::Query query{impl_.get(), point, {}};
  query.best.squared_distance = radius * radius;
  RTCPointQuery rtc_query{};
  rtc_query.x = static_cast<float>(point.x());
  rtc_query.y = static_cast<float>(point.y());
  rtc_query.z = static_cast<float>(point.z());
  rtc_query.time = 0;
  const double rounding = 4e-7 * (impl_->magnitude + point.cwiseAbs().maxCoeff());
  rtc_query.radius = static_cast<float>(radius * (1 + 1e-6) + rounding);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &rtc_query, &context, nullptr, &query);
  if (query.best.face < 0) return {};
  return query.best;
}

}  // namespace keypose
