#include "capture/space_masks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/set_rounds.h"
#include "capture/space_grid.h"
#include "capture/windows.h"
#include "core/errors.h"
#include "core/parallel.h"

namespace keypose::capture {
namespace {

cv::Mat View8(const Image8& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels), const_cast<std::uint8_t*>(image.data.data()));
}

/// Voxels that a ray can meet first of their number of denials: all but those within the part that nobody denies.
struct Place {
  Eigen::Vector3d center;
  std::uint8_t denials;
};

std::vector<Place> PlacesOf(const Grid& grid, int most) {
  std::vector<Place> places;
  const auto undenied = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < grid.size.x() && y < grid.size.y() && z < grid.size.z() && grid.denials[grid.At(x, y, z)] == 0;
  };
  for (int z = 0; z < grid.size.z(); ++z)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int x = 0; x < grid.size.x(); ++x) {
        const std::uint8_t denials = grid.denials[grid.At(x, y, z)];
        if (denials > most) continue;
        if (denials == 0 && undenied(x + 1, y, z) && undenied(x - 1, y, z) && undenied(x, y + 1, z) && undenied(x, y - 1, z) &&
            undenied(x, y, z + 1) && undenied(x, y, z - 1))
          continue;
        places.push_back({grid.Center(x, y, z), denials});
      }
  return places;
}

/// The least denials by others along each pixel's ray.
Image8 Picture(const Witness& witness, const std::vector<Place>& places, double cell, int most) {
  Image8 picture(witness.denied.width, witness.denied.height, 1, static_cast<std::uint8_t>(most));
  for (const Place& place : places) {
    Eigen::Vector3d pixel;
    const Witness::Word word = witness.Of(place.center, &pixel);
    if (word == Witness::kUnseen) continue;
    const auto denials = static_cast<std::uint8_t>(std::min(most, place.denials - (witness.heard && word == Witness::kDenied)));
    // A voxel seen from anywhere is about as wide as this.
    const double half = 0.5 * cell * witness.view->camera.fx / pixel.z();
    const int x0 = std::max(0, static_cast<int>(std::lround(pixel.x() - half))),
              y0 = std::max(0, static_cast<int>(std::lround(pixel.y() - half)));
    const int x1 = std::min(picture.width, std::max(x0 + 1, static_cast<int>(std::lround(pixel.x() + half))));
    const int y1 = std::min(picture.height, std::max(y0 + 1, static_cast<int>(std::lround(pixel.y() + half))));
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) *picture.at(x, y) = std::min(*picture.at(x, y), denials);
  }
  return picture;
}

/// Log odds of the figure for each number of denials, from how often masks have it inside and just outside.
std::vector<float> OddsOfDenials(const std::vector<Image8>& masks, const std::vector<Image8>& denials, const std::vector<char>& say,
                                 int most) {
  std::vector<double> inside(static_cast<std::size_t>(most) + 1, 0), outside(inside);
  double all_inside = 0, all_outside = 0;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    if (!say[i]) continue;
    cv::Mat near;
    const int reach = 1 + 2 * (masks[i].width / 24);
    cv::dilate(View8(masks[i]), near, cv::getStructuringElement(cv::MORPH_ELLIPSE, {reach, reach}));
    for (int y = 0; y < near.rows; ++y)
      for (int x = 0; x < near.cols; ++x) {
        const std::uint8_t d = *denials[i].at(x, y);
        if (*masks[i].at(x, y) > 127)
          inside[d] += 1, all_inside += 1;
        else if (near.at<std::uint8_t>(y, x))
          outside[d] += 1, all_outside += 1;
      }
  }
  std::vector<float> odds(inside.size());
  for (std::size_t d = 0; d < odds.size(); ++d)
    odds[d] =
        static_cast<float>(std::log((inside[d] / std::max(all_inside, 1.0) + 1e-3) / (outside[d] / std::max(all_outside, 1.0) + 1e-3)));
  // More denials never speak for the figure more than fewer.
  for (std::size_t d = 1; d < odds.size(); ++d) odds[d] = std::min(odds[d], odds[d - 1]);
  return odds;
}

