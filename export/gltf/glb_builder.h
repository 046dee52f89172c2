// The parts of a GLB file with one animated mesh, for all writers of this room.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "export/gltf/glb_options.h"

namespace keypose::exporting {

/// Rows of single-precision numbers, as a GLB stores them.
using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Points or vectors in single precision and with glTF's axes, where +y is up: with `z_up`,
/// (x, y, z) becomes (x, z, -y).
FloatRows GltfRows(const PointsX3& rows, bool z_up);

/// Positions and normals in glTF's axes: of a mesh, or what a morph target of weight 1 adds.
struct GlbShape {
  FloatRows positions, normals;  ///< V x 3
};

/// When a morph target has which weight.
struct GlbWeights {
  std::vector<double> seconds;  ///< strictly increasing in single precision
  FloatRows weights;            ///< times x targets
  bool steps = false;           ///< the sampler is STEP instead of LINEAR
};

/// Builds the file. Call in this order: Base, Target for each target, Finish.
class GlbBuilder {
 public:
  /// @param split  its faces and texture coordinates are written
  GlbBuilder(const AnimatedMesh& split, std::string name);
  ~GlbBuilder();

  void Base(const GlbShape& shape);
  void Target(const std::string& name, const GlbShape& difference);

  /// @param first_weights  one per target, shown by viewers that do not play the animation
  /// @param animation      without times: none is written
  /// @return the bytes of the file
  /// @throws InputError  a texture for a mesh without texture coordinates, or more than the 4 GiB
  /// that a GLB can hold
  std::string Finish(const std::vector<double>& first_weights, const GlbTextures& textures,
                     const GlbWeights& animation);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace keypose::exporting
