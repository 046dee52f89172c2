// The primaries of colours in linear light, and matrices between them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace keypose::composite {

/// CIE xy of red, green, blue and white.
struct Primaries {
  Eigen::Vector2d red, green, blue, white;
};

extern const Primaries kRec709, kAcesAp0, kAcesAp1;

/// Light of the one's primaries from that of the other's, 3 x 3; whites become each other, adapted
/// by Bradford's cone responses.
/// Source: SMPTE RP 177; Lam, Metamerism and colour constancy, 1985.
Eigen::Matrix3d LightFrom(const Primaries& to, const Primaries& from);

/// Of colours of which this is the way from Rec.709; a known set of primaries where it fits one to
/// 1e-4, which is then given as it is published.
Primaries PrimariesOf(const Eigen::Matrix3d& light_from_rec709);

/// Red, green, blue, white as OpenEXR's attribute `chromaticities` has them.
/// @return none  where they are no colours: not finite, or on one line
std::optional<Primaries> PrimariesOf(const std::array<float, 8>& chromaticities);
std::array<float, 8> ChromaticitiesOf(const Primaries& primaries);

/// Whether the matrix between them differs from 1 by less than rounding.
bool SamePrimaries(const Primaries& a, const Primaries& b);

}  // namespace keypose::composite
