#include "reconstruct/meshing/poisson_surface.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/surface/poisson.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/values/errors.h"

namespace keypose::reconstruct {
namespace {

// PCL works in floats: coordinates far from the origin would lose the surface's detail. So points
// are mapped to the unit cube and back.
struct UnitCube {
  Eigen::RowVector3d center;
  double extent;

  explicit UnitCube(const PointsX3& points) {
    const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    center = 0.5 * (low + high);
    extent = (high - low).maxCoeff();
  }
};

pcl::PointCloud<pcl::PointNormal>::Ptr ToPcl(const PointsX3& points, const PointsX3& normals,
                                             const Eigen::VectorXf& weights, const UnitCube& cube) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  cloud->resize(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::RowVector3f p = ((points.row(i) - cube.center) / cube.extent).cast<float>();
    const Eigen::RowVector3f n =
        normals.row(i).cast<float>() * (weights.size() ? weights[i] : 1.0f);
    auto& out = (*cloud)[i];
    out.x = p.x();
    out.y = p.y();
    out.z = p.z();
    out.normal_x = n.x();
    out.normal_y = n.y();
    out.normal_z = n.z();
  }
  return cloud;
}

Mesh FromPcl(const pcl::PointCloud<pcl::PointNormal>& vertices,
             const std::vector<pcl::Vertices>& polygons, const UnitCube& cube) {
  Mesh mesh;
  mesh.points.resize(vertices.size(), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto& v = vertices[i];
    mesh.points.row(i) = Eigen::RowVector3d(v.x, v.y, v.z) * cube.extent + cube.center;
  }
  std::vector<Eigen::RowVector3i> faces;
  faces.reserve(polygons.size());
  for (const auto& polygon : polygons) {
    const Eigen::RowVector3i f(polygon.vertices[0], polygon.vertices[1], polygon.vertices[2]);
    if (f[0] != f[1] && f[1] != f[2] && f[2] != f[0]) faces.push_back(f);
  }
  mesh.faces.resize(faces.size(), 3);
  for (std::size_t i = 0; i < faces.size(); ++i) mesh.faces.row(i) = faces[i];
  return mesh;
}

}  // namespace

Mesh ScreenedPoisson(const PointsX3& points, const PointsX3& normals,
                     const Eigen::VectorXf& weights, const PoissonOptions& options) {
  const UnitCube cube(points);
  pcl::Poisson<pcl::PointNormal> poisson;
  poisson.setInputCloud(ToPcl(points, normals, weights, cube));
  poisson.setConfidence(weights.size() > 0);  // given by the normals' lengths
  poisson.setDepth(options.depth);
  poisson.setScale(static_cast<float>(kPoissonCubeScale));
  // A solver division above the tree's depth is ignored. Below depth 9 one block is fastest; above,
  // this saves memory.
  poisson.setSolverDivide(8);
  poisson.setIsoDivide(8);
  poisson.setMinDepth(std::min(5, options.depth));
  poisson.setPointWeight(static_cast<float>(options.point_weight));
  poisson.setSamplesPerNode(static_cast<float>(options.samples_per_node));
  // With several threads the order of its sums would vary.
  poisson.setThreads(1);
  pcl::PointCloud<pcl::PointNormal> vertices;
  std::vector<pcl::Vertices> polygons;
  poisson.performReconstruction(vertices, polygons);
  Mesh mesh = FromPcl(vertices, polygons, cube);
  if (mesh.face_count() == 0 || !mesh.points.allFinite())
    throw SolverError("mesh: the Poisson equation gave no surface for " +
                      std::to_string(points.rows()) +
                      " points; check that their normals point outside, or lower `depth`");
  return mesh;
}

}  // namespace keypose::reconstruct
