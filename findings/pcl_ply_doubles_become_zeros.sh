#!/usr/bin/env bash
# PCL reads a PLY whose coordinates are doubles, reports success, and gives every point as (0, 0, 0).
#
# Seen with: Debian 12's libpcl-dev 1.13.0+dfsg-3.
# Input: four points as "property double x", "y", "z" (PLY allows any type of number), and the same points as floats.
# Output: loadPLYFile returns 0 for both, with four points. From floats they are right, from doubles all are zeros. Only
# a line "Failed to find match for field 'x'" on standard error tells; a mesh that is read and converted does the same.
# Why it matters: doubles are what programs write that want a mesh to survive the disk. Surface reconstruction on such a
# cloud fails much later, and for a reason that seems to be its own.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install libpcl-dev=1.13.0+dfsg-3 libpcl-io1.13=1.13.0+dfsg-3 \
  libpcl-common1.13=1.13.0+dfsg-3 >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
libraries="$work/root/usr/lib/x86_64-linux-gnu"

for type in float double; do
  printf '%s\n' ply "format ascii 1.0" "element vertex 4" "property $type x" "property $type y" "property $type z" \
    end_header "1 0 0" "0 2 0" "0 0 3" "4 5 6" >"$type.ply"
done
cat >read.cpp <<'CPP'
#include <pcl/conversions.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <cstdio>

int main(int, char** files) {
  pcl::PointCloud<pcl::PointXYZ> cloud, of_mesh;
  pcl::PolygonMesh mesh;
  const int cloud_result = pcl::io::loadPLYFile(files[1], cloud);
  const int mesh_result = pcl::io::loadPLYFile(files[1], mesh);
  pcl::fromPCLPointCloud2(mesh.cloud, of_mesh);
  double cloud_sum = 0, mesh_sum = 0;
  for (const auto& point : cloud) cloud_sum += point.x + point.y + point.z;
  for (const auto& point : of_mesh) mesh_sum += point.x + point.y + point.z;
  std::printf("cloud: result %d, %zu points, sum %g; mesh: failed %d, %zu points, sum %g\n", cloud_result,
              cloud.size(), cloud_sum, mesh_result < 0, of_mesh.size(), mesh_sum);
}
CPP
g++ -w -I root/usr/include/pcl-1.13 -I root/usr/include/eigen3 -I root/usr/include -I /usr/include/pcl-1.13 \
  -I /usr/include/eigen3 read.cpp -o read -L "$libraries" -lpcl_io -lpcl_common -lboost_system
floats=$(LD_LIBRARY_PATH="$libraries" ./read float.ply 2>/dev/null)
doubles=$(LD_LIBRARY_PATH="$libraries" ./read double.ply 2>messages)
echo "floats:  $floats"
echo "doubles: $doubles"
echo "on standard error: $(grep -m1 "field 'x'" messages || true)"
if [ "$floats" = "cloud: result 0, 4 points, sum 21; mesh: failed 0, 4 points, sum 21" ] &&
  [ "$doubles" = "cloud: result 0, 4 points, sum 0; mesh: failed 0, 4 points, sum 0" ]; then
  echo "as before"
else
  echo "CHANGED"
  exit 1
fi