/// One round at one size: what the others deny, weighed, leans the forest's odds.
/// @param hearing  one a view: 0 is told nothing of the others
std::vector<Image8> SpaceRound(const std::vector<Image8>& images, const std::vector<Image8>& masks, const std::vector<Image8>& denials,
                               const std::vector<char>& say, const std::vector<char>& hearing, const std::vector<BoardOdds>& boards,
                               const MaskOptions& masking, const SpaceOptions& options, double weight) {
  constexpr double kManyViews = 48;
  // A hull is larger than its figure, the more so the fewer the views: that nobody denies a place says less than that some do.
  std::vector<float> leaning_of = OddsOfDenials(masks, denials, say, options.most_denials);
  const double sure = std::clamp(static_cast<double>(images.size()) / kManyViews, 0.5, 1.0);
  for (float& odds : leaning_of) odds *= static_cast<float>(odds < 0 ? weight : sure * weight);
  // Views that are told nothing: a last kind of pixel, of which nothing is known.
  const auto untold = static_cast<std::uint8_t>(leaning_of.size());
  leaning_of.push_back(0);
  std::vector<Image8> told = denials;
  for (std::size_t i = 0; i < told.size(); ++i)
    if (!hearing[i]) std::fill(told[i].data.begin(), told[i].data.end(), untold);
  Round round{images, {}, {}, FindTakes(images, masking.border_share), &told, std::move(leaning_of)};
  for (std::size_t i = 0; i < images.size(); ++i) {
    round.lab.push_back(LabOf(images[i]));
    round.zones.push_back(ZonesOf(masks[i]));
  }
  return SegmentByForest(round, boards, masking);
}

/// Views that contradict the others in outline, and not in colour.
std::vector<std::size_t> SilentByOutline(const Standing& standing, const ColorOptions& options) {
  std::vector<std::size_t> silent;
  for (std::size_t i = 0; i < standing.say.size(); ++i)
    if (!standing.say[i] && standing.colors[i].contrary <= options.most_contrary) silent.push_back(i);
  return silent;
}

Image8 Binary(Image8 mask) {
  for (std::uint8_t& m : mask.data) m = m > 127 ? 255 : 0;
  return mask;
}

Image8 ResizedMask(const Image8& mask, int width, int height) {
  Image8 to(width, height, 1);
  cv::Mat view = View8(to);
  cv::resize(View8(mask), view, view.size(), 0, 0, mask.width > width ? cv::INTER_AREA : cv::INTER_LINEAR);
  return Binary(std::move(to));
}

}  // namespace

int DenialsToldApart(std::size_t views, const SpaceOptions& options) {
  return std::clamp(static_cast<int>(views) / 6, std::min(3, options.most_denials), options.most_denials);
}

std::vector<Image8> DenialsByOthers(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& asked,
                                    const std::vector<char>& say) {
  SpaceOptions options = asked;
  const auto heard = say.empty() ? views.size() : static_cast<std::size_t>(std::count(say.begin(), say.end(), 1));
  options.most_denials = DenialsToldApart(heard, asked);
  if (std::count_if(masks.begin(), masks.end(), [](const Image8& mask) { return MaskFraction(mask) > 0; }) < 3)
    throw InputError("masks: fewer than 3 photographs have a mask with anything in it; look at capture's contact sheet");
  const std::vector<Witness> witnesses = WitnessesOf(views, masks, options.margin_px, say);
  const Grid grid = SharedSpace(views, masks, witnesses, options, options.most_denials);
  const std::vector<Place> places = PlacesOf(grid, options.most_denials);
  std::vector<Image8> pictures(views.size());
  ParallelFor(static_cast<std::int64_t>(views.size()), [&](std::int64_t i) {
    pictures[static_cast<std::size_t>(i)] = Picture(witnesses[static_cast<std::size_t>(i)], places, grid.cell, options.most_denials);
  });
  return pictures;
}

