// The paper's measures of an interpolation: relative changes of area and volume from the first key,
// in total and per face.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::report {

/// One frame. All values are relative to the first key: 0.02 means 2 % more.
struct FrameDistortion {
  double t = 0;
  double area = 0, volume = 0;                ///< of the chosen method
  double linear_area = 0, linear_volume = 0;  ///< of straight lines between the keys
  bool key = false;
  bool stands = false;  ///< repeats an earlier frame: held, or on twos
  int same_as = -1;     ///< the earlier frame that it repeats; -1 if none
  double time_s = 0;    ///< on the timeline; t if distortion.json has none
  /// target values between the keys; NaN if distortion.json has none
  double area_path = NAN, volume_path = NAN;
};

/// Mean and standard deviation over the in-between frames: a row of the paper's Tables 1 and 2.
struct DistortionRow {
  double linear_mean = 0, linear_deviation = 0, mean = 0, deviation = 0;
  int frames = 0;
};

/// Parses distortion.json: {"frames": [{"t", "area", "volume", "linear_area", "linear_volume"}],
/// "key_frames": [0, ...]}; values may be relative (0 at the first key) or ratios (1 at the first
/// key); the first frame decides which. A frame may also have "time", "area_path", "volume_path"
/// and "same_as", the number of the frame that it repeats.
/// @throws InputError  malformed, no frames, or a value that is not finite
std::vector<FrameDistortion> ParseDistortion(const std::string& text);

/// Gives the frames the times at which they show when they are played at `fps`, from that of the
/// first on: keys without times have no rate of their own.
void PlayAt(double fps, std::vector<FrameDistortion>* frames);

DistortionRow AreaRow(const std::vector<FrameDistortion>& frames);
DistortionRow VolumeRow(const std::vector<FrameDistortion>& frames);

/// Per face of one in-between frame: (measure(t) - measure(first key)) / measure(first key).
struct FaceDistortion {
  /// F; volume of the tetrahedron with the mesh's centroid; without degenerate faces
  std::vector<double> area, volume;
  std::vector<double> linear_area, linear_volume;
};
/// @param first, frame, second  positions of the first key, the frame, the second key; all V x 3
/// @param t  the frame's place between the two keys, in [0,1]; the straight lines are evaluated
/// there
FaceDistortion PerFace(const PointsX3& first, const PointsX3& frame, const PointsX3& second,
                       const FacesX3& faces, double t);

/// Shares of the values in `bins` equal parts of [low, high]. Values outside count in the first or
/// last part.
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
