// The kinematic template as one camera would show it: which segments cover a pixel, and points of
// its silhouette.
#pragma once

#include <cstdint>
#include <vector>

#include "motion/body/body_surface.h"
#include "motion/tracking/mask_silhouette.h"

namespace keypose::motion {

/// A coarse picture of the segments: bit s of a pixel is set where segment s covers it. It is
/// larger than the silhouette's crop by a margin on each side.
struct SegmentRaster {
  static constexpr int kCell = 2;     ///< pixels of the silhouette to a side of a cell
  static constexpr int kMargin = 24;  ///< cells around the crop
  int width = 0, height = 0;
  std::vector<std::uint16_t> bits;

  Eigen::Vector2d CellOf(const Eigen::Vector2d& pixel) const {
    return (pixel.array() + 0.5) / kCell - 0.5 + kMargin;
  }
  /// 0 outside of the raster.
  std::uint16_t At(const Eigen::Vector2d& pixel) const;
};

/// Vertices of the sixteen segments in the silhouette's pixels, and whether all lie before the
/// camera.
struct ProjectedBody {
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> pixels;  ///< kBodyVertices x 2
  bool before_camera = true;
};
/// @param segments  bit s: segment s is projected; rows of others are not written
ProjectedBody Project(const Silhouette& silhouette, const LocalSurface& surface,
                      const PosedBody& body, std::uint32_t segments = 0xffff);
/// How finely a segment is drawn.
enum class Detail {
  kFine,   ///< every second ring, sixteen angles: a silhouette's error is far below a cell
  kCoarse  ///< every fourth ring, eight angles: below a cell; for comparing many poses
};
/// The same of one segment, only for the vertices that VisitSpans draws.
/// @param projected  pixels of kBodyVertices x 2; other rows stay
void ProjectDrawn(const Silhouette& silhouette, const LocalSurface& surface, const PosedBody& body,
                  int segment, Detail detail, ProjectedBody* projected);

/// An empty raster for the silhouette.
SegmentRaster MakeRaster(const Silhouette& silhouette);
/// Calls fill(first, end), indices of cells in one row, for the cells whose centres a face of the
/// segment covers; a cell may come several times.
template <class Fill>
void VisitSpans(const SegmentRaster& raster, const ProjectedBody& projected, int segment,
                Detail detail, Fill&& fill);
/// Sets the bits of the segments.
void Draw(const ProjectedBody& projected, std::uint32_t segments, SegmentRaster* raster);
/// 1 in cells whose centre lies in the mask.
std::vector<std::uint8_t> MaskCells(const Silhouette& silhouette, const SegmentRaster& raster);

/// A point of the template's silhouette, on an edge between two vertices.
struct OutlineSample {
  int segment = 0;
  int a = 0, b = 0;       ///< the edge's vertices in the segment
  double share = 0;       ///< the point is (1 - share) a + share b
  Eigen::Vector3d local;  ///< in its joint's frame
  Eigen::Vector3d world;
  Eigen::Vector2d pixel, normal;  ///< in the silhouette's crop; unit, outwards
  double length = 0;              ///< of the silhouette that it stands for [px]
};
/// Points of occluding contours beyond which the raster shows no other segment.
/// Source: recipes M.13: contours where the normal is perpendicular to the line of sight.
std::vector<OutlineSample> FindOutline(const Silhouette& silhouette, const LocalSurface& surface,
                                       const PosedBody& body, const ProjectedBody& projected,
                                       const SegmentRaster& raster);

}  // namespace keypose::motion

#include "motion/tracking/body_outline.inc"
