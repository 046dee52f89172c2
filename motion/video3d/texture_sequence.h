// A texture for each frame of a moving mesh, from films of several fixed cameras.
#pragma once

#include <functional>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "motion/video3d/camera_exposure.h"
#include "motion/video3d/filmed_view.h"
#include "motion/video3d/surface_texels.h"
#include "motion/video3d/texture_fill.h"
#include "motion/video3d/view_blender.h"

namespace keypose::motion {

/// What the cameras filmed in one frame, and where the mesh is.
struct FilmedFrame {
  PointsX3 points;                      ///< V x 3, in world
  std::vector<Image8> pictures, masks;  ///< one per camera; empty: none of this frame
};

struct SequenceOptions {
  int texture_size = 1024;
  bool level_exposure = true;
  FilmedViewOptions view;
  BlendOptions blend;
  FillOptions fill;
};

struct SequenceInput {
  const Mesh& mesh;                ///< faces and UVs, and the shape of a frame
  const std::vector<View>& views;  ///< in world
  int frames = 0;
  std::function<FilmedFrame(int frame)> read;  ///< in order, but for a few frames at the beginning
  Image8 own_texture;                          ///< RGB, of texture_size; or empty
};

/// Where the colours of all frames wait until those after them are known.
struct ColorStore {
  std::function<void(int frame, const TexelColors& colors)> put;
  std::function<TexelColors(int frame)> get;
};

struct SequenceReport {
  CameraExposures exposure;
  double seen_ever = 0;                 ///< share of the surface that some frame shows
  std::vector<double> own, neighbours;  ///< per frame: shares, as FilledTexture
  std::vector<double> covered;          ///< per camera: share of the mesh's pixels in its masks
  std::vector<int> frames_seen;         ///< per camera: frames in which the mesh is in it
};

/// Takes the finished texture of a frame; called for different frames at once.
using TakeTexture = std::function<void(int frame, const Image8& texture)>;

/// Films are read once for all, a few frames twice (to compare exposures). Then each frame's holes
/// are filled from the frames around it.
/// @throws InputError  no UVs
/// Same bits for any thread count.
SequenceReport MakeTextures(const SequenceInput& input, const SequenceOptions& options,
                            const ColorStore& store, const TakeTexture& take,
                            Progress* progress = nullptr);

/// The power of two from 256 to 2048 at which a texel is about a pixel of the camera that shows the
/// face largest, over half of the surface. Occlusion is ignored.
int AdviseSequenceSize(const Mesh& mesh, const std::vector<View>& views);

}  // namespace keypose::motion
