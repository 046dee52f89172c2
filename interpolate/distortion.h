// The paper's Tables 1 and 2 and Figure 6: how area and volume stray on the way between keys.
#pragma once

#include <string>
#include <vector>

#include "interpolate/sequence.h"

namespace keypose::interpolation {

/// Relative change against a segment's first key over its in-betweens, and more honest measures.
struct DistortionRow {
  double mean = 0, sd = 0;    ///< of (A_k - A_0) / A_0 over in-betweens, sd with n - 1
  double path_deviation = 0;  ///< largest |A(t) / (A_0^(1-t) A_1^t) - 1|; 0 where the ends have different signs or none
  double end_ratio = 1;       ///< A_1 / A_0: what a mean cannot be blamed for
};

/// Faces' relative area change against the segment's first key, at one frame: counts of `bins` equal bins over [low, high]; outliers in the
/// end bins.
struct FaceHistogram {
  double low = -0.5, high = 0.5;
  std::vector<int> counts;
};

struct SegmentDistortion {
  int from_frame = 0, to_frame = 0;
  DistortionRow area, volume, linear_area, linear_volume;
};

struct FrameDistortion {
  double t = 0;                                                     ///< key index + fraction: 0 .. keys - 1
  double area = 1, volume = 1, linear_area = 1, linear_volume = 1;  ///< over the first key's
  FaceHistogram faces, linear_faces;
};

struct DistortionReport {
  std::vector<FrameDistortion> frames;
  std::vector<SegmentDistortion> segments;
};

DistortionReport MeasureDistortion(const Sequence& sequence, const FacesX3& faces);
std::string ToJson(const DistortionReport& report, const Sequence& sequence, const std::string& method);
/// Tables 1 and 2 for a person, one line a segment.
std::vector<std::string> ToTable(const DistortionReport& report, const std::string& method);

}  // namespace keypose::interpolation
