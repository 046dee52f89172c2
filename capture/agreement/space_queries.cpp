#include "capture/agreement/space_queries.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "capture/agreement/space_grid.h"
#include "capture/pictures/working_image.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

/// Voxels that a ray can meet before others with the same number of contradictions: all except
/// those inside the part without contradictions.
struct Place {
  Eigen::Vector3d center;
  std::uint8_t contradictions;
};

std::vector<Place> PlacesOf(const Grid& grid, int most) {
  std::vector<Place> places;
  const auto uncontradicted = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < grid.size.x() && y < grid.size.y() &&
           z < grid.size.z() && grid.contradictions[grid.At(x, y, z)] == 0;
  };
  for (int z = 0; z < grid.size.z(); ++z)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int x = 0; x < grid.size.x(); ++x) {
        const std::uint8_t contradictions = grid.contradictions[grid.At(x, y, z)];
        if (contradictions > most) continue;
        if (contradictions == 0 && uncontradicted(x + 1, y, z) && uncontradicted(x - 1, y, z) &&
            uncontradicted(x, y + 1, z) && uncontradicted(x, y - 1, z) &&
            uncontradicted(x, y, z + 1) && uncontradicted(x, y, z - 1))
          continue;
        places.push_back({grid.Center(x, y, z), contradictions});
      }
  return places;
}

/// The smallest number of contradictions by others along each pixel's ray.
Image8 Picture(const MaskSampler& sampler, const std::vector<Place>& places, double cell,
               int most) {
  Image8 picture(sampler.contradicted.width, sampler.contradicted.height, 1,
                 static_cast<std::uint8_t>(most));
  for (const Place& place : places) {
    Eigen::Vector3d pixel;
    const MaskSample sample = sampler.At(place.center, &pixel);
    if (sample == MaskSample::kUnseen) continue;
    const auto contradictions = static_cast<std::uint8_t>(std::min(
        most, place.contradictions - (sampler.inlier && sample == MaskSample::kContradicted)));
    // Half the width of a voxel, approximately the same from any direction.
    const double half = 0.5 * cell * sampler.view->camera.fx / pixel.z();
    const int x0 = std::max(0, static_cast<int>(std::lround(pixel.x() - half))),
              y0 = std::max(0, static_cast<int>(std::lround(pixel.y() - half)));
    const int x1 =
        std::min(picture.width, std::max(x0 + 1, static_cast<int>(std::lround(pixel.x() + half))));
    const int y1 =
        std::min(picture.height, std::max(y0 + 1, static_cast<int>(std::lround(pixel.y() + half))));
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) *picture.at(x, y) = std::min(*picture.at(x, y), contradictions);
  }
  return picture;
}

}  // namespace

int MostContradictionsCounted(std::size_t views, const SpaceOptions& options) {
  return std::clamp(static_cast<int>(views) / 6, std::min(3, options.most_contradictions),
                    options.most_contradictions);
}

std::vector<Image8> ContradictionsByOthers(const std::vector<View>& views,
                                           const std::vector<Image8>& masks,
                                           const SpaceOptions& asked,
                                           const std::vector<char>& inlier) {
  SpaceOptions options = asked;
  const auto inliers = inlier.empty()
                           ? views.size()
                           : static_cast<std::size_t>(std::count(inlier.begin(), inlier.end(), 1));
  options.most_contradictions = MostContradictionsCounted(inliers, asked);
  if (std::count_if(masks.begin(), masks.end(),
                    [](const Image8& mask) { return MaskFraction(mask) > 0; }) < 3)
    throw InputError(
        "masks: fewer than 3 photographs have a mask with anything in it; look at capture's "
        "contact sheet");
  const std::vector<MaskSampler> samplers = MaskSamplersOf(views, masks, options, inlier);
  const Grid grid = SharedSpace(views, masks, samplers, options, options.most_contradictions);
  const std::vector<Place> places = PlacesOf(grid, options.most_contradictions);
  std::vector<Image8> pictures(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t i) {
    pictures[static_cast<std::size_t>(i)] = Picture(samplers[static_cast<std::size_t>(i)], places,
                                                    grid.cell, options.most_contradictions);
  });
  return pictures;
}

std::vector<Image8> ThicknessOfHull(const std::vector<View>& views,
                                    const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& inlier) {
  const std::vector<MaskSampler> samplers = MaskSamplersOf(views, masks, options, inlier);
  const Grid grid = SharedSpace(views, masks, samplers, options, 1);
  const int longest = LongestSide(grid);
  std::vector<Image8> pictures(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    pictures[i] = Image8(masks[i].width, masks[i].height, 1, 0);
    for (int y = 0; y < masks[i].height; ++y)
      for (int x = 0; x < masks[i].width; ++x)
        if (*masks[i].at(x, y) > 127)
          *pictures[i].at(x, y) = static_cast<std::uint8_t>(
              std::min(255, 100 * ChordOf(samplers[i], x, y, grid, false) / longest));
  });
  return pictures;
}

SpaceSurface SurfaceOfSpace(const std::vector<View>& views, const std::vector<Image8>& masks,
                            const SpaceOptions& options, const std::vector<char>& inlier) {
  const Grid grid =
      SharedSpace(views, masks, MaskSamplersOf(views, masks, options, inlier), options, 1);
  const auto inside = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < grid.size.x() && y < grid.size.y() &&
           z < grid.size.z() && grid.contradictions[grid.At(x, y, z)] == 0;
  };
  std::vector<Eigen::Vector3d> points, normals;
  for (int z = 0; z < grid.size.z(); ++z)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int x = 0; x < grid.size.x(); ++x) {
        if (!inside(x, y, z)) continue;
        if (inside(x + 1, y, z) && inside(x - 1, y, z) && inside(x, y + 1, z) &&
            inside(x, y - 1, z) && inside(x, y, z + 1) && inside(x, y, z - 1))
          continue;
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (int dz = -2; dz <= 2; ++dz)
          for (int dy = -2; dy <= 2; ++dy)
            for (int dx = -2; dx <= 2; ++dx)
              if (inside(x + dx, y + dy, z + dz)) normal -= Eigen::Vector3d(dx, dy, dz);
        if (normal.norm() < 1e-9) continue;
        points.push_back(grid.Center(x, y, z));
        normals.push_back(normal.normalized());
      }
  SpaceSurface surface;
  surface.cell = grid.cell;
  surface.points.points.resize(std::ssize(points), 3);
  surface.points.normals.resize(std::ssize(points), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    surface.points.points.row(static_cast<Eigen::Index>(i)) = points[i];
    surface.points.normals.row(static_cast<Eigen::Index>(i)) = normals[i];
  }
  return surface;
}

std::vector<double> AgreementInSpace(const std::vector<Image8>& masks,
                                     const std::vector<Image8>& contradictions) {
  constexpr int enough = 2;
  std::vector<double> agreement(masks.size(), 0);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    double both = 0, either = 0;
    for (std::size_t p = 0; p < masks[i].data.size(); ++p) {
      const bool mask = masks[i].data[p] > 127, hull = contradictions[i].data[p] < enough;
      both += mask && hull;
      either += mask || hull;
    }
    agreement[i] = either > 0 ? both / either : 0;
  }
  return agreement;
}

}  // namespace keypose::capture
