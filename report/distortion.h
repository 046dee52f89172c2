// The paper's measures of an interpolation: how area and volume depart from the first key's, in
// total and per face.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::report {

/// One frame; all values are relative to the first key: 0.02 is 2 % more.
struct FrameDistortion {
  double t = 0;
  double area = 0, volume = 0;                ///< of the interpolation that was asked for
  double linear_area = 0, linear_volume = 0;  ///< of straight lines between the keys
  bool key = false;
  bool stands = false;  ///< shows a key again: held, or on twos
  int same_as = -1;     ///< the earlier frame that it shows again; -1 where it is one of its own
  double time_s = 0;    ///< on the timeline; t where distortion.json has none
  double area_path = NAN,
         /// what they should be on the way between the keys; NaN where that is not said
      volume_path = NAN;
};

/// Mean and standard deviation over the in-between frames: a row of the paper's Tables 1 and 2.
struct DistortionRow {
  double linear_mean = 0, linear_deviation = 0, mean = 0, deviation = 0;
  int frames = 0;
};

/// Parses distortion.json: {"frames": [{"t", "area", "volume", "linear_area", "linear_volume"}],
/// "key_frames": [0, ...]}; values may be relative (0 at the first key) or ratios (1 at the first
/// key), which is found from the first frame. A frame may also have "time", "area_path",
/// "volume_path" and "same_as", the number of the frame that it repeats.
/// @throws InputError  malformed, no frames, or a value that is not finite
std::vector<FrameDistortion> ParseDistortion(const std::string& text);

DistortionRow AreaRow(const std::vector<FrameDistortion>& frames);
DistortionRow VolumeRow(const std::vector<FrameDistortion>& frames);

/// Per face of one in-between frame: (measure(t) - measure(first key)) / measure(first key).
struct FaceDistortion {
  std::vector<double> area, volume;  ///< F; volume of the tetrahedron with the mesh's centroid.
                                     ///< Faces without measure are left out
  std::vector<double> linear_area, linear_volume;
};
/// @param first, frame, second  positions of the first key, the frame, the second key; all V x 3
/// @param t  of the frame between the two keys, in [0,1]: where the straight lines are taken
FaceDistortion PerFace(const PointsX3& first, const PointsX3& frame, const PointsX3& second,
                       const FacesX3& faces, double t);

/// Counts of values in `bins` equal parts of [low, high], as shares of all; values outside fall
/// into the first or last.
std::vector<double> Histogram(const std::vector<double>& values, double low, double high, int bins);

/// A row of the paper's two tables.
struct PaperRow {
  const char* character;
  int faces;
  const char* landmarks;
  DistortionRow area, volume;
};
/// Tables 1 and 2 of Ciucanu et al., "E-StopMotion", as printed.
const std::vector<PaperRow>& PaperTables();

}  // namespace keypose::report
