// Finds places that were picked on one mesh again on another mesh of the same thing in the same
// pose.
#pragma once

#include <memory>
#include <string>

#include "core/camera.h"
#include "core/mesh_binding.h"

namespace keypose {

/// How the frame of the mesh before goes over into that of the mesh now.
struct FrameChange {
  Similarity3 now_from_before;
  bool same_frame = false;  ///< the meshes lie in each other as they are
  double agreeing = 0;  ///< share of the one surface that lies on the other and faces the same way;
                        ///< the lower of both directions
  double misfit = 0;    ///< median distance of the sample from the mesh now, over its diagonal
  /// the thing looks the same from several sides, and nothing tells which is meant
  bool ambiguous = false;
  bool found() const { return agreeing >= kLeastAgreeing && !ambiguous; }
  std::string Words() const;  ///< "in the same frame", "turned by 12 degrees, 1.021 times as large"

  static constexpr double kLeastAgreeing = 0.6;
};

/// A place found again.
struct CarriedPlace {
  enum class Grade {
    kSure,
    kDoubtful,  ///< a person should look
    kLost       ///< there is no such place
  };
  Grade grade = Grade::kLost;
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  double off = 0;   ///< from where the place should be to the surface, over the diagonal
  std::string why;  ///< empty when sure: "the surface is 4.3 % of the diagonal away"
};

/// Carries places from a mesh that is known by its binding to a mesh that is at hand, which must
/// outlive this.
///
/// The frame as it is comes first. Else the sample is laid onto the mesh by similarity ICP (point
/// to plane, robust) from 156 turns; the one with the least distance, difference of normals and,
/// where both have them, of colours wins. Colours are compared up to the brightness of the whole.
/// @throws InputError  an unusable mesh
/// Cost: 1 s of processor time where the frame changed, else 10 ms.
/// Same bits for any thread count.
class Carrier {
 public:
  Carrier(const MeshBinding& before, const Mesh& now);
  ~Carrier();
  const FrameChange& change() const;
  CarriedPlace Carry(const SurfacePlace& before) const;
  /// @param now_point  a point in the frame now
  Eigen::Vector3d BackFrom(const Eigen::Vector3d& now_point) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
