// The report's pictures.
#pragma once

#include <string>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "report/evidence/contents.h"

namespace keypose::report {

struct SidesOptions {
  std::vector<double> azimuths_deg = {20, 110, 200, 290};
  double elevation_deg = 14;
  int width = 360, height = 400;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};

/// Views from all round, with the texture if there are a texture and UVs, else with the mesh's
/// colours.
std::vector<Picture> TexturedSides(const Mesh& mesh, const Image8* texture,
                                   const SidesOptions& options);
/// Views in clay grey with edges.
std::vector<Picture> ShapeSides(const Mesh& mesh, const SidesOptions& options);
/// Views coloured by a value per vertex, from 0 to `highest`.
std::vector<Picture> HeatSides(const Mesh& mesh, const Eigen::VectorXd& values, double highest,
                               const SidesOptions& options);
/// The colours of HeatSides in CSS, from 0 to `highest`.
std::vector<std::string> HeatStops();

/// All frames, seen by one camera that shows them all. The frames share the faces and UVs of
/// `mesh`.
std::vector<Picture> Film(const Mesh& mesh, const std::vector<PointsX3>& frames,
                          const std::vector<std::string>& captions, const Image8* texture,
                          const SidesOptions& options);

/// The mesh in clay with a ring around a vertex, from the side that shows the vertex best.
/// @param size  of the figure's picture; the ring scales with it
Image8 MarkedVertex(const Mesh& mesh, int vertex, const SidesOptions& size);

/// The points as squares of a few pixels, the nearest in front.
Picture CloudPicture(const PointCloud& cloud, const SidesOptions& options);

/// A photograph with everything outside the mask darkened and the mask's outline drawn.
Image8 MaskTile(const Image8& small_photograph, const Image8& small_mask);

}  // namespace keypose::report