std::vector<Image8> ThicknessOfHull(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& say) {
  const std::vector<Witness> witnesses = WitnessesOf(views, masks, options.margin_px, say);
  const Grid grid = SharedSpace(views, masks, witnesses, options, 1);
  const int longest = LongestSide(grid);
  std::vector<Image8> pictures(views.size());
  ParallelFor(static_cast<std::int64_t>(views.size()), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    pictures[i] = Image8(masks[i].width, masks[i].height, 1, 0);
    for (int y = 0; y < masks[i].height; ++y)
      for (int x = 0; x < masks[i].width; ++x)
        if (*masks[i].at(x, y) > 127)
          *pictures[i].at(x, y) = static_cast<std::uint8_t>(std::min(255, 100 * ChordOf(witnesses[i], x, y, grid, false) / longest));
  });
  return pictures;
}

SpaceSurface SurfaceOfSpace(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& options,
                            const std::vector<char>& say) {
  const Grid grid = SharedSpace(views, masks, WitnessesOf(views, masks, options.margin_px, say), options, 1);
  const auto inside = [&](int x, int y, int z) {
    return x >= 0 && y >= 0 && z >= 0 && x < grid.size.x() && y < grid.size.y() && z < grid.size.z() && grid.denials[grid.At(x, y, z)] == 0;
  };
  std::vector<Eigen::Vector3d> points, normals;
  for (int z = 0; z < grid.size.z(); ++z)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int x = 0; x < grid.size.x(); ++x) {
        if (!inside(x, y, z)) continue;
        if (inside(x + 1, y, z) && inside(x - 1, y, z) && inside(x, y + 1, z) && inside(x, y - 1, z) && inside(x, y, z + 1) &&
            inside(x, y, z - 1))
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
  surface.points.points.resize(static_cast<Eigen::Index>(points.size()), 3);
  surface.points.normals.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    surface.points.points.row(static_cast<Eigen::Index>(i)) = points[i];
    surface.points.normals.row(static_cast<Eigen::Index>(i)) = normals[i];
  }
  return surface;
}

std::vector<double> AgreementInSpace(const std::vector<Image8>& masks, const std::vector<Image8>& denials) {
  constexpr int enough = 2;
  std::vector<double> agreement(masks.size(), 0);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    double both = 0, either = 0;
    for (std::size_t p = 0; p < masks[i].data.size(); ++p) {
      const bool mask = masks[i].data[p] > 127, hull = denials[i].data[p] < enough;
      both += mask && hull;
      either += mask || hull;
    }
    agreement[i] = either > 0 ? both / either : 0;
  }
  return agreement;
}

