// What is known of a film, and what it teaches: the clean plate, the light on the character, its
// shadow, grain, blur.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "composite/composing/shot_geometry.h"
#include "composite/layer/character_layer.h"
#include "composite/layer/set_geometry.h"
#include "composite/light/grain.h"
#include "composite/light/shadow_fit.h"
#include "composite/light/shot_light.h"
#include "composite/plate/clean_plate.h"

namespace keypose::composite {

/// The character's looks: meshes of one connectivity, and textures mixed by weights.
struct Looks {
  FacesX3 faces;
  UvsX2 uvs;
  FacesX3 uv_faces;
  std::vector<ImageF> textures;              ///< RGB, linear, of one size
  std::vector<std::vector<double>> weights;  ///< per frame of the animation, one a texture; empty:
                                             ///< the first texture
  bool plain = false;                        ///< one colour, without the light that textures hold
  /// With the texture of one frame.
  Character At(int frame) const;
};

/// A filmed picture, and the animation's frame that it shows.
struct FilmedPicture {
  int film = 0;        ///< index of the picture
  int animation = 0;   ///< clamped to the animation
  int anchor = -1;     ///< index of the anchor; -1: not located
  bool shows = true;   ///< else the animation is not yet or no longer there
  bool keyed = false;  ///< it shows a key pose
};

/// The set as a camera sees it that is at one place for one picture only.
struct MovingPlate {
  ImageF picture;           ///< RGB, as Film::read gives it
  float grain_lacking = 0;  ///< as CleanPlate's, of all pixels
  double doubtful = 0;      ///< PlateBetweenTwo's, where it was made from its neighbours
};

struct Film {
  std::vector<FilmedPicture> pictures;
  /// RGB, of the camera's size: stored levels of 255, or scene light where there is `shown`.
  std::function<ImageF(int film)> read;
  /// Of pictures that are scene light, linear and without bounds: levels of 255 (sRGB) to look at.
  /// Else none.
  std::function<ImageF(const ImageF& light)> shown;
  /// Of a film that was keyed: how much of each pixel is there, 1 channel, 0 to 1. Else none.
  std::function<ImageF(int film)> alpha;
  ImageF given_plate;  ///< RGB, as `read` gives pictures; empty: none
  /// Of a moving camera: the plate of a frame of the animation, of the camera's size. Else none.
  std::function<MovingPlate(int animation)> plate_at;
  /// Props and furniture before and around the character, besides its table; may be null.
  std::shared_ptr<const SetGeometry> set;
  const RayScene* props() const { return set ? &set->scene : nullptr; }
  Image8 holdout;  ///< 1 channel: 255 where a prop stands before the character; empty: nowhere
};

struct FilmLessons {
  CleanPlate plate;    ///< of a still camera
  ImageF plate_alpha;  ///< of a still camera and a keyed film: of the set; else empty
  std::vector<Eigen::Vector3d> exposures;  ///< per picture of the film, over the plate's
  ShotLight light;                         ///< its frames are those of light_frames
  std::vector<int> light_frames;           ///< of the animation, ascending
  std::map<int, PointsX3> shifts;          ///< for ShotGeometry::SetShifts; empty: not followed
  double beside_px = 0;  ///< mean shift of what is seen, where the film was followed
  ShadowFit shadow;
  std::optional<Grain> grain;
  double blur_px = 0;              ///< standard deviation, of the lens on the character
  std::vector<std::string> notes;  ///< what could not be learnt, for the user
};

/// A picture of the film, or a plate of it, in linear light; and as stored levels of 255.
ImageF LightIn(const Film& film, ImageF picture);
ImageF LevelsIn(const Film& film, ImageF picture);

CleanPlate PlateOf(const Film& film, const MovingPlate& moving_plate);

/// The share of light that the figure's shadow leaves at each pixel, where the table or the set is:
/// 1 channel.
/// @param set  may be null
ImageF ShadowPicture(const RayScene& figure, const Ground& table, const ShadowStrength& strength,
                     const SetGeometry* set, const View& view, const PixelRays& rays);

/// Vertices' gains at a time of the animation.
PointsX3 GainsAt(const ShotGeometry& geometry, const FilmLessons& lessons, double time,
                 const PointsX3& normals);

}  // namespace keypose::composite
