// Closed triangle meshes of implicit solids.
#pragma once

#include <functional>

#include "core/values/mesh.h"

namespace keypose::synth {

/// The surface {f = 0} inside a box as a closed, oriented 2-manifold (marching tetrahedra on the
/// body-centred cubic lattice).
///
/// @param f          negative inside, positive on and near the box; Lipschitz constant at most
/// `lipschitz`; called from many threads
/// @param low, high  the box [m]
/// @param spacing    edge of the lattice's cubes [m]; faces are about half that size
/// @return vertices on the surface to 2 % of the spacing; their order depends only on the inputs
/// @throws InputError  nothing inside the box, or more than 2^31 lattice points. Cost: f is
/// evaluated only near the surface. Same bits for any thread count. Source: Labelle & Shewchuk,
/// Isosurface Stuffing, SIGGRAPH 2007, for the lattice. Departs: no warping; cuts keep 1 % from
/// lattice points.
Mesh Polygonize(const std::function<double(const Eigen::Vector3d&)>& f, const Eigen::Vector3d& low,
                const Eigen::Vector3d& high, double spacing, double lipschitz = 1.3);

}  // namespace keypose::synth
