// The focal length that a photograph's EXIF tells.
#pragma once

#include <algorithm>

namespace keypose {

/// Focal length in pixels of an image `width` x `height`, from EXIF values that are 0 when absent;
/// 0 if unknown. The 35 mm equivalent refers to the longer side (36 mm). If the sensor's width is
/// missing, or must come from a reduced photograph, 23 mm is assumed for lenses of 10 mm and
/// longer: an initial value for sfm, which refines it.
inline double FocalPx(int width, int height, double focal_35mm, double focal_mm,
                      double sensor_width_mm) {
  const double longer = std::max(width, height);
  if (focal_35mm > 0) return focal_35mm / 36 * longer;
  if (focal_mm <= 0) return 0;
  // The sensor's width comes from its pixel pitch. Programs that reduce a photograph drop the pitch
  // or keep it; if they keep it, the sensor seems small and its pixels large, a combination that no
  // camera has. Small pixels or a very short lens indicate a phone; else the camera most likely has
  // an APS-C sensor.
  const double pitch_um = 1000 * sensor_width_mm / longer;
  const bool trusted = sensor_width_mm > 0 && !(sensor_width_mm < 16 && pitch_um > 3.6);
  if (!trusted && focal_mm < 10) return 0;
  const double width_mm = trusted ? sensor_width_mm : 23.0;
  return focal_mm / width_mm * longer;
}

}  // namespace keypose
