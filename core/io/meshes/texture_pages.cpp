#include "core/io/meshes/texture_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>

#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/picture_bytes.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "core/values/image.h"
#include "core/values/size_of.h"

namespace keypose {

int PagedMesh::PageOf(const TexturePage& page) {
  const auto index = std::find(pages.begin(), pages.end(), page) - pages.begin();
  if (index == std::ssize(pages)) pages.push_back(page);
  return static_cast<int>(index);
}

namespace {

/// Programs put borders exactly at 0 and 1, and round them.
constexpr double kPageBorder = 1e-4;
constexpr int kPadding = 4;          ///< texels around what is used of a page
constexpr int kLongestSide = 16384;  ///< of the texture that is made
/// A block of a palette: a triangle's corners lie at its texels 1 and kBlock - 2.
constexpr int kBlock = 8;
constexpr double kLeastScale = 0.125;  ///< pages that must shrink further are not worth it

using Corners = std::array<Eigen::Vector2d, 3>;

/// Whole repeats by which a face is moved so that it begins in the unit square.
double ShiftOf(Wrap wrap, double least) {
  if (wrap == Wrap::kClamp) return 0;
  const double repeats = std::floor(least + kPageBorder);
  return wrap == Wrap::kRepeat ? repeats : 2 * std::floor(repeats / 2);
}

struct UvRange {
  Eigen::Vector2d least = Eigen::Vector2d::Constant(INFINITY);
  Eigen::Vector2d most = Eigen::Vector2d::Constant(-INFINITY);
  bool InSquare() const {
    return least.minCoeff() >= -kPageBorder && most.maxCoeff() <= 1 + kPageBorder;
  }
};

/// A rectangle of texels of the new texture, and what of the page it shows.
struct Tile {
  int left = 0, top = 0;       ///< in the new texture, of the padding
  int width = 0, height = 0;   ///< with padding
  int from_x = 0, from_y = 0;  ///< the page's texel that lies at left, top
};

int Wrapped(int at, int size, Wrap wrap) {
  if (wrap == Wrap::kClamp) return std::clamp(at, 0, size - 1);
  const int period = wrap == Wrap::kMirror ? 2 * size : size;
  const int rest = ((at % period) + period) % period;
  return rest < size ? rest : period - 1 - rest;
}

/// Levels of sRGB multiplied in linear light.
std::array<std::uint8_t, 256> TimesFactor(double factor) {
  std::array<std::uint8_t, 256> levels{};
  for (int level = 0; level < 256; ++level) {
    const double linear = std::clamp(factor * LinearFromSrgb(level / 255.0), 0.0, 1.0);
    levels[level] = static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(linear)));
  }
  return levels;
}

std::uint8_t SrgbLevel(double linear) {
  return static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(std::clamp(linear, 0.0, 1.0))));
}

/// What a texture of this kind is called; "": one that a mesh cannot have.
std::string EndingOf(std::string_view bytes) {
  const std::string kind = ImageKindOf(bytes.substr(0, 4096));
  if (kind == "jpeg") return ".jpg";
  if (kind == "png") return ".png";
  if (kind == "tiff") return ".tif";
  return kind == "heif" ? ".heic" : "";
}

class PageJoiner {
 public:
  PageJoiner(PagedMesh& paged, const std::string& who) : paged_(paged), who_(who) {}

  OneTexture Join() {
    if (IsPlain() || !ShiftFaces()) return Kept();
    if (IsOnePage()) return Shifted();
    return Baked();
  }

 private:
  bool HasOnePage() const {
    return paged_.pages.size() == 1 && !HasPaletteFaces() &&
           paged_.pages[0].factor == Eigen::Vector3d::Ones();
  }

  bool IsOnePage() const { return HasOnePage() && ranges_[0].InSquare(); }

  /// The usual case, without looking at each face.
  bool IsPlain() const {
    const UvsX2& uvs = paged_.mesh.uvs;
    return HasOnePage() && uvs.minCoeff() >= -kPageBorder && uvs.maxCoeff() <= 1 + kPageBorder;
  }

  bool HasPaletteFaces() const {
    return std::find(paged_.page_of_face.begin(), paged_.page_of_face.end(), -1) !=
           paged_.page_of_face.end();
  }

  Corners CornersOf(Eigen::Index face) const {
    Corners corners;
    for (int k = 0; k < 3; ++k)
      corners[k] = paged_.mesh.uvs.row(paged_.mesh.uv_faces(face, k)).transpose();
    return corners;
  }

  const TexturePage* PageOfFace(Eigen::Index face) const {
    const int page = paged_.page_of_face[static_cast<std::size_t>(face)];
    return page < 0 ? nullptr : &paged_.pages[page];
  }

