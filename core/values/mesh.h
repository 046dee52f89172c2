// Triangle meshes and point clouds as plain arrays. Rooms exchange them.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace keypose {

/// rows are points or vectors
using PointsX3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// rows are 0-based corners
using FacesX3 = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;
using ColorsX3 = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, 3, Eigen::RowMajor>;  ///< sRGB, 0..255
/// u right, v up, in [0,1]
using UvsX2 = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

/// An indexed triangle mesh. Optional parts have zero rows when absent.
struct Mesh {
  PointsX3 points;   ///< V x 3
  FacesX3 faces;     ///< F x 3, counter-clockwise seen from outside
  PointsX3 normals;  ///< V x 3 unit, or empty
  ColorsX3 colors;   ///< V x 3, or empty
  UvsX2 uvs;         ///< T x 2, or empty; v is up, so (0,0) is the lower left corner of the texture
  FacesX3 uv_faces;  ///< F x 3 into uvs, or empty

  int vertex_count() const { return static_cast<int>(points.rows()); }
  int face_count() const { return static_cast<int>(faces.rows()); }
  bool has_uvs() const { return uv_faces.rows() == faces.rows() && uvs.rows() > 0; }
};

/// Oriented, coloured points. Optional parts have zero rows when absent.
struct PointCloud {
  PointsX3 points;             ///< P x 3
  PointsX3 normals;            ///< P x 3 unit, pointing to the cameras, or empty
  ColorsX3 colors;             ///< P x 3, or empty
  Eigen::VectorXf confidence;  ///< P in [0,1], or empty
};

}  // namespace keypose
