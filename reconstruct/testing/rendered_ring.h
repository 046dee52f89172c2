// A ring of rendered views of a lumpy ball with known surface and cameras, for tests and
// benchmarks.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct::testing {

struct RingOptions {
  int views = 12;        ///< on each of two rings, at 15 and 45 degrees
  int size = 160;        ///< of the square pictures [px]
  double contrast = 60;  ///< of the texture, grey levels; 0 gives a flat colour
  double noise = 0.7;    ///< of the sensor, grey levels
  double k1 = 0;         ///< radial distortion
  bool shaded = false;   ///< light fixed to the camera: textureless surfaces then shade
};

struct RenderedScene {
  Mesh truth;   ///< about the unit ball, with lumps of 0.15 and a dent
  Scene scene;  ///< exact cameras; no sparse points
  std::vector<Image8> images, masks;
  double footprint = 0;  ///< size of a pixel of the pictures on the surface
};

RenderedScene RenderRing(const RingOptions& options);
/// At the size of the pictures. The defaults are those of stage dense.
std::vector<PreparedView> Prepared(const RenderedScene& rendered, int levels = 3);

struct Accuracy {
  /// 90 % of the points are nearer to the true surface than this, in footprints
  double footprints_90 = 0;
  double outliers = 0;      ///< share of points farther than 5 footprints
  double completeness = 0;  ///< share of the true surface above the rings' blind spot that has a
                            ///< point within 3 footprints
  double normal_deg_mean = 0;
};
/// For the first `count` points of the cloud.
Accuracy Measure(const RenderedScene& rendered, const PointCloud& cloud, int count);

/// For each view, all the others.
std::vector<std::vector<int>> AllOthers(int count);

}  // namespace keypose::reconstruct::testing