  /// Finds the shift of each face and the range of each page.
  /// @return whether anything changes: a shift, several pages, a factor, a range beyond the square
  bool ShiftFaces() {
    ranges_.assign(paged_.pages.size(), {});
    shifts_.assign(paged_.page_of_face.size(), Eigen::Vector2d::Zero());
    bool changed = false;
    for (Eigen::Index f = 0; f < paged_.mesh.faces.rows(); ++f) {
      const TexturePage* page = PageOfFace(f);
      if (!page) continue;
      changed |= ShiftFace(f, *page);
    }
    return changed || !IsOnePage();
  }

  bool ShiftFace(Eigen::Index f, const TexturePage& page) {
    const Corners corners = CornersOf(f);
    const Eigen::Vector2d least = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]),
                          most = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    const Eigen::Vector2d shift(ShiftOf(page.wrap_u, least.x()), ShiftOf(page.wrap_v, least.y()));
    shifts_[static_cast<std::size_t>(f)] = shift;
    UvRange& range = ranges_[static_cast<std::size_t>(&page - paged_.pages.data())];
    range.least = range.least.cwiseMin(least - shift);
    range.most = range.most.cwiseMax(most - shift);
    return shift != Eigen::Vector2d::Zero();
  }

  /// The single picture without what must not count in it, or a WebP as PNG.
  OneTexture WithPicture(OneTexture result) {
    PageFile& file = paged_.pictures[paged_.pages[0].picture];
    result.ending = EndingOf(file.bytes);
    if (!result.ending.empty()) {
      result.picture = std::move(file.bytes);
      return result;
    }
    result.as_it_was = false;
    try {
      result.picture = PngBytes(DecodePicture(file.bytes, file.name));
      result.ending = ".png";
    } catch (const InputError& error) {
      result.why = fmt::format("{} has no texture now: {}", who_, error.what());
    }
    return result;
  }

  OneTexture Kept() {
    OneTexture result;
    result.uvs = std::move(paged_.mesh.uvs);
    result.uv_faces = std::move(paged_.mesh.uv_faces);
    result.as_it_was = true;
    return WithPicture(std::move(result));
  }

  /// New coordinates: equal ones become one entry.
  template <class Place>
  void PlaceCorners(const Place& place, OneTexture* result) const {
    std::map<std::pair<double, double>, int> ids;
    std::vector<Eigen::Vector2d> uvs;
    result->uv_faces.resize(paged_.mesh.faces.rows(), 3);
    for (Eigen::Index f = 0; f < paged_.mesh.faces.rows(); ++f) {
      const Corners corners = place(f);
      for (int k = 0; k < 3; ++k) {
        const auto [entry, is_new] =
            ids.emplace(std::pair(corners[k].x(), corners[k].y()), SizeOf(uvs));
        if (is_new) uvs.push_back(corners[k]);
        result->uv_faces(f, k) = entry->second;
      }
    }
    result->uvs.resize(std::ssize(uvs), 2);
    for (std::size_t i = 0; i < uvs.size(); ++i)
      result->uvs.row(static_cast<Eigen::Index>(i)) = uvs[i].transpose();
  }

  Corners ShiftedCorners(Eigen::Index f) const {
    Corners corners = CornersOf(f);
    for (Eigen::Vector2d& corner : corners) corner -= shifts_[static_cast<std::size_t>(f)];
    return corners;
  }

  OneTexture Shifted() {
    OneTexture result;
    PlaceCorners([this](Eigen::Index f) { return ShiftedCorners(f); }, &result);
    return WithPicture(std::move(result));
  }

  OneTexture Baked() {
    OneTexture result;
    try {
      DecodePages();
      MakePalette();
      scale_ = FittingScale();
      if (scale_ < kLeastScale) {
        result.why = fmt::format(
            "{} has no texture now: its textures, repeated as often as it shows them, do not fit "
            "into {} x {} pixels; bake them into one layout and one texture in your modelling "
            "program first",
            who_, kLongestSide, kLongestSide);
        return result;
      }
      if (scale_ < 1)
        result.why = fmt::format(
            "{}: its textures were baked into one of at most {} x {} pixels, at {:.0f} % of their "
            "size",
            who_, kLongestSide, kLongestSide, 100 * scale_);
      result.picture = PngBytes(Painted());
    } catch (const InputError& error) {
      result.why = fmt::format("{} has no texture now: {}", who_, error.what());
      return result;
    }
    result.ending = ".png";
    PlaceCorners([this](Eigen::Index f) { return BakedCorners(f); }, &result);
    return result;
  }

  void DecodePages() {
    images_.resize(paged_.pictures.size());
    for (const TexturePage& page : paged_.pages) {
      const PageFile& file = paged_.pictures[page.picture];
      if (images_[page.picture].empty())
        images_[page.picture] = DecodePicture(file.bytes, file.name);
    }
  }

  Eigen::Vector2d SizeOfPage(std::size_t page) const {
    const Image8& image = images_[paged_.pages[page].picture];
    return {std::max(1.0, std::round(scale_ * image.width)),
            std::max(1.0, std::round(scale_ * image.height))};
  }

  /// The tile of a page, not placed yet. Empty where no face shows it.
  Tile TileOf(std::size_t page) const {
    Tile tile;
    const UvRange& range = ranges_[page];
    if (!(range.least.x() <= range.most.x())) return tile;
    const Eigen::Vector2d size = SizeOfPage(page);
    const double top = (1 - range.most.y()) * size.y(), bottom = (1 - range.least.y()) * size.y();
    const double left = range.least.x() * size.x(), right = range.most.x() * size.x();
    constexpr double kFar = 1e8;  // beyond what fits anyway
    if (std::max({-top, bottom, -left, right}) > kFar) {
      tile.width = tile.height = static_cast<int>(kFar);
      return tile;
    }
    tile.from_x = static_cast<int>(std::floor(left)) - kPadding;
    tile.from_y = static_cast<int>(std::floor(top)) - kPadding;
    tile.width = static_cast<int>(std::ceil(right)) + kPadding - tile.from_x;
    tile.height = static_cast<int>(std::ceil(bottom)) + kPadding - tile.from_y;
    return tile;
  }

  /// The faces of page -1 in square blocks, equal ones once.
  void MakePalette() {
    std::map<std::array<std::uint8_t, 9>, int> blocks;
    block_of_face_.assign(paged_.page_of_face.size(), -1);
    for (std::size_t f = 0; f < paged_.page_of_face.size(); ++f) {
      if (paged_.page_of_face[f] >= 0) continue;
      std::array<std::uint8_t, 9> levels{};
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) levels[3 * k + c] = SrgbLevel(paged_.corner_colors[f][k][c]);
      const auto [entry, is_new] = blocks.emplace(levels, SizeOf(palette_));
      if (is_new) palette_.push_back(levels);
      block_of_face_[f] = entry->second;
    }
  }

  int PaletteColumns() const {
    return std::max(1, static_cast<int>(std::ceil(std::sqrt(SizeOf(palette_)))));
  }

  /// Places all tiles on shelves, the highest first. The last tile is the palette.
  /// @return whether they fit
  bool PlaceTiles() {
    tiles_.clear();
    for (std::size_t p = 0; p < paged_.pages.size(); ++p) tiles_.push_back(TileOf(p));
    Tile palette;
    if (!palette_.empty()) {
      palette.width = kBlock * PaletteColumns();
      palette.height = kBlock * ((SizeOf(palette_) - 1) / PaletteColumns() + 1);
    }
    tiles_.push_back(palette);
    double area = 0;
    int widest = 1;
    for (const Tile& tile : tiles_) {
      area += static_cast<double>(tile.width) * tile.height;
      widest = std::max(widest, tile.width);
    }
    if (widest > kLongestSide || area > static_cast<double>(kMostPixels)) return false;
    width_ = std::min(kLongestSide, std::max(widest, static_cast<int>(std::sqrt(area)) + 1));
    FillShelves();
    return height_ <= kLongestSide;
  }

  void FillShelves() {
    std::vector<int> order(tiles_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return tiles_[a].height > tiles_[b].height; });
    int left = 0, top = 0, shelf = 0;
    for (const int t : order) {
      Tile& tile = tiles_[t];
      if (left + tile.width > width_) {
        top += shelf;
        left = 0;
        shelf = 0;
      }
      tile.left = left;
      tile.top = top;
      left += tile.width;
      shelf = std::max(shelf, tile.height);
    }
    height_ = std::max(1, top + shelf);
  }

  /// The largest scale of 1, 1/2, ... at which all tiles fit; tiles are placed then.
  double FittingScale() {
    for (scale_ = 1; scale_ >= kLeastScale; scale_ /= 2)
      if (PlaceTiles()) return scale_;
    return 0;
  }

  Image8 Painted() {
    Image8 texture(width_, height_, 3);
    for (std::size_t p = 0; p < paged_.pages.size(); ++p) PaintPage(p, &texture);
    PaintPalette(&texture);
    return texture;
  }

  void PaintPage(std::size_t p, Image8* texture) const {
    const TexturePage& page = paged_.pages[p];
    const Tile& tile = tiles_[p];
    const Eigen::Vector2d size = SizeOfPage(p);
    const Image8 image =
        Reduced(images_[page.picture], static_cast<int>(size.x()), static_cast<int>(size.y()));
    std::array<std::array<std::uint8_t, 256>, 3> levels;
    for (int c = 0; c < 3; ++c) levels[c] = TimesFactor(page.factor[c]);
    for (int y = 0; y < tile.height; ++y)
      for (int x = 0; x < tile.width; ++x) {
        const std::uint8_t* from = image.at(Wrapped(tile.from_x + x, image.width, page.wrap_u),
                                            Wrapped(tile.from_y + y, image.height, page.wrap_v));
        std::uint8_t* to = texture->at(tile.left + x, tile.top + y);
        for (int c = 0; c < 3; ++c) to[c] = levels[c][from[c]];
      }
  }

  /// Means of the texels that fall together.
  static Image8 Reduced(const Image8& image, int width, int height) {
    if (image.width == width && image.height == height) return image;
    Image8 small(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) MeanOf(image, x, y, &small);
    return small;
  }

  static void MeanOf(const Image8& image, int x, int y, Image8* small) {
    const auto edge = [](int at, int from, int to) {
      return static_cast<int>(std::int64_t{at} * from / to);
    };
    const int x0 = edge(x, image.width, small->width), y0 = edge(y, image.height, small->height);
    const int x1 = std::max(x0 + 1, edge(x + 1, image.width, small->width));
    const int y1 = std::max(y0 + 1, edge(y + 1, image.height, small->height));
    std::array<std::int64_t, 3> sum{};
    for (int j = y0; j < y1; ++j)
      for (int i = x0; i < x1; ++i)
        for (int c = 0; c < 3; ++c) sum[c] += image.at(i, j)[c];
    const std::int64_t count = std::int64_t{x1 - x0} * (y1 - y0);
    for (int c = 0; c < 3; ++c)
      small->at(x, y)[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
  }

  /// Each block is a triangle's colours, carried on linearly beyond it.
  void PaintPalette(Image8* texture) const {
    const Tile& tile = tiles_.back();
    constexpr double kSpan = kBlock - 3;  // from one corner's texel to the other's
    for (int b = 0; b < SizeOf(palette_); ++b)
      for (int y = 0; y < kBlock; ++y)
        for (int x = 0; x < kBlock; ++x) {
          const double s = (x - 1) / kSpan, t = (y - 1) / kSpan;
          std::uint8_t* to = texture->at(tile.left + BlockLeft(b) + x, tile.top + BlockTop(b) + y);
          for (int c = 0; c < 3; ++c) {
            const auto& levels = palette_[b];
            const double level = (1 - s - t) * levels[c] + s * levels[3 + c] + t * levels[6 + c];
            to[c] = static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
          }
        }
  }

  int BlockLeft(int block) const { return kBlock * (block % PaletteColumns()); }
  int BlockTop(int block) const { return kBlock * (block / PaletteColumns()); }

  /// @param x, y  texels of the new texture, from its upper left corner
  Eigen::Vector2d UvAt(double x, double y) const { return {x / width_, 1 - y / height_}; }

  Corners BakedCorners(Eigen::Index f) const {
    const TexturePage* page = PageOfFace(f);
    if (!page) return PaletteCorners(block_of_face_[static_cast<std::size_t>(f)]);
    const auto p = static_cast<std::size_t>(page - paged_.pages.data());
    const Tile& tile = tiles_[p];
    const Eigen::Vector2d size = SizeOfPage(p);
    Corners corners = ShiftedCorners(f);
    for (Eigen::Vector2d& corner : corners)
      corner = UvAt(tile.left + corner.x() * size.x() - tile.from_x,
                    tile.top + (1 - corner.y()) * size.y() - tile.from_y);
    return corners;
  }

  Corners PaletteCorners(int block) const {
    const double left = tiles_.back().left + BlockLeft(block) + 1.5,
                 top = tiles_.back().top + BlockTop(block) + 1.5;
    return {UvAt(left, top), UvAt(left + kBlock - 3, top), UvAt(left, top + kBlock - 3)};
  }

  PagedMesh& paged_;
  const std::string& who_;
  std::vector<UvRange> ranges_;                       // of the pages
  std::vector<Eigen::Vector2d> shifts_;               // of the faces
  std::vector<Image8> images_;                        // of the pictures
  std::vector<std::array<std::uint8_t, 9>> palette_;  // sRGB of three corners
  std::vector<int> block_of_face_;                    // -1: none
  std::vector<Tile> tiles_;                           // of the pages, and of the palette
  int width_ = 1, height_ = 1;                        // of the new texture
  double scale_ = 1;
};

}  // namespace

OneTexture JoinPages(PagedMesh&& paged, const std::string& who) {
  return PageJoiner(paged, who).Join();
}

}  // namespace keypose
