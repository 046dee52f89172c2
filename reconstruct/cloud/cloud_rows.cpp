#include "reconstruct/cloud/cloud_rows.h"

namespace keypose::reconstruct {

int KeepRows(const std::vector<char>& keep, PointCloud* cloud) {
  Eigen::Index to = 0;
  const Eigen::Index count = cloud->points.rows();
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!keep[i]) continue;
    if (to != i) {
      cloud->points.row(to) = cloud->points.row(i);
      cloud->normals.row(to) = cloud->normals.row(i);
      cloud->colors.row(to) = cloud->colors.row(i);
      cloud->confidence[to] = cloud->confidence[i];
    }
    ++to;
  }
  if (to == count) return 0;
  cloud->points.conservativeResize(to, 3);
  cloud->normals.conservativeResize(to, 3);
  cloud->colors.conservativeResize(to, 3);
  cloud->confidence.conservativeResize(to);
  return static_cast<int>(count - to);
}

}  // namespace keypose::reconstruct
