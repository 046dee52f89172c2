// The animation as pictures, one a frame of the film.
#pragma once

#include <functional>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "export/playback.h"

namespace keypose::exporting {

struct FilmOptions {
  int width = 960, height = 720;  ///< px
  double azimuth_deg = -1;  ///< of the camera, counter-clockwise seen from above, 0 from -y; below
                            ///< 0: see AzimuthOfMotion
  bool z_up = true;
};

/// What a film shows of the frames.
struct FilmScene {
  const std::vector<Mesh>& frames;      ///< of one connectivity; the first one's UVs hold for all
  const std::vector<Image8>& textures;  ///< in the layout of the first frame; may be empty
  /// of each frame a weight for each texture; empty: the first texture throughout
  std::vector<std::vector<double>> blend;
};

/// Frames by number in the order in which a film of `fps` shows them, each for one picture: held
/// ones repeat.
std::vector<int> FilmFrames(const std::vector<Moment>& moments, double fps);

/// The azimuth from which most motion is seen: way across the picture of what faces the camera,
/// over all frames. Of 11 within 75 degrees of -y; 20 when nothing moves.
double AzimuthOfMotion(const std::vector<Mesh>& frames, const FilmOptions& options);

/// Renders what each of `order` shows and hands it on; equal frames in a row are rendered once.
/// Same bits for any thread count.
void RenderFilm(const FilmScene& scene, const std::vector<int>& order, const FilmOptions& options,
                const std::function<void(const Image8&)>& take, Progress* progress);

}  // namespace keypose::exporting
