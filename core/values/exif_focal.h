// The focal length that a photograph's EXIF tells.
#pragma once

#include <algorithm>
#include <cmath>

namespace keypose {

/// Diagonal of a picture of 35 mm film, 36 mm x 24 mm [mm].
inline constexpr double kFilmDiagonal_mm = 43.26661530556787;  // sqrt(36^2 + 24^2)

/// The 35 mm equivalent of a focal length in pixels, as CIPA DC-008 (EXIF) and makers mean it: the
/// lens that shows as much along the diagonal. Of pictures of 3:2 that is as much along the width.
inline double Equivalent35mm(double focal_px, int width, int height) {
  return focal_px * kFilmDiagonal_mm / std::hypot(width, height);
}

/// Focal length in pixels of an image `width` x `height`, from EXIF values that are 0 when absent;
/// 0 if unknown. The 35 mm equivalent, which is rounded to a millimetre, decides; the length over
/// the sensor's longer side is used where it agrees, as it is exact, or where there is no
/// equivalent. If the sensor's size is missing, or must come from a reduced photograph, 23 mm is
/// assumed for lenses of 10 mm and longer: an initial value for sfm, which refines it.
inline double FocalPx(int width, int height, double focal_35mm, double focal_mm,
                      double sensor_longer_mm) {
  const double longer = std::max(width, height);
  // The sensor's size comes from its pixel pitch. Programs that reduce a photograph drop the pitch
  // or keep it; if they keep it, the sensor seems small and its pixels large, a combination that no
  // camera has. Small pixels or a very short lens indicate a phone; else the camera most likely has
  // an APS-C sensor.
  const double pitch_um = 1000 * sensor_longer_mm / longer;
  const bool trusted = sensor_longer_mm > 0 && !(sensor_longer_mm < 16 && pitch_um > 3.6);
  const double by_sensor = trusted && focal_mm > 0 ? focal_mm / sensor_longer_mm * longer : 0;
  if (focal_35mm > 0) {
    constexpr double kRounding_mm = 0.6;
    const double off_mm = std::abs(Equivalent35mm(by_sensor, width, height) - focal_35mm);
    if (by_sensor > 0 && off_mm <= kRounding_mm) return by_sensor;
    return focal_35mm / kFilmDiagonal_mm * std::hypot(width, height);
  }
  if (by_sensor > 0) return by_sensor;
  return focal_mm < 10 ? 0 : focal_mm / 23.0 * longer;
}

}  // namespace keypose
