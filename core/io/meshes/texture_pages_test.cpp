#include "core/io/meshes/texture_pages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/picture_bytes.h"

namespace keypose::texture_pages_test {

using ::testing::HasSubstr;

/// Squares of two triangles beside each other, each of a page and a picture of its own.
PagedMesh Squares(const std::vector<Image8>& pictures) {
  PagedMesh paged;
  const int count = static_cast<int>(pictures.size());
  paged.mesh.points.resize(4 * count, 3);
  paged.mesh.faces.resize(2 * count, 3);
  paged.mesh.uvs.resize(4, 2);
  paged.mesh.uvs << 0, 0, 1, 0, 1, 1, 0, 1;
  paged.mesh.uv_faces.resize(2 * count, 3);
  for (int s = 0; s < count; ++s) {
    for (int v = 0; v < 4; ++v)
      paged.mesh.points.row(4 * s + v) << paged.mesh.uvs(v, 0) + 2 * s, paged.mesh.uvs(v, 1), 0;
    paged.mesh.faces.row(2 * s) << 4 * s, 4 * s + 1, 4 * s + 2;
    paged.mesh.faces.row(2 * s + 1) << 4 * s, 4 * s + 2, 4 * s + 3;
    paged.mesh.uv_faces.row(2 * s) << 0, 1, 2;
    paged.mesh.uv_faces.row(2 * s + 1) << 0, 2, 3;
    paged.pictures.push_back({"picture", PngBytes(pictures[s])});
    TexturePage page;
    page.picture = s;
    paged.page_of_face.insert(paged.page_of_face.end(), 2, paged.PageOf(page));
  }
  return paged;
}

Image8 Numbered(int width, int height, std::uint8_t blue) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(x);
      image.at(x, y)[1] = static_cast<std::uint8_t>(y);
      image.at(x, y)[2] = blue;
    }
  return image;
}

TEST(TexturePages, EachTexelOfEachPageIsFoundAgain) {
  const std::vector<Image8> pictures = {Numbered(37, 20, 1), Numbered(64, 64, 2),
                                        Numbered(5, 100, 3)};
  const PagedMesh paged = Squares(pictures);
  const OneTexture one = JoinPages(PagedMesh(paged), "mesh");
  EXPECT_EQ(one.why, "");
  EXPECT_FALSE(one.as_it_was);
  const Image8 texture = DecodePicture(one.picture, "joined");
  for (int s = 0; s < 3; ++s) {
    const Image8& image = pictures[s];
    // The first triangle's corners are 00, 10 and 11 of the page.
    const Eigen::RowVector2d a = one.uvs.row(one.uv_faces(2 * s, 0)),
                             b = one.uvs.row(one.uv_faces(2 * s, 1)),
                             c = one.uvs.row(one.uv_faces(2 * s, 2));
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const double u = (x + 0.5) / image.width, v = 1 - (y + 0.5) / image.height;
        const Eigen::RowVector2d uv = a + u * (b - a) + v * (c - b);
        const std::uint8_t* at = texture.at(static_cast<int>(uv[0] * texture.width),
                                            static_cast<int>((1 - uv[1]) * texture.height));
        ASSERT_EQ(int{at[0]}, x);
        ASSERT_EQ(int{at[1]}, y);
        ASSERT_EQ(int{at[2]}, s + 1);
      }
  }
}

TEST(TexturePages, OnePageInTheUnitSquareStaysAsItIs) {
  const PagedMesh paged = Squares({Numbered(8, 8, 1)});
  const OneTexture one = JoinPages(PagedMesh(paged), "mesh");
  EXPECT_TRUE(one.as_it_was);
  EXPECT_EQ(one.picture, paged.pictures[0].bytes);
  EXPECT_EQ(one.ending, ".png");
  EXPECT_EQ(one.uvs, paged.mesh.uvs);
  EXPECT_EQ(one.uv_faces, paged.mesh.uv_faces);
}

TEST(TexturePages, TheSameBitsEachTime) {
  const PagedMesh paged = Squares({Numbered(30, 30, 1), Numbered(30, 30, 2)});
  EXPECT_EQ(JoinPages(PagedMesh(paged), "mesh").picture,
            JoinPages(PagedMesh(paged), "mesh").picture);
}

TEST(TexturePages, WhatRepeatsTooOftenIsSaid) {
  PagedMesh paged = Squares({Numbered(100, 100, 1)});
  paged.mesh.uvs *= 10000;
  const OneTexture one = JoinPages(std::move(paged), "fox.obj");
  EXPECT_EQ(one.picture, "");
  EXPECT_THAT(one.why, ::testing::AllOf(HasSubstr("fox.obj"), HasSubstr("do not fit")));
}

TEST(TexturePages, WhatFitsOnlyAtASmallerScaleShrinksAndIsSaid) {
  PagedMesh paged = Squares({Image8(10, 10, 3, 90)});
  paged.mesh.uvs.col(0) *= 3000;
  const OneTexture one = JoinPages(std::move(paged), "fox.obj");
  EXPECT_THAT(one.why, HasSubstr("50 % of their size"));
  const Image8 texture = DecodePicture(one.picture, "joined");
  EXPECT_EQ(texture.width, 15000 + 8);
  EXPECT_EQ(int{texture.at(7000, 5)[1]}, 90);
}

}  // namespace keypose::texture_pages_test
