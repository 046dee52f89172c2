// Turntable photographs of a synthetic world, with exact cameras and masks.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/plate.h"
#include "core/progress.h"
#include "synth/mishaps.h"
#include "synth/world.h"

namespace keypose::synth {

/// The plate under the character: a ChArUco board in the plane z = 0, centred on the axis.
struct PlateOptions {
  bool charuco = false;
  int squares_x = PlateLayout{}.columns, squares_y = PlateLayout{}.rows;  ///< the plate that capture prints
  double square_m = PlateLayout{}.square_m;
  double marker_m = PlateLayout{}.marker_m;
};

struct PhotographerOptions {
  int views = 32;                                 ///< in all, spread evenly over the rings
  std::vector<double> elevations_deg = {12, 40};  ///< one ring each
  int width = 1024, height = 768;
  double focal_35mm = 60;  ///< 35 mm equivalent
  double k1 = -0.06, k2 = 0.02, p1 = 0.0003, p2 = -0.0002;
  double principal_shift_px = 3;      ///< of the principal point off the centre, to the right and down
  double fill = 0.8;                  ///< share of the image's height that the character takes
  double azimuth_jitter_deg = 1.0;    ///< the turntable is turned by hand
  double aim_jitter = 0.004;          ///< of the camera between rings, times distance
  std::string background = "studio";  ///< studio (structured, static in the camera's frame) | plain
  bool shadows = true;
  double table_shadow = 0.25;          ///< darkness of the shadow on the table: 1 is one lamp in a dark room, 0.25 a light tent
  double ambient = 0.42, lamp = 0.75;  ///< light on white clay, linear
  double lamp_aside_rad = -0.85;       ///< of the lamp from the camera, about z: it stands to the left
  double lamp_elevation_deg = 52;      ///< of the lamp above the table
  double gloss = 0.035;                ///< height of the wet highlight, linear
  double noise = 1;                    ///< sensor noise, times that of an ordinary camera
  double blur_px = 0.55;               ///< standard deviation of the lens blur
  double vignetting = 0.12;            ///< light lost in the corners
  int supersampling = 2;               ///< rays per pixel along each axis
  std::uint64_t seed = 1;
  PlateOptions plate;
  Mishaps mishaps;  ///< Take() knows of moves on the table, of hands and of lamps; what shows another figure takes another Photographer
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

struct SyntheticView {
  View view;     ///< exact camera, in the world's frame (fixed to the character)
  Image8 image;  ///< sRGB photograph
  Image8 mask;   ///< 255 where at least half of the pixel is character
};

/// Takes photographs one by one. Construction prepares light and rays; Take is const and safe from many threads.
class Photographer {
 public:
  /// @param rig  stands where that photographer stands, instead of where the figure fills the picture; null: on its own
  /// @throws UsageError  bad options
  Photographer(const World& world, const Pose& pose, const PhotographerOptions& options, const Photographer* rig = nullptr);
  ~Photographer();
  Photographer(Photographer&&) noexcept;

  int view_count() const;
  /// Named IMG_0001.jpg and so on, ring after ring.
  const View& ViewAt(int i) const;
  /// The i-th photograph; a pure function of world, pose, options and i: same bits for any thread count.
  SyntheticView Take(int i) const;
  /// The empty set, as seen by every view (the background is static in the camera's frame).
  Image8 BackgroundPlate() const;
  const Mesh& surface() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All photographs of one pose.
std::vector<SyntheticView> Photograph(const World& world, const Pose& pose, const PhotographerOptions& options,
                                      Progress* progress = nullptr);

/// The exact cameras, with `points` truth surface vertices as sparse points, each seen by the views that really see it (for tests of dense,
/// texture).
Scene TruthScene(const World& world, const Pose& pose, const std::vector<SyntheticView>& photographs, int points = 3000);

}  // namespace keypose::synth
