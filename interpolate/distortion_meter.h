// The paper's Tables 1 and 2 and Figure 6: how far area and volume deviate between keys.
#pragma once

#include <string>
#include <vector>

#include "interpolate/sequence.h"
#include "interpolate/timing/spline.h"

namespace keypose::interpolation {

/// One quantity over a segment's in-betweens, relative to the segment's first key.
struct DistortionRow {
  double mean = 0, sd = 0;    ///< of (A_k - A_0) / A_0 over in-betweens, sd with n - 1
  double path_deviation = 0;  ///< largest |A / path - 1|; the path is A_0^(1-t) A_1^t, C1 through
                              ///< smooth keys; 0 where an end is not positive
  double end_ratio = 1;       ///< A_1 / A_0: the part of the mean that the keys themselves cause
};

/// Histogram of the faces' relative area change at one frame, against the segment's first key. The
/// bins over [low, high] are equal; the end bins also count values outside of it.
struct FaceHistogram {
  double low = -0.5, high = 0.5;
  std::vector<int> counts;
};

struct SegmentDistortion {
  int from_frame = 0, to_frame = 0;
  int in_betweens = 0;  ///< frames that show neither key
  DistortionRow area, volume, linear_area, linear_volume;
};

struct FrameDistortion {
  double t = 0;       ///< key index + share of the way: 0 .. keys - 1
  double time_s = 0;  ///< on the timeline
  double area = 1, volume = 1, linear_area = 1, linear_volume = 1;  ///< relative to the first key's
  double area_path = 1, volume_path = 1;  ///< the wanted values; 0 where a key has none
  double volume_move = 0;  ///< largest displacement of a vertex by the volume correction / diagonal
  int on_table = 0;        ///< vertices that touch the table
  int same_as = -1;        ///< the earlier frame that it repeats, or -1
  bool stands = false;     ///< the picture stays until the next frame
  FaceHistogram faces, linear_faces;
};

struct DistortionReport {
  std::vector<FrameDistortion> frames;
  std::vector<SegmentDistortion> segments;
};

/// Measures frames one by one. It stores numbers, but no positions.
class DistortionMeter {
 public:
  /// The keys, the faces and the schedule must outlive the meter.
  DistortionMeter(const std::vector<PointsX3>& keys, const FacesX3& faces,
                  const Schedule& schedule);
  void Add(const FrameView& frame);
  DistortionReport Finish() const;  ///< @pre all frames were added

 private:
  struct Measured {
    double area, volume, linear_area, linear_volume;
  };
  SegmentDistortion SegmentOf(int span) const;

  const std::vector<PointsX3>& keys_;
  const FacesX3& faces_;
  const Schedule& schedule_;
  std::vector<double> key_areas_, key_volumes_;
  std::vector<Eigen::VectorXd> key_face_areas_;
  SpanSpline<double> area_path_, volume_path_;  ///< of logarithms
  bool has_area_path_ = true, has_volume_path_ = true;
  double diagonal_;
  std::vector<FrameDistortion> frames_;
  std::vector<Measured> measured_;
};

std::string ToJson(const DistortionReport& report, const Schedule& schedule,
                   const SourceReport& source, const std::string& method);
/// Tables 1 and 2 as text, one line per segment.
std::vector<std::string> ToTable(const DistortionReport& report, const std::string& method);

}  // namespace keypose::interpolation