RefinedMasks RefineInSpace(const std::vector<Image8>& images, const std::vector<Image8>& masks, const std::vector<View>& views,
                           const std::vector<BoardOdds>& boards, const MaskOptions& masking, const SpaceOptions& options,
                           Progress* progress) {
  cv::setNumThreads(1);
  std::vector<BoardOdds> known = boards;
  known.resize(images.size());
  // Rounds but the last at half the size: they settle which parts belong, the last where the outline runs.
  std::vector<Image8> small, small_masks;
  std::vector<View> small_views = views;
  for (std::size_t i = 0; i < images.size(); ++i) {
    small.push_back(WorkingImage(images[i], std::max(images[i].width, images[i].height) / 2));
    small_masks.push_back(ResizedMask(masks[i], small[i].width, small[i].height));
    small_views[i].camera = views[i].camera.Scaled(static_cast<double>(small[i].width) / images[i].width);
  }
  const std::vector<BoardOdds> small_boards = Halved(known, small);
  SpaceOptions coarse = options;
  coarse.resolution = std::max(16, options.resolution * 3 / 4);
  coarse.margin_px = 0.7 * options.margin_px;
  RefinedMasks refined;
  const auto denials_by = [&](const std::vector<char>& say) {
    const auto heard = say.empty() ? views.size() : static_cast<std::size_t>(std::count(say.begin(), say.end(), 1));
    return Denials{DenialsByOthers(small_views, small_masks, coarse, say), DenialsToldApart(heard, coarse)};
  };
  Denials denials = denials_by({});
  refined.agreement_before = AgreementInSpace(small_masks, denials.pictures);
  const auto judge = [&] {
    Standing standing = JudgeOutlines(small_masks, denials, denials_by, options.standing);
    const SpaceSurface surface = SurfaceOfSpace(small_views, small_masks, coarse, standing.say);
    standing.colors = FitsOfColors(small, small_masks, small_views, surface.points, surface.cell, standing.say, options.colors);
    const std::vector<char> by_outline = standing.say;
    JudgeColors(standing.colors, options.colors, standing.say);
    if (standing.say != by_outline) denials = denials_by(standing.say);
    const auto silent = static_cast<double>(std::count(standing.say.begin(), standing.say.end(), 0));
    standing.undecided |= silent > options.standing.most_doubtful * static_cast<double>(views.size());
    return standing;
  };
  refined.standing_before = judge();
  std::vector<char> say = refined.standing_before.say;
  // At first the others' word is only as good as masks that are partly wrong.
  for (const double weight : {1.0, options.weight, options.weight}) {
    Step(progress, 0.15 * weight, "masks in space");
    small_masks = SpaceRound(small, small_masks, denials.pictures, say, say, small_boards, masking, coarse, weight);
    denials = denials_by(say);
  }
  refined.agreement = AgreementInSpace(small_masks, denials.pictures);
  denials = denials_by({});
  refined.standing = judge();
  if (const std::vector<std::size_t> again = SilentByOutline(refined.standing, options.colors); !again.empty()) {
    const std::vector<Image8> unled = small_masks;
    const std::vector<Image8> led = SpaceRound(small, small_masks, denials.pictures, refined.standing.say,
                                               std::vector<char>(views.size(), 1), small_boards, masking, coarse, options.weight);
    for (const std::size_t i : again) small_masks[i] = led[i];
    denials = denials_by({});
    refined.standing = judge();
    for (const std::size_t i : again)
      if (!refined.standing.say[i]) small_masks[i] = unled[i];
  }
  say = refined.standing.say;
  Step(progress, 0.6, "masks in space");
  std::vector<Image8> large;
  for (std::size_t i = 0; i < images.size(); ++i) large.push_back(ResizedMask(small_masks[i], images[i].width, images[i].height));
  std::vector<Image8> lab;
  for (const Image8& image : images) lab.push_back(LabOf(image));
  const std::vector<Take> takes = FindTakes(images, masking.border_share);
  const auto round = [&](const std::vector<Image8>& from) {
    refined.masks = SpaceRound(images, from, DenialsByOthers(views, from, options, say), say, say, known, masking, options, options.weight);
    std::vector<Image8> zones;
    for (const Image8& mask : refined.masks) zones.push_back(ZonesOf(mask));
    return BackdropsOf(lab, zones, takes, masking.largest_misfit);
  };
  constexpr double kWorthARound = 3e-4;  // of the figure, opened: less teaches the others nothing
  Backdrops backdrops = round(large);
  std::vector<Image8> open = refined.masks;
  if (OpenWindows(images, views, backdrops.of, options, say, open) > kWorthARound) {
    backdrops = round(open);
    OpenWindows(images, views, backdrops.of, options, say, refined.masks);
  }
  refined.backdrops = std::move(backdrops.of);
  if (backdrops.Confusing())
    for (Backdrop& backdrop : refined.backdrops) backdrop.empty = {};
  if (std::all_of(refined.backdrops.begin(), refined.backdrops.end(), [](const Backdrop& b) { return b.empty.empty(); })) return refined;
  std::vector<Image8> thickness = ThicknessOfHull(views, refined.masks, options, say);
  for (std::size_t i = 0; i < images.size(); ++i) refined.backdrops[i].thickness = std::move(thickness[i]);
  return refined;
}

}  // namespace keypose::capture
