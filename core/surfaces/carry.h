// Transfers places that were picked on one mesh to another mesh of the same object in the same
// pose.
#pragma once

#include <memory>
#include <string>

#include "core/surfaces/mesh_binding.h"
#include "core/values/camera.h"

namespace keypose {

/// The transformation from the frame of the old mesh ("before") to that of the new mesh ("now").
struct FrameChange {
  Similarity3 now_from_before;
  bool same_frame = false;  ///< the meshes coincide without any transformation
  double agreeing = 0;  ///< share of one surface that lies on the other and faces the same way; the
                        ///< smaller of the two directions
  double misfit = 0;    ///< median distance of the samples from the new mesh, over its diagonal
  /// the object looks the same from several sides, and the right alignment cannot be determined
  bool ambiguous = false;
  bool found() const { return agreeing >= kLeastAgreeing && !ambiguous; }
  std::string Words() const;  ///< "in the same frame", "turned by 12 degrees, 1.021 times as large"

  static constexpr double kLeastAgreeing = 0.6;
};

/// A place on the new mesh.
struct CarriedPlace {
  enum class Grade {
    kSure,
    kDoubtful,  ///< a person should look
    kLost       ///< the new mesh has no such place
  };
  Grade grade = Grade::kLost;
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  double off = 0;  ///< distance from the expected place to the surface, over the diagonal
  /// the reason, such as "the surface is 4.3 % of the diagonal away"; empty when sure
  std::string why;
};

/// Transfers places from an old mesh, of which only the binding is known, to a new mesh. The new
/// mesh must outlive this object.
///
/// The unchanged frame is tried first. If it does not fit, robust point-to-plane ICP with a
/// similarity aligns the binding's samples with the mesh, from 156 initial rotations. The result
/// with the lowest cost wins: the cost adds up distances, differences of normals and, where both
/// meshes have colours, differences of colours. One gain for each colour channel is removed before
/// colours are compared.
/// @throws InputError  an unusable mesh
/// Cost: 1 s of processor time when the frame has changed, else 10 ms.
/// Same bits for any thread count.
class Carrier {
 public:
  Carrier(const MeshBinding& before, const Mesh& now);
  ~Carrier();
  const FrameChange& change() const;
  CarriedPlace Carry(const SurfacePlace& before) const;
  /// @param now_point  a point in the new frame
  Eigen::Vector3d BackFrom(const Eigen::Vector3d& now_point) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
