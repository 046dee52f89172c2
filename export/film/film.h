// The animation as pictures, one per frame of the film.
#pragma once

#include <functional>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "export/animation/playback.h"

namespace keypose::exporting {

struct FilmOptions {
  int width = 960, height = 720;  ///< px
  /// of the camera, counter-clockwise seen from above, 0: from -y; below 0: see AzimuthOfMotion
  double azimuth_deg = -1;
  bool z_up = true;
};

/// The frames and textures of a film.
struct FilmScene {
  const std::vector<Mesh>& frames;      ///< of one connectivity; all use the UVs of the first
  const std::vector<Image8>& textures;  ///< in the layout of the first frame; may be empty
  /// per frame, a weight per texture; empty: always the first texture
  std::vector<std::vector<double>> blend;
};

/// The azimuth [degrees] that shows most motion: the image motion of vertices that face the camera,
/// over all frames. One of 11 azimuths within 75 degrees of -y; 20 if nothing moves.
double AzimuthOfMotion(const std::vector<Mesh>& frames, const FilmOptions& options);

/// Renders the frames of `order` and passes on each picture. Equal consecutive frames are rendered
/// once. Same bits for any thread count.
void RenderFilm(const FilmScene& scene, const std::vector<int>& order, const FilmOptions& options,
                const std::function<void(const Image8&)>& take, Progress* progress);

}  // namespace keypose::exporting
