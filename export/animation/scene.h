// An animation with all that belongs to it, read once: each format takes from it what it can hold.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/surfaces/face_net.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "export/animation/animated_mesh.h"
#include "export/animation/playback.h"
#include "export/animation/texture_blend.h"

namespace keypose::exporting {

/// The content of a compressed image file.
struct EncodedImage {
  std::string bytes;      ///< empty: no texture
  std::string mime_type;  ///< "image/png" or "image/jpeg"
  std::string name;
  /// The name of a file with this content: "texture_0.png".
  std::string FileName(int number) const;
};

/// The frame that shows a pose.
struct KeyMark {
  int frame = 0;
  std::string pose;
};

struct Scene {
  std::string name = "character";        ///< of the object, and of files
  std::vector<std::string> frame_names;  ///< "frame_0000", ...
  std::vector<Mesh> frames;              ///< of one connectivity; the UVs of the first count
  FaceNet net;         ///< of the first frame, for formats that have polygons, else its triangles
  AnimatedMesh split;  ///< the same frames, vertices split along texture seams, with normals
  std::vector<double>
      frame_t;  ///< per frame: key number plus share of the way to the next, or empty
  Clip clip;
  PlaybackOptions playback;
  bool z_up = true;  ///< up is +z in the frames; false: +y

  /// Distinct textures of the keys, in the layout of the first frame. The first is what programs
  /// show that cannot blend textures. May be empty.
  std::vector<EncodedImage> textures;
  std::vector<Image8> texture_pixels;                ///< of each texture, RGB
  std::vector<std::string> poses;                    ///< the pose of each texture
  std::vector<TextureMoment> texture_moments;        ///< empty: always the first texture
  std::vector<std::vector<double>> texture_weights;  ///< per frame and texture, or empty
  /// Where each frame has a texture of its own: file names, one per frame ("frame_0000.png"), and
  /// their pixels, RGB, read when asked for. `textures` is then the first frame's alone.
  std::vector<std::string> frame_texture_names;
  std::function<Image8(int frame)> texture_of_frame;
  std::vector<KeyMark> keys;  ///< in order of time; may be empty

  int frame_count() const { return clip.frame_count(); }
};

/// A file of a format, not yet written.
struct FormatFile {
  std::string path;  ///< below the animation's folder, with '/' between folders
  std::string bytes;
};

/// What a format makes of a scene.
struct FormatFiles {
  std::vector<FormatFile> files;
  /// Largest distance between a vertex as the format holds it and as it was given, over all frames,
  /// divided by the first frame's bounding diagonal. Measured on the numbers that were written.
  double error_over_diagonal = 0;
  std::map<std::string, double> measured;  ///< further figures for animation.json
};

/// The frames that are shown, one per picture of a film at the scene's frame rate: with holds,
/// repeats and the way back of a pingpong.
std::vector<int> ShownFrames(const Scene& scene);

/// Whether the last frame that is shown is the first of the next round.
bool Loops(const Scene& scene);

/// What a player shows over and over: ShownFrames; of a loop without the last, since a picture that
/// shows twice in a row is seen as a hitch.
std::vector<int> RoundOf(const Scene& scene);

/// The times at which a format with linear interpolation needs a frame; see LinearKeyframes.
std::vector<Keyframe> SceneKeyframes(const Scene& scene);

/// For each mark of a pose that is shown: its time [s]. In order of the marks.
std::vector<double> KeySeconds(const Scene& scene);

/// Points of a frame in a world whose +y points up: (x, y, z) -> (x, z, -y), or unchanged.
PointsX3 WithYUp(const PointsX3& points, bool z_up);

/// The name in the folder `textures` of the texture that programs show which show only one.
/// @pre there is a texture
std::string FirstTextureFile(const Scene& scene);

/// Bounding diagonal of the first frame; errors are given relative to it.
double SceneDiagonal(const Scene& scene);

}  // namespace keypose::exporting
