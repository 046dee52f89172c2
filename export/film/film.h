// The animation as pictures, one per frame of the film, and one frame from all round.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "export/animation/scene.h"
#include "views/film/frame_painter.h"

namespace keypose::exporting {

struct FilmOptions {
  int width = 960, height = 720;  ///< px
  /// of the camera, counter-clockwise seen from above, 0: from -y; below 0: see AzimuthOfMotion
  double azimuth_deg = -1;
  bool z_up = true;
  bool shadow = true;         ///< on a table at the lowest point of all frames
  double elevation_deg = 14;  ///< of the camera above the figure's middle
  double fov_deg = 28;        ///< vertical field of view: 28 is that of a 48 mm lens
  double light = 0.35;        ///< FilmScene::shading
  Eigen::Matrix<std::uint8_t, 3, 1> background = kFilmBackground;  ///< of films, not of pictures
};

/// A colour by its name (paper, white, grey, black, green) or as #RRGGBB; nothing if it is neither.
std::optional<Eigen::Matrix<std::uint8_t, 3, 1>> FilmColor(const std::string& text);

/// What a film shows of a scene. Refers to the scene, which must outlive it.
FilmScene SceneOfFilm(const Scene& scene, const FilmOptions& options);

/// The azimuth [degrees] that shows most motion: the image motion of vertices that face the camera,
/// over all frames. One of 11 azimuths within 75 degrees of -y; 20 if nothing moves.
double AzimuthOfMotion(const std::vector<Mesh>& frames, const FilmOptions& options);

/// A camera at options.elevation_deg whose picture contains all frames and the dark part of their
/// shadow.
View FilmView(const std::vector<Mesh>& frames, const FilmOptions& options);

/// Takes one picture after the other: RGBA, straight alpha; see FramePainter. It is called from
/// another thread, one call at a time.
using TakePicture = std::function<void(const Image8&)>;

/// Renders the frames of `order` and passes on each picture. Equal consecutive frames are rendered
/// once. Same bits for any thread count.
void RenderFilm(const FilmScene& scene, const std::vector<int>& order, const FilmOptions& options,
                const TakePicture& take, Progress* progress);

/// Cameras on a circle round the figure, all at the same height and distance and evenly spaced, the
/// first at options.azimuth_deg (below 0: 20); one picture after the last would be the first again.
/// A viewer sees the figure turn counter-clockwise, seen from above.
///
/// @param count  at least 1
std::vector<View> TurntableViews(const Mesh& frame, const FilmOptions& options, int count);

/// Pictures of a turn of kTurnSeconds at a frame rate.
inline constexpr double kTurnSeconds = 4;
int TurntablePictures(double fps);

/// Renders one frame from all round, beginning where the film's camera stands. The table is at this
/// frame's lowest point.
/// Same bits for any thread count.
void RenderTurntable(const FilmScene& scene, int frame, double fps, const FilmOptions& options,
                     const TakePicture& take, Progress* progress);

/// The frame that a person means by a frame number ("0", "12"), a frame's name ("frame_0012") or
/// the name of a pose that is a key. Empty: the first key; frame 0 if there is none.
/// @throws UsageError  no such frame or key; lists the keys
int FindFrame(const Scene& scene, const std::string& wanted);

}  // namespace keypose::exporting
