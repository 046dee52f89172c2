// The report's pictures.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "report/contents.h"

namespace keypose::report {

struct SidesOptions {
  std::vector<double> azimuths_deg = {20, 110, 200, 290};
  double elevation_deg = 14;
  int width = 360, height = 400;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

/// From all round; with a texture where there are one and UVs, else the mesh's colours.
std::vector<Picture> TexturedSides(const Mesh& mesh, const Image8* texture,
                                   const SidesOptions& options);
/// Clay grey, edges drawn.
std::vector<Picture> ShapeSides(const Mesh& mesh, const SidesOptions& options);
/// Coloured by a value at each vertex, 0 to `highest`.
std::vector<Picture> HeatSides(const Mesh& mesh, const Eigen::VectorXd& values, double highest,
                               const SidesOptions& options);
/// The colours of HeatSides as CSS, from 0 to the highest.
std::vector<std::string> HeatStops();

/// All frames by one camera that holds them all. Frames share `mesh`'s faces and UVs.
std::vector<Picture> Film(const Mesh& mesh, const std::vector<PointsX3>& frames,
                          const std::vector<std::string>& captions, const Image8* texture,
                          const SidesOptions& options);

/// The mesh in clay with a ring around a vertex, seen from the side from which the vertex shows
/// best.
/// @param size  of the figure's picture; the ring's size goes with it
Image8 MarkedVertex(const Mesh& mesh, int vertex, const SidesOptions& size);

/// Points as squares of a few pixels, nearest in front.
Picture CloudPicture(const PointCloud& cloud, const SidesOptions& options);

/// A photograph `width` wide: what the mask leaves out is darkened, its outline drawn.
Image8 MaskTile(const Image8& small_photograph, const Image8& small_mask);

}  // namespace keypose::report
