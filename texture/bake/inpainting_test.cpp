#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "texture/bake/testing_spheres.h"

namespace keypose::texture::inpainting_test {

/// A painting of a sphere's atlas, texel by texel.
Painting PaintedBy(
    const Mesh& mesh, const Atlas& atlas,
    const std::function<std::pair<Vector3f, int>(int, const Vector3d&)>& color_and_sure) {
  Painting painting(atlas.size);
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    const int f = atlas.face[texel];
    if (f < 0) continue;
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      x += static_cast<double>(atlas.Weights(texel)[k]) *
           mesh.points.row(mesh.faces(f, k)).transpose();
    const auto [color, sure] = color_and_sure(f, x);
    painting.At(texel) = color;
    painting.sure[texel] = static_cast<std::uint8_t>(sure);
  }
  return painting;
}

// A face that one photograph shows only beside its edge, where half of a pixel is the white
// backdrop.
TEST(InpaintUnseen, TakesWhatIsSeenBesideEdgesOnlyFromAround) {
  const Mesh mesh = PatchSphere(8);
  const Atlas atlas = RasterizeAtlas(mesh, 192);
  const Vector3f green(0.1f, 0.4f, 0.1f), white(0.8f, 0.8f, 0.8f);
  for (const int sure : {1, 255}) {
    Painting painting = PaintedBy(mesh, atlas, [&](int f, const Vector3d&) {
      return f == 10 ? std::pair(white, sure) : std::pair(green, 255);
    });
    InpaintUnseen(mesh, atlas, painting);
    for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
      if (atlas.face[texel] != 10) continue;
      ASSERT_NEAR(painting.At(texel)[0], sure == 1 ? 0.1f : 0.8f,
                  0.03);  // 8/255 of the difference remain
    }
  }
}

// A glove and a sleeve meet in front and behind; below, in a strip that no photograph shows, they
// do not mix to grey.
TEST(InpaintUnseen, PaintsThatMeetDoNotRunIntoEachOther) {
  const Mesh mesh = PatchSphere(16);
  const Atlas atlas = RasterizeAtlas(mesh, 256);
  const Vector3f glove(0.5f, 0.3f, 0.05f), sleeve(0.05f, 0.13f, 0.25f);
  const auto unseen = [](const Vector3d& x) { return x.x() > 0 && std::abs(x.y()) < 0.4; };
  Painting painting = PaintedBy(mesh, atlas, [&](int, const Vector3d& x) {
    return std::pair(x.z() > 0 ? glove : sleeve, unseen(x) ? 0 : 255);
  });
  const Painting before = painting;
  InpaintUnseen(mesh, atlas, painting);
  double mixed = 0, all = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (atlas.face[texel] < 0 || before.sure[texel]) continue;
    all += 1;
    mixed +=
        std::min((painting.At(texel) - glove).norm(), (painting.At(texel) - sleeve).norm()) > 0.1f;
  }
  EXPECT_GT(all, 1000);
  EXPECT_LT(mixed / all, 0.1);
}

}  // namespace keypose::texture::inpainting_test
