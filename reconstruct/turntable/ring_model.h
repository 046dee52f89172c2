// A turntable capture with few unknowns: one fixed camera per ring, and one table angle per view.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose::reconstruct {

/// One photograph on the table.
struct RingView {
  int image = 0;         ///< index in the image set
  int ring = 0;          ///< index into RingModel::rings
  double index = 0;      ///< position on the table in steps, in the order of the photographs
  double angle_rad = 0;  ///< of the table
};

/// All cameras of a capture: x_in_camera = ring * Rz(angle) * x_on_table, where z is the table's
/// axis.
struct RingModel {
  Camera camera;
  std::vector<Rigid3> rings;     ///< camera from table at angle 0
  std::vector<double> step_rad;  ///< table angle between consecutive photographs of each ring; its
                                 ///< sign is the direction of rotation
  std::vector<RingView> views;   ///< by image

  Rigid3 CameraFromTable(const RingView& view) const;
};

/// Rotation about z.
Eigen::Matrix3d RotationAboutZ(double angle_rad);

/// Pose of the second camera in the first one's frame.
Rigid3 SecondFromFirst(const RingModel& model, const RingView& first, const RingView& second);

/// The matrix F with second^T F first = 0 for pixels, lens distortion aside.
Eigen::Matrix3d FundamentalMatrix(const Camera& camera, const Rigid3& second_from_first);

/// The photographs of each ring.
struct RingLayout {
  struct Place {
    int image = 0;
    double index = 0;  ///< in steps
  };
  std::vector<std::vector<Place>> rings;
  /// number of each ring's positions in a full turn; the initial step is 360 degrees over this
  std::vector<int> positions;
  std::string reason;  ///< as text: "2 rings of 18 in the order of names"
};

/// Rings of the given sizes in the order of the names.
/// @throws InputError  the sizes do not add up to the number of photographs
RingLayout LayoutOfSizes(int images, const std::vector<int>& sizes);

/// Possible layouts of photographs with these names: one to four rings of equal size. Numbers at
/// the end of the names (IMG_0012.jpg) show which are missing; names without numbers count in their
/// order.
std::vector<RingLayout> LikelyLayouts(const std::vector<std::string>& names);

/// The layout of photographs whose table angles are known; which way round the table turns stays
/// open. Nothing if a ring has fewer than 3 photographs, or two of one angle.
/// @param rings       each photograph's ring, any numbers
/// @param angles_deg  each photograph's angle of the table
std::optional<RingLayout> LayoutOfAngles(const std::vector<int>& rings,
                                         const std::vector<double>& angles_deg);

}  // namespace keypose::reconstruct
