// Pictures of one frame, with alpha: the figure and its shadow on a table that is not seen itself.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/film/ground_shadow.h"

namespace keypose {

/// The frames and textures of a film.
struct FilmScene {
  const std::vector<Mesh>& frames;      ///< of one connectivity; all use the UVs of the first
  const std::vector<Image8>& textures;  ///< in the layout of the first frame; may be empty
  /// per frame, a weight per texture; empty: always the first texture
  std::vector<std::vector<double>> blend = {};
  /// where set: the texture of a frame, in place of `textures`; asked for when the frame is painted
  std::function<Image8(int frame)> texture_of_frame = {};
  /// of the renderer (RenderOptions), over the light that the texture already contains
  double shading = 0.35;
};

/// A frame, ready for pictures from any side.
class FramePainter {
 public:
  /// @param frame   index into scene.frames
  /// @param ground  where the shadow falls; nullptr: no shadow
  FramePainter(const FilmScene& scene, int frame, const Ground* ground);
  ~FramePainter();
  FramePainter(const FramePainter&) = delete;
  FramePainter& operator=(const FramePainter&) = delete;

  /// RGBA, straight alpha, sRGB. A pixel of the table is black with the alpha that darkens what it
  /// is laid over as the shadow would, when values are mixed as they are stored, as editing
  /// programs and browsers do. Same bits for any thread count.
  Image8 Picture(const View& view) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A picture of one frame; see FramePainter.
Image8 RenderPicture(const FilmScene& scene, int frame, const View& view, const Ground* ground);

/// The background of films.
inline const Eigen::Matrix<std::uint8_t, 3, 1> kFilmBackground{246, 247, 249};

/// The RGBA picture laid over a plain colour: RGB. An RGB picture stays as it is.
/// @throws InputError  neither 3 nor 4 channels
Image8 LaidOver(const Image8& picture, const Eigen::Matrix<std::uint8_t, 3, 1>& background);

/// The picture as a PNG file: 8 bit, sRGB, with alpha if there are 4 channels.
/// @throws InputError  neither 3 nor 4 channels, or no pixels
std::string EncodePng(const Image8& picture);

}  // namespace keypose
